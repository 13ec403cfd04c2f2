"""Motions of a machine over time: wanted ones, and simulated ones."""
