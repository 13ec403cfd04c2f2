"""Closed loops of a machine: their closed forms, determined in numbers first, and then as expressions."""
