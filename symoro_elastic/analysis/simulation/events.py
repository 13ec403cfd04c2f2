"""Events of a motion: a joint reaches a position, or a velocity."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.motion.signals import JointSignal, entry_of, outputs

States = Callable[[Array], tuple[Array, Array]]
"""q, qd (N, n) at times (N,)."""
LOOKS = 9
"""Times within a step at which a level is looked for."""


@dataclass(frozen=True)
class Level:
    """A level of a joint's position or velocity: `signal` is its name, `k` the entry of q, `order` 0 or 1."""

    signal: str
    k: int
    order: int
    level: float

    def above(self, states: States, t: Array) -> Array:
        """Return the difference of the signal and its level at times (N,)."""
        return np.asarray(states(t)[self.order][:, self.k] - self.level)


@dataclass(frozen=True)
class Crossing:
    """A time, s, at which a signal crosses a level, upwards or downwards."""

    signal: str
    level: float
    t: float
    upwards: bool


def level_of(machine: Machine, signal: str, level: float) -> Level:
    """Return a level of a signal by its name; raises `InputError` for all but joint positions and velocities."""
    (source,) = outputs(machine, [signal])
    if not isinstance(source, JointSignal) or source.order > 1:
        name = machine.independent_joints[0].name
        what = f"{signal} is not a position or velocity of a joint: give {name}.q = X, or .qd"
        raise machine.error("--event", what)
    return Level(source.name, entry_of(machine, source), source.order, level)


class Watch:
    """Detector of level crossings in consecutive time intervals; touching a level is not a crossing."""

    def __init__(self, levels: Sequence[Level]) -> None:
        self.levels = levels
        self._last: dict[Level, tuple[float, float]] = {}

    def crossings(self, states: States, begins: float, ends: float) -> list[Crossing]:
        """Return the crossings between two times, in the order of time."""
        t = np.linspace(begins, ends, LOOKS)
        crossings = [crossing for level in self.levels for crossing in self._of(level, states, t)]
        return sorted(crossings, key=lambda crossing: crossing.t)

    def _of(self, level: Level, states: States, t: Array) -> Iterator[Crossing]:
        """Yield the crossings of a level between times; a signal at the level keeps its previous side."""
        for at, above in zip(t.tolist(), level.above(states, t).tolist(), strict=True):
            since, before = self._last.get(level, (at, above))
            if before * above < 0:
                search = for_vibrations("scipy.optimize").brentq
                t_crossing = search(lambda t: float(level.above(states, np.array([t]))[0]), since, at, xtol=1e-15)
                yield Crossing(level.signal, level.level, float(t_crossing), above > 0)
            if above:
                self._last[level] = at, above
