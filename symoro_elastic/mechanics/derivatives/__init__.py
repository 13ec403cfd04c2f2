"""Derivatives of the dynamic models by recursion: of torques, of accelerations, by the motion of the base."""
