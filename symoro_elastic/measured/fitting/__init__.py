"""Fits of any model to measurements: unknowns, estimates and their verdicts, undetermined directions."""
