"""Stability lobes of a cut: the depth up to which waves that the tool leaves on the surface die out, by spindle speed.

The force along one direction is K b (h_0 + y(t - T) - y(t)): cutting coefficient K, width of the chip b, thickness h_0,
and the deflection y now and one tooth ago, T = 60/(teeth times speed). With the response Phi of y to the force the cut
is at the border of stability where

    1 + K b g(w) = 0,    g(w) = (1 - e^(-i w T)) Phi(i w)

that is at frequencies where g is real and negative; the least b there is the limit, and below -1/(2 K min Re Phi) all
speeds are stable (Tlusty; Altintas and Budak 1995). It is exact for forces of constant direction, as in turning.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade, laplace
from symoro_elastic.analysis.control.driven_machine import States, driven_machine
from symoro_elastic.analysis.control.loops import OpenAxis, least, mechanical_names
from symoro_elastic.analysis.control.plant import Plant, position_row, response_slopes
from symoro_elastic.analysis.control.tuning import USUAL, Distances
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion

PER_TURN = 60.0
"""Seconds in a minute: speeds are in turns per minute."""
IN_A_TURN, MOST_FREQUENCIES = 24, 100_000
"""Frequencies in each turn of e^(-i w T), at least, where there are no more."""
MOST_SOLVED = 4
"""Borders that are solved for at a speed, those of the least depths at the frequencies beside."""


@dataclass(frozen=True)
class Cut:
    """Cutting coefficient, N/m2, teeth; the outputs along which the force acts and the chip gets thicker."""

    coefficient: float
    teeth: int
    direction: str
    thickness: str


@dataclass(frozen=True)
class Lobe:
    """The limit at one position: `depths` (speeds,), m, and the frequencies of the waves, Hz, at each speed.

    `least` is the depth below which all speeds are stable, at the `frequency` of the waves; infinite where nothing
    limits it. `influences` are d ln least / d ln p by parameter.
    """

    place: Mapping[str, float]
    depths: Array
    waves: Array
    least: float
    frequency: float
    influences: Mapping[str, float]

    @property
    def strongest(self) -> list[tuple[str, float]]:
        """What the least depth depends on most, first the strongest."""
        return sorted(self.influences.items(), key=lambda pair: -abs(pair[1]))


@dataclass(frozen=True, repr=False)
class Lobes(Result):
    """Stability limits of a cut over spindle speeds, turns per minute, at positions of a machine."""

    machine: str
    cut: Cut
    speeds: Array
    places: tuple[Lobe, ...]
    notes: tuple[str, ...] = ()

    @property
    def worst(self) -> Array:
        """The depths (speeds,) that are stable at all positions, m."""
        found: Array = np.min([place.depths for place in self.places], axis=0)
        return found

    @property
    def headline(self) -> str:
        """Machine, directions and speeds."""
        ends = f"{self.speeds[0]:g} to {self.speeds[-1]:g} turns per minute"
        return f"Stability lobes of {self.machine}: {self.cut.direction}, {len(self.speeds)} speeds from {ends}"


def lobes_at(
    motion: EquationsOfMotion,
    states: States,
    cut: Cut,
    speeds: Array,
    damping: float = 0.0,
    distances: Distances = USUAL,
    progress: Progress = no_progress,
) -> Lobes:
    """Return the stability limits of a cut at some states; loops of drives are closed, other motors are held.

    Gains that the file leaves to tuning are found, at `distances`. Raises `InputError`.
    """
    refuse_wrong(cut, speeds, motion.source)
    whole = driven_machine(motion, states, distances, damping, False, (cut.direction, cut.thickness))
    places = []
    for k, plant in enumerate(whole.plants):
        places.append(lobe(plant, whole.cascades, cut, speeds))
        progress(k + 1, len(whole.plants))
    return Lobes(motion.machine.name, cut, speeds, tuple(places), whole.notes)


def refuse_wrong(cut: Cut, speeds: Array, source: str) -> None:
    """Raise `InputError` for a cut that is none, and for speeds that are none."""
    if not (cut.coefficient > 0 and np.isfinite(cut.coefficient)):
        raise InputError(source, "--cutting", f"{cut.coefficient:g} N/m2 is not above zero: steel has some 2e9")
    if not (len(speeds) and (speeds > 0).all() and np.isfinite(speeds).all()):
        raise InputError(source, "--speeds", "spindle speeds are numbers above zero, turns per minute")


def lobe(plant: Plant, cascades: Sequence[Cascade], cut: Cut, speeds: Array) -> Lobe:
    """Return the stability limits of a cut at one position, with the loops of drives closed."""
    tool = _Tool(plant, tuple(cascades), cut)
    grid = OpenAxis(plant, next(iter(plant.axes), ""), tuple(cascades), 0.0).frequencies
    longest = PER_TURN / (cut.teeth * float(speeds.min()))
    tried = np.union1d(grid, np.linspace(grid[0], grid[-1], _count(grid[-1] * IN_A_TURN * longest)))
    known = tool.response(tried)
    found = [tool.limit(tried, known, PER_TURN / (cut.teeth * speed)) for speed in speeds]
    lowest, frequency = least(lambda f: tool.response(f).real, grid)
    smallest = -1 / (2 * cut.coefficient * lowest) if lowest < 0 else np.inf
    depths, waves = (np.array(column) for column in zip(*found, strict=True))
    influences = tool.influences(frequency, lowest) if lowest < 0 else {}
    return Lobe(dict(plant.place), depths, waves, smallest, frequency, influences)


def _count(wanted: float) -> int:
    return int(min(max(wanted, 2), MOST_FREQUENCIES))


@dataclass(frozen=True)
class _Tool:
    """The response of the chip's thickness to the force on the tool."""

    plant: Plant
    cascades: tuple[Cascade, ...]
    cut: Cut

    @property
    def rows(self) -> tuple[Array, Array]:
        """Rows (n,) of the direction of the force and of the thickness."""
        linear = self.plant.linear
        return position_row(linear, self.cut.direction), position_row(linear, self.cut.thickness)

    def response(self, frequencies: Array) -> ComplexArray:
        """Return Phi at frequencies in Hz."""
        direction, thickness = self.rows
        return self.plant.response(laplace(frequencies), self.cascades, thickness, direction)

    def limit(self, tried: Array, known: ComplexArray, period: float) -> tuple[float, float]:
        """Return the least depth and the frequency of its waves for a tooth in each period, s.

        `known` is the response at the frequencies `tried`; where the border is crossed between two of them, those that
        are least there are solved for.
        """

        def g(f: Array) -> ComplexArray:
            return (1 - np.exp(-laplace(f) * period)) * self.response(f)

        before = (1 - np.exp(-laplace(tried) * period)) * known
        changes = np.flatnonzero(np.sign(before.imag[:-1]) * np.sign(before.imag[1:]) < 0)
        real = np.minimum(before.real[changes], before.real[changes + 1])
        solve = for_vibrations("scipy.optimize").brentq
        best = (np.inf, np.nan)
        for k in changes[np.argsort(real)][:MOST_SOLVED]:
            f = float(solve(lambda f: float(g(np.array([f]))[0].imag), tried[k], tried[k + 1], rtol=1e-13))
            at = float(g(np.array([f]))[0].real)
            best = min(best, (-1 / (self.cut.coefficient * at), f)) if at < 0 else best
        return best

    def influences(self, frequency: float, real: float) -> dict[str, float]:
        """Return d ln b / d ln p of the least depth -1/(2 K Re Phi) at its frequency: -d Re Phi/Re Phi."""
        direction, thickness = self.rows
        s = complex(laplace(np.array([frequency]))[0])
        slopes = response_slopes(self.plant, s, self.cascades, thickness, direction)
        values = self.plant.linear.motion.parameters
        return {name: float(-values[name] * slopes[name].real / real) for name in mechanical_names(self.plant)}
