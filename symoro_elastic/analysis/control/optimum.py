"""Joint tuning: the gains of all drives with the least peak compliance over positions, at the required margins.

With all responses of the machine under its first drives at a frequency, other drives are rows of a matrix (motors,
motors),

    T = R - R_first,  R = C (Kv P + s V) + s Y V,    tool by force = G_tt - G_tm (1 + T)^-1 T_t,

P and V being positions that are controlled and velocities of motors by their torques. (Responses without drives would
lose digits near 0 Hz, where the machine moves freely.) The distances of open loops are
quotients of determinants, |1 + L| = |det(1 + T)|/|det(1 + T_open)|, T_open without Kv in the row of a position loop,
without C in that of a velocity loop. So no system of the machine is solved while gains are tuned, and slopes by
logarithms of gains are exact: d ln det(1 + T) = tr((1 + T)^-1 dT).

The peak over frequencies, outputs and positions is a minimax problem: each step is a linear programme of the extremes
that count, within a trust region (Madsen 1975). At its end extremes between frequencies are solved for, join the
others, and the search goes on until they meet their distances.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade, laplace
from symoro_elastic.analysis.control.closed_loop import closed_loop
from symoro_elastic.analysis.control.largest_gain import refined_minimum
from symoro_elastic.analysis.control.loops import AxisLoops, OpenAxis, loops_of
from symoro_elastic.analysis.control.plant import Plant, position_row
from symoro_elastic.analysis.control.sampled import sampled_loop
from symoro_elastic.analysis.control.tuning import Distances
from symoro_elastic.foundation.array_types import Array, ComplexArray, IndexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.signals import output_unit
from symoro_elastic.quantities.units import MICRO

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
BY_FREQUENCY = ("frequencies", "P", "V", "P_t", "V_t", "G_tm", "G_tt")
"""Fields of responses that have a row for each frequency."""
RANGE = np.log(1e4)
"""Of the logarithm of a gain about its start."""


@dataclass(frozen=True)
class Optimum:
    """Drives with their gains, and the largest peak of compliance over positions, before and with them."""

    cascades: tuple[Cascade, ...]
    before: float
    peak: float

    def summary(self, outputs: Sequence[str]) -> str:
        """Return a line about the peak before and after."""
        change = f"{MICRO * self.peak:.4g} um/N or urad/(N m), {MICRO * self.before:.4g}"
        subject = f"optimum of {', '.join(drive.motor for drive in self.cascades)}: peak of {', '.join(outputs)}"
        return f"{subject} {change} where gains are tuned one by one"


def optimum(
    plants: Sequence[Plant], cascades: Sequence[Cascade], distances: Distances, outputs: Sequence[str]
) -> Optimum:
    """Return the drives whose tuned gains minimize the largest peak compliance of the outputs.

    `cascades` have gains to begin with, at which the loops are stable. Raises `InputError`.
    """
    search = _Search(tuple(_Responses.of(plant, cascades, outputs) for plant in plants), tuple(cascades), distances)
    x, value = search.start, search.at(search.start)
    before = value.peak
    for _ in range(ROUNDS):
        x, value = search.descend(x, value)
        if not search.refine(x):
            break
        value = search.at(x)
    return Optimum(search.drives(x), float(np.exp(before)), float(np.exp(value.peak)))


@dataclass(frozen=True)
class _Responses:
    """Responses under the drives `first` at frequencies (F,), by torques of m motors and forces at o outputs."""

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
        """Return the responses at frequencies that are dense about the poles of the machine and of the loops."""
        fastest = min((element.time for drive in cascades for element in drive.path if element.time), default=0.0)
        axis = OpenAxis(plant, cascades[0].motor, tuple(cascades), fastest)
        return cls.at(plant, cascades, tuple(outputs), axis.frequencies)

    @classmethod
    def at(cls, plant: Plant, cascades: Sequence[Cascade], outputs: tuple[str, ...], frequencies: Array) -> _Responses:
        """Return the responses at frequencies in Hz."""
        axes, m = [plant.axes[drive.motor] for drive in cascades], len(cascades)
        tool = [position_row(plant.linear, name) for name in outputs]
        p, v = np.array([axis.position for axis in axes]), np.array([axis.velocity for axis in axes])
        moved = plant.displacements(laplace(frequencies), cascades, np.vstack([v, *tool]).T)
        by_torque, by_force = moved[:, :, :m], moved[:, :, m:]
        own = np.einsum("on,fno->fo", np.array(tool), by_force)
        of_motors = (p @ by_torque, v @ by_torque, p @ by_force, v @ by_force)
        return cls(plant, tuple(cascades), outputs, frequencies, *of_motors, np.array(tool) @ by_torque, own)

    @cached_property
    def return_matrix(self) -> ComplexArray:
        """Return difference minus 1, R (F, m, m + o), of the first drives."""
        by_position, by_velocity, by_current = _Closed(self, self.first).parts
        return by_position + by_velocity + by_current

    def join(self, other: _Responses) -> _Responses:
        """Return both sets of responses, in order of frequencies."""
        both: dict[str, Any] = {x: np.concatenate([getattr(self, x), getattr(other, x)]) for x in BY_FREQUENCY}
        return replace(self, **both).part(np.argsort(both["frequencies"], kind="stable"))

    def part(self, at: IndexArray) -> _Responses:
        """Return the responses at the frequencies with these indices."""
        arrays: dict[str, Any] = {x: getattr(self, x)[at] for x in BY_FREQUENCY}
        return replace(self, **arrays)


@dataclass(frozen=True)
class _Closed:
    """Drives that close loops on the responses: rows of the return difference minus 1, T, and slopes by gains."""

    of: _Responses
    cascades: tuple[Cascade, ...]

    @cached_property
    def s(self) -> ComplexArray:
        """Laplace variable s = 2 pi i f at the frequencies."""
        return laplace(self.of.frequencies)

    @cached_property
    def parts(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Rows (F, m, m + o) of position, velocity and current feedback: C Kv P, C s V, s Y V."""
        s = self.s
        C = np.stack([cascade.controller(s) for cascade in self.cascades], axis=1)[:, :, None]
        none = np.zeros_like(s)
        currents = [drive.current for drive in self.cascades]
        Y = np.stack([loop.drag_response(s) if loop else none for loop in currents], axis=1)[:, :, None]
        Kv = np.array([cascade.Kv for cascade in self.cascades])[None, :, None]
        P = np.concatenate([self.of.P, self.of.P_t], axis=2)
        V = s[:, None, None] * np.concatenate([self.of.V, self.of.V_t], axis=2)
        return C * Kv * P, C * V, Y * V

    def rows(self, axis: int | None = None, without: str = "") -> ComplexArray:
        """Return T and T_t (F, m, m + o), the row of an axis without its position loop ("Kv") or controller ("C")."""
        by_position, by_velocity, by_current = self.parts
        rows: ComplexArray = by_position + by_velocity + by_current
        if axis is not None:
            open_row = by_current + (by_velocity if without == "Kv" else 0)
            rows[:, axis] = open_row[:, axis]
        return np.asarray(rows - self.of.return_matrix)

    def changes(self, axis: int, key: str, without: str = "") -> ComplexArray:
        """Return d(T, T_t)/d ln g (F, m + o), the row of an axis by one of its gains g: Kp, Kv or 1/Tn.

        The row is `without` "Kv", or without "C".
        """
        by_position, by_velocity, _ = (part[:, axis] for part in self.parts)
        if without == "C":
            return np.zeros_like(by_position)
        rows: ComplexArray = (without != "Kv") * by_position + (key != "Kv") * by_velocity
        if key == "Tn":
            rows *= (1 / (1 + self.cascades[axis].Tn * self.s))[:, None]
        return rows

    @property
    def m(self) -> int:
        """Number of drives."""
        return len(self.cascades)

    def matrix(self, axis: int | None = None, without: str = "") -> ComplexArray:
        """Return the return difference 1 + T (F, m, m)."""
        return np.asarray(np.eye(self.m) + self.rows(axis, without)[:, :, : self.m])

    def distance(self, axis: int, loop: str) -> Array:
        """Return ln |1 + L| (F,) of the "velocity" or the "position" loop of an axis."""
        around, opened = self._determinants(axis, loop)
        return np.asarray(np.log(np.abs(np.linalg.det(around) / np.linalg.det(opened))))

    def _determinants(self, axis: int, loop: str) -> tuple[ComplexArray, ComplexArray]:
        inner = self.matrix(axis, "Kv")
        return (self.matrix(), inner) if loop == "position" else (inner, self.matrix(axis, "C"))

    def distance_slopes(self, axis: int, loop: str, keys: Sequence[tuple[int, str]]) -> Array:
        """Return d ln |1 + L| / d ln g (F, gains) of a loop of an axis at F frequencies; gains g are Kp, Kv or 1/Tn."""
        inverses = [np.linalg.inv(matrix) for matrix in self._determinants(axis, loop)]
        left_out = ("", "Kv") if loop == "position" else ("Kv", "C")
        slopes = np.zeros((len(self.s), len(keys)))
        for k, (j, key) in enumerate(keys):
            for sign, inverse, without in zip((1, -1), inverses, left_out, strict=True):
                change = self.changes(j, key, without if j == axis else "")
                slopes[:, k] += sign * np.einsum("fm,fm->f", change[:, : self.m], inverse[:, :, j]).real
        return slopes

    def compliance(self, output: int) -> ComplexArray:
        """Return the displacement (F,) of an output by a force there."""
        pushed = self._motor_torques(output)
        return np.asarray(self.of.G_tt[:, output] - np.einsum("fm,fm->f", self.of.G_tm[:, output], pushed))

    def _motor_torques(self, output: int) -> ComplexArray:
        right = self.rows()[:, :, self.m + output, None]
        return np.asarray(np.linalg.solve(self.matrix(), right)[:, :, 0], dtype=complex)

    def compliance_slopes(self, output: int, keys: Sequence[tuple[int, str]]) -> Array:
        """Return the slopes (F, gains) of ln |compliance| by the logarithms of gains."""
        pushed, here = self._motor_torques(output), self.compliance(output)
        adjoint = np.linalg.solve(self.matrix().transpose(0, 2, 1), self.of.G_tm[:, output, :, None])[:, :, 0]
        slopes = np.zeros((len(self.s), len(keys)))
        for k, (j, key) in enumerate(keys):
            change = self.changes(j, key)
            own = change[:, self.m + output] - np.einsum("fm,fm->f", change[:, : self.m], pushed)
            slopes[:, k] = (-adjoint[:, j] * own / here).real
        return slopes


