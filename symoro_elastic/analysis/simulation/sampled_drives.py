"""Motions with sampled drives: the controllers' own code once in each period, and the machine between.

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

from symoro_elastic.analysis.control.cascade import CURRENT, FirstOrder
from symoro_elastic.analysis.control.drive_laws import INPUTS, TAU, XD, DriveLaw, current_loop
from symoro_elastic.analysis.control.sampled import dead_time_of, period_of
from symoro_elastic.analysis.simulation.driven import DrivenMotion
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.drives import SAME
from symoro_elastic.models.drives.control import CONTROL, START
from symoro_elastic.numerics.verification.implementations import numpy_model


class Sample(NamedTuple):
    """Inputs and outputs of the sampled controllers at a time t, s; arrays (m,) by motor, (states,) for zc."""

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
    """Zero-order hold of torques (m,): the times, s, from which each applies, and the samples."""

    times: list[float] = field(default_factory=list)
    torques: list[Array] = field(default_factory=list)
    samples: list[Sample] = field(default_factory=list)

    def at(self, t: Array) -> Array:
        """Return the held torques (N, m) at times (N,)."""
        if t[0] >= self.times[-1]:
            return np.tile(self.torques[-1], (len(t), 1))
        return np.asarray(np.array(self.torques)[np.searchsorted(self.times, t, side="right") - 1])


class Sampling:
    """Sampled controllers of a motion: hold intervals, samples and outputs."""

    def __init__(self, reference: Reference) -> None:
        """Prepare the controllers; raises `InputError` for those that cannot be sampled."""
        self.reference = reference
        source = reference.machine.label
        self.period = period_of(reference.drives, source)
        self.dead_times = [dead_time_of(drive, self.period, source) for drive in reference.drives]
        code = numpy_model(reference.machine, (CONTROL, START))
        self._control: Any = code.control
        y, yd, ydd = (x[0] for x in reference.at(np.zeros(1)))
        self._states: Array = code.control_start(y, yd, ydd, reference.start.torques)
        self.held = self._at_start()

    def copy_at_start(self) -> Self:
        """Return a copy at the start, with its own record."""
        other = copy.copy(self)
        other.held = self._at_start()
        return other

    def _at_start(self) -> Held:
        return Held([-np.inf], [self.reference.start.torques.copy()])

    @property
    def intervals(self) -> Iterator[tuple[float, float]]:
        """Time intervals of constant torques."""
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
        """Times after a sample at which torques change, including the sample itself."""
        return sorted({0.0, *(dead for dead in self.dead_times if dead < self.period)})

    def hold(self, number: int, t: float, read: Callable[[], tuple[Array, Array]]) -> None:
        """Start interval `number` at time t: sample positions and velocities (m,), update due torques."""
        offsets, history = self._offsets, self.held
        at = offsets[number % len(offsets)]
        torques = history.torques[-1].copy()
        if at == 0:
            before = history.samples[-1].u if history.samples else history.torques[0]
            due = [k for k, dead in enumerate(self.dead_times) if dead == self.period]
            torques[due] = before[due]
            history.samples.append(self._sample(t, *read()))
        due = [k for k, dead in enumerate(self.dead_times) if dead == at]
        torques[due] = history.samples[-1].u[due]
        history.times.append(t)
        history.torques.append(torques)

    def _sample(self, t: float, measured: Array, speed: Array) -> Sample:
        """Return the inputs and outputs of the controllers at t."""
        (r,), (rd,), (rdd,) = self.reference.at(np.array([t]))
        zc = self.held.samples[-1].zc_next if self.held.samples else self._states
        read = (measured, speed, r, rd, rdd, self.reference.fed_torques(np.array([t]))[0], zc)
        u, zc_next = self._control(*read)
        return Sample(t, *read, u, zc_next)


class SampledMotion(Sampling, DrivenMotion):
    """The right-hand side of a motion under sampled drives; y = [q; qd; z], z has states of current loops."""

    explicit = "RK45"
    """Intervals are short, and every one costs a start."""

    def __init__(self, reference: Reference, folder: Path) -> None:
        """Compile the motion; raises `InputError`, `CompilerMissing`, `CompilationFailed`."""
        Sampling.__init__(self, reference)
        paths = [drive.path for drive in reference.drives]
        self.lags = [sum(x.time for x in path if isinstance(x, FirstOrder) and x.name == CURRENT) for path in paths]
        DrivenMotion.__init__(self, reference, folder)

    def laws(self) -> list[DriveLaw]:
        """Return the current loops, the only continuous parts of the drives."""
        return [current_loop(drive, lag) for drive, lag in zip(self.reference.drives, self.lags, strict=True)]

    def begin(self, number: int, t: float, y: Array) -> None:
        """Start interval `number` at time t with state y: sample, and update due torques."""

        def read() -> tuple[Array, Array]:
            motion = self.states(np.array([t]), y[None], self.reference.at_start)
            x, (xd,) = self.of_motors(motion)
            return self.controlled(motion, x)[0], xd

        self.hold(number, t, read)

    def inputs(self, motion: Motion) -> Array:
        """Return the inputs (N, m, 6) of current loops: held torques, and velocities of motors."""
        torques = self.held.at(motion.t)
        inputs = np.zeros((*torques.shape, len(INPUTS)))
        inputs[..., TAU] = torques
        inputs[..., XD] = self.of_motors(motion)[1]
        return inputs
