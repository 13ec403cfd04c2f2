"""Models checked against references in many digits."""
