"""Closed loops in reduced coordinates: where they close, how fast, and with which forces."""
