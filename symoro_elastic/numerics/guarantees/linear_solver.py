"""Lemma 8, direct models through the inertia matrix: errors of x of A x = b, without following the elimination.

Errors grow by the depth of an elimination where they are followed from operation to operation; those of a matrix do
not. Let A be symmetric and positive definite in a box, and W a matrix without entry below zero such that, everywhere,

    d' A^-1 d <= |d|' W |d|        for all d

With the norm |v|_A = (v' A v)^(1/2) and Cauchy, |v_i| <= (W_ii)^(1/2) |v|_A, for v_i = (A^-1 e_i)' A v.

**Elimination.** The program has A~, b~ with |A~ - A| <= EA and |b~ - b| <= Eb, and carries out A~ = R' D^-1 R
(`mechanics/factorization.py`, L = D^-1 R): r_ik = A~_ik - sum r_ji r_jk/d_j over the j that come before i. Let each
term be rounded k times, sums excluded. A sum of t such terms and of c, in any order, is s with
s (1 + h) = c - sum terms (1 + h'), |h|, |h'| <= g(t + k), g(m) = m u/(1 - m u), for roundings that c has, too, cancel
(N. Higham, Accuracy and Stability of Numerical Algorithms, lemma 8.4). So, with all d_j > 0,

    |A~ - R' D^-1 R|_ik <= g(t_ik + k) sum |r_ji||r_jk|/d_j <= g(t_ik + k) (p_i p_k)^(1/2),   p_i = sum r_ji^2/d_j

by Cauchy, and p_i <= A~_ii/(1 - g). The same holds for both substitutions, where matrices R' D^-1 and R are off by
g(f_i + k) and g(f'_j + k) of their entries. Together (A~ + F) x~ = b~ with

    |F_ik| <= sum_j (g(t_ik + k) + g(f_i + k) + g(f'_j + k)) |r_ji||r_jk|/d_j (1 + 4 g)
           <= (g(t_ik + k) + g(f_i + k) + max_j g(f'_j + k)) (1 + 4 g) (A~_ii A~_kk)^(1/2)

The first is smaller where entries beside the diagonal are: with r_ik = A~_ik - ..., d_j as below,

    |r_ik| <= rho_ik = |A_ik| + E_ik + sum_j rho_ji rho_jk W_jj/(1 - kappa)

**Pivots.** Let E = EA + |F|, c_i = (W_ii)^(1/2), kappa = c' E c < 1. Each A + G with |G| <= E has
|v' G v| <= kappa v' A v, hence (1 - kappa) A <= A + G <= (1 + kappa) A, and so are Schur complements: the computed d_j
are within kappa d_j of the exact ones, which are 1/W_jj or more. They are positive: multiply all roundings by s, and
let s rise from 0 to 1; until some d_j is zero the bounds hold, and d_j is at least 1 - kappa times the exact one, so
none gets there.

**Errors.** A (x~ - x) = (b~ - b) - (A~ - A + F) x~ = d. With q = |x~ - x|_A and |x|_A^2 = b' A^-1 b <= B = |b|' W |b|:

    |d| <= Eb + E (X + q c) = e + q v,   |x_i| <= X_i <= c_i B^(1/2),   q^2 = d' A^-1 d <= (e + q v)' W (e + q v)

bounds q where v' W v < 1, and |x~_i - x_i| <= c_i q. Several W may be used: each bounds q.

**Joint by joint.** The norm does not separate joints: a small inertia has the errors of the large ones. Where all
entries of the inverse are bounded, |A^-1| <= W, so are |x| <= |A^-1 m| + W |b - m|, for any m: signs in b count; and,
from any bound Y of |x~ - x|, |x~ - x| <= W (e + E Y), of which the smaller counts, and so on. The norm of x profits,
too: |x|_A^2 = b' x <= |b|' X.

**Inverses.** There are three ways to a W without entry below zero with d' A^-1 d <= |d|' W |d| in a box:

1. **Rotors.** A - diag(Ia) is positive semidefinite where bodies can exist, so W = diag(1/Ia) (lemma 5). It is always
   available where all joints have rotors, and ignores the bodies.
2. **Intervals.** A >= M - D in a sub-box (lemma 6), so W = |(M - D)^-1|.
3. **Entries.** |A^-1| <= W is such a W, too: in all cells of a box (`inverse_on_cells.py`), or from intervals of A.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial, reduce

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.models.programs.linear_system import LinearSystem
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.guarantees.axes import Axis, axis_of
from symoro_elastic.numerics.guarantees.box import FULL_TURN, Box, Parts
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.inverse_on_cells import Cells, near_inverses, verified_bounds
from symoro_elastic.numerics.guarantees.largest_value import WORK, largest
from symoro_elastic.numerics.guarantees.mean_value import errors_by_adjoints
from symoro_elastic.numerics.guarantees.polynomials import NotPolynomial, degrees
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, Bounds, Rounding, extend_bounds, running_errors
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Expression, Operand, reachable
from symoro_elastic.symbolic.operations import NEGATE, SYMBOL
from symoro_elastic.symbolic.program import Program

MOST_CELLS, MORE_CELLS = 5_000, 100_000
"""Maximum number of cells of positions; with polynomials."""
DRAWN = 500
"""Number of random states from which the middle of the range of an entry of b is estimated."""
OUTWARDS = 1 + 1e-9
"""Bound of the rounding of sums of nonnegative numbers."""
REPEATED = 3
"""Number of refinements of error bounds, joint by joint."""
MARGIN = 1e-9
"""Bound of the rounding of computations with matrices of unit diagonal."""
OUTWARDS_OF_INVERSES = 1 + 1e-6
MOST_NODES = 60_000


@dataclass(frozen=True)
class Solver:
    """The linear system of a program in a box, and W from its rotors; `polynomials` costs some seconds more."""

    system: LinearSystem
    box: Box
    rotors: Array
    polynomials: bool = False

    def of_program(self, to: Callable[[Operand], Operand], program: Program) -> Solver | None:
        """The solver of a program with reordered sums; None if that lacks entries of A or b."""
        system, present = self.system.map(to), {node.id for node in program.nodes}
        missing = any(isinstance(x, Expression) and x.positive.id not in present for x in system.entries)
        return None if missing else replace(self, system=system)

    @cached_property
    def _everywhere(self) -> tuple[Array, Array]:
        """Bounds of all entries of the inverse, and of |A^-1 m|, m the middle of the right side, in the whole box."""
        size = len(self.system.joints)
        bounds = on_cells(self.system.A, self.box, MORE_CELLS if self.polynomials else MOST_CELLS, self._right[0])
        return (bounds.W, bounds.solution) if bounds else (np.full((size, size, 1), np.inf), np.full((size, 1), np.inf))

    @cached_property
    def _right(self) -> tuple[Array, Array]:
        """Middles and half widths of the entries of b, by polynomials."""
        right = self.system.right
        if not self.polynomials:
            return np.zeros(len(right)), np.full(len(right), np.inf)
        states = self.box.states(DRAWN, np.random.default_rng(0))
        value = evaluate(right, states, arithmetic(np.float64))
        samples = [np.asarray(value(x), dtype=float) for x in right]
        middles = np.array([float(np.min(x) / 2 + np.max(x) / 2) for x in samples])
        pairs = zip(right, map(Fraction, middles), strict=True)
        return middles, np.array([largest(pair, self.box, work=WORK).bound for pair in pairs])

    @cached_property
    def _inner(self) -> list[Expression]:
        """The nodes of the elimination in order, including negations that the program may lack."""
        before = {node.id for node in reachable(self.system.entries)}
        return [node for node in reachable([*self.system.x, *self.system.pivots]) if node.id not in before]

    def __call__(self, bounds: Bounds, parts: Parts, adjoints: bool) -> Bounds:
        """Bounds of all nodes narrowed by lemma 8; with `adjoints` lemma 2 bounds the entries of A and b."""
        inputs = SystemBounds.of(self.system, self._closer(bounds) if adjoints else bounds)
        entries, solution = self._everywhere
        middle, half = (x[:, None] for x in self._right)
        b = inputs.b.meeting(Interval(middle - half * OUTWARDS, middle + half * OUTWARDS))
        with np.errstate(invalid="ignore"):
            most = np.fmin(
                inputs.x, solution + (entries * Interval(b.low - middle, b.high - middle).magnitude).sum(axis=1)
            )
            entries = np.fmin(entries, entries_by_intervals(inputs.A))
        inputs = replace(inputs, b=b, x=most * OUTWARDS)
        result = x_bounds(self.system, inputs, [self.rotors, by_intervals(inputs.A)], entries, bounds.rounding)
        inner = [node for node in self._inner if node.id in bounds.range]
        ranges = {node.id: bounds.range[node.id] for node in inner}
        proven: dict[int, Array] = {}
        for x, most, error in zip(self.system.x, result.magnitude, result.error, strict=True):
            if isinstance(x, Expression) and x.positive.id in ranges:
                ranges[x.positive.id] = ranges[x.positive.id].meeting(Interval(-most, most))
                proven[x.positive.id] = error
        for x, error in zip(self.system.pivots, result.pivot_error, strict=True):
            if isinstance(x, Expression):
                proven[x.positive.id] = error
        narrowings = {number: partial(Interval.meeting, x) for number, x in ranges.items()}
        narrowed = bounds.without(inner)
        extend_bounds(narrowed, inner, parts, narrowings=narrowings, proven=proven)
        return narrowed

    def _closer(self, bounds: Bounds) -> Bounds:
        """Bounds in which errors of the entries of A and b are reduced by lemma 2."""
        entries = [*{x.positive.id: x.positive for x in self.system.entries if isinstance(x, Expression)}.values()]
        errors = errors_by_adjoints(reachable(entries), entries, bounds)
        smaller = {x.id: np.minimum(bounds.error[x.id], error) for x, error in zip(entries, errors, strict=True)}
        return replace(bounds, error={**bounds.error, **smaller})


@dataclass(frozen=True)
class SystemBounds:
    """Bounds of A x = b by sub-box: ranges and errors of A (n, n, sub-boxes) and b (n, sub-boxes), largest |x|."""

    A: Interval
    A_error: Array
    b: Interval
    b_error: Array
    x: Array

    @classmethod
    def of(cls, system: LinearSystem, bounds: Bounds) -> SystemBounds:
        """The bounds of a system from those of the nodes of its program."""
        size = len(system.joints)

        def stack(entries: Sequence[Array]) -> Array:
            return np.array([np.broadcast_to(x, bounds.shape) for x in entries])

        def ranges(entries: Sequence[Operand]) -> Interval:
            intervals = [_range(x, bounds) for x in entries]
            return Interval(stack([x.low for x in intervals]), stack([x.high for x in intervals]))

        A, shape = [x for row in system.A for x in row], (size, size, -1)
        return cls(
            Interval(*(end.reshape(shape) for end in ranges(A))),
            stack([_error(x, bounds) for x in A]).reshape(shape),
            ranges(system.right),
            stack([_error(x, bounds) for x in system.right]),
            stack([_magnitude(x, bounds) for x in system.x]),
        )


def _range(x: Operand, bounds: Bounds) -> Interval:
    """The range of an entry, which may be the negation of a node."""
    if isinstance(x, Expression) and x.operation == NEGATE:
        return -bounds.range_of(x.positive)
    return bounds.range_of(x)


def _magnitude(x: Operand, bounds: Bounds) -> Array:
    """The largest magnitude of an entry; infinite for an entry that the program does not compute."""
    is_computed = not isinstance(x, Expression) or x.positive.id in bounds.range
    return _range(x, bounds).magnitude if is_computed else np.array(np.inf)


def _error(x: Operand, bounds: Bounds) -> Array:
    return bounds.error_of(x.positive if isinstance(x, Expression) else x)


@dataclass(frozen=True)
class SolutionBounds:
    """Errors and magnitudes of x and errors of pivots, by joint and sub-box; infinite where nothing is proven."""

    error: Array
    magnitude: Array
    pivot_error: Array


def x_bounds(
    system: LinearSystem, inputs: SystemBounds, bounds_of_inverse: Sequence[Array], entries: Array, rounding: Rounding
) -> SolutionBounds:
    """Bounds of the solution of a system by lemma 8; `bounds_of_inverse` are W, (n, n, sub-boxes) or (n, n, 1).

    `entries` is a W that bounds all entries of the inverse; infinite where there is none.
    """
    diagonal, b = np.einsum("iib->ib", inputs.A.high), inputs.b.magnitude
    with np.errstate(all="ignore"):
        inverses = np.array(np.broadcast_arrays(*bounds_of_inverse, entries, inputs.A.high)[:-1])
        c = np.sqrt(np.einsum("wiib->wib", inverses).min(axis=0))
        size = np.sqrt(_least(_form(inverses, b, b)))
        most = np.fmin(np.fmin(inputs.x, c * size * OUTWARDS), _times(entries, b))
        size = np.fmin(size, np.sqrt(np.einsum("ib,ib->b", b, most)) * OUTWARDS)
        most = np.fmin(most, c * size * OUTWARDS)
        lost = _underflow(system, diagonal, c, size, rounding)
        E = (inputs.A_error + _of_elimination(system, inputs, c, lost, rounding) + lost) * OUTWARDS
        kappa, v = _kappa(E, c), np.einsum("ikb,kb->ib", E, c) * OUTWARDS
        e = (inputs.b_error + np.einsum("ikb,kb->ib", E, most) + lost) * OUTWARDS
        q = np.where(kappa < 1, _least(_largest_norm(inverses, e, v)), np.inf)
        error = c * q * OUTWARDS
        for _ in range(REPEATED):
            error = np.fmin(error, _times(entries, e + _times(E, error)))
        pivot_error = np.where(kappa < 1, kappa, np.inf) * diagonal * OUTWARDS
    return SolutionBounds(*(np.where(np.isnan(x), np.inf, x) for x in (error, most, pivot_error)))


def _times(W: Array, x: Array) -> Array:
    """W x by sub-box for nonnegative numbers, rounded upwards."""
    return np.asarray((W * x).sum(axis=1) * OUTWARDS)


def _kappa(E: Array, c: Array) -> Array:
    return np.asarray(np.einsum("ib,ikb,kb->b", c, E, c) * OUTWARDS)


def _form(W: Array, x: Array, y: Array) -> Array:
    """x' W y by W and sub-box."""
    return np.asarray(np.einsum("ib,wikb,kb->wb", x, W, y) * OUTWARDS)


