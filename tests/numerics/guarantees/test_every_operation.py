"""Every operation in every calculus: what is counted of its rounding is never below the worst error that is found.

Programs of one or two operations, whose operands are exact, numbers of the text that are hard to write, or rounded
before; states are drawn in boxes in which a rounding, a number or a sine is as wrong as it may be.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction

import numpy as np
import pytest

from symoro_elastic.codegen.c.printers import is_given
from symoro_elastic.codegen.printers import constant_values
from symoro_elastic.machine.limits import Range
from symoro_elastic.numerics.evaluation.arrays import EXTENDED, HAS_EXTENDED, arithmetic
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.dropped_terms import ChangedNodes, errors_of_changes
from symoro_elastic.numerics.guarantees.mean_value import errors_by_adjoints, forms_of
from symoro_elastic.numerics.guarantees.polynomial_rounding import rounding_bound
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, Rounding, running_errors
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Expression, Graph, Level, Operand, reachable
from symoro_elastic.symbolic.operations import ADD, ATAN2, COS, MAXIMUM, MINIMUM, OPERATIONS, SIGN, SIN, SQRT, SUBTRACT

pytestmark = pytest.mark.skipif(not HAS_EXTENDED, reason="no type is wider than double")

STATES = 4000
TYPES: Mapping[str, type] = {"double": np.float64, "single": np.float32, "mixed": np.float32}
HARD = {
    precision: max(
        (Fraction(k, 1000) for k in range(501, 999)), key=lambda c: abs(Fraction(float(TYPES[precision](float(c)))) - c)
    )
    for precision in TYPES
}
"""Numbers between 1/2 and 1 that are furthest from those of a precision: about half of their distance."""
CREEP = Fraction(1, 10_000)


def speed(graph: Graph, s: Operand, c: Fraction) -> Expression:
    """sqrt(s^2 + (c creep)^2)."""
    return graph.node(SQRT, s * s + (c * CREEP) ** 2)


def smooth(graph: Graph, s: Operand, c: Fraction) -> Operand:
    """The sign of a velocity, made smooth."""
    return s / speed(graph, s, c)


def cubed(x: Expression) -> Operand:
    """Its third power."""
    return x * x * x


TOGETHER: Mapping[str, Callable[[Graph, Fraction, Expression, Expression, Expression], Operand]] = {
    "sum": lambda g, c, x, y, v: x + y,
    "sum with a number": lambda g, c, x, y, v: x + 3 * c,
    "sum of products": lambda g, c, x, y, v: x * y + x * c,
    "difference": lambda g, c, x, y, v: x - y,
    "difference from a number": lambda g, c, x, y, v: 3 * c - x,
    "difference that cancels": lambda g, c, x, y, v: x * c - y * c,
    "change of sign": lambda g, c, x, y, v: g.node("neg", x * c),
    "product": lambda g, c, x, y, v: x * y,
    "product with a number": lambda g, c, x, y, v: x * c,
    "product with a power of two": lambda g, c, x, y, v: x * c * 4,
    "product with a hard constant": lambda g, c, x, y, v: x * (g.pi * c),
    "square of what is rounded": lambda g, c, x, y, v: (x * c) * (x * c),
    "product that is lost": lambda g, c, x, y, v: x * Fraction(2) ** -140 * c * Fraction(2) ** -11,
    "quotient": lambda g, c, x, y, v: x / y,
    "quotient of what is rounded": lambda g, c, x, y, v: (x * c) / (y * c),
    "quotient by a number": lambda g, c, x, y, v: x / c,
    "quotient by a constant": lambda g, c, x, y, v: x / (g.pi * 2) * c,
    "quotient by a power of two": lambda g, c, x, y, v: x * c / 4,
    "quotient of a number": lambda g, c, x, y, v: c / x,
    "constant": lambda g, c, x, y, v: g.pi * c + 0 * x,
    "cosine of a part of pi": lambda g, c, x, y, v: x + g.node("cospi", c / 2),
    "sine": lambda g, c, x, y, v: g.node(SIN, v),
    "cosine": lambda g, c, x, y, v: g.node(COS, v),
    "sine of a sum": lambda g, c, x, y, v: g.node(SIN, v + 2 * y) * x,
    "sine of an angle and a number": lambda g, c, x, y, v: g.node(SIN, v + 16 * c) * x,
    "cosine of an angle and a constant": lambda g, c, x, y, v: g.node(COS, v + g.pi * c),
    "sine of what is rounded": lambda g, c, x, y, v: g.node(SIN, v * c),
    "sine and its angle": lambda g, c, x, y, v: g.node(SIN, v) * v + v * c,
    "root": lambda g, c, x, y, v: g.node(SQRT, x),
    "root of what is rounded": lambda g, c, x, y, v: g.node(SQRT, x * x + c),
    "arc tangent": lambda g, c, x, y, v: g.node(ATAN2, y, -x),
    "arc tangent of what is rounded": lambda g, c, x, y, v: g.node(ATAN2, y * c, x * y),
    "arc tangent that jumps": lambda g, c, x, y, v: g.node(ATAN2, x * c - y * c, -x),
    "arc tangent of a zero with a sign": lambda g, c, x, y, v: g.node(ATAN2, -g.symbol("w"), -x),
    "sign": lambda g, c, x, y, v: g.node(SIGN, v) * c,
    "sign of what is rounded": lambda g, c, x, y, v: g.node(SIGN, x * y * c - x * (y * c)) * x,
    "sign of a rounded difference": lambda g, c, x, y, v: g.node(SIGN, -(3 * (x - y))) * c,
    "smooth sign": lambda g, c, x, y, v: smooth(g, g.symbol("s"), c) * c,
    "smooth sign of what is rounded": lambda g, c, x, y, v: smooth(g, g.symbol("s") * 2 * c, c),
    "its slope": lambda g, c, x, y, v: c * c * CREEP / cubed(speed(g, g.symbol("s"), c)),
    "Stribeck's law": lambda g, c, x, y, v: c / ((g.symbol("s") / CREEP) * (g.symbol("s") / CREEP) + 1),
    "minimum": lambda g, c, x, y, v: g.node(MINIMUM, x * c, y),
    "maximum": lambda g, c, x, y, v: g.node(MAXIMUM, x * c, y * c * c),
    "maximum and a number": lambda g, c, x, y, v: g.node(MAXIMUM, x - 1, c / 8),
}
"""Operations by their operands: x and y within 1 to 1.3, v around 3 pi, w from 0 on, a number c."""
RANGES = {"x": Range(1.0, 1.3), "y": Range(1.0, 1.3), "v": Range(9.3, 9.5), "w": Range(0.0, 0.1), "s": Range(-2.0, 2.0)}
BOX = Box(RANGES, frozenset({"v"}))


def test_all_operations_are_here() -> None:
    c = HARD["double"]
    made = [build(Graph(), c, *_variables(Graph())) for build in TOGETHER.values()]
    assert {node.operation for x in made for node in reachable([x])} >= {*OPERATIONS}


def _variables(graph: Graph) -> tuple[Expression, Expression, Expression]:
    x, y, v = map(graph.symbol, "xyv")
    return x, y, v


@pytest.mark.sampled(10)
@pytest.mark.parametrize("precision", TYPES)
@pytest.mark.parametrize("name", TOGETHER)
def test_no_rounding_is_left_out(name: str, precision: str) -> None:
    graph = Graph()
    root = TOGETHER[name](graph, HARD[precision], *_variables(graph))
    assert isinstance(root, Expression)
    worst = found(root, precision)
    bounds = proven(root, ROUNDINGS[precision])
    assert all(worst <= bound * (1 + 2.0**-9) for bound in bounds.values()), (worst, bounds)
    assert not 0 < 16 * worst < min(bounds.values()) < 1e-3


def proven(root: Expression, rounding: Rounding) -> dict[str, float]:
    """The error of a program by each calculus."""
    nodes = reachable([root])
    given = [node.operands[0] for node in nodes if node.operation in (SIN, COS) and is_given(node.operands[0])]
    angles = {node.id for node in reachable(given)}
    bounds = running_errors(nodes, BOX.whole, rounding, angles)
    forms = forms_of(nodes, bounds, BOX.whole)
    assert forms
    closer = running_errors(nodes, BOX.whole, rounding, angles, forms.narrowing())
    return {
        "lemma 9": float(np.max(closer.error_of(root))),
        "lemma 2 with it": float(errors_by_adjoints(nodes, [root], closer, forms_of(nodes, closer, BOX.whole)).max()),
        "lemma 1": float(np.max(bounds.error_of(root))),
        "lemma 2": float(errors_by_adjoints(nodes, [root], bounds).max()),
        "polynomials": rounding_bound(root, BOX, rounding).bound,
    }


def found(root: Expression, precision: str) -> float:
    """The worst error at drawn states, half of them where much cancels: x near y, v near 3 pi, w zero."""
    draw, dtype, narrow = np.random.default_rng(0), TYPES[precision], precision == "mixed"
    states = BOX.states(STATES, draw)
    near, half = draw.integers(-3, 4, STATES // 2), STATES // 2
    unit = 2.0**-23 if precision == "single" else 2.0**-52
    states["y"][:half] = states["x"][:half] + near * unit
    states["v"][:half] = 3 * math.pi + near * unit * 8
    states["w"][:half] = 0.0
    states["s"][:half] *= 10.0 ** -draw.uniform(0, 8, half)
    held = {name: np.clip(x.astype(np.float64 if narrow else dtype), *_ends(name)) for name, x in states.items()}
    exact = evaluate([root], {name: x.astype(EXTENDED) for name, x in held.items()}, arithmetic(EXTENDED))(root)
    known = {number: dtype(x) for number, x in constant_values([root]).items()}
    with np.errstate(all="ignore"):
        if narrow:
            nodes = reachable([root])
            wide = evaluate(nodes, held, arithmetic(np.float64))
            sines = (node for node in nodes if node.operation in (SIN, COS) and node.level == Level.STATE)
            known |= {node.id: np.float32(wide(node)) for node in sines if is_given(node.operands[0])}
        value = evaluate([root], {name: x.astype(dtype) for name, x in held.items()}, arithmetic(dtype), known)(root)
    return float(np.abs(np.asarray(value).astype(EXTENDED) - exact).max())


def _ends(name: str) -> tuple[float, float]:
    return RANGES[name].low, RANGES[name].high


@pytest.mark.parametrize("operation", [ADD, SUBTRACT])
@pytest.mark.parametrize("name", ["sign", "arc tangent", "maximum", "root", "quotient", "cosine"])
def test_no_change_is_left_out(name: str, operation: str) -> None:
    """An addend is left out of the operand of an operation: the change of its result is within that of lemma 3."""
    graph = Graph()
    x, y, v = _variables(graph)
    left = graph.node(operation, x - Fraction(11, 10), v * Fraction(1, 20))
    root = {
        "sign": lambda: graph.node(SIGN, left) * y,
        "arc tangent": lambda: graph.node(ATAN2, left, -y) * y,
        "maximum": lambda: graph.node(MAXIMUM, left, y - 1) * y,
        "root": lambda: graph.node(SQRT, left * left + 1) * y,
        "quotient": lambda: y / (left + 3),
        "cosine": lambda: graph.node(COS, left) * y,
    }[name]()
    nodes = reachable([root])
    bounds = running_errors(nodes, BOX.whole, ROUNDINGS["double"])
    bound = errors_of_changes(nodes, [root], bounds, ChangedNodes(dropped=frozenset({(left.id, 1)})))
    states = BOX.states(STATES, np.random.default_rng(1))
    kept = evaluate([root], states, arithmetic(np.float64))(root)
    short = evaluate([root], states, arithmetic(np.float64), {left.id: states["x"] - 1.1})(root)
    assert np.abs(short - kept).max() <= bound.max()
