"""Predicted errors of a method's steps: the method itself on the linear model.

    y' = y_r' + J (y - y_r) + [0; M^-1 R],    J = [0 I; -M^-1 K, -M^-1 D],    y = [q; v]

M, D, K, R are cubic between their samples. T is that of generated steps: for W-methods the inertia at the beginning of
the step, stiffness and damping of the joints themselves, and the loops of drives; for methods with exact derivatives J.
Motors without servo are where they are prescribed to be at every stage. The exact solution is that of a fine run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from functools import cache, cached_property, singledispatch
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.prediction.output_matrices import between, interpolate
from symoro_elastic.analysis.simulation.prediction.path import LinearPath
from symoro_elastic.analysis.simulation.prediction.small_motion import SmallMotion
from symoro_elastic.analysis.simulation.prediction.spring_errors import relative
from symoro_elastic.codegen.integration.tableaus import (
    Coefficients,
    Method,
    Midpoint,
    Rosenbrock,
    Tableau,
    WMethod,
    times_of,
)
from symoro_elastic.foundation.array_types import AnyArray, Array, BoolArray, ComplexArray

FINE = 4
"""Steps of the fine run between samples of the model, at least."""
FEWEST, MOST_STEPS = 10, 5_000
"""Steps over a motion that are tried."""
MARGIN, SAVED = 1.05, 1.15
"""Ratio of steps to those by the order of a method; ratio of steps that are too few and enough, for a choice."""
SHORTLY = 0.02
"""Part of the time between samples over which df/dt is taken."""
BLOCK = 256
"""Steps whose matrices are made at once."""
Rate = Callable[[int, AnyArray], AnyArray]
Solve = Callable[[AnyArray], AnyArray]


@dataclass(frozen=True)
class _Rates:
    """Linear right-hand side f(t, y) = [y_v; rate + slope (y - reference)] at times (N,)."""

    slope: Array
    reference: Array
    rate: Array

    @cached_property
    def _at_zero(self) -> Array:
        return np.asarray(self.rate - (self.slope @ self.reference[..., None])[..., 0])

    def at(self, Y: Array) -> Array:
        """Return f of affine functions Y (N, 2n, 2n + 1) of the initial state."""
        n = self.rate.shape[1]
        moved = self.slope @ Y
        moved[..., -1] += self._at_zero
        return np.concatenate([Y[:, n:], moved], axis=1)


@dataclass(frozen=True)
class _Solver:
    """Solver of (I - g T) z = r by (M + g D + g^2 K) z_v = M r_v - g K r_q, z_q = r_q + g z_v, for steps (N,).

    Arrays (N, r, r) of the coordinates `rows`: what r_v and r_q give to r_v - z_v.
    """

    g: float
    rows: Array
    by_velocity: Array
    by_position: Array

    def solution(self, r: Array) -> Array:
        """Return the solution z for right-hand sides r that are affine functions."""
        r_q, r_v = np.split(r, 2, axis=1)
        z_v = r_v.copy()
        z_v[:, self.rows] -= self.by_velocity @ r_v[:, self.rows] + self.by_position @ r_q[:, self.rows]
        return np.concatenate([r_q + self.g * z_v, z_v], axis=1)


@dataclass(frozen=True)
class _Steps:
    """Steps of size h of a method: right-hand sides by stage, solver, and right-hand sides nearby for df/dt.

    `driven` are entries of y that are prescribed, `ends` (N, 2n) where they are after each step.

    A step is an affine function of y, so that the method is run once for all steps, on affine functions
    Y = [A, b] (N, 2n, 2n + 1) of the y at their start in place of numbers; only A y + b follows step by step.
    """

    method: Method
    h: float
    stages: tuple[_Rates, ...]
    solver: _Solver | None
    around: tuple[_Rates, _Rates, Array] | None
    driven: Array
    ends: Array

    def after(self, y: Array) -> Iterator[Array]:
        """Yield the state y (2n,) after each step."""
        for A in self._functions():
            y = A[:, :-1] @ y + A[:, -1]
            yield y

    def _functions(self) -> Array:
        """Return the steps as affine functions of y (N, 2n, 2n + 1)."""
        steps, size = self.ends.shape
        start = np.tile(np.eye(size, size + 1), (steps, 1, 1))

        def rate(i: int, Y: Array) -> Array:
            return self._at(self.stages[i], Y)

        def solution(r: Array) -> Array:
            return self.solver.solution(r) if self.solver else r

        functions: Array = step(self.method, self.h, start, rate, solution, self._of_time(start))
        return self._with_driven(functions, self.ends)

    def _at(self, rates: _Rates, Y: Array) -> Array:
        """Return f with motors at their prescribed states."""
        return rates.at(self._with_driven(Y, rates.reference))

    def _with_driven(self, Y: Array, there: Array) -> Array:
        result = Y.copy()
        result[:, self.driven] = 0.0
        result[:, self.driven, -1] = there[:, self.driven]
        return result

    def _of_time(self, Y: Array) -> Array:
        """Return df/dt at the start of steps."""
        if self.around is None:
            return np.zeros_like(Y)
        before, after, apart = self.around
        return np.asarray((self._at(after, Y) - self._at(before, Y)) / apart[:, None, None])


@dataclass(frozen=True)
class StepErrors:
    """Errors of time-step methods on one path without the springs `left_out` (entries of q).

    They are locked; static where the outputs of the path follow their deflections, see `LinearPath.recovering`.
    """

    path: LinearPath
    left_out: tuple[int, ...] = ()

    @cached_property
    def rows(self) -> Array:
        """The entries of q that the equations of motion determine."""
        return np.array([k for k in self.path.moved if k not in self.left_out], dtype=int)

    def errors(self, method: Method, steps: int) -> dict[str, float]:
        """Return the largest errors by output at the ends of equal steps; infinite if they overflow."""
        path = self.path
        t = np.linspace(0.0, path.t[-1], steps + 1)
        outputs = path.outputs.at(path.t, t)
        with np.errstate(over="ignore", invalid="ignore"):
            wrong = self._run(method, t) - self._exact(t)
            q, v = np.split(wrong, 2, axis=1)
            terms = ((outputs.Cq, q), (outputs.Cv, v), (outputs.Ca, self._accelerations(t, wrong)))
            largest = np.abs(sum(np.einsum("toi,ti->to", C, x) for C, x in terms)).max(axis=0)
        return dict(zip(outputs.names, np.where(np.isfinite(largest), largest, np.inf).tolist(), strict=True))

    def _exact(self, t: Array) -> Array:
        """Return y (N, 2n) of the linear model at times t."""
        solution = self._solution
        h = self.path.h / FINE
        value, rate = interpolate(h, (solution.d[:, 0], solution.dd[:, 0], solution.ddd[:, 0]), t)
        return np.asarray(self._states(t) + np.concatenate([value, rate], axis=1))

    @cached_property
    def _solution(self) -> SmallMotion:
        """The exact small motion, at times finer than those of the path."""
        return self.path.finer(FINE * (len(self.path.t) - 1) + 1).without([self.left_out])

    def _run(self, method: Method, t: Array) -> Array:
        """Return the states y (N, 2n) by the method at times t."""
        y = [self._states(t[:1])[0]]
        rounded = replace(method, **{field.name: _floats(getattr(method, field.name)) for field in fields(method)})
        for first in range(0, len(t) - 1, BLOCK):
            y.extend(self._steps(rounded, t[first : first + BLOCK + 1]).after(y[-1]))
        return np.array(y)

    def _steps(self, method: Method, t: Array) -> _Steps:
        """Return the steps between times t (N,)."""
        n, h, begins = len(self.path.joints), float(t[1] - t[0]), t[:-1]
        entries = np.setdiff1d(np.arange(n), self.path.moved)  # those that follow the reference exactly
        near = [np.clip(begins + sign * SHORTLY * self.path.h, 0.0, self.path.t[-1]) for sign in (-1, 1)]
        return _Steps(
            method,
            h,
            tuple(self._rates(begins + c * h) for c in nodes(method)),
            None if isinstance(method, Tableau) else self._solver(method, begins, h),
            (self._rates(near[0]), self._rates(near[1]), near[1] - near[0]) if isinstance(method, Rosenbrock) else None,
            np.concatenate([entries, n + entries]),
            self._states(t[1:]),
        )

    @cached_property
    def _at_samples(self) -> tuple[Array, Array]:
        """Right-hand side at the samples of the model: -M^-1 [K, D] (N, n, 2n), and v' at y_r (N, n).

        They are smooth where the acceleration of a motor under a servo is not.
        """
        path, rows = self.path, self.rows
        sides = np.concatenate([path.K, path.D, path.R[..., None]], axis=2)[:, rows]
        solved = np.linalg.solve(path.M[:, rows[:, None], rows], sides)
        slope = np.zeros((len(path.t), len(path.joints), 2 * len(path.joints)))
        slope[:, rows] = -solved[..., :-1]
        rate = path.states(path.t)[2]
        rate[:, rows] += solved[..., -1]
        return slope, rate

    def _rates(self, t: Array) -> _Rates:
        path = self.path
        slope, rate = (between(path.t, x, t) for x in self._at_samples)
        return _Rates(slope, self._states(t), rate)

    def _solver(self, method: Method, t: Array, h: float) -> _Solver:
        path, rows, g = self.path, self.rows, gamma(method) * h
        inertia = path.M if path.of_loads is None else path.M - path.of_loads
        M, D, K = (between(path.t, x, t)[:, rows[:, None], rows] for x in (inertia, path.D, path.K))
        if not isinstance(method, Rosenbrock):
            damping = between(path.t, path.damping, t)[:, rows]
            D, K = damping[:, :, None] * np.eye(len(rows)), np.diag(path.stiffness[rows])
            if path.controlled is not None:
                D, K = (x + loops[rows[:, None], rows] for x, loops in zip((D, K), path.controlled, strict=True))
        S = g * D + g**2 * K
        inverse = np.linalg.inv(M + S)
        return _Solver(g, rows, inverse @ S, inverse @ (g * K))

    def _accelerations(self, t: Array, wrong: Array) -> Array:
        """Return acceleration errors (N, n) caused by errors of the state y (N, 2n)."""
        blocks = [slice(first, first + BLOCK) for first in range(0, len(t), BLOCK)]
        return np.concatenate([np.einsum("tij,tj->ti", self._rates(t[b]).slope, wrong[b]) for b in blocks])

    def _states(self, t: Array) -> Array:
        """Return the reference states y_r (N, 2n) at times t."""
        q, v, _ = self.path.states(t)
        return np.concatenate([q, v], axis=1)


@dataclass(frozen=True)
class StepChoice:
    """A sufficient number of equal steps of a method, and their errors by output.

    `is_tried` is False where errors were found at longer steps, and go down by the order of the method.
    """

    steps: int
    errors: Mapping[str, float]
    is_tried: bool = True


def fewest_steps(
    of: StepErrors, method: Method, tolerance: Mapping[str, float], share: float, at_least: int = 1
) -> StepChoice:
    """Return approximately the fewest steps whose errors are at most `share` of the tolerances.

    More are taken where a few per cent of them would not be saved.
    """
    wrong, steps, errors = (0, np.inf), max(at_least, FEWEST), of.errors(method, max(at_least, FEWEST))
    while (excess := relative(errors, tolerance) / share) > 1:
        factor = float(np.clip(MARGIN * excess ** (1 / method.order), 1.2, 8.0))
        if steps * factor > MOST_STEPS:
            return _extrapolation(method, steps, errors, excess)
        wrong, steps = (steps, excess), int(np.ceil(steps * factor))
        errors = of.errors(method, steps)
    while wrong[0] and steps > max(SAVED * wrong[0], wrong[0] + 1):
        fewer = _between(wrong, (steps, relative(errors, tolerance) / share))
        fewer_errors = of.errors(method, fewer)
        excess = relative(fewer_errors, tolerance) / share
        if excess > 1:
            wrong = fewer, excess
        else:
            steps, errors = fewer, fewer_errors
    return StepChoice(steps, errors)


def _between(wrong: tuple[int, float], enough: tuple[int, float]) -> int:
    """Return a number of steps strictly between too few and enough, by interpolation of their errors."""
    middle = np.sqrt(wrong[0] * enough[0])
    if np.isfinite(wrong[1]) and 0 < enough[1] < wrong[1]:
        order = np.log(wrong[1] / enough[1]) / np.log(enough[0] / wrong[0])
        expected = MARGIN * wrong[0] * wrong[1] ** (1 / order)
        middle = np.clip(expected, np.sqrt(SAVED) * wrong[0], enough[0] / np.sqrt(SAVED))
    return int(np.clip(round(float(middle)), wrong[0] + 1, enough[0] - 1))


def _extrapolation(method: Method, steps: int, errors: Mapping[str, float], excess: float) -> StepChoice:
    """Return the steps that suffice by extrapolation of the errors at too few steps, by the order of the method."""
    if not np.isfinite(excess):
        return StepChoice(MOST_STEPS, errors, is_tried=False)
    factor = excess ** (1 / method.order)
    fewer = {name: error / factor**method.order for name, error in errors.items()}
    return StepChoice(int(np.ceil(steps * factor)), fewer, is_tried=False)


def _floats(value: Any) -> Any:
    """Return a value with its fractions, also within tuples, converted to floats."""
    if isinstance(value, tuple):
        return tuple(map(_floats, value))
    return float(value) if isinstance(value, Fraction) else value


def nodes(method: Method) -> Array:
    """Return the nodes c of a method: fractions of a step at which it evaluates the right-hand side."""
    return np.array(times_of(method), dtype=float)


def gamma(method: Method) -> float:
    """Return gamma of the systems (I - gamma h J) x = b that steps h of a method solve, 0 for an explicit one."""
    if isinstance(method, Midpoint):
        return 0.5
    return 0.0 if isinstance(method, Tableau) else float(method.gamma)


@singledispatch
def step(method: Method, h: float, y: AnyArray, f: Rate, solve: Solve, of_time: AnyArray) -> AnyArray:
    """Return y (...,) after a step of h; `of_time` is df/dt at its start, for methods with exact derivatives."""
    raise NotImplementedError


@step.register
def _(method: Tableau, h: float, y: AnyArray, f: Rate, solve: Solve, of_time: AnyArray) -> AnyArray:
    k: list[AnyArray] = []
    for i, row in enumerate(method.A):
        k.append(f(i, y + h * _sum(row, k)))
    return y + h * _sum(method.b, k)


@step.register
def _(method: WMethod, h: float, y: AnyArray, f: Rate, solve: Solve, of_time: AnyArray) -> AnyArray:
    k: list[AnyArray] = []
    for i, (a, g) in enumerate(zip(method.a, method.g, strict=True)):
        w = _sum(g, k) / float(method.gamma)
        k.append(solve(f(i, y + h * _sum(a, k)) + w) - w)
    return y + h * _sum(method.b, k)


@step.register
def _(method: Rosenbrock, h: float, y: AnyArray, f: Rate, solve: Solve, of_time: AnyArray) -> AnyArray:
    u: list[AnyArray] = []
    for i, (a, c) in enumerate(zip(method.a, method.c, strict=True)):
        right = f(i, y + _sum(a, u)) + _sum(c, u) / h + float(method.gammas[i]) * h * of_time
        u.append(float(method.gamma) * h * solve(right))
    return y + _sum(method.m, u)


@step.register
def _(method: Midpoint, h: float, y: AnyArray, f: Rate, solve: Solve, of_time: AnyArray) -> AnyArray:
    k = 0.0 * y
    for _iteration in range(method.iterations):
        k = k + solve(f(0, y + h / 2 * k) - k)
    return y + h * k


def growth(method: Method, z: AnyArray) -> AnyArray:
    """Return the stability function R(z) of a method, with z = lambda h and an exact Jacobian."""
    ones = np.ones_like(z)
    return step(method, 1.0, ones, lambda _, y: z * y, lambda r: r / (1 - gamma(method) * z), 0.0 * ones)


def _sum(weights: Coefficients, terms: list[AnyArray]) -> AnyArray:
    """Return the sum of weights_j terms_j; zero without terms."""
    parts = [float(weight) * term for weight, term in zip(weights, terms, strict=True) if weight]
    return sum(parts[1:], start=parts[0]) if parts else np.zeros(())


ROUNDING = 1e-9
"""Growth in a step that is due to rounding of a pole, not to instability."""
GROWING = 1e-6
"""Real part of a pole, of its magnitude, above which its motion grows by itself."""
FARTHEST, APART = 15.0, 0.005
"""Of |lambda h| in the search for a limit: beyond the explicit methods in use."""
HALVINGS, ANGLES = 40, 721
PLACES = 40
"""Positions along a motion at which poles are taken."""
KEPT = 0.9
"""Part of its amplitude that a vibration keeps over a period, up to which it counts as damped."""
SLOWEST, FREQUENCIES = 1e-2, 2000
"""w h of the slowest vibration that is evaluated, and the number of vibrations up to pi."""


def poles(path: LinearPath, left_out: tuple[int, ...] = ()) -> ComplexArray:
    """Return the poles, rad/s, at positions along a motion, with springs (entries of q) omitted."""
    places = np.unique(np.linspace(0, len(path.t) - 1, PLACES).astype(int))
    rows = np.array([k for k in path.moved if k not in left_out], dtype=int)
    M, D, K = (x[places][:, rows[:, None], rows] for x in (path.M, path.D, path.K))
    r = len(rows)
    system = np.zeros((len(places), 2 * r, 2 * r))
    system[:, :r, r:] = np.eye(r)
    system[:, r:] = -np.linalg.solve(M, np.concatenate([K, D], axis=2))
    return np.asarray(np.linalg.eigvals(system).astype(complex).ravel())


def largest_stable_step(method: Method, of: ComplexArray) -> float:
    """Return the largest step, s, at which a method is stable for all poles `of`, rad/s; may be infinite.

    Poles of motions that grow by themselves, such as that of a pendulum upside down, set no limit.
    """
    speeds = np.abs(of)
    directions = of / np.where(speeds, speeds, 1.0)
    counted = (speeds > ROUNDING * speeds.max(initial=0.0)) & (directions.real <= GROWING)
    if not counted.any():
        return np.inf
    chosen = directions[counted]
    angles, reach = _boundary(method)
    towards = np.angle(np.minimum(chosen.real, 0.0) + 1j * np.abs(chosen.imag))
    return float(np.min(np.interp(towards, angles, reach) / speeds[counted]))


@cache
def _boundary(method: Method) -> tuple[Array, Array]:
    """Return angles of z in the upper left quadrant, and the largest stable |z| at each angle."""
    angles = np.linspace(np.pi / 2, np.pi, ANGLES)
    return angles, _reach(method, np.minimum(np.cos(angles), 0.0) + 1j * np.sin(angles))


def _reach(method: Method, directions: ComplexArray) -> Array:
    """Return for each direction the largest |z| up to which |R(z)| <= 1; infinite beyond the search range."""
    radii = np.arange(APART, FARTHEST, APART)
    stable = _stable(method, directions[:, None] * radii)
    first = np.argmin(stable, axis=1)
    high = radii[first]
    low = high - APART
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        is_stable = _stable(method, directions * middle)
        low, high = np.where(is_stable, middle, low), np.where(is_stable, high, middle)
    return np.where(stable.all(axis=1), np.inf, low)


def _stable(method: Method, z: ComplexArray) -> BoolArray:
    return np.asarray(np.abs(growth(method, z)) <= 1 + ROUNDING)


def damped_above(method: Method, h: float) -> float | None:
    """Return the frequency, Hz, above which vibrations are damped by steps h: by a tenth in a period, or faster.

    Vibrations of less than two steps a period are not followed at all. None where such steps damp none: they keep
    the energy, or make it grow.
    """
    wh = np.geomspace(SLOWEST, np.pi, FREQUENCIES)
    gain = np.abs(growth(method, 1j * wh))
    if not gain[-1] < 1 - ROUNDING:
        return None
    damped = gain ** (2 * np.pi / wh) <= KEPT
    return float(wh[int(np.argmax(damped)) if damped.any() else -1] / (2 * np.pi * h))
