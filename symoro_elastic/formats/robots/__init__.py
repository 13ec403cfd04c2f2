"""Robots as links and joints in placements at zero, and their tables of geometric parameters."""
