"""Finite-element models reduced to bodies by modes."""
