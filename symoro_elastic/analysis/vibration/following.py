"""Motions of springs and passive joints for prescribed motors: initial value problems."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.analysis.vibration.inverse_model import InverseModel
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State

MOST_SWINGS = 50_000
"""Periods of the fastest mode that are followed: 25 to 100 evaluations of the model each, two minutes in all."""
MOST_STEPS = 8 * MOST_SWINGS
TOO_FAST = "the motion becomes too fast to integrate at {:.4g} s: shorten it, or change springs and dampers"
Rate = Callable[[float, Array], Array]
RELATIVE, ABSOLUTE = 1e-7, 1e-12
"""Errors of a step, of the coordinates in rad or m."""


@dataclass(frozen=True)
class MotorCurve:
    """Positions (m,) of motors as polynomials of time between `breaks` (pieces + 1,), s.

    `coefficients` (degree + 1, pieces, m) are those of powers of the time since the break, the highest first.
    """

    breaks: Array
    coefficients: Array

    @classmethod
    def through(cls, t: Array, positions: Array, degree: int) -> MotorCurve:
        """Return the spline of a degree through positions (N, m) at times (N,)."""
        spline = for_vibrations("scipy.interpolate").make_interp_spline(t, positions, k=degree)
        breaks = np.unique(spline.t)
        rates = [spline.derivative(k)(breaks[:-1]) / math.factorial(k) for k in reversed(range(degree + 1))]
        return cls(breaks, np.array(rates))

    def with_rates(self) -> Any:
        """Return a function of time with values q, qd, qdd, (3, m), or (N, 3, m) at times (N,)."""
        blocks = [self.coefficients]
        for _ in range(2):
            powers = np.arange(len(self.coefficients) - 1, -1, -1)[:, None, None]
            lowered = (blocks[-1] * powers)[:-1]
            blocks.append(np.concatenate([np.zeros_like(self.coefficients[:1]), lowered]))
        return for_vibrations("scipy.interpolate").PPoly(np.stack(blocks, axis=2), self.breaks)


def motion_between_motors(
    motion: EquationsOfMotion, start: State, curve: MotorCurve, times: Array, source: str,
    progress: Progress = no_progress,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Return q, qd, qdd (N, n) of all joints at times (N,), from rest, by an 8th-order Runge-Kutta method.

    Raises `InputError` for joints that stick, and where steps get too small; `source` names the motion.
    """
    refuse_sticking(motion)
    n, motors = len(motion.joints), motion.motors
    dependent = [k for k in range(n) if k not in motors]
    inverse = InverseModel(motion)
    moved, m = curve.with_rates(), len(dependent)

    def states_at(t: Any, y: Array) -> tuple[Array, Array, Array]:
        q, qd = np.zeros((2, *np.shape(t), n))
        motor_motion = moved(t)
        q[..., motors], qd[..., motors] = motor_motion[..., 0, :], motor_motion[..., 1, :]
        q[..., dependent], qd[..., dependent] = y[..., :m], y[..., m:]
        return q, qd, inverse(q, qd, motor_motion[..., 2, :])[1]

    def rate(t: float, y: Array) -> Array:
        return np.concatenate([y[m:], states_at(t, y)[2][dependent]])

    initial = np.concatenate([start.q[dependent], np.zeros(m)])
    return states_at(times, _integrate(rate, initial, times, source, progress))


def _integrate(
    rate: Callable[[float, Array], Array], first: Array, times: Array, source: str, progress: Progress
) -> Array:
    """Return y (N, ...) of y' = rate(t, y) at times (N,); raises `InputError` for too small or too many steps."""
    states = np.tile(first, (len(times), 1))
    if not len(first):
        return states
    solver = for_vibrations("scipy.integrate").DOP853(rate, times[0], first, times[-1], rtol=RELATIVE, atol=ABSOLUTE)
    done = 1
    for _ in range(MOST_STEPS):
        failure = solver.step()
        passed = done + int(np.searchsorted(times[done:], solver.t, side="right"))
        if failure or not np.isfinite(solver.y).all():
            break
        if passed > done:
            states[done:passed] = solver.dense_output()(times[done:passed]).T
            done = passed
            progress(done, len(times))
        if solver.status == "finished":
            return states
    raise InputError(source, "t", TOO_FAST.format(solver.t))


def refuse_sticking(motion: EquationsOfMotion) -> None:
    """Raise `InputError` for dry friction without a creep law on a joint without a motor.

    It sticks, and no step is small enough.
    """
    machine, q = motion.given, motion.neutral_positions()
    laws = {j: machine.joint(j).friction for j in machine.articulated}
    dry = [j for j, law in laws.items() if law.creep.is_zero and law.coulomb.value(motion.parameters)]
    free = [k for k in range(len(q)) if k not in motion.motors]
    for j, row in zip(dry, motion.slopes(q, dry), strict=True):
        if row[free].any():
            what = f"{machine.joint(j).name} has no motor, so dry friction holds it at times, and such a motion cannot"
            what += " be integrated: give its friction a creep velocity, or make its coulomb friction 0, in a copy of"
            raise InputError(motion.source, "friction", f"{what} the table")


def refuse_swings(seconds: float, fastest: float, source: str, place: str) -> None:
    """Raise `InputError` for a motion of too many periods; `fastest` in rad/s."""
    hertz = fastest / (2 * math.pi)
    if seconds * hertz > MOST_SWINGS:
        what = f"{seconds:.4g} s at {hertz:.4g} Hz is too long to integrate: cut it to {MOST_SWINGS / hertz:.3g} s"
        raise InputError(source, place, what)
