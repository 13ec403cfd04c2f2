"""Natural frequencies of a model with changes: how far they are from those of the whole one, at positions of the box.

Where a direct model gives qdd(q, 0, tau), the machine at rest moves after d qdd = J dq + B dtau. With torques that hold
the motors m still, which the other joints p do not feel,

    d qdd_p = (J_pp - B_p B_m^-1 J_mp) dq_p = -S dq_p,

and the eigenvalues of S are omega^2 with motors held; those of -J with free motors. As many count, the largest:
the others are rigid, or swing by gravity alone (below the lowest held one, as held motors raise frequencies). An
inverse model has S = -d qdd_p / dq_p only. Derivatives are adjoints: exact. They are taken at the equilibrium of the
whole model for drawn positions of the motors: the other joints, and the torques of the motors, are as balance requires.

A change shifts a frequency from omega to the root of an eigenvalue, which is complex where the motion grows or decays,
and zero where it does not swing any more: the distance of both is the shift. A search orders and sums the shifts of
single changes to first order, and computes those of all changes together once a pass.

To first order, for S x = lambda x, y' S = lambda y' and y' x = 1 an eigenvalue moves by d lambda = y' dS x, and

    -dS x = (dJ_pp - B_p B_m^-1 dJ_mp) x - (dB_p - B_p B_m^-1 dB_m) H x,        H = B_m^-1 J_mp,

so d lambda = -w' d(qdd_d): the change of the derivative of accelerations in the direction d (x for positions, -H x for
torques), weighted by w (y for passive joints, -y' B_p B_m^-1 for motors). With free motors S = -J, d = x and w = y.

A change that moves the value of its node by e moves w' qdd by a e, where a is the adjoint of w' qdd; the derivative of
that in the direction d is a central difference: effects are needed at two states for each mode and position, and one
sweep back along the tape finds those of all changes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array, BoolArray
from symoro_elastic.machine.within import Tolerance
from symoro_elastic.numerics.evaluation.quantile_bound import bound_of_more
from symoro_elastic.numerics.within.effects import Adjoints, Sweep, node_shift
from symoro_elastic.numerics.within.states import Bounds
from symoro_elastic.numerics.within.tape import NO_CHANGES, Change, Changes, Tape
from symoro_elastic.symbolic.program import Program

POSITIONS, WATCHED, JOINING = 1000, 8, 8
"""Positions at which a reduced program is judged; at which a search looks; how many of the worst join these."""
BLOCK = 250
SLACK, LEAST = 0.98, 0.5
"""The limit of a search is lowered to this fraction of what would do; at least by this factor."""
LEFT_OVER = 0.95
"""With less of the tolerance used, the limit of a search is raised."""
STEPS, CLOSE = 8, 1e-6
"""Of Newton's method; accelerations that are left at an equilibrium, of the first ones."""
SMALLEST = 1e-300
STILL = 1e-9
"""Of the largest eigenvalue: a motion without stiffness."""
LOST = 0.999
"""Of a frequency: so large a shift is the loss of a mode, whatever is allowed."""
STEP = 1e-5
"""Of the central difference: radians or metres of the joint that moves most."""


@dataclass(frozen=True)
class NaturalFrequencies:
    """The tolerance of natural frequencies; `motors` are the indices of the motors in q."""

    tolerance: Tolerance
    motors: tuple[int, ...]


