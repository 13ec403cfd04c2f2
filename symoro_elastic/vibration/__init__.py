"""Vibration of a machine about a state: equilibrium, linearization, modes, frequency responses, reduced models.

And what makes it follow without: feed-forward through its springs.

motion = motion_of(machine)
linear = linearize(motion, equilibrium(motion, at={"motor_x": 0.3}))
found = modes(with_motors(linear, held=["motor_x"]))
strain_shares(found).largest(0), sensitivity(found).strongest(0, 3)
feed_forward(machine, move(machine, start={}, strokes={"motor_x": 0.1}, duration=0.5, degree=7)).tau
"""
