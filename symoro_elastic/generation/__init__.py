"""From a machine to files: the nine steps, base parameters, FMUs."""