class FrequencyShifts:
    """Shifts of natural frequencies that changes of a program cause, as fractions of the allowed shift.

    Raises `ValueError` for a program that is not a direct or inverse model of all joints.
    """

    def __init__(self, required: NaturalFrequencies, program: Program, tape: Tape, box: Bounds, seed: int) -> None:
        self._required, self._tape, self._box, self._seed = required, tape, box, seed
        self._places = _Places.of(program, tape, required.motors)
        self._watched = self._exact(self._states_at_rest(WATCHED, 0))
        self._limit = 1.0
        self._effects: ShiftEffects | None = None

    def errors(self, accepted: Sequence[Change]) -> Array:
        """Return the shifts (positions * modes,) at the watched positions as signed fractions of the limit."""
        at = self._watched
        roots = self._roots(at.states, Changes.of(accepted))
        signs = np.where(roots.real < at.roots.real, -1.0, 1.0)
        return np.asarray((signs * self._distances(roots, at.roots)).reshape(-1) / self._limit)

    def effects(self, accepted: Sequence[Change]) -> Callable[[Change], Array]:
        """Return by how much one more change moves the `errors`, to first order."""
        if self._effects is None:
            self._effects = ShiftEffects(self._tape, self._watched.states, self._modes())
        return self._effects.after(accepted)

    def bound(self, accepted: Sequence[Change], number: int) -> float:
        """Return a bound on the shifts at many positions, and at as many more.

        Where it is too large, the worst positions are watched from then on, with a lower limit.
        """
        at = self._exact(self._states_at_rest(POSITIONS, number + 1))
        shifts = self._distances(self._roots(at.states, Changes.of(accepted)), at.roots).max(axis=1, initial=0.0)
        worst = np.argsort(-shifts)[:JOINING]
        if not (most := float(shifts.max(initial=0.0))):
            return 0.0
        bound = max(most, bound_of_more(np.maximum(shifts, SMALLEST), POSITIONS))
        if not bound <= 1:
            states = np.concatenate([self._watched.states, at.states[:, worst]], axis=1)
            self._watched = _WatchedStates(states, np.concatenate([self._watched.roots, at.roots[worst]]))
            self._limit *= max(SLACK * most / bound, SLACK / most if most > 1 else 0.0, LEAST)
            self._effects = None
        return bound

    def raise_limit(self, shift: float) -> bool:
        """Raise the limit of a search where a bound on shifts leaves a part of the tolerance; True if it rose."""
        raised = min(1.0, self._limit * SLACK / max(shift, SLACK / 2)) if 0 < shift < LEFT_OVER else self._limit
        has_more, self._limit = raised > self._limit, raised
        if has_more:
            self._effects = None
        return has_more

    def _states_at_rest(self, count: int, number: int) -> Array:
        """States at rest, at random positions."""
        states = self._box.at_rest(count + 1, np.random.default_rng([self._seed, 9, number]))
        return states[:, 1:]

    def _exact(self, states: Array) -> _WatchedStates:
        """The equilibria nearest to states, and the frequencies there."""
        states = self._equilibria(states)
        return _WatchedStates(states, self._roots(states, NO_CHANGES))

    def _allowed_shifts(self, omega: Array) -> Array:
        """The tolerance of frequencies."""
        tolerance = self._required.tolerance
        return np.asarray(tolerance.value * (omega if tolerance.relative else np.full_like(omega, 2 * np.pi)))

    def _distances(self, roots: AnyArray, exact: AnyArray) -> Array:
        """Shifts (states, modes) as fractions of the allowed shift; infinite where a mode is lost."""
        omega, distance = exact.real, np.abs(roots - exact)
        with np.errstate(all="ignore"):
            shifts = np.where(distance < LOST * omega, distance / self._allowed_shifts(omega), np.inf)
        return np.where(omega > 0, shifts, 0.0)

    def _modes(self) -> Modes:
        """The modes of the whole model at the positions that are watched.

        An eigenvalue omega^2 that falls by allowed (2 omega - allowed) uses up the tolerance.
        """
        omega = self._watched.roots.real
        allowed = np.minimum(self._allowed_shifts(omega), LOST * omega) * self._limit
        with np.errstate(all="ignore"):
            scales = np.where(omega > 0, 1 / (allowed * (2 * omega - allowed)), 0.0)
        _, J, B = self._linear(self._watched.states, NO_CHANGES)
        directions, weights = self._places.modes_of(J, B, len(self._tape.results))
        return Modes(directions, weights, scales)

    def _roots(self, states: Array, changes: Changes) -> AnyArray:
        """Roots of the eigenvalues (states, modes), with motors held, then with free ones."""
        parts = [states[:, k : k + BLOCK] for k in range(0, states.shape[1], BLOCK)]
        return np.concatenate([self._roots_of_block(part, changes) for part in parts])

    def _roots_of_block(self, states: Array, changes: Changes) -> AnyArray:
        _, J, B = self._linear(states, changes)
        with np.errstate(all="ignore"):
            return np.concatenate([_roots_of(S)[:, : self._places.modes] for S in self._places.stiffness(J, B)], axis=1)

    def _linear(self, states: Array, changes: Changes) -> tuple[Array, Array, Array]:
        """Accelerations (states, n), and their derivatives J (states, n, n) and B (states, n, motors)."""
        tape, count = self._tape, states.shape[1]
        rows = tape.rows_in(np.empty((tape.count, count)))
        tape.fill(rows, tape.steps(changes, roots=tape.results), states)
        size = len(tape.results)
        seeds = np.broadcast_to(np.eye(size)[:, :, None], (size, size, count))
        adjoints = Sweep(tape, size, count).adjoints(rows, seeds, changes)
        for place in changes.frozen:  # nothing depends on an argument that is a number
            adjoints[place] = None
        return self._places.linearization(tape.values(rows), adjoints)

    def _equilibria(self, states: Array) -> Array:
        """The states moved to the nearest equilibrium by Newton's method; unchanged where it does not converge."""
        moved = states.copy()
        qdd, J, B = self._linear(moved, NO_CHANGES)
        first = np.maximum(np.abs(qdd).max(axis=1), SMALLEST)
        for _ in range(STEPS):
            moved[self._places.unknowns] -= self._places.newton(qdd, J, B).T
            qdd, J, B = self._linear(moved, NO_CHANGES)
        reached = np.abs(qdd).max(axis=1) <= CLOSE * first
        return np.where(reached, moved, states)


