"""Sampled motions and torques: files, units, checks."""
