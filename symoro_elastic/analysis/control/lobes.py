"""Stability lobes of a cut: the largest depth without regenerative chatter, by spindle speed.

Forces are F = K b W (y(t) - y(t - T)), of the deflections now and one tooth ago (`cutting`). With the response Phi of
the deflections to the forces the cut is at the border of stability where

    1 + K b (1 - e^(-i w T)) L(w) = 0,    L an eigenvalue of -W Phi(i w)

that is at frequencies where the product is real and negative; the least b there is the limit, and below
-1/(2 K min Re L) all speeds are stable (Tlusty; Altintas and Budak 1995). It is exact for forces of constant direction,
as in turning, L = Phi. In milling W is the mean of what changes as teeth turn: for that change, `semi_discretization`.

The border of stability of a cut with forces that change within the time between teeth, by semi-discretization.

With x' = A x + B F of the machine and its closed loops, y = C x and F = K b W(t) (y(t) - y(t - T)), the time T between
teeth is divided into N intervals h. In each of them W is its mean, and y(t - T) the polynomial of degree 3 through its
values at four of their ends, the two of the interval and one on either side:

    x_k+1 = P_k x_k + sum_i R_ki y_k-N+i,   i = -1 ... 2,
    P_k = e^(A_k h),   R_ki = -int_0^h e^(A_k (h - s)) l_i(s/h) ds K b B W_k

A_k = A + K b B W_k C, l_i the polynomials of Lagrange. The cut is stable where all eigenvalues of the map over T, of x
and the last N + 1 values of y, are within the unit circle (Insperger and Stepan 2002, 2004, who take the mean of two
values: with the polynomial errors in turning fall with the fourth power of h, in milling with the square of it, by W).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.analysis.control.borders import branches, least_deep
from symoro_elastic.analysis.control.cascade import Cascade, laplace
from symoro_elastic.analysis.control.closed_loop import ClosedLoop, closed_loop
from symoro_elastic.analysis.control.cutting import Cut, refuse_wrong, sign_and_name
from symoro_elastic.analysis.control.driven_machine import States, driven_machine, is_undamped, refuse_undamped
from symoro_elastic.analysis.control.loops import OpenAxis
from symoro_elastic.analysis.control.plant import Plant, Row, position_row, response_slopes
from symoro_elastic.analysis.control.sampled import sampled_loop
from symoro_elastic.analysis.control.tuning import AT_USUAL_DISTANCES
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion

FIRST_WAVE, BEYOND = 0.1, 60
"""Waves between two teeth at the lowest frequency; frequencies below and above those about poles."""
GROWS = 1e-7
"""Of the fastest pole: a motion that grows by less does not."""
BESIDE_POLE, FELT = (1e-9, 1e-3), 100.0
"""Relative distances to a pole without damping, and the least ratio of responses there where the tool feels it."""
IN_A_WAVE = 8
"""Intervals of a semi-discretization in a wave: with fewer its depth is off by more than some 1 %."""
PARTS, CHANGING = 64, 0.1
"""Of the time between teeth, in which factors are compared, and of their mean: a smaller change does not matter."""
FIRST, RATIO, HIGHEST = 0.5, 1.25, 8.0
"""Depths that are tried, of the one of the zeroth-order theory: from, by steps of, up to."""
NOTHING = 1e-4
"""Of that depth: the least that counts as a cut."""
EXACT = 1e-6
"""Relative error of a depth, in addition to that of the intervals."""
NODES = 4
"""Values of y that a polynomial goes through."""
DERIVATIVES = np.array([[0, 6, 0, 0], [-2, -3, 6, -1], [3, -6, 3, 0], [-3, 9, -9, 3]]) / np.array([[6], [6], [3], [3]])
"""Of the polynomials of Lagrange through -1, 0, 1, 2 (columns) at 0: value and first to third derivative (rows)."""


@dataclass(frozen=True)
class Lobe:
    """The limit at one position: `depths` (speeds,), m, and chatter frequencies, Hz, at each speed.

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
        """Influences on the least depth, the strongest first."""
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
        """Depths (speeds,) that are stable at all positions, m; by semi-discretization if it was computed."""
        depths = [place.depths if place.periodic is None else place.periodic for place in self.places]
        return np.asarray(np.min(depths, axis=0))

    @property
    def headline(self) -> str:
        """Name of the machine, directions and speeds."""
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
    """Return the stability limits of a cut at some states; loops of drives are closed, other motors are locked.

    Gains that the file leaves to tuning are found, at the usual distances. With `intervals` there are also depths by
    semi-discretization. Raises `InputError`.
    """
    refuse_wrong(cut, speeds, motion.given)
    driven = driven_machine(motion, states, AT_USUAL_DISTANCES, damping, cut.outputs)
    places: list[Lobe] = []
    for plant in driven.plants:
        place = lobe(plant, driven.cascades, cut, speeds)
        if intervals:
            place = with_periodic(place, plant, driven.cascades, cut, speeds, intervals)
        places.append(place)
        progress(len(places), len(driven.plants))
    notes = [*driven.notes, *(_coarse(places, cut, speeds, intervals) if intervals else _note_on_mean(cut))]
    notes += _unlimited_speeds(places)
    return Lobes(motion.machine.name, cut, speeds, tuple(places), tuple(notes))