def _least(bounds: Array) -> Array:
    """The least of several bounds, by sub-box, ignoring NaN."""
    return np.asarray(np.min(np.where(np.isnan(bounds), np.inf, bounds), axis=0))


def _largest_norm(W: Array, e: Array, v: Array) -> Array:
    """The largest q with q^2 <= (e + q v)' W (e + q v), by W and sub-box."""
    denominator, across = 1 - _form(W, v, v), _form(W, v, e)
    root = np.sqrt(across**2 + denominator * _form(W, e, e))
    return np.asarray(np.where(denominator > 0, (across + root) / denominator * OUTWARDS, np.inf))


def _of_elimination(system: LinearSystem, inputs: SystemBounds, c: Array, lost: Array, rounding: Rounding) -> Array:
    """Bound, by sub-box, of the elimination's backward error |F_ik|: by A's diagonal, or by the factor R if smaller."""

    def g(count: Array) -> Array:
        times = (count + system.roundings) * rounding.u
        return times / (1 - times)

    shared, backward = g(system.shared) + g(system.forward)[:, None], g(system.backward)
    more = 1 + 4 * (shared.max() + backward.max())
    computed = np.einsum("iib->ib", inputs.A.high + inputs.A_error)
    F: Array = ((shared + backward.max()) * more)[..., None] * np.sqrt(computed[:, None] * computed)
    E = (inputs.A_error + F + lost) * OUTWARDS
    denominator = 1 - _kappa(E, c)
    inverse = np.where(denominator > 0, c**2 / denominator, np.inf)
    rho, most = inputs.A.magnitude + E, np.sqrt(computed[:, None] * computed) * more
    by_rows = np.zeros_like(F)
    for j in range(len(rho)):
        row = np.minimum(rho[j, j:], most[j, j:])
        terms = row[:, None] * row * inverse[j]
        terms[0] = terms[:, 0] = row
        by_rows[j:, j:] += (shared[j:, j:] + backward[j])[..., None] * terms
        rho[j + 1 :, j + 1 :] += terms[1:, 1:]
    return np.asarray(np.fmin(F, by_rows * more * OUTWARDS))


