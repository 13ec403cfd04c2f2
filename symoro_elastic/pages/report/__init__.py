"""One page about a machine: picture, table, modes, responses, requirements of a scene, counts, accuracy, equations."""
