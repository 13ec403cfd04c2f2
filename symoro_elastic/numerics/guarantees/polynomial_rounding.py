"""Proven rounding errors of polynomials: sums of the errors of operations times derivatives of the result by them.

**Lemma.** Let operation i of a program without quotients be wrong by e_i, at most w_i u times the magnitude of its
exact value from computed operands, z_i its value, a_i the derivative of the result by it. Then

    |computed - exact| <= u sum w_i |a_i| |z_i| + u sum w_i m(a_i) m(z_i) ((1 + u)^k - 1)

where m are sums of magnitudes of the products that a_i and z_i are when written out, and k bounds how often one of a_i
and one of z_i are rounded together. *Proof.* The computed values solve z~ = op(z~) + e. For a product,
x~ y~ - x y = (x~ - x) y~ + x (y~ - y), so the differences obey a linear recursion, and that of the result is
sum b_i e_i: b_i is a_i written out, with z~ in place of z at some places. z~ written out is z with factors (1 + d),
|d| <= u, at most k' to a product. So b_i is within ((1 + u)^k' - 1) m(a_i) of a_i, and what bounds e_i as close to z_i.

In place of |z_i| may stand r_i, the largest power of two below its largest value: rounding is at most u r_i. Sines and
cosines are below 1, so theirs is 1/2: 1.5 units of the last place are 3/2 u at most. Of w_i |a_i z_i| and w_i r_i |a_i|
each summand has the one whose largest value at the nodes of the axes is smaller; both bound it, at every state.

A quotient by a constant is the product with its reciprocal, whose error is that of the constant, which is rounded, too.

**The first sum, proven.** a_i z_i is a polynomial of the degrees of the result or less: its values at the nodes of all
axes determine its coefficients (`axes.py`). Those that belong to one harmonic of each angle, cosines and sines, are the
coefficients of a product of vectors (cos k phi, sin k phi) of length 1: their part is at most the root of the sum of
their squares. Functions of slides and arcs are at most 1, as is each product of the motion. So

    sup |a_i z_i| <= sum over harmonics, and products of the motion, of these roots.

Most of this sum is bounded at once, on a grid of some angles: no state has all parts at their
largest. Variables that stand inside of sines and outside are two (`polynomials.py`). The bound of the first torque of a
heavy arm on whole turns is 19 times the worst error found: 7 times because not all errors add up there, 1.5 times for
powers of two, which vary by state, 1.2 times for products of the motion; the rest is lost in positions.

**A sum on a grid.** The largest value of sum w_i |f_i| is less than the sum of their largest. *Lemma.* Let f_i(x, y, s)
be polynomials of positions x, of positions y and of the motion s. Each is a sum, over the products of s and over the
harmonics of y, of polynomials c_ik(x). With |c|_k the magnitude of the coefficients of one harmonic (for turns the root
of the sum of squares of those of cosine and sine; each other function is at most 1),

    sum w_i |f_i(x, y, s)| <= S(x) = sum_i w_i sum_k |c_ik(x)|  <=  product of 1/cos(pi m_j/N_j) max of S over a grid

where x_j is an axis of order m_j with N_j points. *Proof.* The first part are the triangle inequality and that of
Cauchy. |c|_k is the largest of linear combinations of its coefficients, so S is the largest of a family of fixed
linear combinations of polynomials of x, which are polynomials of the same orders: lemma 4 holds for it (`axes.py`).

Few x are enough: those for which the sum falls most, as a sample of the f_i shows, and as many as are worth their work.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple

import numpy as np

from symoro_elastic.codegen.c.printers import is_given
from symoro_elastic.foundation.array_types import AnyArray
from symoro_elastic.numerics.guarantees.axes import TURN, UNIT, Axis, of_harmonics
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.largest_value import axes_of
from symoro_elastic.numerics.guarantees.polynomials import (
    NotPolynomial,
    Polynomial,
    circular,
    constants,
    degrees_of,
    number,
    polynomial_of,
    separate_sides,
    values_of,
    variable,
)
from symoro_elastic.numerics.guarantees.running_error import OF_CIRCLE, Rounding, constant_error, is_power_of_two, ufp
from symoro_elastic.symbolic import operations
from symoro_elastic.symbolic.expression import Expression, Level, Operand, reachable
from symoro_elastic.symbolic.operations import COS, SIN, SYMBOL

MOST_NODES = 40_000
SHARE = 0.96
"""Fraction of the first sum that is bounded on a grid."""
BELOW_ONE = 0.5
"""The largest power of two below 1."""
SAMPLED = 12
"""Number of summands from which the grid is chosen."""
MOST_SAMPLED = 8
"""Number of largest polynomials by sampled summand."""
RATIOS = (8, 10, 12, 16)
"""Points of a grid over the order of the axis: factors of 1.08, 1.05, 1.04 and 1.02."""
MOST_WORK = 5e9
"""Limit of the work (values of coefficients) on a grid."""
PRICE = 0.05
"""Exponent of work: twice as much of it has to make a bound smaller by 3 % (2^-0.05)."""
MOST_AXES = 3
AT_ONCE = 2**18
"""Values of coefficients that fit the processor's cache."""
ONE = np.ones((1, 1), np.float32)
"""The basis of an axis that polynomials do not depend on."""
SINGLE_UNIT = 2.0**-24
OUTWARDS = 1 + 1e-6