class _WatchedStates(NamedTuple):
    """States (symbols, states), and the roots of the eigenvalues of the whole model there (states, modes)."""

    states: Array
    roots: AnyArray


@dataclass(frozen=True)
class _Motion:
    """An oscillation x of the joints `moving` (indices of positions): xdd = `weights` qdd = -S x.

    `weights` are (states, joints, accelerations); `torques` (states, torques, joints) times x hold what does not move.
    """

    weights: Array
    moving: Sequence[int]
    torques: Array

    def stiffness(self, J: Array) -> Array:
        """S of xdd = -S x (states, joints, joints), from J, the derivatives of accelerations by positions."""
        return np.asarray(-(self.weights @ J[:, :, list(self.moving)]))


@dataclass(frozen=True)
class _Places:
    """Indices of accelerations among results, and of positions and torques among symbols.

    A position that nothing depends on is -1. `passive` and `motors` are numbers of accelerations; inverse models have
    none of motors, and no torques.
    """

    accelerations: tuple[int, ...]
    positions: tuple[int, ...]
    torques: tuple[int, ...]
    passive: tuple[int, ...]
    motors: tuple[int, ...]
    symbols: tuple[int, ...]

    @classmethod
    def of(cls, program: Program, tape: Tape, motors: Sequence[int]) -> _Places:
        """Raise `ValueError` for a program without accelerations of all joints, or without joints that swing."""
        inputs = {argument.name: argument.symbols for argument in program.inputs}
        outputs = {x.name: places for x, places in zip(program.outputs, tape.entries, strict=True)}
        if "qdd" not in outputs or len(outputs["qdd"]) != len(inputs.get("q", ())):
            raise ValueError("natural frequencies are those of direct_dynamics and inverse_dynamics with all joints")
        order = {name: number for number, name in enumerate(tape.symbols)}
        passive = [k for k in range(len(inputs["q"])) if k not in motors]
        if not passive or any(inputs["q"][k] not in order for k in passive):
            raise ValueError("natural frequencies need joints that swing where the motors are held")
        is_direct = "tau" in inputs
        numbers = sorted([*passive, *motors]) if is_direct else passive
        if any(outputs["qdd"][k] not in tape.results for k in numbers):
            raise ValueError("natural frequencies need accelerations that depend on the state")
        return cls(
            tuple(tape.results.index(outputs["qdd"][k]) for k in numbers),
            tuple(order.get(inputs["q"][k], -1) for k in numbers),
            tuple(order[name] for name in inputs["tau"] if name in order) if is_direct else (),
            tuple(numbers.index(k) for k in passive),
            tuple(numbers.index(k) for k in motors) if is_direct else (),
            tuple(tape.symbols.values()),
        )

    @property
    def modes(self) -> int:
        """How many frequencies count, with motors held and with free ones."""
        return len(self.passive)

    @property
    def unknowns(self) -> list[int]:
        """Indices of the symbols that equilibrium determines: positions of passive joints, and torques."""
        return [*(self.positions[k] for k in self.passive), *self.torques]

    def linearization(self, values: Array, adjoints: Adjoints) -> tuple[Array, Array, Array]:
        """Accelerations (states, n), and derivatives by positions and torques (states, n, ...)."""

        def by(symbols: Sequence[int]) -> Array:
            columns_or_none = [None if k < 0 else adjoints[self.symbols[k]] for k in symbols]
            zero = np.zeros(values.shape)
            columns = [(zero if x is None else x)[list(self.accelerations)] for x in columns_or_none]
            shape = len(columns), len(self.accelerations), values.shape[1]
            return np.array(columns).reshape(shape).transpose(2, 1, 0)

        return values[list(self.accelerations)].T, by(self.positions), by(self.torques)

    def stiffness(self, J: Array, B: Array) -> list[Array]:
        """S of xdd = -S x (states, joints, joints) with motors held, if any, and free; B are derivatives by torques."""
        return [motion.stiffness(J) for motion in self._motions(J, B)]

    def modes_of(self, J: Array, B: Array, results: int) -> tuple[Array, Array]:
        """Directions and weights of `Modes`, with motors held, then with free ones."""
        modes = []
        for motion in self._motions(J, B):
            x, y = (vectors[:, : self.modes] for vectors in _vectors_of(motion.stiffness(J)))
            directions = _scatter(x, [self.positions[k] for k in motion.moving], len(self.symbols))
            directions += _scatter(x @ motion.torques.transpose(0, 2, 1), self.torques, len(self.symbols))
            modes.append((directions, _scatter(y @ motion.weights, self.accelerations, results)))
        directions, weights = (np.concatenate(parts, axis=1) for parts in zip(*modes, strict=True))
        return directions, weights

    def _motions(self, J: Array, B: Array) -> list[_Motion]:
        """The oscillations with motors held, if there are motors, and with free motors."""
        p, m, size = list(self.passive), list(self.motors), len(self.accelerations)
        unit = np.broadcast_to(np.eye(size), J.shape)
        free = _Motion(unit, range(size), np.zeros((len(J), len(self.torques), size)))
        if not m:
            return [free]
        weights = unit[:, p].copy()
        weights[:, :, m] = -B[:, p] @ _least_solution(B[:, m], unit[:, : len(m), : len(m)])
        return [_Motion(weights, p, -_least_solution(B[:, m], J[:, m][:, :, p])), free]

    def newton(self, qdd: Array, J: Array, B: Array) -> Array:
        """The step (states, unknowns) of Newton's method; zero where there is none."""
        matrix = np.concatenate([J[:, :, list(self.passive)], B], axis=2)
        scale = np.maximum(np.abs(matrix).max(axis=1, keepdims=True), SMALLEST)
        step = _least_solution(matrix / scale, qdd[:, :, None])[:, :, 0] / scale[:, 0]
        return np.asarray(np.where(np.isfinite(step), step, 0.0))