def _underflow(system: LinearSystem, diagonal: Array, c: Array, norm: Array, rounding: Rounding) -> Array:
    """Bound of the underflow in entries of A or b, by sub-box.

    A term, such as (r_ji (1/d_j)) r_jk, is off by the smallest number times a factor, and there are 3 n terms at most.
    """
    factors = 1 + diagonal.max(axis=0) + 1 / diagonal.min(axis=0) + c.max(axis=0) ** 2
    size = len(system.joints) + system.roundings
    return np.asarray(64 * size * rounding.least * (factors * (1 + c.max(axis=0) * norm)) ** 2)


def by_rotors(least: Mapping[int, Array], joints: Sequence[int]) -> Array:
    """W (n, n, 1) from rotors by joint; infinite where a joint has none."""
    with np.errstate(divide="ignore"):
        inverse = OUTWARDS_OF_INVERSES / np.array([float(least.get(j, np.zeros(1)).flat[0]) for j in joints])
    return np.array(np.diag(inverse)[..., None])


def by_intervals(A: Interval) -> Array:
    """W (n, n, sub-boxes) from the intervals of a matrix; infinite where it may be singular."""
    low, high = (np.moveaxis(end, -1, 0) for end in A)
    with np.errstate(all="ignore"):
        middle = low / 2 + high / 2
        scale = 1 / np.sqrt(np.einsum("bii->bi", middle))
        radius = np.maximum(high - middle, middle - low) * OUTWARDS_OF_INVERSES
        spread = np.einsum("bik,bk->bi", radius, scale) * scale
        off = (spread + MARGIN)[..., None] * np.eye(len(A.low))
        inverses = np.abs(near_inverses(middle * scale[:, :, None] * scale[:, None, :] - off, 1e3 * MARGIN))
        inverses += MARGIN * np.trace(inverses, axis1=1, axis2=2)[:, None, None]
        return np.moveaxis(inverses * scale[:, :, None] * scale[:, None, :], 0, -1)


