"""Proven rounding errors of polynomials: each operation's error times the derivative of the result by it.

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

Most of this sum is bounded at once, on a grid of some angles (`sum_on_grid.py`): no state has all parts at their
largest. Variables that stand inside of sines and outside are two (`separated.py`). The bound of the first torque of a
heavy arm on whole turns is 19 times the worst error found: 7 times because not all errors add up there, 1.5 times for
powers of two, which vary by state, 1.2 times for products of the motion; the rest is lost in positions.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple

import numpy as np

from symoro_elastic.codegen.c.printers import is_given
from symoro_elastic.numerics.guarantees.axes import TURN, UNIT, Axis, of_harmonics
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.coefficients import Polynomial, circular, constants, number, values_of, variable
from symoro_elastic.numerics.guarantees.degrees import NotPolynomial
from symoro_elastic.numerics.guarantees.running_error import OF_CIRCLE, Rounding, constant_error, is_power_of_two, ufp
from symoro_elastic.numerics.guarantees.separated import separated
from symoro_elastic.numerics.guarantees.sum_on_grid import SumOnGrid, best_ratios, coefficients_of, heaviest
from symoro_elastic.numerics.guarantees.surface import axes_of, degrees_of, numbers_in
from symoro_elastic.symbolic import operations
from symoro_elastic.symbolic.expression import Expression, Level, Operand, reachable
from symoro_elastic.symbolic.operations import COS, SIN, SYMBOL

MOST_NODES = 40_000
SHARE = 0.96
"""Of the first sum, what is bounded together."""
BELOW_ONE = 0.5
"""The largest power of two below 1."""
SAMPLED, MOST_SAMPLED = 12, 8
"""Summands that decide which grid is used, and the most polynomials of each."""


@dataclass(frozen=True)
class RoundingBound:
    """A proven bound of a result's rounding error, in its unit; `crude` is that of sums of magnitudes alone.

    `bound` is infinite, and `reason` says why, where the result is no polynomial.
    """

    bound: float
    crude: float
    reason: str = ""


@dataclass(frozen=True)
class _Program:
    """What the sweeps need: nodes in order, constants, values at the nodes of the axes, and which nodes are angles."""

    nodes: Sequence[Expression]
    axes: Sequence[Axis]
    known: Mapping[int, float]
    values: Mapping[int, Polynomial]
    angles: Collection[int]
    numbers: Mapping[str, float]

    @cached_property
    def grown(self) -> float:
        """At least what errors of values at the nodes are multiplied by."""
        return math.prod(axis.amplification for axis in self.axes)

    @cached_property
    def spread(self) -> float:
        """At least the relative error of coefficients from values at the nodes, over `grown`."""
        return sum(axis.mismatch + 2 * axis.basis_error + 8 * len(axis.orders) * UNIT for axis in self.axes)

    def missing(self, x: Polynomial) -> float:
        """At least the sum of errors of a polynomial's coefficients, from its values at the nodes."""
        return x.size * len(x.terms) * (x.roundings * UNIT + self.spread) * self.grown

    def value(self, x: Operand) -> Polynomial:
        return self.values[x.id] if type(x) is Expression else number(float(x))


def rounding_bound(root: Operand, box: Box, rounding: Rounding) -> RoundingBound:
    """Return a bound of the rounding error of an expression over a box, carried out as it stands.

    Arguments are exact; constants are rounded once; fused products round less. Where there are more than `MOST_NODES`
    nodes of axes, the bound is the crude one.
    """
    if type(root) is not Expression:
        error = float(constant_error(root, rounding))
        return RoundingBound(error, error)
    (copy,), box = separated([root], box, signs=not rounding.is_mixed)
    root = copy if type(copy) is Expression else root
    try:
        if rounding.is_mixed:
            _refuse_narrow_angles(reachable([root]))
        found = degrees_of(root, box)
        axes = axes_of(found, box)
        few = math.prod(len(axis.nodes) for axis in axes) <= MOST_NODES
        motion = sorted({*found.powers} - {axis.name for axis in axes})
        program = _program(reachable([root]), axes, box, motion, few)
    except NotPolynomial as error:
        return RoundingBound(math.inf, math.inf, str(error))
    return _bound(program, root, rounding, few)


