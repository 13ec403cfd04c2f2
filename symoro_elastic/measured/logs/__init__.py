"""Identification of a real machine: parameters and their standard deviations from measured motion and torques."""
