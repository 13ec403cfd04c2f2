"""Vibration of a machine about a state: equilibrium, linearization, modes, frequency responses, reduced models.

motion = motion_of(machine)
linear = linearize(motion, equilibrium(motion, at={"motor_x": 0.3}))
found = modes(with_motors(linear, held=["motor_x"]))
strain_shares(found).largest(0), sensitivity(found).strongest(0, 3)
"""
