"""All gains together: the least peak of compliance at the tool, over positions, with loops at their distances.

With all responses of the machine under its first drives at a frequency, other drives are rows of a matrix (motors,
motors),

    T = R - R_first,  R = C (Kv P + s V) + s Y V,    tool by force = G_tt - G_tm (1 + T)^-1 T_t,

P and V being positions that are controlled and velocities of motors by their torques. (Responses without drives would
lose digits near 0 Hz, where the machine moves freely.) The distances of open loops are
quotients of determinants, |1 + L| = |det(1 + T)|/|det(1 + T_open)|, T_open without Kv in the row of a position loop,
without C in that of a velocity loop. So no system of the machine is solved while gains are sought, and slopes by
logarithms of gains are exact: d ln det(1 + T) = tr((1 + T)^-1 dT).

The peak over frequencies, outputs and positions is a minimax problem: each step is a linear programme of the extremes
that count, within a trust region (Madsen 1975). At its end extremes between frequencies are solved for, join the
others, and the search goes on until they meet their distances.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade, laplace
from symoro_elastic.analysis.control.closed_loop import closed_loop
from symoro_elastic.analysis.control.largest_gain import refined_minimum
from symoro_elastic.analysis.control.loops import AxisLoops, OpenAxis, loops_of
from symoro_elastic.analysis.control.plant import Plant, position_row
from symoro_elastic.analysis.control.sampled import sampled_loop
from symoro_elastic.analysis.control.tuning import Distances
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.signals import output_unit

FIRST, LARGEST, LEAST = 0.2, 0.5, 1e-5
"""Trust region of the logarithms of gains: at first, at most, and where the search ends."""
MOST_STEPS, ROUNDS = 120, 4
CLOSE_DISTANCE, CLOSE_PEAK = 0.7, 0.7
"""Of logarithms: extremes that are farther from counting than this are left out of a step."""
PRICE = 20.0
"""Of a distance that is not kept, in logarithms of the peak."""
GAINED, MET = 1e-6, 1e-6
"""Of the logarithm of the peak, by a step; of distances, where extremes between frequencies end the search."""
TIE = 1e-4
"""Of the logarithm of a gain: gains that change nothing else rise, or stay."""
RANGE = np.log(1e4)
"""Of the logarithm of a gain about its start."""


@dataclass(frozen=True)
class Optimum:
    """Drives with their gains, and the largest peak of compliance over positions, before and with them."""

    cascades: tuple[Cascade, ...]
    before: float
    peak: float

    def told(self, outputs: Sequence[str]) -> str:
        """Return a line about the peak."""
        change = f"{self.peak:.4g} m/N or rad/(N m), {self.before:.4g} where gains are sought one by one"
        return f"optimum of {', '.join(one.motor for one in self.cascades)}: peak of {', '.join(outputs)} {change}"


@dataclass(frozen=True)
class _Extremes:
    """Logarithms of extremes (n,) and their slopes (n, gains)."""

    values: Array
    slopes: Array


def optimum(
    plants: Sequence[Plant], cascades: Sequence[Cascade], distances: Distances, outputs: Sequence[str]
) -> Optimum:
    """Return the drives with the gains that are sought at the least peak of the compliances of outputs.

    `cascades` have gains to begin with, at which the loops are stable. Raises `InputError`.
    """
    search = _Search(tuple(_Responses.of(plant, cascades, outputs) for plant in plants), tuple(cascades), distances)
    x, found = search.start, search.at(search.start)
    before = found.peak
    for _ in range(ROUNDS):
        x, found = search.descended(x, found)
        if not search.refine(x):
            break
        found = search.at(x)
    return Optimum(search.drives(x), float(np.exp(before)), float(np.exp(found.peak)))


@dataclass(frozen=True)
class _Responses:
    """Responses under drives that are `first` at frequencies (F,), by torques of m motors and forces at o outputs."""

    plant: Plant
    first: tuple[Cascade, ...]
    outputs: tuple[str, ...]
    frequencies: Array
    P: ComplexArray
    V: ComplexArray
    P_t: ComplexArray
    V_t: ComplexArray
    G_tm: ComplexArray
    G_tt: ComplexArray

    @classmethod
    def of(cls, plant: Plant, cascades: Sequence[Cascade], outputs: Sequence[str]) -> _Responses:
        """Return them at frequencies that are close to each other about the poles of the machine and of the loops."""
        fastest = min((one.time for drive in cascades for one in drive.path if one.time), default=0.0)
        axis = OpenAxis(plant, cascades[0].motor, tuple(cascades), fastest)
        return cls.at(plant, cascades, tuple(outputs), axis.frequencies)

    @classmethod
    def at(cls, plant: Plant, cascades: Sequence[Cascade], outputs: tuple[str, ...], frequencies: Array) -> _Responses:
        """Return them at frequencies in Hz."""
        axes, m = [plant.axes[one.motor] for one in cascades], len(cascades)
        tool = [position_row(plant.linear, name) for name in outputs]
        p, v = np.array([axis.position for axis in axes]), np.array([axis.velocity for axis in axes])
        moved = plant.moved(laplace(frequencies), cascades, np.vstack([v, *tool]).T)
        by_torque, by_force = moved[:, :, :m], moved[:, :, m:]
        own = np.einsum("on,fno->fo", np.array(tool), by_force)
        of_motors = (p @ by_torque, v @ by_torque, p @ by_force, v @ by_force)
        return cls(plant, tuple(cascades), outputs, frequencies, *of_motors, np.array(tool) @ by_torque, own)

    @cached_property
    def taken(self) -> ComplexArray:
        """R (F, m, m + o) of the first drives."""
        by_position, by_velocity, by_current = _Closed(self, self.first).parts
        return by_position + by_velocity + by_current

    def joined(self, other: _Responses) -> _Responses:
        """Return both together, in order of frequencies."""
        order = np.argsort(np.concatenate([self.frequencies, other.frequencies]), kind="stable")
        names = ("frequencies", "P", "V", "P_t", "V_t", "G_tm", "G_tt")
        both: dict[str, Any] = {
            name: np.concatenate([getattr(self, name), getattr(other, name)])[order] for name in names
        }
        return replace(self, **both)

    def part(self, at: Array) -> _Responses:
        """Return those at frequencies of these numbers."""
        names = ("frequencies", "P", "V", "P_t", "V_t", "G_tm", "G_tt")
        kept: dict[str, Any] = {name: getattr(self, name)[at] for name in names}
        return replace(self, **kept)


@dataclass(frozen=True)
class _Closed:
    """Drives around responses: rows of T, and what changes them."""

    of: _Responses
    cascades: tuple[Cascade, ...]

    @cached_property
    def s(self) -> ComplexArray:
        """2 pi i f."""
        return laplace(self.of.frequencies)

    @cached_property
    def parts(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Rows (F, m, m + o), torques of motors and forces at outputs: C Kv P, C s V, s Y V."""
        s = self.s
        C = np.stack([one.controller(s) for one in self.cascades], axis=1)[:, :, None]
        none = np.zeros_like(s)
        Y = np.stack([one.current.dragged(s) if one.current else none for one in self.cascades], axis=1)[:, :, None]
        Kv = np.array([one.Kv for one in self.cascades])[None, :, None]
        P = np.concatenate([self.of.P, self.of.P_t], axis=2)
        V = s[:, None, None] * np.concatenate([self.of.V, self.of.V_t], axis=2)
        return C * Kv * P, C * V, Y * V

    def rows(self, axis: int | None = None, without: str = "") -> ComplexArray:
        """Return T and T_t (F, m, m + o); in the row of an axis `without` "Kv", or "C"."""
        by_position, by_velocity, by_current = self.parts
        found: ComplexArray = by_position + by_velocity + by_current
        if axis is not None:
            rest = by_current + (by_velocity if without == "Kv" else 0)
            found[:, axis] = rest[:, axis]
        changed: ComplexArray = found - self.of.taken
        return changed

    def changes(self, axis: int, key: str) -> ComplexArray:
        """Return dT and dT_t (F, m + o), the row of an axis, by the logarithm of one of its gains, 1/Tn for Tn."""
        by_position, by_velocity, _ = (part[:, axis] for part in self.parts)
        if key == "Kv":
            return by_position
        if key == "Kp":
            return by_position + by_velocity
        rate = 1 / (self.cascades[axis].Tn * self.s)
        found: ComplexArray = (rate / (1 + rate))[:, None] * (by_position + by_velocity)
        return found

    @property
    def m(self) -> int:
        """Number of drives."""
        return len(self.cascades)

    def matrix(self, axis: int | None = None, without: str = "") -> ComplexArray:
        """Return 1 + T (F, m, m)."""
        found: ComplexArray = np.eye(self.m) + self.rows(axis, without)[:, :, : self.m]
        return found

    def distance(self, axis: int, loop: str) -> Array:
        """Return ln |1 + L| (F,) of the "velocity" or the "position" loop of an axis."""
        around, left = self._determinants(axis, loop)
        found: Array = np.log(np.abs(np.linalg.det(around) / np.linalg.det(left)))
        return found

    def _determinants(self, axis: int, loop: str) -> tuple[ComplexArray, ComplexArray]:
        inner = self.matrix(axis, "Kv")
        return (self.matrix(), inner) if loop == "position" else (inner, self.matrix(axis, "C"))

    def distance_slopes(self, axis: int, loop: str, keys: Sequence[tuple[int, str]]) -> Array:
        """Return the slopes (F, gains) of these logarithms."""
        inverses = [np.linalg.inv(matrix) for matrix in self._determinants(axis, loop)]
        left_out = ("", "Kv") if loop == "position" else ("Kv", "C")
        found = np.zeros((len(self.s), len(keys)))
        for k, (j, key) in enumerate(keys):
            for sign, inverse, without in zip((1, -1), inverses, left_out, strict=True):
                change = self.changes(j, key)
                if j == axis and without:
                    change = change - self._of_position(j, key) if without == "Kv" else np.zeros_like(change)
                found[:, k] += sign * np.einsum("fm,fm->f", change[:, : self.m], inverse[:, :, j]).real
        return found

    def _of_position(self, axis: int, key: str) -> ComplexArray:
        """Return the share of Kv in a change."""
        by_position = self.parts[0][:, axis]
        if key != "Tn":
            return by_position
        rate = 1 / (self.cascades[axis].Tn * self.s)
        found: ComplexArray = (rate / (1 + rate))[:, None] * by_position
        return found

    def compliance(self, output: int) -> ComplexArray:
        """Return the displacement (F,) of an output by a force there."""
        pushed = self._pushed(output)
        found: ComplexArray = self.of.G_tt[:, output] - np.einsum("fm,fm->f", self.of.G_tm[:, output], pushed)
        return found

    def _pushed(self, output: int) -> ComplexArray:
        right = self.rows()[:, :, self.m + output, None]
        found: ComplexArray = np.asarray(np.linalg.solve(self.matrix(), right)[:, :, 0], dtype=complex)
        return found

    def compliance_slopes(self, output: int, keys: Sequence[tuple[int, str]]) -> Array:
        """Return the slopes (F, gains) of the logarithm of its amount."""
        pushed, here = self._pushed(output), self.compliance(output)
        left = np.linalg.solve(self.matrix().transpose(0, 2, 1), self.of.G_tm[:, output, :, None])[:, :, 0]
        found = np.zeros((len(self.s), len(keys)))
        for k, (j, key) in enumerate(keys):
            change = self.changes(j, key)
            own = change[:, self.m + output] - np.einsum("fm,fm->f", change[:, : self.m], pushed)
            found[:, k] = (-left[:, j] * own / here).real
        return found


