"""Parameters of a machine from measurements.

`fitting` knows no machine: unknowns, estimates and their verdicts. `logs` are records of motions (`identify`),
`vibration_tests` are frequency responses and lists of modes (`update`).
"""