@dataclass(frozen=True)
class RoundingBound:
    """A proven bound of a result's rounding error, in its unit; `crude` uses sums of magnitudes only.

    `bound` is infinite, and `reason` says why, where the result is not a polynomial.
    """

    bound: float
    crude: float
    reason: str = ""


@dataclass(frozen=True)
class _Program:
    """A program for the sweeps: nodes in order, constants, values at the nodes of the axes, numbers of angles."""

    nodes: Sequence[Expression]
    axes: Sequence[Axis]
    constants: Mapping[int, float]
    values: Mapping[int, Polynomial]
    angles: Collection[int]
    numbers: Mapping[str, float]

    @cached_property
    def amplification(self) -> float:
        """Bound of the factor from errors of values at the nodes to errors of the polynomial."""
        return math.prod(axis.amplification for axis in self.axes)

    @cached_property
    def spread(self) -> float:
        """Bound of the relative error of coefficients from values at the nodes, over `amplification`."""
        return sum(axis.mismatch + 2 * axis.basis_error + 8 * len(axis.orders) * UNIT for axis in self.axes)

    def missing(self, x: Polynomial) -> float:
        """Bound of the sum of errors of a polynomial's coefficients, from its values at the nodes."""
        return x.size * len(x.terms) * (x.roundings * UNIT + self.spread) * self.amplification

    def value(self, x: Operand) -> Polynomial:
        return polynomial_of(x, self.values)


def rounding_bound(root: Operand, box: Box, rounding: Rounding) -> RoundingBound:
    """Return a bound of the rounding error of an expression over a box, carried out as it stands.

    Arguments are exact; constants are rounded once; fused products round less. Where there are more than `MOST_NODES`
    nodes of axes, the bound is the crude one.
    """
    if type(root) is not Expression:
        error = float(constant_error(root, rounding))
        return RoundingBound(error, error)
    (copy,), box = separate_sides([root], box, signs=not rounding.is_mixed)
    root = copy if type(copy) is Expression else root
    try:
        circles = [node for node in reachable([root]) if node.operation in (SIN, COS) and node.level == Level.STATE]
        if rounding.is_mixed and not all(is_given(node.operands[0]) for node in circles):
            raise NotPolynomial("an angle is computed in single precision")
        degrees = degrees_of([root], box)
        axes = axes_of(degrees, box)
        few = math.prod(len(axis.nodes) for axis in axes) <= MOST_NODES
        motion = sorted({*degrees.powers} - {axis.name for axis in axes})
        program = _program(reachable([root]), axes, box, motion, few)
    except NotPolynomial as error:
        return RoundingBound(math.inf, math.inf, str(error))
    return _bound(program, root, rounding, few)


def _program(nodes: Sequence[Expression], axes: Sequence[Axis], box: Box, motion: Sequence[str], few: bool) -> _Program:
    numbers = box.numbers
    moving = {name: variable(k, box.ranges[name]) for k, name in enumerate(motion)}
    fixed = {name: number(x, 0) for name, x in numbers.items()}
    constant_values = constants(nodes, {})
    _refuse_work_on_parameters(nodes, constant_values)
    values = values_of(nodes, fixed | moving | _at_nodes(axes, few), constant_values)
    angles: set[int] = set()
    for node in reversed(nodes):
        if node.operation in (SIN, COS) or (node.id in angles and node.operation != SYMBOL):
            angles |= {x.id for x in node.operands if type(x) is Expression}
    return _Program(nodes, axes, constant_values, values, angles, numbers)


