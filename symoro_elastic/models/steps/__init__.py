"""The models that generated time steps call."""
