"""Beams: sections, joints at fitted places, modes, and their errors."""
