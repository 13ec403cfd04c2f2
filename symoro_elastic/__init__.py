"""Symbolic models of mechanical systems with lumped elasticity, after Khalil and Gautier."""

__version__ = "0.1.0"
