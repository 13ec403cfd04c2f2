"""Identification of a real machine: from measured motion and torques to parameters and what they are worth."""
