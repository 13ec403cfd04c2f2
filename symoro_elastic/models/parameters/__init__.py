"""Base inertial parameters of a machine."""
