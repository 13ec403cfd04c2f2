"""Models of forces and accelerations."""
