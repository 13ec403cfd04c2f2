"""Motions of machines whose motors all follow exactly: torques by the inverse model, without integration."""

from __future__ import annotations

import math

import numpy as np

from symoro_elastic.analysis.simulation.compiled_steps import Trajectory
from symoro_elastic.analysis.simulation.energy_balance import energy_balance
from symoro_elastic.analysis.simulation.observed import Observer
from symoro_elastic.analysis.simulation.periods import WHOLE
from symoro_elastic.analysis.simulation.prediction.resolution import in_detail, refuse_unresolved
from symoro_elastic.analysis.simulation.reference_motion import SAMPLES, Reference
from symoro_elastic.analysis.simulation.simulate import Request, Simulating
from symoro_elastic.analysis.simulation.simulated import EXACT, Simulation
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.numerics.motion.signals import MOTOR_TORQUE


def follows_exactly(reference: Reference) -> bool:
    """Return whether the motion of the motors determines that of all joints."""
    machine = reference.machine
    is_whole = bool(machine.motors) and len(machine.motors) == len(machine.independent)
    return is_whole and reference.servo is None and not reference.base


def follow(reference: Reference, request: Request) -> Simulation:
    """Return an exactly prescribed motion, with torques, outputs and energies; raises `InputError`.

    Its samples are those of --step, else enough to resolve all parts of the motion. Its errors are zero by definition.
    """
    if request.method is not None:
        what = "every joint is a motor that follows exactly, so nothing is integrated: leave it out, or give servos"
        raise InputError(reference.prescribed.source or reference.machine.label, "--method", what)
    steps = _steps(reference, request)
    names = request.outputs or tuple(request.tolerance or ())
    names = names or tuple(f"{motor}.{MOTOR_TORQUE}" for motor in reference.motors)
    t = np.linspace(0.0, reference.duration, steps + 1)
    observer = Observer(reference.machine, reference, names)
    blocks = reference.motion(t).blocks
    trajectory = Trajectory(blocks, t, EXACT, reference.duration / steps, steps, 0.0)
    motion = observer.motion(trajectory)
    outputs = observer.outputs(motion)
    return Simulation(
        reference, trajectory, motion, names, outputs, np.zeros_like(outputs), dict.fromkeys(names, 0.0),
        dict(request.tolerance or {}), {}, 0, energy_balance(reference, motion), None, math.inf,
    )  # fmt: skip


def _steps(reference: Reference, request: Request) -> int:
    """Return the number of samples minus one."""
    if request.step is None:
        refuse_unresolved(reference)
        return max(SAMPLES - 1, in_detail(reference))
    simulating = Simulating(reference, request)
    if not 0 < request.step < math.inf:
        raise simulating.error("--step", f"{request.step:g} s is not a time: give a positive number")
    simulating.refuse_many(reference.duration / request.step)
    return math.ceil(reference.duration / request.step * (1 - WHOLE))
