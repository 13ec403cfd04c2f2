"""What is computed with models of a machine.

About a state: `vibration`, `control` (drives and cuts), `singularities`. Over time: `simulation`, and the `ladder` of
models that a motion requires, records (`time_series`). Over variants: `sweeps` of parameters and positions, `trade_off`
of speed against accuracy over builds of code.
"""
