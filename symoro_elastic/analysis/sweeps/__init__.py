"""Sweeps: results of a machine over grids and samples of its parameters and positions.

`axes` reads what is swept, `quantities` finds it in the machine, `design` are the points. `points` computes the figures
of one; `processes` and `cluster` compute many at once, and `journal` keeps what was computed. `sweep` is the result.
"""
