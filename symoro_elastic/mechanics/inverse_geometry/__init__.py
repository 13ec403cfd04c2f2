"""Inverse geometric models in closed form: all joint positions that place a frame."""
