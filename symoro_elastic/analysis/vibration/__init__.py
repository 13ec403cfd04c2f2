"""Vibration of a machine about a state: equilibrium, linearization, modes, frequency responses, reduced models.

Feed-forward through its springs avoids exciting them.

from symoro_elastic.formats import read_machine
from symoro_elastic.analysis.vibration.modes import strain_shares
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from symoro_elastic.analysis.vibration.feed_forward import feed_forward
from symoro_elastic.analysis.vibration.linearization import linearize, with_motors
from symoro_elastic.numerics.motion.equations_of_motion import motion_of
from symoro_elastic.analysis.vibration.modes import modes, sensitivity
from symoro_elastic.analysis.vibration.reference_trajectory import move

machine, warnings = read_machine("examples/two_axis.toml")
motion = motion_of(machine)
linear = linearize(motion, equilibrium(motion, at={"motor_x": 0.3}))
modal = modes(with_motors(linear, held=["motor_x"]))
strain_shares(modal).largest(0), sensitivity(modal).strongest(0, 3)
feed_forward(machine, move(machine, start={}, strokes={"motor_x": 0.1}, duration=0.5, degree=7)).tau
"""