def entries_by_intervals(A: Interval) -> Array:
    """A bound of all entries of A^-1 (n, n, sub-boxes) from the intervals of A; infinite where none is proven."""
    low, high = (np.moveaxis(end, -1, 0) for end in A)
    with np.errstate(all="ignore"):
        middle = low / 2 + high / 2
        scale = 1 / np.sqrt(np.einsum("bii->bi", middle))
        both = scale[:, :, None] * scale[:, None, :]
        radius = np.maximum(high - middle, middle - low) * both * OUTWARDS_OF_INVERSES + MARGIN
        C = near_inverses(middle * both)
        G = np.abs(np.eye(len(A.low)) - C @ (middle * both)) + np.abs(C) @ radius
        return np.moveaxis(verified_bounds(C, G, C) * both, 0, -1)


@dataclass(frozen=True)
class OnCells:
    """Bounds W (n, n, 1) of the entries of A^-1, and of |A^-1 d| (n, 1) for the requested d."""

    W: Array
    solution: Array


def on_cells(A: Sequence[Sequence[Operand]], box: Box, most: int, d: Array) -> OnCells | None:
    """Bounds from at most `most` cells of positions; None if entries are not polynomials, or nothing is proven."""
    entries = [x for row in A for x in row]
    try:
        axes = _axes(entries, box)
    except NotPolynomial:
        return None
    if math.prod(len(axis.nodes) for axis in axes) > MOST_NODES:
        return None
    at_nodes = _matrices(entries, len(A), box, {axis.name: axis.nodes for axis in axes})
    scale = 1 / np.sqrt(np.einsum("bii->bi", at_nodes).max(axis=0))
    both = scale[:, None] * scale
    values = (at_nodes * both).reshape(*(len(axis.nodes) for axis in axes), *both.shape)
    off = MARGIN + _rounding(entries, box, both)
    bounds = Cells.of(values, axes, [box.ranges[axis.name] for axis in axes], off).bounds(most, d * scale)
    if bounds is None:
        return None
    return OnCells((bounds[:, :-1] * both)[..., None], (bounds[:, -1] * scale)[:, None])


