"""Drives of the machine: their states along a time step, controllers that are sampled, closed loops."""
