"""Motions of motors with sampled drives: the controllers' own code once in each period, and the machine between.

At t = k T the code that `generate --model control` writes reads the machine and its set points, and gives torques u.
Each u is held over a period, which begins a dead time 0 <= Td <= T after the sample; a current loop follows it by
z' = (u - z)/lag.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from symoro_elastic.analysis.control.cascade import CURRENT, Cascade, DeadTime, FirstOrder
from symoro_elastic.analysis.control.drive_laws import INPUTS, TAU, XD, DriveLaw, current_loop
from symoro_elastic.analysis.control.sampled import period_of
from symoro_elastic.analysis.simulation.driven import DrivenMotion
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.drives.control import CONTROL, START
from symoro_elastic.numerics.implementations import numpy_model

SAME = 1e-9
"""Of a period: a dead time that is this near to it is a period."""


class Sample(NamedTuple):
    """What the controllers are given at a time t, s, and what they give; arrays (m,) of motors, (states,) of zc."""

    t: float
    measured: Array
    speed: Array
    r: Array
    rd: Array
    rdd: Array
    tau: Array
    zc: Array
    u: Array
    zc_next: Array


@dataclass
class Held:
    """The torques (m,) that are held from times on, s, and the samples that they come from."""

    times: list[float] = field(default_factory=list)
    torques: list[Array] = field(default_factory=list)
    samples: list[Sample] = field(default_factory=list)

    def at(self, t: Array) -> Array:
        """Return the torques (N, m) that are held at times (N,)."""
        if t[0] >= self.times[-1]:
            return np.tile(self.torques[-1], (len(t), 1))
        found: Array = np.array(self.torques)[np.searchsorted(self.times, t, side="right") - 1]
        return found


class Sampling:
    """The controllers of a motion: the intervals in which torques are held, and what they sample and give."""

    def __init__(self, reference: Reference) -> None:
        """Raises `InputError`."""
        self.reference = reference
        self.period = period_of(reference.drives, reference.machine.label)
        self.dead_times = [_dead_time(one, self.period, reference.machine) for one in reference.drives]
        code = numpy_model(reference.machine, (CONTROL, START))
        self._control: Any = code.control
        y, yd, ydd = (x[0] for x in reference.at(np.zeros(1)))
        self._states: Array = code.control_start(y, yd, ydd, reference.start.torques)
        self.held = self._at_start()

    def begun(self) -> Self:
        """Return the same from the start, with a record of its own."""
        other = copy.copy(self)
        other.held = self._at_start()
        return other

    def _at_start(self) -> Held:
        return Held([-np.inf], [self.reference.start.torques.copy()])

    @property
    def intervals(self) -> Iterator[tuple[float, float]]:
        """The times between which torques are held."""
        offsets, duration = self._offsets, self.reference.duration
        k, last = 0, 0.0
        while last < duration:
            times = [k * self.period + offset for offset in (*offsets[1:], self.period)]
            times[-1] = (k + 1) * self.period
            for t in times:
                ends = duration if t > duration * (1 - SAME) else t
                if last < duration:
                    yield last, ends
                last = ends
            k += 1

    @property
    def _offsets(self) -> list[float]:
        """Times after a sample at which torques change, the sample itself first."""
        return sorted({0.0, *(dead for dead in self.dead_times if dead < self.period)})

    def hold(self, number: int, t: float, read: Callable[[], tuple[Array, Array]]) -> None:
        """Take the interval of this number, which begins at t: sample positions and speeds (m,), hold what is due."""
        offsets, held = self._offsets, self.held
        at = offsets[number % len(offsets)]
        torques = held.torques[-1].copy()
        if at == 0:
            before = held.samples[-1].u if held.samples else held.torques[0]
            due = [k for k, dead in enumerate(self.dead_times) if dead == self.period]
            torques[due] = before[due]
            held.samples.append(self._sample(t, *read()))
        due = [k for k, dead in enumerate(self.dead_times) if dead == at]
        torques[due] = held.samples[-1].u[due]
        held.times.append(t)
        held.torques.append(torques)

    def _sample(self, t: float, measured: Array, speed: Array) -> Sample:
        """Return what the controllers read and give at t."""
        (r,), (rd,), (rdd,) = self.reference.at(np.array([t]))
        zc = self.held.samples[-1].zc_next if self.held.samples else self._states
        read = (measured, speed, r, rd, rdd, self.reference.fed_torques(np.array([t]))[0], zc)
        u, zc_next = self._control(*read)
        return Sample(t, *read, u, zc_next)


class SampledMotion(Sampling, DrivenMotion):
    """The right side of a motion between samples; y = [q; qd; z], torques of current loops in order of motors."""

    explicit = "RK45"
    """Intervals are short, and every one costs a start."""

    def __init__(self, reference: Reference, folder: Path) -> None:
        """Raises `InputError`, `CompilerMissing`, `CompilationFailed`."""
        Sampling.__init__(self, reference)
        self.lags = np.array([_lag(one) for one in reference.drives])
        DrivenMotion.__init__(self, reference, folder)

    def laws(self) -> list[DriveLaw]:
        """Return the current loops, which are all that is between samples."""
        return [current_loop(one, lag) for one, lag in zip(self.reference.drives, self.lags, strict=True)]

    def begin(self, number: int, t: float, y: Array) -> None:
        """Take the interval of this number, which begins at t with y: sample, and hold what is due."""

        def read() -> tuple[Array, Array]:
            motion = self.states(np.array([t]), y[None], self.reference.at_start)
            x, (xd,) = self.of_motors(motion)
            return self.controlled(motion, x)[0], xd

        self.hold(number, t, read)

    def inputs(self, motion: Motion) -> Array:
        """Return the inputs (N, m, 6) of current loops: torques that are held, and the velocities of motors."""
        held = self.held.at(motion.t)
        found = np.zeros((*held.shape, len(INPUTS)))
        found[..., TAU] = held
        found[..., XD] = self.of_motors(motion)[1]
        return found


def _lag(one: Cascade) -> float:
    return sum(x.time for x in one.path if isinstance(x, FirstOrder) and x.name == CURRENT)


def _dead_time(one: Cascade, period: float, machine: Machine) -> float:
    dead = sum(x.time for x in one.path if isinstance(x, DeadTime))
    if dead > period * (1 + SAME):
        what = f"{dead:g} s is longer than the period, {period:g} s: give at most one period"
        raise InputError(machine.label, f"drives, {one.motor}, dead_time", what)
    return period if dead > period * (1 - SAME) else dead