def lobe(plant: Plant, cascades: Sequence[Cascade], cut: Cut, speeds: Array) -> Lobe:
    """Return the stability limits of a cut at one position, with the loops of drives closed."""
    loop, tool = closed_loop(plant, cascades), _Tool(plant, tuple(cascades), cut)
    _refuse_unstable(plant, cascades, loop)
    refuse_undamped(plant, tool.undamped_poles(loop.poles), "No depth is stable at most speeds")
    periods = cut.period(1.0) / speeds
    of_tool = branches(tool.eigenvalues, _grid(plant, cascades, periods))
    reals, waves = least_deep(of_tool, periods)
    lowest, frequency = min(branch.least for branch in of_tool)
    depths = np.full(len(speeds), np.inf)
    depths[reals < 0] = -1 / (2 * cut.coefficient * reals[reals < 0])
    if not lowest < 0:
        return Lobe(dict(plant.place), depths, waves, np.inf, np.nan, {})
    smallest = -1 / (2 * cut.coefficient * lowest)
    return Lobe(dict(plant.place), depths, waves, smallest, frequency, tool.influences(frequency))


def _grid(plant: Plant, cascades: Sequence[Cascade], periods: Array) -> Array:
    """Return frequencies in Hz, dense about each pole, down and up to the first wave between two teeth."""
    around_poles = OpenAxis(plant, next(iter(plant.axes), ""), tuple(cascades), 0.0).frequencies
    first, last = around_poles[[0, -1]]
    below = np.geomspace(min(first, FIRST_WAVE / periods.max()), first, BEYOND)
    above = np.geomspace(last, 2 * last + 2 / periods.min(), BEYOND)
    return np.unique(np.concatenate([below, around_poles, above]))


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
    depths = [periodic.limit(speed, b) if np.isfinite(b) else np.inf for speed, b in zip(speeds, near, strict=True)]
    return replace(place, periodic=np.array(depths))


def _coarse(places: Sequence[Lobe], cut: Cut, speeds: Array, intervals: int) -> list[str]:
    """Return a note if intervals of the semi-discretization are few per wave."""
    turns = max(float(np.nanmax(place.waves * cut.period(1.0) / speeds, initial=0.0)) for place in places)
    if not intervals < IN_A_WAVE * turns:
        return []
    return [f"{intervals} intervals are {intervals / turns:.2g} in a wave, fewer than {IN_A_WAVE}: give more of them"]


