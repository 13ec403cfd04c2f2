"""Flexible parts of machine files: cells of six springs, beams, and bodies by modes."""
