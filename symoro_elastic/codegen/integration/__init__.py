"""Integration of the equations of motion over time."""
