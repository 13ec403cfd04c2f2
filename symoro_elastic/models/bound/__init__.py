"""A machine bound to the equations, and what all models are made of: rules, names, traces, the state."""