def _program(nodes: Sequence[Expression], axes: Sequence[Axis], box: Box, motion: Sequence[str], few: bool) -> _Program:
    numbers = numbers_in(box)
    moving = {name: variable(k, box.ranges[name]) for k, name in enumerate(motion)}
    unused = {str(node.operands[0]): number(0.0) for node in nodes if node.operation == SYMBOL}
    given = {name: number(x, 0) for name, x in numbers.items()}
    known = constants(nodes, {})
    _refuse_work_on_parameters(nodes, known)
    values = dict(values_of(nodes, unused | given | moving | _at_nodes(axes, few), known))
    angles: set[int] = set()
    for node in reversed(nodes):
        if node.operation in (SIN, COS) or (node.id in angles and node.operation != SYMBOL):
            angles |= {x.id for x in node.operands if type(x) is Expression}
    return _Program(nodes, axes, known, values, angles, numbers)


def _at_nodes(axes: Sequence[Axis], few: bool) -> dict[str, Polynomial]:
    """Return the positions at all nodes, or in the middle only; their size is that over the whole range."""
    found = {}
    for j, axis in enumerate(axes):
        nodes = axis.nodes if few else np.array([axis.middle])
        size = max(abs(axis.low), abs(axis.high), float(np.abs(nodes).max()))
        found[axis.name] = Polynomial({(): nodes.reshape([-1 if k == j else 1 for k in range(len(axes))])}, size, 0)
    return found


def _refuse_narrow_angles(nodes: Sequence[Expression]) -> None:
    """In mixed precision some sines are those of angles in single precision."""
    for node in nodes:
        if node.operation in (SIN, COS) and node.level == Level.STATE and not is_given(node.operands[0]):
            raise NotPolynomial("an angle is computed in single precision")


def _refuse_work_on_parameters(nodes: Sequence[Expression], known: Collection[int]) -> None:
    for node in nodes:
        if node.id not in known and node.operation not in _PARTIALS and node.operation != SYMBOL:
            raise NotPolynomial(f"its {node.operation} works on parameters: fold them to numbers")
        if node.operation == operations.DIVIDE and node.id not in known:
            divisor = node.operands[1]
            if type(divisor) is Expression and divisor.id not in known:
                raise NotPolynomial("it divides by parameters: fold them to numbers")


def _bound(program: _Program, root: Expression, rounding: Rounding, refined: bool) -> RoundingBound:
    u = rounding.u
    crude = rest = 0.0
    sums: list[_Summand] = []
    for node, a in _derivatives(program, root):
        z = program.value(node)
        weight, relative, added = _weights(node, rounding, program)
        part, count = a.size * ((weight + relative) * z.size + added), a.roundings + z.roundings + 1
        crude += part
        rest += part * math.expm1(count * math.log1p(u)) + a.size * rounding.least / u
        if not refined or not part:
            continue
        sums.append(_summand(node, a, program, (weight, relative, added), math.expm1(count * math.log1p(u))))
    outwards = (1 + 4e-9) * u  # numbers in single precision are rounded twice, from text and from double
    first = min(_first_sum(program, root, sums), crude) if refined else crude
    return RoundingBound((first + rest) * outwards, (crude + rest) * outwards)