def _roots_of(S: Array) -> AnyArray:
    """Roots of the eigenvalues (states, modes), by falling real part; those of motions that do not swing are zero."""
    roots = _swinging(np.linalg.eigvals(np.where(_finite(S), S, 0.0)))
    return np.take_along_axis(roots, _order(roots), axis=1)


def _vectors_of(S: Array) -> tuple[Array, Array]:
    """Right and left eigenvectors (states, modes, joints), in the order of the roots; their products are 1."""
    values, x = np.linalg.eig(np.where(_finite(S), S, 0.0))
    order = _order(_swinging(values))[:, :, None]
    right, left = (np.take_along_axis(y.real, order, axis=1) for y in (x.transpose(0, 2, 1), np.linalg.pinv(x)))
    largest = np.maximum(np.abs(right).max(axis=2, keepdims=True), SMALLEST)
    return right / largest, left * largest


def _swinging(values: AnyArray) -> AnyArray:
    """Roots of eigenvalues (states, modes)."""
    values = values.astype(complex)
    swings: BoolArray = (np.abs(values) > STILL * np.abs(values).max(axis=1, keepdims=True)) & (values.real > 0)
    return np.where(swings, np.sqrt(values), 0.0)


def _order(roots: AnyArray) -> AnyArray:
    """The order of falling real parts."""
    return np.argsort(-roots.real, axis=1, kind="stable")


