"""Documents with equations."""