@dataclass(frozen=True)
class _Judged:
    """A point of the search: the logarithm of the largest peak, and by how much a distance is not kept, at most."""

    peak: float
    short: float

    @property
    def merit(self) -> float:
        """What gets less in each step."""
        return self.peak + PRICE * self.short


@dataclass
class _Search:
    """The search for gains: logarithms x (gains,) of Kp, Kv and 1/Tn of the axes that are sought."""

    responses: tuple[_Responses, ...]
    cascades: tuple[Cascade, ...]
    distances: Distances

    @property
    def keys(self) -> list[tuple[int, str]]:
        """Axis and name of each gain."""
        return [(j, key) for j, one in enumerate(self.cascades) for key in one.sought]

    @property
    def start(self) -> Array:
        """x at the gains that are given."""
        numbers = [(key, getattr(self.cascades[j], key)) for j, key in self.keys]
        return np.array([np.log(1 / x if key == "Tn" else x) for key, x in numbers])

    def drives(self, x: Array) -> tuple[Cascade, ...]:
        """Return the drives with gains x."""
        gains: list[dict[str, float]] = [{} for _ in self.cascades]
        for (j, key), value in zip(self.keys, np.exp(x).tolist(), strict=True):
            gains[j][key] = 1 / value if key == "Tn" else value
        return tuple(one.with_gains(**changed) for one, changed in zip(self.cascades, gains, strict=True))

    def wanted(self, loop: str) -> float:
        """Return the logarithm of the distance of a loop."""
        return float(np.log(getattr(self.distances, loop)))

    def _rows(self, drives: tuple[Cascade, ...]) -> list[tuple[_Closed, list[Array], list[Array]]]:
        """Return each position with ln distances over wanted ones, and ln compliances, all (F,)."""
        found = []
        for one in self.responses:
            closed = _Closed(one, drives)
            distances = [closed.distance(j, loop) - self.wanted(loop) for j, loop in self.loops]
            peaks = [np.log(np.abs(closed.compliance(o))) for o in range(len(one.outputs))]
            found.append((closed, distances, peaks))
        return found

    @property
    def loops(self) -> list[tuple[int, str]]:
        """Axis and name of each loop with a gain that is sought."""
        return [(j, loop) for j, one in enumerate(self.cascades) if one.sought for loop in ("velocity", "position")]

    def at(self, x: Array) -> _Judged:
        """Return the peak and the distances at gains x."""
        rows = self._rows(self.drives(x))
        short = max(-min(float(d.min()) for _, distances, _ in rows for d in distances), 0.0)
        return _Judged(max(float(c.max()) for _, _, peaks in rows for c in peaks), short)

    def extremes(self, x: Array) -> tuple[_Extremes, _Extremes]:
        """Return the least distances over wanted ones, and the largest compliances, with their slopes."""
        kept: list[list[tuple[Array, Array]]] = [[], []]
        rows = self._rows(self.drives(x))
        top = max(float(c.max()) for _, _, peaks in rows for c in peaks)
        for closed, distances, peaks in rows:
            for (j, loop), values in zip(self.loops, distances, strict=True):
                at = _dips(values, CLOSE_DISTANCE)
                part = _Closed(closed.of.part(at), closed.cascades)
                kept[0].append((values[at], part.distance_slopes(j, loop, self.keys)))
            for o, values in enumerate(peaks):
                at = _dips(-values, CLOSE_PEAK - top)
                part = _Closed(closed.of.part(at), closed.cascades)
                kept[1].append((values[at], part.compliance_slopes(o, self.keys)))
        found = [_Extremes(*map(np.concatenate, zip(*one, strict=True))) for one in kept]
        return found[0], found[1]

    def descended(self, x: Array, here: _Judged) -> tuple[Array, _Judged]:
        """Return gains from which no step leads further down, and what they give."""
        radius, first = FIRST, self.start
        for _ in range(MOST_STEPS):
            step, gain = self._step(x, here, radius, first)
            if gain < GAINED or radius < LEAST:
                break
            there = self.at(x + step)
            ratio = (here.merit - there.merit) / gain
            if ratio > 0.1 and self.is_stable(x + step):
                x, here = x + step, there
                radius = min(2 * radius, LARGEST) if ratio > 0.7 else radius
            else:
                radius /= 3
        return x, here

    def _step(self, x: Array, here: _Judged, radius: float, first: Array) -> tuple[Array, float]:
        """Return the step of the linear programme, and what it promises: dx, ln peak, what distances lack."""
        distances, peaks = self.extremes(x)
        n = len(x)
        A = np.vstack([
            np.hstack([peaks.slopes, -np.ones((len(peaks.values), 1)), np.zeros((len(peaks.values), 1))]),
            np.hstack([-distances.slopes, np.zeros((len(distances.values), 1)), -np.ones((len(distances.values), 1))]),
        ])  # fmt: skip
        b = np.concatenate([-peaks.values, distances.values])
        cost = np.concatenate([np.full(n, -TIE), [1.0, PRICE]])
        low, high = np.maximum(-radius, first - RANGE - x), np.minimum(radius, first + RANGE - x)
        bounds = [*zip(low, high, strict=True), (None, None), (0, None)]
        found = for_vibrations("scipy.optimize").linprog(cost, A, b, bounds=bounds)
        if not found.success:
            return np.zeros(n), 0.0
        return found.x[:n], here.merit - float(cost[n:] @ found.x[n:])

    def is_stable(self, x: Array) -> bool:
        """Whether all motions die out at all positions."""
        drives = self.drives(x)
        plants = [one.plant for one in self.responses]
        return all((sampled_loop(one, drives) or closed_loop(one, drives)).growth < 0 for one in plants)

    def refine(self, x: Array) -> bool:
        """Add the extremes between frequencies; whether one of them is beyond those that were known."""
        found, drives = False, self.drives(x)
        refined = []
        for one, (_, distances, peaks) in zip(self.responses, self._rows(drives), strict=True):
            new: list[float] = []
            axes = loops_of(one.plant, drives)
            for (j, loop), values in zip(self.loops, distances, strict=True):
                new += self._between(one.frequencies, values, _distance_of(axes[j], loop, self.wanted(loop)))
            for o, values in enumerate(peaks):
                new += self._between(one.frequencies, -values, _peak_of(one, drives, o))
            found = found or bool(new)
            refined.append(one.joined(_Responses.at(one.plant, one.first, one.outputs, np.array(new))) if new else one)
        self.responses = tuple(refined)
        return found

    def _between(self, frequencies: Array, values: Array, of: Callable[[Array], Array]) -> list[float]:
        """Return the place of the lowest value between frequencies, where it is lower than what is known."""
        k = int(values.argmin())
        lowest, place = refined_minimum(of, frequencies, k)
        return [place] if lowest < values[k] - MET else []


