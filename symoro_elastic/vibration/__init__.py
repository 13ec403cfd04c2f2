"""Vibration of a machine about a state: equilibrium, linearization, modes, frequency responses, reduced models.

Feed-forward through its springs avoids exciting them.

motion = motion_of(machine)
linear = linearize(motion, equilibrium(motion, at={"motor_x": 0.3}))
modal = modes(with_motors(linear, held=["motor_x"]))
strain_shares(modal).largest(0), sensitivity(modal).strongest(0, 3)
feed_forward(machine, move(machine, start={}, strokes={"motor_x": 0.1}, duration=0.5, degree=7)).tau
"""
