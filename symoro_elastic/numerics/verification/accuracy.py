"""Errors of a model's results in units of rounding, and the effect of a one-ulp change of the inputs.

The error at a state is the largest difference from the exact result over its largest entry (over 1 where the result
is zero), divided by the unit roundoff u of the arithmetic; of a model with several results, the worst of these. Exact
values come from extended precision, the worst one from balls, so it is proven.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

from symoro_elastic.codegen.compile import TYPES
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.models.programs.catalogue import TracedModel
from symoro_elastic.numerics.evaluation.arrays import EXTENDED, HAS_EXTENDED, Parameters, evaluate_arrays
from symoro_elastic.numerics.evaluation.quantile_bound import bound_of_more, bound_of_quotients
from symoro_elastic.numerics.verification.states import States
from symoro_elastic.symbolic.arithmetic import Arithmetic, evaluate_nodes, library
from symoro_elastic.symbolic.operations import COSPI, MAXIMUM, MINIMUM, SIGN
from symoro_elastic.symbolic.program import Program

FIRST_BITS, MOST_BITS = 160, 20_480
PROVEN_ZERO = 1e-100
"""Results that are proven smaller are zero."""

ComputedResults = Mapping[str, AnyArray | Sequence[AnyArray]]
"""Results by name, states along the first axis; a sequence of arrays represents its sum."""

Sizes = dict[str, tuple[Array, Array]]
"""Absolute errors and the largest exact entries, by result."""

NUMBERS_AT_ONCE = 2_000_000
LEAST_MOVES, MOVED_STATES = 32, 400
MOST_EXTENDED_BITS = 53
EXTENDED_U = float(np.finfo(EXTENDED).eps)
ENCLOSURE_WIDTH = 2.0**-20
EXTENDED_ZERO = 1e-300
"""Extended results that are smaller are zero."""
UNSEEN = 100_000
"""Number of future states for which errors are bounded."""
LEAST_ERROR = 2.0**-6
"""Errors below it, in u, are as good as it: exact results have no tail."""


def round_states(states: States, precision: Precision) -> States:
    """Return the states rounded to the arrays of this precision."""
    dtype = TYPES[precision.state]
    return states.map(lambda block: block.astype(dtype).astype(float))


def rounded_values(values: Mapping[str, float], precision: Precision) -> dict[str, float]:
    """Return the parameters rounded to the arrays of this precision."""
    return {name: float(TYPES[precision.state](value)) for name, value in values.items()}


@dataclass(frozen=True)
class Errors:
    """Errors of a model over some states, in units of u relative to the largest entry of a result.

    `worst` (a proven bound, at state `at`; infinite where a result is not finite) and `typical` (the median).
    Next to them, worst and median effect of moving every input (variables, velocities, torques, parameters) one ulp
    up or down at the same states; NaN where numpy has no extended precision. States where the model divides by zero,
    or whose exact results are out of range, are not `judged`. `unseen` bounds the worst error at `UNSEEN` other states
    drawn the same way (`numerics/evaluation/quantile_bound.py`).
    """

    u: float
    worst: float
    typical: float
    input_effect: float
    typical_input_effect: float
    judged: int
    at: int
    unseen: float

    @property
    def relative(self) -> float:
        """The worst error relative to the largest entry."""
        return self.worst * self.u

    @property
    def bound(self) -> float:
        """The bound on errors at other states, relative to the largest entry."""
        return self.unseen * self.u


class Reference:
    """The exact results of a model at states, in extended precision, each computed once."""

    def __init__(self, traced: TracedModel, states: States, values: Mapping[str, float]) -> None:
        """Store the model, states along the first axis, and the values of the parameters."""
        self.traced, self.states, self.values = traced, states, values
        self._step = max(1, NUMBERS_AT_ONCE // (1 + len(traced.program.nodes)))
        self._known: dict[int, dict[str, AnyArray]] = {}

    def parts(self, count: int) -> list[slice]:
        """Return slices of the first states, as many in each as are computed at once."""
        return [slice(k, min(k + self._step, count)) for k in range(0, count if HAS_EXTENDED else 0, self._step)]

    def at(self, part: slice) -> dict[str, AnyArray]:
        """Return results by name at the states of a slice from `parts`."""
        if part.start not in self._known:
            states = self.states[part.start : part.start + self._step]
            self._known[part.start] = evaluate_arrays(self.traced, states, self.values, EXTENDED)
        return {name: entries[: part.stop - part.start] for name, entries in self._known[part.start].items()}


def measure(
    reference: Reference,
    results: ComputedResults,
    precision: Precision = DOUBLE,
    *,
    count: int | None = None,
    seed: int = 0,
    cancelling: bool = True,
) -> Errors:
    """Return the errors of `results`, computed in this precision at the first `count` states of a reference, or at all.

    States and values are exact as they are: where the arrays of the precision do not hold them (`round_states`,
    `rounded_values` do), their rounding is part of the error. Where cancelling terms do not make errors grow, as in
    double-double, they need not count for the bound.
    Some 20 000 states a second for a 6-joint arm; a thousand times fewer in double-double, or where numpy has no
    extended precision. Raises `InputError` where python-flint is missing, `ValueError` for results of other shapes.
    """
    judge = _Judge(reference, results, precision, len(reference.states) if count is None else count)
    states = len(judge.states)
    errors, effects = np.full((2, states), np.nan)
    sizes: list[Sizes] = []
    for part in reference.parts(states):
        wanted = reference.at(part)
        errors[part] = judge.quickly(part, wanted)
        effects[part] = judge.effects(part, wanted, np.random.default_rng([seed, part.start]))
        sizes.append(judge.sizes(part, wanted))
    judge.prove_worst(errors)
    judge.prove_worst_effect(errors, effects, random.Random(seed))
    return _summary(errors, effects, judge.u, _unseen(errors, sizes if cancelling else ()))


def _unseen(errors: Array, sizes: Sequence[Sizes]) -> float:
    """Return the bound on errors at other states, in u."""
    judged = ~np.isnan(errors)
    bounds = [bound_of_more(np.maximum(errors[judged], LEAST_ERROR), UNSEEN)] if judged.any() else [math.inf]
    for name in sizes[0] if sizes else ():
        absolute, largest = (np.concatenate([part[name][k] for part in sizes]) for k in (0, 1))
        there = judged & (largest > EXTENDED_ZERO)
        if there.any():
            floor = np.maximum(absolute[there], LEAST_ERROR * largest[there].min())
            bounds.append(bound_of_quotients(floor, largest[there], UNSEEN))
    return max(bounds)


def _summary(errors: Array, effects: Array, u: float, unseen: float) -> Errors:
    judged = ~np.isnan(errors)
    if not judged.any():
        return Errors(u, math.nan, math.nan, math.nan, math.nan, judged=0, at=-1, unseen=math.inf)
    at, moved = int(np.nanargmax(errors)), ~np.isnan(effects[judged])
    return Errors(
        u,
        worst=float(errors[at]),
        typical=float(np.median(errors[judged])),
        input_effect=float(np.nanmax(effects[judged])) if moved.any() else math.nan,
        typical_input_effect=float(np.nanmedian(effects[judged])) if moved.any() else math.nan,
        judged=int(judged.sum()),
        at=at,
        unseen=unseen,
    )


class _Judge:
    """Compares the results of a model with exact results."""

    def __init__(self, reference: Reference, results: ComputedResults, precision: Precision, count: int) -> None:
        self.traced, self.states, self.values = reference.traced, reference.states[:count], reference.values
        outputs = self.traced.program.outputs
        self.results = {output.name: _parts(results[output.name], len(self.states)) for output in outputs}
        self.u = 2.0**-precision.bits
        self.inputs = TYPES[precision.state]
        self.is_extended_enough = HAS_EXTENDED and precision.bits <= MOST_EXTENDED_BITS
        self.most = float(np.finfo(np.float32 if precision.real == "float" else np.float64).max)

    def quickly(self, part: slice, wanted: Mapping[str, AnyArray]) -> Array:
        """Return errors, in u, NaN where extended precision is not enough."""
        errors: Array = _distance(self._results(part), wanted) / self.u
        within = [(np.abs(entries) <= self.most).all(axis=1) for entries in wanted.values()]
        errors[~np.logical_and.reduce(within)] = np.nan
        return errors

    def sizes(self, part: slice, wanted: Mapping[str, AnyArray]) -> Sizes:
        """Return absolute errors, in u, and the largest exact entries, by result."""
        differences = _differences(self._results(part), wanted)
        with np.errstate(over="ignore"):
            return {name: (np.asarray(x / self.u, float), np.asarray(y, float)) for name, (x, y) in differences.items()}

    def _results(self, part: slice) -> dict[str, list[AnyArray]]:
        return {name: [x[part] for x in parts] for name, parts in self.results.items()}

    def effects(self, part: slice, wanted: Mapping[str, AnyArray], rng: np.random.Generator) -> Array:
        """Return the largest effect of moved inputs at the first states, in u; NaN at all others."""
        effects = np.full(part.stop - part.start, np.nan)
        some = slice(0, max(0, MOVED_STATES - part.start))
        states = self.states[part][some]
        for _ in range(math.ceil(LEAST_MOVES / len(self.states)) if len(states) else 0):
            other = evaluate_arrays(self.traced, *self._perturb(states, rng), EXTENDED)
            effect = _distance({name: [x] for name, x in other.items()}, {name: x[some] for name, x in wanted.items()})
            effects[some] = np.fmax(effects[some], effect / self.u)
        return effects

    def _perturb(self, states: States, rng: np.random.Generator) -> tuple[States, Parameters]:
        """Return every input one ulp up or down, at random; parameters become one number a state."""

        def off(x: Array) -> Array:
            return np.asarray(self._off(x, np.where(rng.random(x.shape) < 0.5, -np.inf, np.inf)))

        return states.map(off), {name: off(np.full(len(states), value)) for name, value in self.values.items()}

    def _off(self, x: Any, towards: Any) -> Any:
        """Return numbers one ulp of the precision off."""
        rounded = np.asarray(x, self.inputs)
        return x + (np.nextafter(rounded, np.asarray(towards, self.inputs)).astype(float) - rounded.astype(float))

    def prove_worst(self, errors: Array) -> None:
        """Replace errors by proven ones: all unknown ones, then the largest until it is proven."""
        unknown = np.isnan(errors) | (not self.is_extended_enough)
        proven: set[int] = set(np.flatnonzero(unknown).tolist())
        for state in proven:
            errors[state] = self.exactly(state)
        while not np.isnan(errors).all() and (worst := int(np.nanargmax(errors))) not in proven:
            errors[worst] = self.exactly(worst)
            proven.add(worst)

    def prove_worst_effect(self, errors: Array, effects: Array, source: random.Random) -> None:
        """Replace effects of the inputs by proven ones, largest first, where extended precision may be too coarse."""
        spoilt = errors * (EXTENDED_U / self.u) > effects / 16
        proven: set[int] = set()
        while not np.isnan(effects).all() and (worst := int(np.nanargmax(effects))) not in proven and spoilt[worst]:
            moves = math.ceil(LEAST_MOVES / len(self.states))
            effects[worst] = max(self._exact_effect(worst, source) for _ in range(moves))
            proven.add(worst)

    def _exact_effect(self, state: int, source: random.Random) -> float:
        symbols = self._symbols(state)
        moved = {name: self._off(x, source.choice((-math.inf, math.inf))) for name, x in symbols.items()}
        try:
            wanted, other = (self._enclose(inputs) for inputs in (symbols, moved))
        except NoEnclosure:
            return math.nan
        return max(distance(other[name], entries) for name, entries in wanted.items()) / self.u

    def _symbols(self, state: int) -> dict[str, float]:
        symbols = dict(self.values)
        for argument in self.traced.program.inputs:
            symbols |= zip(argument.symbols, getattr(self.states, argument.name)[state].tolist(), strict=True)
        return symbols

    def _enclose(self, symbols: Mapping[str, float]) -> dict[str, Balls]:
        return enclosures(self.traced.program, symbols, self.u * ENCLOSURE_WIDTH)

    def exactly(self, state: int) -> float:
        """Return the proven error at a state; NaN where the exact results are out of range or do not exist."""
        try:
            wanted = self._enclose(self._symbols(state))
        except NoEnclosure:
            return math.nan
        if any(entry.abs_lower() > self.most for entries in wanted.values() for entry in entries):
            return math.nan
        computed = {name: sums([x[state].tolist() for x in self.results[name]]) for name in wanted}
        return max((distance(computed[name], entries) / self.u for name, entries in wanted.items()), default=0.0)


def _parts(results: AnyArray | Sequence[AnyArray], states: int) -> list[AnyArray]:
    """Return the arrays whose sum a result is, one row a state."""
    parts = [results] if isinstance(results, np.ndarray) else list(results)
    return [np.asarray(x).reshape(states, -1) for x in parts]


def _differences(
    results: Mapping[str, Sequence[AnyArray]], wanted: Mapping[str, AnyArray]
) -> dict[str, tuple[AnyArray, AnyArray]]:
    """Return by result the largest difference and the largest exact entry at each state."""
    differences = {}
    with np.errstate(all="ignore"):
        for name, exact in wanted.items():
            apart = np.abs(results[name][0] - exact + sum(results[name][1:]))
            differences[name] = apart.max(axis=1, initial=0), np.abs(exact).max(axis=1, initial=0)
    return differences


def _distance(results: Mapping[str, Sequence[AnyArray]], wanted: Mapping[str, AnyArray]) -> Array:
    """Return by state the largest difference over the largest exact entry, of the worst result."""
    worst = np.zeros(len(next(iter(wanted.values()))))
    with np.errstate(all="ignore"):
        for difference, scale in _differences(results, wanted).values():
            relative = (difference / np.where(scale > EXTENDED_ZERO, scale, 1)).astype(float)
            worst = np.maximum(worst, np.where(np.isfinite(relative), relative, np.inf))
    return worst


Balls = list[Any]


# Exact values of programs, enclosed in balls: numbers with a proven bound of their error (python-flint's arb).
class NoEnclosure(ArithmeticError):
    """No finite enclosure exists: the model divides by zero at this state, or by a number within rounding of it."""


def enclosures(program: Program, symbols: Mapping[str, float], negligible: float) -> dict[str, Balls]:
    """Return results of a program by name, entry by entry, for these exact inputs.

    Precision is raised until every radius is below `negligible` times the largest entry of its result, or the
    result is proven zero. Raises `NoEnclosure`, and `InputError` where python-flint is missing.
    """
    flint = _flint()
    bits = FIRST_BITS
    while bits <= MOST_BITS:
        with flint.ctx.workprec(bits):
            results = _evaluate(program, symbols)
            if all(_is_tight(entries, negligible) for entries in results.values()):
                return results
        bits *= 2
    raise NoEnclosure(f"no enclosure with {MOST_BITS} bits: the model divides by a number within rounding of zero")


def sums(parts: Sequence[Sequence[float]]) -> Balls:
    """Return the exact sums of corresponding numbers of several sequences."""
    flint = _flint()
    with flint.ctx.workprec(FIRST_BITS):
        return [sum(map(flint.arb, entry), flint.arb(0)) for entry in zip(*parts, strict=True)]


def distance(computed: Balls, entries: Balls) -> float:
    """Return the largest difference from enclosed entries over the largest entry, or over 1 where all are zero.

    A proven upper bound, infinite where an entry found is not finite.
    """
    flint = _flint()
    if not all(x.is_finite() for x in computed):
        return math.inf
    with flint.ctx.workprec(2 * FIRST_BITS):
        difference = max((abs(x - y).upper() for x, y in zip(computed, entries, strict=True)), default=flint.arb(0))
        return float((difference / scale(entries)).upper())


def scale(entries: Balls) -> Any:
    """Return the largest entry, from below; 1 where all are zero."""
    largest = max((entry.abs_lower() for entry in entries), default=0)
    return largest if largest > PROVEN_ZERO else _flint().arb(1)


def _is_tight(entries: Balls, negligible: float) -> bool:
    if not all(entry.is_finite() for entry in entries):
        return False
    largest = max((entry.abs_lower() for entry in entries), default=0)
    allowed = largest * negligible if largest > PROVEN_ZERO else PROVEN_ZERO
    return all(entry.rad() <= allowed for entry in entries)


def _evaluate(program: Program, symbols: Mapping[str, float]) -> dict[str, Balls]:
    balls, arb = _arithmetic(), _flint().arb
    value = evaluate_nodes(program.nodes, {name: arb(x) for name, x in symbols.items()}, balls)
    return {output.name: [value(x) for x in output.entries] for output in program.outputs}


@cache
def _arithmetic() -> Arithmetic[Any]:
    flint = _flint()
    arb = flint.arb

    def number(x: Fraction | int) -> Any:
        return arb(flint.fmpq(*Fraction(x).as_integer_ratio()))

    return Arithmetic(number, library(arb, {SIGN: arb.sgn, MINIMUM: arb.min, MAXIMUM: arb.max, COSPI: arb.cos_pi}))


@cache
def _flint() -> Any:
    return import_optional("flint", "an error bound", "accuracy")