def _at_nodes(axes: Sequence[Axis], few: bool) -> dict[str, Polynomial]:
    """Return the positions at all nodes, or in the middle only; their size is that over the range."""
    positions = {}
    for j, axis in enumerate(axes):
        nodes = axis.nodes if few else np.array([axis.middle])
        size = max(abs(axis.low), abs(axis.high), float(np.abs(nodes).max()))
        positions[axis.name] = Polynomial({(): nodes.reshape([-1 if k == j else 1 for k in range(len(axes))])}, size, 0)
    return positions


def _refuse_work_on_parameters(nodes: Sequence[Expression], constant_values: Collection[int]) -> None:
    for node in nodes:
        if node.id not in constant_values and node.operation not in _PARTIALS and node.operation != SYMBOL:
            raise NotPolynomial(f"its {node.operation} works on parameters: fold them to numbers")
        if node.operation == operations.DIVIDE and node.id not in constant_values:
            divisor = node.operands[1]
            if type(divisor) is Expression and divisor.id not in constant_values:
                raise NotPolynomial("it divides by parameters: fold them to numbers")


def _bound(program: _Program, root: Expression, rounding: Rounding, refined: bool) -> RoundingBound:
    u = rounding.u
    crude = second_sum = 0.0
    sums: list[_Summand] = []
    for node, a in _derivatives(program, root):
        z = program.value(node)
        weight, relative, added = _weights(node, rounding, program)
        part, count = a.size * ((weight + relative) * z.size + added), a.roundings + z.roundings + 1
        crude += part
        second_sum += part * math.expm1(count * math.log1p(u)) + a.size * rounding.least / u
        if not refined or not part:
            continue
        sums.append(_summand(node, a, program, (weight, relative, added), math.expm1(count * math.log1p(u))))
    outwards = (1 + 4e-9) * u  # numbers in single precision are rounded twice, from text and from double
    first = min(_first_sum(program, root, sums), crude) if refined else crude
    return RoundingBound((first + second_sum) * outwards, (crude + second_sum) * outwards)


class _Summand(NamedTuple):
    """Bound of a node z's part in an error, of derivative a: `weight` |a z|, or `weight` |a| if `is_alone`, + `added`.

    `largest` bounds the first of the two.
    """

    node: int
    is_alone: bool
    weight: float
    largest: float
    added: float


def _summand(
    node: Expression, a: Polynomial, program: _Program, errors: tuple[float, float, float], growth: float
) -> _Summand:
    """Return the smaller bound of a node's term; computed values are larger by up to `growth` of their size."""
    weight, relative, added = errors
    z, alone = program.value(node), _largest(a, program)
    is_angle = node.id in program.angles
    size = z.size if is_angle else _largest(z, program)
    last = float(ufp(np.array(size + z.size * growth)))
    last = min(last, BELOW_ONE) if node.operation in (SIN, COS) else last
    of_a = weight * last + relative * size + added
    if is_angle:
        return _Summand(node.id, True, of_a, alone * of_a, 0.0)
    product = a * z
    if of_a * _largest_at_nodes(a) <= (weight + relative) * _largest_at_nodes(product) + added * _largest_at_nodes(a):
        return _Summand(node.id, True, of_a, alone * of_a, 0.0)
    return _Summand(node.id, False, weight + relative, (weight + relative) * _largest(product, program), added * alone)


def _largest_at_nodes(x: Polynomial) -> float:
    """Return the largest sum of magnitudes of coefficients at a node of the axes."""
    return float(np.max(sum((np.abs(values) for values in x.terms.values()), np.zeros(()))))


