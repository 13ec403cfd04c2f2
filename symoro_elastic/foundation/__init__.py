"""What does not depend on machines."""
