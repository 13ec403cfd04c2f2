"""Stability lobes of a cut: the depth up to which waves that the tool leaves on the surface die out, by spindle speed.

Forces are F = K b W (y(t) - y(t - T)), of the deflections now and one tooth ago (`cutting`). With the response Phi of
the deflections to the forces the cut is at the border of stability where

    1 + K b (1 - e^(-i w T)) L(w) = 0,    L an eigenvalue of -W Phi(i w)

that is at frequencies where the product is real and negative; the least b there is the limit, and below
-1/(2 K min Re L) all speeds are stable (Tlusty; Altintas and Budak 1995). It is exact for forces of constant direction,
as in turning, L = Phi. In milling W is the mean of what changes as teeth turn: for that change, `semi_discretization`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade, laplace
from symoro_elastic.analysis.control.closed_loop import closed_loop
from symoro_elastic.analysis.control.cutting import Cut, refuse_wrong
from symoro_elastic.analysis.control.driven_machine import States, driven_machine
from symoro_elastic.analysis.control.loops import OpenAxis, least, mechanical_names, roots
from symoro_elastic.analysis.control.plant import Plant, position_row, response_slopes
from symoro_elastic.analysis.control.sampled import sampled_loop
from symoro_elastic.analysis.control.semi_discretization import TimePeriodicCut
from symoro_elastic.analysis.control.tuning import USUAL
from symoro_elastic.foundation.array_types import AnyArray, Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion

IN_A_TURN, MOST_FREQUENCIES = 24, 100_000
"""Frequencies in each turn of e^(-i w T), at least, where there are no more."""
MOST_SOLVED = 4
"""Borders that are solved for at a speed, those of the least depths at the frequencies beside."""
NEAR = 0.7
"""Of the least real part at a border, by a straight line between frequencies: nearer to zero none is solved for."""
GROWS = 1e-7
"""Of the fastest pole: a motion that grows by less does not."""
REAL = 1e-6
"""Of a number at a border: a smaller imaginary part is none."""
IN_A_WAVE = 8
"""Intervals of a semi-discretization in a wave: with fewer its depth is off by more than some 1 %."""
PARTS, CHANGING = 64, 0.1
"""Of the time between teeth, in which factors are compared, and of their mean: a smaller change does not matter."""


@dataclass(frozen=True)
class Lobe:
    """The limit at one position: `depths` (speeds,), m, and the frequencies of the waves, Hz, at each speed.

    `least` is the depth below which all speeds are stable, at the `frequency` of the waves; infinite where nothing
    limits it. `influences` are d ln least / d ln p by parameter. `periodic` (speeds,) are the depths by
    semi-discretization, where they are wanted.
    """

    place: Mapping[str, float]
    depths: Array
    waves: Array
    least: float
    frequency: float
    influences: Mapping[str, float]
    periodic: Array | None = None

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
        """The depths (speeds,) that are stable at all positions, m: by semi-discretization where they are known."""
        each = [place.depths if place.periodic is None else place.periodic for place in self.places]
        found: Array = np.min(each, axis=0)
        return found

    @property
    def headline(self) -> str:
        """Machine, directions and speeds."""
        ends = f"{self.speeds[0]:g} to {self.speeds[-1]:g} turns per minute"
        return f"Stability lobes of {self.machine}: {', '.join(self.cut.forces)}, {len(self.speeds)} speeds from {ends}"


def lobes_at(
    motion: EquationsOfMotion,
    states: States,
    cut: Cut,
    speeds: Array,
    damping: float = 0.0,
    intervals: int | None = None,
    progress: Progress = no_progress,
) -> Lobes:
    """Return the stability limits of a cut at some states; loops of drives are closed, other motors are held.

    Gains that the file leaves to tuning are found, at the usual distances. With `intervals` there are also depths by
    semi-discretization. Raises `InputError`.
    """
    refuse_wrong(cut, speeds, motion.given)
    whole = driven_machine(motion, states, USUAL, damping, False, (*cut.forces, *cut.deflections))
    places: list[Lobe] = []
    for plant in whole.plants:
        place = lobe(plant, whole.cascades, cut, speeds)
        if intervals:
            place = with_periodic(place, plant, whole.cascades, cut, speeds, intervals)
        places.append(place)
        progress(len(places), len(whole.plants))
    notes = [*whole.notes, *(_coarse(places, cut, speeds, intervals) if intervals else _averaged(cut))]
    return Lobes(motion.machine.name, cut, speeds, tuple(places), tuple(notes))


def lobe(plant: Plant, cascades: Sequence[Cascade], cut: Cut, speeds: Array) -> Lobe:
    """Return the stability limits of a cut at one position, with the loops of drives closed."""
    _refuse_unstable(plant, cascades)
    tool = _Tool(plant, tuple(cascades), cut)
    grid = OpenAxis(plant, next(iter(plant.axes), ""), tuple(cascades), 0.0).frequencies
    longest = cut.period(float(speeds.min()))
    tried = np.union1d(grid, np.linspace(grid[0], grid[-1], _count(grid[-1] * IN_A_TURN * longest)))
    known = followed(tool.eigenvalues(tried))
    depths, waves = tool.limits(tried, known, cut.period(1.0) / speeds)
    lowest, frequency = least(lambda f: tool.eigenvalues(f).real.min(axis=1), grid)
    smallest = -1 / (2 * cut.coefficient * lowest) if lowest < 0 else np.inf
    influences = tool.influences(frequency) if lowest < 0 else {}
    return Lobe(dict(plant.place), depths, waves, smallest, frequency, influences)


def with_periodic(
    place: Lobe, plant: Plant, cascades: Sequence[Cascade], cut: Cut, speeds: Array, intervals: int
) -> Lobe:
    """Return a lobe with depths by semi-discretization."""
    loop, tool = closed_loop(plant, cascades), _Tool(plant, tuple(cascades), cut)
    forces, rows = tool.rows
    n = plant.free.shape[1]
    C = np.hstack([rows @ plant.free, np.zeros((len(rows), len(loop.A) - n))])
    periodic = TimePeriodicCut(loop.A, loop.by_force @ forces.T, C, cut, intervals)
    near = np.where(np.isfinite(place.depths), place.depths, place.least)
    found = [periodic.limit(speed, b) if np.isfinite(b) else np.inf for speed, b in zip(speeds, near, strict=True)]
    return replace(place, periodic=np.array(found))


def _coarse(places: Sequence[Lobe], cut: Cut, speeds: Array, intervals: int) -> list[str]:
    """Return a note where waves have few intervals."""
    turns = max(float(np.nanmax(place.waves * cut.period(1.0) / speeds, initial=0.0)) for place in places)
    if not intervals < IN_A_WAVE * turns:
        return []
    return [f"{intervals} intervals are {intervals / turns:.2g} in a wave, fewer than {IN_A_WAVE}: give more of them"]


def _averaged(cut: Cut) -> list[str]:
    """Return a note where forces change as teeth turn, which the mean over a turn leaves out."""
    mean = cut.factors()[0]
    change = float(np.abs(cut.factors(PARTS) - mean).max() / np.abs(mean).max())
    if change <= CHANGING:
        return []
    what = f"forces differ from their mean by up to {change:.0%} of it as teeth turn"
    return [f"{what}: depths at a speed may be far off, give --intervals, as 40"]


def _refuse_unstable(plant: Plant, cascades: Sequence[Cascade]) -> None:
    """Raise `InputError` where the loops are unstable without a cut: a border of stability has no meaning then."""
    loop = closed_loop(plant, cascades)
    if not len(loop.A):
        return
    growth = (sampled_loop(plant, cascades) or loop).growth
    if growth > GROWS * np.abs(loop.poles).max():
        at = "".join(f" at {name}={x:g}" for name, x in plant.place.items())
        what = f"without a cut a motion grows by {growth:.3g} 1/s{at}: see symoro-elastic control"
        raise InputError(plant.linear.motion.source, "drives", what)


def _count(wanted: float) -> int:
    return int(min(max(wanted, 2), MOST_FREQUENCIES))


def followed(values: ComplexArray) -> ComplexArray:
    """Return eigenvalues (frequencies, m), m one or two, in an order in which each of them changes least."""
    if values.shape[1] == 1:
        return values
    kept, crossed = (np.abs(values[1:] - values[:-1, order]).sum(axis=1) for order in ([0, 1], [1, 0]))
    is_crossed = np.concatenate([[False], np.cumsum(crossed < kept) % 2 == 1])
    return np.where(is_crossed[:, None], values[:, ::-1], values)


@dataclass(frozen=True)
class _Tool:
    """The deflections of the tool by the forces on it, and what a cut makes of them."""

    plant: Plant
    cascades: tuple[Cascade, ...]
    cut: Cut

    @cached_property
    def rows(self) -> tuple[Array, Array]:
        """Rows (m, n) of the directions of the forces, and of the deflections."""
        linear = self.plant.linear
        forces, deflections = self.cut.forces, self.cut.deflections
        return (
            np.array([position_row(linear, name) for name in forces]),
            np.array([position_row(linear, name) for name in deflections]),
        )

    @cached_property
    def mean(self) -> Array:
        """The mean of W (m, m)."""
        found: Array = self.cut.factors()[0]
        return found

    def eigenvalues(self, frequencies: Array) -> ComplexArray:
        """Return those of -W Phi (frequencies, m) at frequencies in Hz."""
        forces, rows = self.rows
        responses = rows @ self.plant.moved(laplace(frequencies), self.cascades, forces.T)
        whole = -self.mean @ responses
        if whole.shape[1] == 1:
            return whole[:, 0]
        (a, b), (c, d) = whole.transpose(1, 2, 0)
        middle, half = (a + d) / 2, np.sqrt((a - d) ** 2 / 4 + b * c)
        found: ComplexArray = np.stack([middle + half, middle - half], axis=1)
        return found

    def limits(self, tried: Array, known: ComplexArray, periods: Array) -> tuple[Array, Array]:
        """Return the least depths and the frequencies of their waves for a tooth in each of these periods, s.

        `known` are the eigenvalues at the frequencies `tried`; where a border is crossed between two of them, those
        that are least there are solved for.
        """
        crossed = [self._crossed(tried, known, period) for period in periods]
        of = np.repeat(np.arange(len(periods)), [len(one) for one in crossed])
        k, branch = np.concatenate(crossed).T

        def g(f: Array) -> ComplexArray:
            """The products at frequencies between numbers k and the next ones, by the eigenvalues that are near."""
            share = ((f - tried[k]) / (tried[k + 1] - tried[k]))[:, None]
            near = (1 - share) * known[k, branch][:, None] + share * known[k + 1, branch][:, None]
            values = self.eigenvalues(f)
            value = np.take_along_axis(values, np.abs(values - near).argmin(axis=1)[:, None], axis=1)[:, 0]
            return (1 - np.exp(-laplace(f) * periods[of])) * value

        f = roots(lambda f: g(f).imag, tried[k], tried[k + 1])
        at = g(f)
        is_border = (at.real < 0) & (np.abs(at.imag) < REAL * np.abs(at))
        depth = np.full(len(f), np.inf)
        depth[is_border] = -1 / (self.cut.coefficient * at.real[is_border])
        depths, waves = np.full(len(periods), np.inf), np.full(len(periods), np.nan)
        for i in np.argsort(-depth):
            if np.isfinite(depth[i]):
                depths[of[i]], waves[of[i]] = depth[i], f[i]
        return depths, waves

    def _crossed(self, tried: Array, known: ComplexArray, period: float) -> AnyArray:
        """Return (crossings, 2) numbers of frequencies and of eigenvalues behind which borders are crossed."""
        before = (1 - np.exp(-laplace(tried) * period))[:, None] * known
        changes = np.argwhere(np.sign(before.imag[:-1]) * np.sign(before.imag[1:]) < 0)
        low, high = before[:-1][tuple(changes.T)], before[1:][tuple(changes.T)]
        real = low.real - low.imag * (high.real - low.real) / (high.imag - low.imag)
        order = np.argsort(real)[:MOST_SOLVED]
        found: AnyArray = changes[order[real[order] <= NEAR * real.min(initial=0.0)]]
        return found

    def influences(self, frequency: float) -> dict[str, float]:
        """Return d ln b / d ln p of the least depth -1/(2 K Re L) at its frequency: -d Re L/Re L.

        With left and right vectors l, r of -W Phi at L: dL = l* (-W dPhi) r/(l* r).
        """
        forces, rows = self.rows
        s = laplace(np.array([frequency]))
        whole = -self.mean @ (rows @ self.plant.moved(s, self.cascades, forces.T))[0]
        values, right = np.linalg.eig(whole)
        k = int(values.real.argmin())
        left = np.linalg.inv(right)[k]
        slopes = response_slopes(self.plant, complex(s[0]), self.cascades, -(left @ self.mean) @ rows,
                                 right[:, k] @ forces)  # fmt: skip
        given = self.plant.linear.motion.parameters
        return {name: float(-given[name] * slopes[name].real / values[k].real) for name in mechanical_names(self.plant)}
