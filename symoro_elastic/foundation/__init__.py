"""Foundations that are independent of machines."""
