"""What is computed with models: vibration, simulation, the ladder, identification, sweeps, the trade-off."""
