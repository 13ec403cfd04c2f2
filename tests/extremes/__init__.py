"""The extremes: machines and states at the limits, each with the bound of its error and what a user is told."""
