"""Drives around a machine: margins and bandwidths of their loops, what limits their gains, and how to choose them."""
