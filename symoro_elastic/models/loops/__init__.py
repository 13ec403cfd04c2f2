"""Closed loops of a machine: how each closes, found out once in numbers, and then in expressions."""