class _Judged(NamedTuple):
    """A point of the search: the logarithm of the largest peak, and that plus the penalty of violated margins."""

    peak: float
    merit: float


@dataclass
class _Search:
    """The search for gains: logarithms x (gains,) of Kp, Kv and 1/Tn of the axes that are tuned."""

    responses: tuple[_Responses, ...]
    cascades: tuple[Cascade, ...]
    distances: Distances

    @property
    def keys(self) -> list[tuple[int, str]]:
        """Axes and names of the tuned gains."""
        return [(j, key) for j, cascade in enumerate(self.cascades) for key in cascade.tuned_gains]

    @property
    def start(self) -> Array:
        """The vector x of the present gains."""
        numbers = [(key, getattr(self.cascades[j], key)) for j, key in self.keys]
        return np.array([np.log(1 / x if key == "Tn" else x) for key, x in numbers])

    def drives(self, x: Array) -> tuple[Cascade, ...]:
        """Return the drives with gains x."""
        gains: list[dict[str, float]] = [{} for _ in self.cascades]
        for (j, key), value in zip(self.keys, np.exp(x).tolist(), strict=True):
            gains[j][key] = 1 / value if key == "Tn" else value
        return tuple(cascade.with_gains(**changed) for cascade, changed in zip(self.cascades, gains, strict=True))

    def required_distance(self, loop: str) -> float:
        """Return the logarithm of the required modulus margin of a loop."""
        return float(np.log(getattr(self.distances, loop)))

    def _rows(self, drives: tuple[Cascade, ...]) -> list[tuple[_Closed, list[Array], list[Array]]]:
        """Return for each position the closed loops, ln distances over required ones, and ln compliances, all (F,)."""
        rows = []
        for responses in self.responses:
            closed = _Closed(responses, drives)
            distances = [closed.distance(j, loop) - self.required_distance(loop) for j, loop in self.loops]
            peaks = [np.log(np.abs(closed.compliance(o))) for o in range(len(responses.outputs))]
            rows.append((closed, distances, peaks))
        return rows

    @property
    def loops(self) -> list[tuple[int, str]]:
        """Axes and names of the loops with a tuned gain."""
        tuned = [j for j, drive in enumerate(self.cascades) if drive.tuned_gains]
        return [(j, loop) for j in tuned for loop in ("velocity", "position")]

    def at(self, x: Array) -> _Judged:
        """Return the peak and the distances at gains x."""
        rows = self._rows(self.drives(x))
        short = max(-min(float(d.min()) for _, distances, _ in rows for d in distances), 0.0)
        peak = max(float(c.max()) for _, _, peaks in rows for c in peaks)
        return _Judged(peak, peak + PRICE * short)

    def extremes(self, x: Array) -> tuple[list[Array], list[Array]]:
        """Return logarithms (n,) and slopes (n, gains) of the least distances over required ones, and of peaks."""
        least: list[tuple[Array, Array]] = []
        largest: list[tuple[Array, Array]] = []
        rows = self._rows(self.drives(x))
        top = max(float(c.max()) for _, _, peaks in rows for c in peaks)
        for closed, distances, peaks in rows:
            for (j, loop), values in zip(self.loops, distances, strict=True):
                at = _dips(values, CLOSE_DISTANCE)
                part = _Closed(closed.of.part(at), closed.cascades)
                least.append((values[at], part.distance_slopes(j, loop, self.keys)))
            for o, values in enumerate(peaks):
                at = _dips(-values, CLOSE_PEAK - top)
                part = _Closed(closed.of.part(at), closed.cascades)
                largest.append((values[at], part.compliance_slopes(o, self.keys)))
        of_distances, of_peaks = ([*map(np.concatenate, zip(*x, strict=True))] for x in (least, largest))
        return of_distances, of_peaks

    def descend(self, x: Array, here: _Judged) -> tuple[Array, _Judged]:
        """Return the gains at which no step reduces the merit function, and their values."""
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
        """Return the step of the linear programme, and its predicted gain of merit."""
        (distances, slopes_of_distances), (peaks, slopes_of_peaks) = self.extremes(x)
        n = len(x)
        A = np.hstack([np.vstack([slopes_of_peaks, -slopes_of_distances]), np.zeros((len(peaks) + len(distances), 2))])
        A[: len(peaks), n], A[len(peaks) :, n + 1] = -1, -1
        b = np.concatenate([-peaks, distances])
        cost = np.concatenate([np.full(n, -TIE), [1.0, PRICE]])
        low, high = np.maximum(-radius, first - RANGE - x), np.minimum(radius, first + RANGE - x)
        bounds = [*zip(low, high, strict=True), (None, None), (0, None)]
        solution = for_vibrations("scipy.optimize").linprog(cost, A, b, bounds=bounds)
        if not solution.success:
            return np.zeros(n), 0.0
        return solution.x[:n], here.merit - float(cost[n:] @ solution.x[n:])

    def is_stable(self, x: Array) -> bool:
        """Whether all motions decay at all positions."""
        drives = self.drives(x)
        plants = [responses.plant for responses in self.responses]
        return all((sampled_loop(plant, drives) or closed_loop(plant, drives)).growth <= 0 for plant in plants)

    def refine(self, x: Array) -> bool:
        """Add the extremes between frequencies; return whether any of them exceeds the previous ones."""
        is_refined, drives = False, self.drives(x)
        refined = []
        for place, (_, distances, peaks) in zip(self.responses, self._rows(drives), strict=True):
            new: list[float] = []
            axes = loops_of(place.plant, drives)
            for (j, loop), values in zip(self.loops, distances, strict=True):
                distance = _distance_of(axes[j], loop, self.required_distance(loop))
                new += self._between(place.frequencies, values, distance)
            for o, values in enumerate(peaks):
                new += self._between(place.frequencies, -values, _peak_of(place, drives, o))
            is_refined = is_refined or bool(new)
            more = _Responses.at(place.plant, place.first, place.outputs, np.array(new)) if new else None
            refined.append(place.join(more) if more else place)
        self.responses = tuple(refined)
        return is_refined

    def _between(self, frequencies: Array, values: Array, of: Callable[[Array], Array]) -> list[float]:
        """Return the frequency of the refined minimum of `of`, if it is lower than all `values` at `frequencies`."""
        k = int(values.argmin())
        lowest, place = refined_minimum(of, frequencies, k)
        return [place] if lowest < values[k] - MET else []