def _scatter(columns: Array, places: Sequence[int], size: int) -> Array:
    """Add columns (states, modes, ...) at their places in a result of `size` columns; those at -1 are omitted."""
    values = np.zeros((*columns.shape[:2], size))
    for column, place in enumerate(places):
        if place >= 0:
            values[:, :, place] += columns[:, :, column]
    return values


def _least_solution(matrix: Array, right: Array) -> Array:
    """Least solutions of square systems, NaN where numbers are not finite."""
    finite = _finite(matrix) & _finite(right)
    solution = np.linalg.pinv(np.where(finite, matrix, 0.0)) @ np.where(finite, right, 0.0)
    return np.where(finite, solution, np.nan)


def _finite(matrices: Array) -> BoolArray:
    """Which matrices hold numbers only (states, 1, 1)."""
    return np.array(np.isfinite(matrices).all(axis=(1, 2)))[:, None, None]


@dataclass(frozen=True)
class Modes:
    """Modes at positions, (positions, modes, ...).

    `directions` are theirs by symbol, `weights` w by result of the tape, `scales` what multiplies a change of an
    eigenvalue: zero for modes that do not count.
    """

    directions: Array
    weights: Array
    scales: Array


class ShiftEffects:
    """Effects of changes on frequencies at positions: `states` are their equilibria (symbols, positions)."""

    def __init__(self, tape: Tape, states: Array, modes: Modes) -> None:
        self._tape = tape
        directions = STEP * modes.directions.transpose(2, 0, 1)
        ends = [states[:, :, None] + sign * directions for sign in (1, -1)]
        self._states = np.concatenate(ends, axis=1).reshape(len(states), -1)
        weights = modes.weights * (modes.scales / (-2 * STEP))[:, :, None]
        weights = weights.transpose(2, 0, 1).reshape(weights.shape[2], -1)
        self._seeds = np.concatenate([weights, -weights], axis=1)[None]
        count = self._states.shape[1]
        self._rows = tape.rows_in(np.empty((tape.count, count)))
        self._sweep = Sweep(tape, 1, count)

    def after(self, accepted: Sequence[Change]) -> Callable[[Change], Array]:
        """Return the effect of a further change (positions * modes,) as a function; valid until the next call."""
        tape, rows, changes = self._tape, self._rows, Changes.of(accepted)
        tape.fill(rows, tape.steps(changes), self._states)
        adjoints = self._sweep.adjoints(rows, self._seeds, changes)
        half = self._states.shape[1] // 2

        def effect(change: Change) -> Array:
            adjoint = adjoints[change.place]
            if adjoint is None:
                return np.zeros(half)
            ends: Array = adjoint[0] * node_shift(tape, rows, change)
            return np.asarray(ends[:half] + ends[half:])

        return effect