def _first_sum(program: _Program, root: Expression, sums: Sequence[_Summand]) -> float:
    """Return a bound of the first sum of errors: its largest terms together on a grid, the others individually."""
    alone = sum(summand.largest + summand.added for summand in sums)
    if not sums or not program.axes:
        return alone
    largest = [sums[k] for k in heaviest((summand.largest for summand in sums), SHARE)]
    parts = {summand.node: summand for summand in largest}

    def products(numbers: Collection[int]) -> Iterator[tuple[_Summand, Polynomial]]:
        for node, a in _derivatives(program, root):
            if node.id in numbers:
                summand = parts[node.id]
                yield summand, a if summand.is_alone else a * program.value(node)

    ratios = _ratios(program, products, largest)
    if not ratios:
        return alone
    grid, missing = SumOnGrid(program.axes, ratios), 0.0
    for summand, x in products(parts):
        missing += summand.weight * program.missing(x)
        for part in coefficients_of(x, program.axes):
            grid.add(summand.weight, part)
    remaining = alone - sum(summand.largest for summand in largest)
    return min(alone, grid.bound + missing * grid.factor + remaining * (1 + 1e-9))


def _ratios(
    program: _Program,
    products: Callable[[Collection[int]], Iterator[tuple[_Summand, Polynomial]]],
    chosen: Sequence[_Summand],
) -> Mapping[int, int]:
    """Return the best grid for a sample: summands evenly along the cumulative sum, with their largest polynomials."""
    cumulative = np.cumsum([summand.largest for summand in chosen])
    places = np.searchsorted(cumulative, (np.arange(SAMPLED) + 0.5) * (cumulative[-1] / SAMPLED))
    numbers = Counter(chosen[k].node for k in places)
    sample = []
    shapes: Counter[tuple[int, ...]] = Counter()
    for summand, x in products({summand.node for summand in chosen}):
        values = [np.asarray(v) for v in x.terms.values()]
        shapes.update(v.shape if v.ndim else (1,) * len(program.axes) for v in values)
        if summand.node in numbers:
            largest = sorted(x.terms, key=lambda key: -float(np.abs(x.terms[key]).max()))[:MOST_SAMPLED]
            part = Polynomial({key: x.terms[key] for key in largest}, x.size, x.roundings)
            weight = numbers[summand.node] / (_largest(x, program) or 1.0)
            sample.append((weight, [*coefficients_of(part, program.axes)]))
    return best_ratios(program.axes, sample, shapes)


def _derivatives(program: _Program, root: Expression) -> Iterator[tuple[Expression, Polynomial]]:
    """Yield computed and constant nodes, users first, with the derivatives of the root by them."""
    derivatives = {root.id: _ONE}
    for node in reversed(program.nodes):
        a = derivatives.pop(node.id, None)
        if a is None:
            continue
        yield node, a
        if node.id in program.constants or node.operation == SYMBOL:
            continue
        partials = _PARTIALS[node.operation]([*map(program.value, node.operands)])
        for x, partial in zip(node.operands, partials, strict=True):
            if type(x) is Expression:
                contribution = a * partial if isinstance(partial, Polynomial) else a if partial > 0 else -a
                derivatives[x.id] = derivatives[x.id] + contribution if x.id in derivatives else contribution


_ONE = number(1.0, 0)
_PARTIALS: dict[str, Callable[[Sequence[Polynomial]], tuple[Polynomial | int, ...]]] = {
    operations.ADD: lambda x: (1, 1),
    operations.SUBTRACT: lambda x: (1, -1),
    operations.NEGATE: lambda x: (-1,),
    operations.MULTIPLY: lambda x: (x[1], x[0]),
    operations.DIVIDE: lambda x: (_ONE / x[1], -(x[0] / x[1] / x[1])),
    SIN: lambda x: (circular(COS, x[0]),),
    COS: lambda x: (-circular(SIN, x[0]),),
}


def _weights(node: Expression, rounding: Rounding, program: _Program) -> tuple[float, float, float]:
    """Return error coefficients of an operation: rounding and constant factors by u and value, added constants by u."""
    if node.id in program.constants:
        return 1.0, 0.0, 0.0
    is_angle = node.id in program.angles
    if node.operation == SYMBOL:
        number = program.numbers.get(str(node.operands[0]), 0.0)
        is_exact = not constant_error(Fraction(number), rounding) and (is_angle or not rounding.is_mixed)
        return (0.0 if is_exact else 1.0), 0.0, 0.0
    if node.operation == operations.NEGATE:
        return 0.0, 0.0, 0.0
    if is_angle:
        share = rounding.u_angle / rounding.u
        return share, 0.0, share * _of_numbers(node, rounding.of_angles)
    if node.operation in (SIN, COS):
        return OF_CIRCLE * rounding.u_angle / rounding.u + rounding.is_mixed, 0.0, 0.0
    errors = _of_numbers(node, rounding)
    if node.operation in (operations.ADD, operations.SUBTRACT):
        return 1.0, 0.0, errors
    numbers = [x for x in node.operands if type(x) is not Expression]
    moves = any(is_power_of_two(x) for x in numbers)
    return (0.0 if moves else 1.0), sum(errors / abs(float(x)) for x in numbers), 0.0