def _unlimited_speeds(places: Sequence[Lobe]) -> list[str]:
    """Return notes on speeds without a border of stability, and where semi-discretization ends its search."""
    limited = [place for place in places if np.isfinite(place.least)]
    deep = sum(np.isinf(place.depths).sum() for place in limited)
    periodic = [np.stack([place.depths, place.periodic]) for place in limited if place.periodic is not None]
    far = sum((np.isfinite(mean) & np.isinf(depth)).sum() for mean, depth in periodic)
    none = sum((depth == 0).sum() for _, depth in periodic)
    of_mean = "the depth by the mean of forces"
    notes = {
        f"{deep} speeds have no border of stability, so no limit": deep,
        f"{far} speeds are stable up to {HIGHEST:g} times {of_mean}: deeper cuts are not tried": far,
        f"{none} speeds are unstable at {NOTHING:g} of {of_mean}, printed as 0": none,
    }
    return [note for note, count in notes.items() if count]


def _note_on_mean(cut: Cut) -> list[str]:
    """Return a note if forces change as teeth turn, which the mean over a turn neglects."""
    mean = cut.factors()[0]
    change = float(np.abs(cut.factors(PARTS) - mean).max() / np.abs(mean).max())
    if change <= CHANGING:
        return []
    what = f"forces differ from their mean by up to {change:.0%} of it as teeth turn"
    return [f"{what}: depths at a speed may be far off, give --intervals, as 40"]


def _refuse_unstable(plant: Plant, cascades: Sequence[Cascade], loop: ClosedLoop) -> None:
    """Raise `InputError` if the loops are unstable without a cut, for which no border of stability exists."""
    if not len(loop.A):
        return
    growth = (sampled_loop(plant, cascades) or loop).growth
    if growth > GROWS * np.abs(loop.poles).max():
        at = "".join(f" at {name}={x:g}" for name, x in plant.place.items())
        what = f"without a cut a motion grows by {growth:.3g} 1/s{at}: see symoro-elastic control"
        raise InputError(plant.linear.motion.source, "drives", what)


@dataclass(frozen=True)
class _Tool:
    """Deflections of the tool by the forces on it, and the eigenvalues of a cut."""

    plant: Plant
    cascades: tuple[Cascade, ...]
    cut: Cut

    @property
    def _signs(self) -> list[list[tuple[float, str]]]:
        """Signs and names of the forces, and of the deflections."""
        return [[sign_and_name(name) for name in names] for names in (self.cut.forces, self.cut.deflections)]

    @cached_property
    def rows(self) -> tuple[Array, Array]:
        """Rows (m, n) of the directions of the forces, and of the deflections."""
        linear = self.plant.linear
        F, C = (np.array([sign * position_row(linear, name) for sign, name in pairs]) for pairs in self._signs)
        return F, C

    @cached_property
    def mean(self) -> Array:
        """The mean of W (m, m)."""
        return np.asarray(self.cut.factors()[0])

    def eigenvalues(self, frequencies: Array) -> ComplexArray:
        """Return the eigenvalues of -W Phi (frequencies, m) at frequencies in Hz."""
        forces, rows = self.rows
        responses = rows @ self.plant.displacements(laplace(frequencies), self.cascades, forces.T)
        matrix = -self.mean @ responses
        if matrix.shape[1] == 1:
            return matrix[:, 0]
        (a, b), (c, d) = matrix.transpose(1, 2, 0)
        middle, half = (a + d) / 2, np.sqrt((a - d) ** 2 / 4 + b * c)
        return np.asarray(np.stack([middle + half, middle - half], axis=1))

    def undamped_poles(self, poles: ComplexArray) -> ComplexArray:
        """Return the undamped poles, 1/s, that the tool's response contains and that make it large."""
        chosen = poles[is_undamped(poles)]
        near, far = (np.abs(self.eigenvalues(np.abs(chosen) / (2 * np.pi) * (1 + x))).max(axis=1) for x in BESIDE_POLE)
        return np.asarray(chosen[near > FELT * far])

    def influences(self, frequency: float) -> dict[str, float]:
        """Return d ln b / d ln p of the least depth -1/(2 K Re L) at its frequency: -d Re L/Re L.

        With left and right vectors l, r of -W Phi at L: dL = l* (-W dPhi) r/(l* r).
        """
        forces, rows = self.rows
        s = laplace(np.array([frequency]))
        matrix = -self.mean @ (rows @ self.plant.displacements(s, self.cascades, forces.T))[0]
        values, right = np.linalg.eig(matrix)
        k = int(values.real.argmin())
        left_vector, right = -(np.linalg.inv(right)[k] @ self.mean), right[:, k]
        of_forces, of_rows = (self._slopes(pairs) for pairs in self._signs)
        row, force = Row(left_vector @ rows, left_vector @ of_rows), Row(right @ forces, right @ of_forces)
        slopes = response_slopes(self.plant, complex(s[0]), self.cascades, row, force)
        repeated_names = {name for drive in self.cascades for name in drive.repeated_names}
        return {name: float(-x.real / values[k].real) for name, x in slopes.items() if x and name not in repeated_names}

    def _slopes(self, pairs: list[tuple[float, str]]) -> Array:
        """Derivatives (p, m, n) of rows of signals, by parameters."""
        return np.stack([sign * self.plant.signal(name).slopes for sign, name in pairs], axis=1)


