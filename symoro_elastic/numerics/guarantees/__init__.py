"""What generated functions guarantee on a box of their arguments: ranges, rounding errors, pivots."""
