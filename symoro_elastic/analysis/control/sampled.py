"""Sampled controllers exactly: the map of machine and controllers over one period.

The torque's set point w is held. It changes a dead time 0 < Td <= T after a sample, so that over a period T

    x(T) = e^(A T) x + e^(A (T - Td)) int_0^Td e^(A s) ds B w_old + int_0^(T - Td) e^(A s) ds B w_new,

x holding the machine and its current loops. Controllers read the machine at samples: integral parts by backward Euler,
filters by Tustin's rule that is exact at their own frequency. Drives without a period are closed in A. A cascade with
modes above half the sampling rate is exact: the map has no frequency limit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.control.cascade import (
    CURRENT,
    Biquad,
    Cascade,
    DeadTime,
    FirstOrder,
    Hold,
    System,
    biquad_system,
    first_order_system,
)
from symoro_elastic.analysis.control.closed_loop import NOTHING, closed_loop
from symoro_elastic.analysis.control.drive_laws import TAU, XD, current_loop
from symoro_elastic.analysis.control.plant import Plant
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.machine.drives import dead_time_within
from symoro_elastic.models.drives.control import common_period


@dataclass(frozen=True)
class SampledLoop:
    """The map (states, states) over a `period`, s."""

    map: Array
    period: float

    @property
    def poles(self) -> ComplexArray:
        """Eigenvalues of the map: a lasting motion is at 1."""
        return np.asarray(np.linalg.eigvals(self.map).astype(complex))

    @property
    def growth(self) -> float:
        """Fastest growth of a motion, 1/s: negative if all decay, 0 within rounding."""
        log_radius = float(np.log(np.abs(self.poles).max()))
        return log_radius / self.period if abs(log_radius) > NOTHING else 0.0


def period_of(cascades: Sequence[Cascade], source: str) -> float:
    """Return the period of the sampled drives, 0 where there are none; raises `InputError` where they have several."""
    periods = {cascade.motor: hold.time for cascade in cascades for hold in cascade.path if isinstance(hold, Hold)}
    return common_period(periods, source)


def dead_time_of(cascade: Cascade, period: float, source: str) -> float:
    """Return the dead time of a sampled drive, s; raises `InputError` for one beyond the period."""
    dead = sum(x.time for x in cascade.path if isinstance(x, DeadTime))
    return dead_time_within(period, dead, cascade.motor, source)


def sampled_loop(plant: Plant, cascades: Sequence[Cascade]) -> SampledLoop | None:
    """Return the map of all loops; None without a sampled drive. Raises `InputError` for different periods."""
    source = plant.linear.motion.source
    period = period_of(cascades, source)
    if not period:
        return None
    with_hold = [drive for drive in cascades if any(isinstance(x, Hold) for x in drive.path)]
    sampled = [VelocityLaw.of(drive, period, source) for drive in with_hold]
    continuous = closed_loop(plant, [drive for drive in cascades if drive not in with_hold])
    A, B = _with_current_loops(plant, continuous.A, continuous.by_force, sampled)
    old, new = _hold_columns(A, B, [controller.dead_time for controller in sampled], period)
    return SampledLoop(_map(plant, A, old, new, sampled, period), period)


def _with_current_loops(plant: Plant, A: Array, by_force: Array, sampled: Sequence[VelocityLaw]) -> tuple[Array, Array]:
    """Return A and B of the machine with the current loops of sampled drives, whose states come last."""
    laws = [current_loop(controller.cascade, controller.lag) for controller in sampled]
    n, N = len(A), plant.free
    ends = n + np.cumsum([0, *(len(law.A) for law in laws)])
    matrix, B = np.zeros((ends[-1], ends[-1])), np.zeros((ends[-1], len(sampled)))
    matrix[:n, :n] = A
    for k, (controller, law) in enumerate(zip(sampled, laws, strict=True)):
        velocity, own = plant.axes[controller.cascade.motor].velocity, slice(ends[k], ends[k + 1])
        push = by_force @ velocity
        matrix[:n, own], matrix[own, own] = np.outer(push, law.C), law.A
        matrix[own, N.shape[1] : 2 * N.shape[1]] = np.outer(law.B[:, XD], velocity @ N)
        B[own, k], B[:n, k] = law.B[:, TAU], push * law.D[TAU]
    return matrix, B


def _hold_columns(A: Array, B: Array, dead_times: Sequence[float], period: float) -> tuple[Array, Array]:
    """Return the input columns of previous and new torque set points over a period, (states, drives) each."""
    expm = for_vibrations("scipy.linalg").expm
    n = len(A)
    old, new = np.zeros_like(B), np.zeros_like(B)
    for k, dead in enumerate(dead_times):
        together = np.zeros((n + 1, n + 1))
        together[:n, :n], together[:n, n] = A, B[:, k]
        after = expm(together * (period - dead))
        old[:, k] = after[:n, :n] @ expm(together * dead)[:n, n]
        new[:, k] = after[:n, n]
    return old, new


def _map(plant: Plant, A: Array, old: Array, new: Array, sampled: Sequence[VelocityLaw], period: float) -> Array:
    """Return the map of x, the set points w of torque, and the controllers' states, in this order."""
    n, m = len(A), len(sampled)
    sizes = [len(controller.law.A) for controller in sampled]
    ends = np.cumsum([n + m, *sizes])
    step = np.zeros((ends[-1], ends[-1]))
    step[:n, :n] = for_vibrations("scipy.linalg").expm(A * period)
    step[:n, n : n + m] = old
    N = plant.free
    free = N.shape[1]
    for k, controller in enumerate(sampled):
        axis, own = plant.axes[controller.cascade.motor], slice(ends[k], ends[k + 1])
        error = np.zeros(ends[-1])  # e = -(Kv p + v) at the sample
        error[:free], error[free : 2 * free] = -controller.cascade.Kv * (axis.position @ N), -(axis.velocity @ N)
        law = controller.law
        w = law.D * error
        w[own] += law.C
        step[n + k] = w
        step[:n] += np.outer(new[:, k], w)
        step[own] += np.outer(law.B, error)
        step[own, own] += law.A
    return step