def _of_numbers(node: Expression, rounding: Rounding) -> float:
    """Return the sum of representation errors of the constant operands of a node, in units of u."""
    return sum(float(constant_error(x, rounding)) for x in node.operands if type(x) is not Expression) / rounding.u


def _largest(x: Polynomial, program: _Program) -> float:
    """Return a bound of the largest value, with free signs of the motion, from values at all nodes."""
    bound = program.missing(x)
    for coefficients in coefficients_of(x, program.axes):
        squares = coefficients * coefficients
        for j, axis in enumerate(program.axes, start=1):
            if axis.kind == TURN:
                squares = of_harmonics(squares, j)
        bound += float(np.sqrt(squares).sum())
    return min(bound * (1 + 1e-9), x.size * (1 + 1e-9))


@dataclass
class SumOnGrid:
    """Bound of a weighted sum of magnitudes on a grid of some axes; `ratios` are points over order, by axis.

    Sums are computed in single precision; `off` bounds that rounding. Errors of the coefficients themselves are not
    included.
    """

    axes: Sequence[Axis]
    ratios: Mapping[int, int]
    total: AnyArray = field(default_factory=lambda: np.zeros(()))
    off: float = 0.0

    def __post_init__(self) -> None:
        rows = ((j, axis, self.ratios.get(j)) for j, axis in enumerate(self.axes))
        self._bases = {j: axis.basis(axis.grid(r, max(axis.orders))).astype(np.float32) for j, axis, r in rows if r}

    @property
    def factor(self) -> float:
        """Bound of the ratio of the sum to its largest value on the grid."""
        return math.prod(1 / math.cos(math.pi / ratio) for ratio in self.ratios.values()) * OUTWARDS

    @property
    def bound(self) -> float:
        """Bound of the largest value of the sum."""
        return (float(self.total.max()) + self.off) * self.factor

    def add(self, weight: float, coefficients: AnyArray) -> None:
        """Add polynomials of the same shape, by their coefficients (polynomials, functions by axis)."""
        for polynomial in coefficients:
            self._add(weight, polynomial)

    def _add(self, weight: float, coefficients: AnyArray) -> None:
        scale = float(np.abs(coefficients).max()) or 1.0
        weight, sums = weight * scale, float(np.abs(coefficients).sum()) / scale
        gridded = sorted(self._bases)
        others = [j for j in range(len(self.axes)) if j not in self._bases]
        ordered = (coefficients / scale).transpose(*others, *gridded)
        shape = [*ordered.shape]
        values: AnyArray = np.ascontiguousarray(ordered, dtype=np.float32)
        bases = [self._bases[j] if coefficients.shape[j] > 1 else ONE for j in gridded] or [ONE]
        for place, basis in reversed([*enumerate(bases[1:], start=len(others) + 1)]):
            if shape[place] > 1:
                values = np.matmul(basis, values.reshape(math.prod(shape[:place]), shape[place], -1))
                shape[place] = len(basis)
        values = values.reshape(*shape[: len(others)], len(bases[0].T), -1)
        rows, magnitudes = self._sum_of_magnitudes(values, bases[0], others)
        points = (len(bases[0]), *shape[len(others) + 1 :]) if gridded else ()
        steps = 4 + sum(len(self.axes[j].orders) + 4 for j in gridded if coefficients.shape[j] > 1)
        self.total = self.total + weight * (1 + (rows + 16) * SINGLE_UNIT) * magnitudes.reshape(points).astype(float)
        self.off += weight * steps * SINGLE_UNIT * sums * OUTWARDS

    def _sum_of_magnitudes(self, values: AnyArray, basis: AnyArray, others: Sequence[int]) -> tuple[int, AnyArray]:
        """Return the number of added magnitudes, and their sum (points of the first axis of the grid, other points).

        `values` are (functions of the other axes, functions of the first axis, other points).
        """
        *lead, _, count = values.shape
        sums = np.empty((len(basis), count), np.float32)
        step = max(1, AT_ONCE // (math.prod(lead) * count))
        for start in range(0, len(basis), step):
            part = basis[start : start + step]
            squares = np.matmul(part, values).reshape(*lead, -1)
            np.multiply(squares, squares, out=squares)
            for place, j in enumerate(others):
                if self.axes[j].kind == TURN:
                    squares = of_harmonics(squares, place)
            magnitudes = np.sqrt(squares, out=squares)
            sums[start : start + step] = magnitudes.sum(axis=tuple(range(len(others)))).reshape(-1, count)
        return math.prod(magnitudes.shape[:-1]), sums


def coefficients_of(x: Polynomial, axes: Sequence[Axis]) -> Iterator[AnyArray]:
    """Yield the coefficients of a polynomial, from its values at the nodes of axes, stacked by shape.

    Every axis is transformed as the first one and becomes the last.
    """
    shapes: defaultdict[tuple[int, ...], list[AnyArray]] = defaultdict(list)
    for values in map(np.asarray, x.terms.values()):
        shape = values.shape or (1,) * len(axes)
        shapes[shape].append(values.reshape(shape))
    for of_shape in shapes.values():
        coefficients = np.stack(of_shape, axis=-1)
        for axis in axes:
            rows = coefficients.reshape(len(coefficients), -1)
            rows = axis.from_values @ rows if len(rows) > 1 else rows
            coefficients = rows.T.reshape(*coefficients.shape[1:], len(rows))
        yield coefficients


Sample = Sequence[tuple[float, Sequence[AnyArray]]]
"""Weights, and coefficients of polynomials by shape."""


def best_ratios(axes: Sequence[Axis], sample: Sample, numbers: Mapping[tuple[int, ...], int]) -> Mapping[int, int]:
    """Return the grid with the best ratio of bound and work for a sample, within `MOST_WORK`; empty without gain.

    `numbers` are the numbers of polynomials by shape.
    """
    best, least = {}, _bound_on(axes, {}, sample) * _work(axes, {}, numbers) ** PRICE
    chosen: dict[int, int] = {}
    for _ in range(min(MOST_AXES, len(axes))):
        more = [chosen | {j: RATIOS[0]} for j, axis in enumerate(axes) if j not in chosen and max(axis.orders)]
        candidates = [(_bound_on(axes, x, sample), x) for x in more if _work(axes, x, numbers) <= MOST_WORK]
        if not candidates:
            break
        sample_bound, chosen = min(candidates, key=lambda pair: pair[0])
        for ratio in RATIOS:
            finer = dict.fromkeys(chosen, ratio)
            work = _work(axes, finer, numbers)
            bound = sample_bound * SumOnGrid(axes, finer).factor / SumOnGrid(axes, chosen).factor * work**PRICE
            if bound < least and work <= MOST_WORK:
                best, least = finer, bound
    return best


def _bound_on(axes: Sequence[Axis], ratios: Mapping[int, int], sample: Sample) -> float:
    grid = SumOnGrid(axes, ratios)
    for weight, parts in sample:
        for part in parts:
            grid.add(weight, part)
    return grid.bound


def _work(axes: Sequence[Axis], ratios: Mapping[int, int], numbers: Mapping[tuple[int, ...], int]) -> float:
    """Work of polynomials on a grid: number of values of coefficients."""
    points = {j: len(axes[j].grid(ratio, max(axes[j].orders))) for j, ratio in ratios.items()}
    values = {shape: math.prod(points.get(j, n) if n > 1 else 1 for j, n in enumerate(shape)) for shape in numbers}
    return float(sum(count * values[shape] for shape, count in numbers.items()))


def heaviest(weights: Iterable[float], share: float) -> list[int]:
    """Return the indices of the largest weights whose sum is a `share` of the total, largest first."""
    sizes = np.array([*weights])
    order = np.argsort(-sizes)
    sums = np.cumsum(sizes[order])
    count = int(np.searchsorted(sums, share * sums[-1])) + 1 if len(sizes) else 0
    return [int(k) for k in itertools.islice(order, count)]
