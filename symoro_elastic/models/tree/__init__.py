"""The open tree of a machine: its cells, transforms, and laws of joints as expressions of a graph."""