@dataclass(frozen=True)
class TimePeriodicCut:
    """A machine with closed loops, x' = A x + B F and y = C x, under a cut, divided into `intervals`."""

    A: Array
    B: Array
    C: Array
    cut: Cut
    intervals: int

    def growth(self, depth: float, speed: float) -> float:
        """Return the logarithm of the largest multiplier over a tooth period: negative if stable."""
        step = self.cut.period(speed) / self.intervals
        n, m, N = len(self.A), len(self.C), self.intervals
        pushes = self.cut.coefficient * depth * self.B @ self.cut.factors(N)
        # The input and its derivatives by s/h, each the rate of the one before.
        together = np.zeros((N, n + NODES * m, n + NODES * m))
        together[:, :n, :n], together[:, :n, n : n + m] = (self.A + pushes @ self.C) * step, -pushes * step
        together[:, n:-m, n + m :] = np.eye((NODES - 1) * m)
        steps = for_vibrations("scipy.linalg").expm(together)
        by_value = np.einsum("kxjm,ji->kixm", steps[:, :n, n:].reshape(N, n, NODES, m), DERIVATIVES)
        # x and y_0 ... y_-N-1, over x_0 and y_-1 ... y_-N-1: columns of the map.
        size = n + (N + 1) * m
        x = np.eye(n, size)
        outputs = [*np.eye(size - n, size, n).reshape(N + 1, m, -1)[::-1], self.C @ x]
        for k in range(N):
            values = sum(by_value[k, i] @ outputs[k + i] for i in range(NODES))
            x = steps[k, :n, :n] @ x + values
            outputs.append(self.C @ x)
        # The last value of y is C x, which the next map has from x.
        monodromy = np.vstack([x, *outputs[-2 : -N - 3 : -1]])
        return float(np.log(np.abs(np.linalg.eigvals(monodromy)).max()))

    def limit(self, speed: float, near: float) -> float:
        """Return the least unstable depth, searched from that of the zeroth-order theory, `near`.

        Infinite where it is stable up to 8 times of it. Islands between depths that are tried, 25 % apart, may be left
        out.
        """
        low = FIRST * near
        while self.growth(low, speed) >= 0:
            low /= 2
            if low < NOTHING * near:
                return 0.0
        high = low
        while high < HIGHEST * near:
            low, high = high, high * RATIO
            if self.growth(high, speed) >= 0:
                solve = for_vibrations("scipy.optimize").brentq
                return float(solve(lambda b: self.growth(b, speed), low, high, rtol=EXACT, xtol=EXACT * high))
        return np.inf
