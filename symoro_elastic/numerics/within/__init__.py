"""Fewer operations within a tolerance: which terms of a program may be left out over a box of arguments."""
