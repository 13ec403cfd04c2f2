"""Checks of machines: singular or implausible ones, gyroscopic rotors, descriptions of loops."""