def _axes(entries: Sequence[Operand], box: Box) -> list[Axis]:
    """The axes of all entries, with full turns of angles; raises `NotPolynomial`."""
    moving = [x for x in entries if isinstance(x, Expression)]
    all_degrees = degrees(moving, box.numbers)
    both = reduce(lambda x, y: x + y, all_degrees) if all_degrees else None
    if both is None:
        return []
    turning = [axis_of(name, n, FULL_TURN, angle=True) for name, n in sorted(both.angles.items())]
    return turning + [axis_of(name, n, box.ranges[name], angle=False) for name, n in sorted(both.powers.items())]


def _matrices(entries: Sequence[Operand], size: int, box: Box, axes: Mapping[str, Array]) -> Array:
    """The matrices (points, n, n) at all combinations of values of the axes."""
    grid = np.meshgrid(*axes.values(), indexing="ij")
    states = {name: x.ravel() for name, x in zip(axes, grid, strict=True)}
    count = math.prod(len(x) for x in axes.values())
    value = evaluate(entries, {**box.numbers, **states}, arithmetic(np.float64))
    columns = [np.broadcast_to(np.asarray(value(x), dtype=float), count) for x in entries]
    return np.moveaxis(np.array(columns).reshape(size, size, count), -1, 0)


def _rounding(entries: Sequence[Operand], box: Box, both: Array) -> float:
    """Error bound (norm) of the matrices that are computed in double precision."""
    nodes = reachable(entries)
    used = [str(node.operands[0]) for node in nodes if node.operation == SYMBOL]
    bounds = running_errors(nodes, box.of(used).whole, ROUNDINGS["double"])
    errors = np.array([float(np.max(bounds.error_of(x))) for x in entries]).reshape(both.shape)
    return float(np.linalg.norm(errors * both)) * OUTWARDS_OF_INVERSES
