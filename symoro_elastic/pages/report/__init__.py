"""One page about a machine: picture, table, modes, responses, what a scene requires, counts, accuracy, equations."""