def _distance_of(axis: AxisLoops, loop: str, wanted: float) -> Callable[[Array], Array]:
    def of(f: Array) -> Array:
        found: Array = np.log(np.abs(1 + axis.open_loops(f)[loop])) - wanted
        return found

    return of


def _peak_of(one: _Responses, drives: tuple[Cascade, ...], output: int) -> Callable[[Array], Array]:
    def of(f: Array) -> Array:
        closed = _Closed(_Responses.at(one.plant, one.first, one.outputs, f), drives)
        found: Array = -np.log(np.abs(closed.compliance(output)))
        return found

    return of


def _dips(values: Array, below: float) -> Array:
    """Return the numbers of values that are no higher than their neighbours and lower than `below`; of the lowest."""
    ends = np.concatenate([[np.inf], values, [np.inf]])
    is_dip = (values <= ends[:-2]) & (values <= ends[2:]) & (values < below)
    found: Array = np.union1d(np.flatnonzero(is_dip), [int(values.argmin())])
    return found


def refuse_mixed(motion: EquationsOfMotion, outputs: Sequence[str]) -> None:
    """Raise `InputError` for compliances of displacements and rotations, which have no largest one."""
    if len({output_unit(motion.given, name) for name in outputs}) > 1:
        what = f"{', '.join(outputs)} are displacements and rotations: name some of one kind by --compliance"
        raise InputError(motion.source, "--optimum", what)