def _distance_of(axis: AxisLoops, loop: str, required_distance: float) -> Callable[[Array], Array]:
    def of(f: Array) -> Array:
        return np.asarray(np.log(np.abs(1 + axis.open_loops(f)[loop])) - required_distance)

    return of


def _peak_of(responses: _Responses, drives: tuple[Cascade, ...], output: int) -> Callable[[Array], Array]:
    def of(f: Array) -> Array:
        closed = _Closed(_Responses.at(responses.plant, responses.first, responses.outputs, f), drives)
        return np.asarray(-np.log(np.abs(closed.compliance(output))))

    return of


def _dips(values: Array, below: float) -> IndexArray:
    """Return the indices of local minima below a bound, or of the least value."""
    ends = np.concatenate([[np.inf], values, [np.inf]])
    is_dip = (values <= ends[:-2]) & (values <= ends[2:]) & (values < below)
    return np.union1d(np.flatnonzero(is_dip), [int(values.argmin())])


def refuse_mixed(motion: EquationsOfMotion, outputs: Sequence[str]) -> None:
    """Raise `InputError` for compliances of displacements and of rotations together, which have no common maximum."""
    if len({output_unit(motion.given, name) for name in outputs}) > 1:
        what = f"{', '.join(outputs)} are displacements and rotations: name outputs of the same kind by --compliance"
        raise InputError(motion.source, "--optimum", what)