class _Summand(NamedTuple):
    """Of a node: its part of the first sum is at most `weight` |a z|, or |a| if `is_alone`, and `added`.

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
    """Return the part of a node: the smaller one of two; computed values are larger by `growth` of their size."""
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
    if of_a * _largest_seen(a) <= (weight + relative) * _largest_seen(product) + added * _largest_seen(a):
        return _Summand(node.id, True, of_a, alone * of_a, 0.0)
    return _Summand(node.id, False, weight + relative, (weight + relative) * _largest(product, program), added * alone)


def _largest_seen(x: Polynomial) -> float:
    """Return the largest sum of magnitudes of coefficients at a node of the axes."""
    return float(np.max(sum((np.abs(values) for values in x.terms.values()), np.zeros(()))))


def _first_sum(program: _Program, root: Expression, sums: Sequence[_Summand]) -> float:
    """Return a bound of the first sum: its largest parts, or most of it on a grid and the rest."""
    alone = sum(one.largest + one.added for one in sums)
    if not sums or not program.axes:
        return alone
    chosen = [sums[k] for k in heaviest((one.largest for one in sums), SHARE)]
    parts = {one.node: one for one in chosen}

    def products(numbers: Collection[int]) -> Iterator[tuple[_Summand, Polynomial]]:
        for node, a in _derivatives(program, root):
            if node.id in numbers:
                one = parts[node.id]
                yield one, a if one.is_alone else a * program.value(node)

    ratios = _ratios(program, products, chosen)
    if not ratios:
        return alone
    grid, missing = SumOnGrid(program.axes, ratios), 0.0
    for one, x in products(parts):
        missing += one.weight * program.missing(x)
        for part in coefficients_of(x, program.axes):
            grid.add(one.weight, part)
    others = alone - sum(one.largest for one in chosen)
    return min(alone, grid.bound + missing * grid.factor + others * (1 + 1e-9))


def _ratios(
    program: _Program,
    products: Callable[[Collection[int]], Iterator[tuple[_Summand, Polynomial]]],
    chosen: Sequence[_Summand],
) -> Mapping[int, int]:
    """Return the grid that is best for a sample: summands evenly along the sum, of each the largest polynomials."""
    reached = np.cumsum([one.largest for one in chosen])
    places = np.searchsorted(reached, (np.arange(SAMPLED) + 0.5) * (reached[-1] / SAMPLED))
    numbers = Counter(chosen[k].node for k in places)
    sample = []
    shapes: Counter[tuple[int, ...]] = Counter()
    for one, x in products({one.node for one in chosen}):
        values = [np.asarray(v) for v in x.terms.values()]
        shapes.update(v.shape if v.ndim else (1,) * len(program.axes) for v in values)
        if one.node in numbers:
            largest = sorted(x.terms, key=lambda key: -float(np.abs(x.terms[key]).max()))[:MOST_SAMPLED]
            part = Polynomial({key: x.terms[key] for key in largest}, x.size, x.roundings)
            sample.append((numbers[one.node] / (_largest(x, program) or 1.0), [*coefficients_of(part, program.axes)]))
    return best_ratios(program.axes, sample, shapes)


def _derivatives(program: _Program, root: Expression) -> Iterator[tuple[Expression, Polynomial]]:
    """Yield the nodes that are computed or are constants, users first, with the derivative of the root by each."""
    found = {root.id: _ONE}
    for node in reversed(program.nodes):
        a = found.pop(node.id, None)
        if a is None:
            continue
        yield node, a
        if node.id in program.known or node.operation == SYMBOL:
            continue
        for x, partial in zip(node.operands, _partials(node, [*map(program.value, node.operands)]), strict=True):
            if type(x) is Expression:
                own = a * partial if isinstance(partial, Polynomial) else a if partial > 0 else -a
                found[x.id] = found[x.id] + own if x.id in found else own


def _partials(node: Expression, x: Sequence[Polynomial]) -> tuple[Polynomial | int, ...]:
    """Return the derivative by each operand, a polynomial or a sign; a divisor is a constant, rounded once."""
    found: tuple[Polynomial | int, ...] = _PARTIALS[node.operation](x)
    return found


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
    """Return the errors of an operation: own and of constant factors by u and value; of added constants by u."""
    if node.id in program.known:
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
    """Return the errors of the numbers that are operands, by u."""
    return sum(float(constant_error(x, rounding)) for x in node.operands if type(x) is not Expression) / rounding.u


def _largest(x: Polynomial, program: _Program) -> float:
    """Return a bound of the largest value, with free signs of the motion, from values at all nodes."""
    found = program.missing(x)
    for coefficients in coefficients_of(x, program.axes):
        squares = coefficients * coefficients
        for j, axis in enumerate(program.axes, start=1):
            if axis.kind == TURN:
                squares = of_harmonics(squares, j)
        found += float(np.sqrt(squares).sum())
    return min(found * (1 + 1e-9), x.size * (1 + 1e-9))