@dataclass(frozen=True)
class VelocityLaw:
    """A sampled velocity controller with filters, z+ = A z + B e, w = C z + D e; its dead time and its lag."""

    cascade: Cascade
    law: System
    dead_time: float
    lag: float

    @classmethod
    def of(cls, cascade: Cascade, period: float, source: str) -> VelocityLaw:
        """Return the controller of a cascade; raises `InputError` for a dead time beyond a period."""
        law = System.gain(cascade.Kp)
        if cascade.Tn < np.inf:
            share = period / cascade.Tn
            law = System(np.eye(1), np.array([period]), np.array([cascade.Kp / cascade.Tn]), cascade.Kp * (1 + share))
        lags = [x for x in cascade.path if isinstance(x, FirstOrder) and x.name == CURRENT]
        for x in cascade.path:
            if isinstance(x, Biquad):
                law = law.then(by_tustin(biquad_system(x), x.w, period))
            elif isinstance(x, FirstOrder) and x.name != CURRENT:
                law = law.then(by_tustin(first_order_system(x), 1 / x.time, period))
        return cls(cascade, law, dead_time_of(cascade, period, source), sum(x.time for x in lags))


def by_tustin(law: System, w: float, period: float) -> System:
    """Return a filter over samples by s = c (z - 1)/(z + 1), c = w/tan(w T/2): exact at w below half the rate."""
    c = w / np.tan(w * period / 2) if w * period < np.pi else 2 / period
    inverse = np.linalg.inv(c * np.eye(len(law.A)) - law.A)
    root = np.sqrt(2 * c)
    D = law.D + float(law.C @ inverse @ law.B)
    return System(inverse @ (c * np.eye(len(law.A)) + law.A), root * inverse @ law.B, root * law.C @ inverse, D)
