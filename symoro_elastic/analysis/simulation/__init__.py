"""Motions of a machine over time: reference motions and simulated motions."""
