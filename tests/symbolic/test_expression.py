"""The expression graph: one object a value, nothing superfluous, nothing changed."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import mpmath
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from symoro_elastic.symbolic import finite_field
from symoro_elastic.symbolic.arithmetic import FLOATS, RATIONAL, Arithmetic, ModularAngles, evaluate, multiprecision
from symoro_elastic.symbolic.expression import Expression, Graph, Level, reachable
from symoro_elastic.symbolic.finite_field import PRIME, TORSION, Residue, circle_of_pi, circle_of_radians
from symoro_elastic.symbolic.functions import arc_tangent, cosine_sine, sign, square_root
from symoro_elastic.symbolic.operations import ADD, COS, COSPI, DIVIDE, MULTIPLY, NEGATE, SIN, SUBTRACT

EXACT = Arithmetic(Fraction, RATIONAL)
U = 2.0**-53
NAMES = ("x", "y", "z")

# Trees of tuples: ("x",) a variable, Fraction a constant, (operation, tree...).
constants = st.one_of(
    st.sampled_from([Fraction(0), Fraction(1), Fraction(-1), Fraction(2), Fraction(1, 2)]),
    st.fractions(-5, 5, max_denominator=9),
)
leaves = st.one_of(st.sampled_from([(name,) for name in NAMES]), constants)
trees = st.recursive(
    leaves,
    lambda below: st.one_of(
        st.tuples(st.sampled_from([ADD, SUBTRACT, MULTIPLY, DIVIDE]), below, below), st.tuples(st.just(NEGATE), below)
    ),
    max_leaves=16,
)
rationals = st.fractions(-9, 9, max_denominator=7)


def value(tree: Any, names: dict[str, Any], number: Any = Fraction) -> Any:
    """A tree computed directly; `ZeroDivisionError` where it has no value."""
    if isinstance(tree, Fraction):
        return number(tree)
    operation, *operands = tree
    if not operands:
        return names[operation]
    return RATIONAL[operation](*(value(operand, names, number) for operand in operands))


def built(graph: Graph, tree: Any) -> Any:
    """The expression of a tree."""
    return value(tree, {name: graph.symbol(name) for name in NAMES})


def graph_of(*trees: Any) -> list[Any]:
    """The expressions of trees in one graph, where no division by an exact zero occurs."""
    graph = Graph()
    try:
        return [built(graph, tree) for tree in trees]
    except ZeroDivisionError:
        assume(False)
        raise


def constant_value(node: Expression) -> float:
    """Double nearest to a constant expression."""
    return float(evaluate([node], {}, multiprecision(60))(node))


# Interning and normal form


@given(trees)
def test_equal_expressions_are_one_object(tree: Any) -> None:
    first, second = graph_of(tree, tree)
    assert first is second or (first == second and not isinstance(first, Expression))


def test_order_of_sums_and_products_does_not_matter() -> None:
    graph = Graph()
    x, y = graph.symbol("x"), graph.symbol("y")
    assert x + y is y + x
    assert x * y is y * x
    assert -(x - y) is y - x
    assert (-x) * y is x * (-y) is -(x * y)
    assert (-x) / (-y) is x / y
    assert x / -y is -(x / y)
    minus = -x
    assert -minus is x
    assert x - (-y) is x + y
    assert (-x) - y is -(x + y)
    assert graph.symbol("x") is x
    assert Graph().symbol("x") is not x


def test_zero_one_and_constants_fold() -> None:
    graph = Graph()
    x = graph.symbol("x")
    before = len(graph)
    for same in (x + 0, 0 + x, x - 0, x * 1, 1 * x, x / 1, x + 0.0, 0.0 + x, x * 1.0, x + Fraction(0)):
        assert same is x
    for zero in (x * 0, 0 * x, x * 0.0, 0.0 * x, x - x, 0 / x, x + -x):
        assert zero == 0 and not isinstance(zero, Expression)
    assert (x / x, -(0 * x)) == (1, 0)
    assert (x / x) / 3 == Fraction(1, 3)  # and no float
    assert len(graph) == before + 1  # -x
    assert 0 - x is -x is x * -1 is x / -1 is (-1) * x
    assert x + 2 - 5 + 3 is x
    assert x * 2 * 3 is x * 6
    assert x * 6 / 3 is x * 2 is x + x
    assert 3 * x - x is x * 2
    assert x * Fraction(1, 3) * 3 is x
    assert (x + 1) - (x + 1) == 0
    assert 2 - x is -(x - 2)
    assert 2 / -x is -(2 / x) is -2 / x


def faults(node: Expression) -> list[str]:
    """What keeps a node from being in normal form."""
    found = []
    plain = [x for x in node.operands if not isinstance(x, Expression)]
    inner = [x for x in node.operands if isinstance(x, Expression)]
    if any(x.id >= node.id for x in inner):
        found.append("an operand that is not older")
    if node.operation in (ADD, SUBTRACT, MULTIPLY, DIVIDE, NEGATE) and any(x.operation == NEGATE for x in inner):
        found.append("a sign inside")
    if node.operation in (ADD, MULTIPLY) and node.operands[0] in plain:
        found.append("a constant in front")
    if node.operation in (ADD, SUBTRACT, MULTIPLY) and 0 in plain:
        found.append("zero")
    if node.operation == MULTIPLY and any(x <= 0 or x == 1 for x in plain):
        found.append("one, or a negative factor")
    if node.operation == SUBTRACT and plain:
        found.append("a constant subtracted")
    if node.operation == DIVIDE and not isinstance(node.operands[1], Expression):
        found.append("division by a constant")
    if node.operation == DIVIDE and any(x <= 0 for x in plain):
        found.append("a numerator that is zero or negative")
    if node.operation in (ADD, SUBTRACT, MULTIPLY, DIVIDE) and not inner:
        found.append("constants only")
    if node.operation in (SUBTRACT, DIVIDE) and node.operands[0] is node.operands[1]:
        found.append("a thing with itself")
    return found


@pytest.mark.thorough
@settings(max_examples=150, deadline=None)
@given(st.lists(trees, min_size=1, max_size=4))
def test_normal_form(several: list[Any]) -> None:
    nodes = reachable(graph_of(*several))
    assert [(node, fault) for node in nodes for fault in faults(node)] == []
    keys = [(n.operation, *(x.id if isinstance(x, Expression) else ("constant", x) for x in n.operands)) for n in nodes]
    assert len(set(keys)) == len(nodes)


def test_levels() -> None:
    graph = Graph()
    state, parameter = graph.symbol("q"), graph.symbol("L", Level.PARAMETER)
    constant = graph.node(COSPI, Fraction(1, 5))
    assert (constant.level, (constant + 1).level, graph.pi.level) == (Level.CONSTANT,) * 3
    assert ((parameter * constant).level, (parameter * 2).level) == (Level.PARAMETER,) * 2
    assert (state * parameter).level == (parameter / state).level == (-state).level == Level.STATE


# Values


@settings(max_examples=200, deadline=None)
@given(trees, st.tuples(rationals, rationals, rationals))
@pytest.mark.thorough
def test_rational_values_are_kept(tree: Any, numbers: tuple[Fraction, ...]) -> None:
    names = dict(zip(NAMES, numbers, strict=True))
    try:
        wanted = value(tree, names)
    except ZeroDivisionError:
        assume(False)
    graph = Graph()
    root = built(graph, tree)
    assert evaluate([root], names, EXACT)(root) == wanted


@pytest.mark.thorough
@settings(max_examples=150, deadline=None)
@given(trees, st.integers(0, 5))
def test_residues_are_kept(tree: Any, seed: int) -> None:
    """The finite field gives what the same operations on residues give."""
    root = graph_of(tree)[0]
    assume(isinstance(root, Expression))
    symbols = {name: root.graph.symbol(name) for name in NAMES}
    try:
        of = ModularAngles(seed).values([root, *symbols.values()])
        wanted = value(tree, {name: of(symbol) for name, symbol in symbols.items()}, Residue)
    except ZeroDivisionError:
        assume(False)
    assert of(root).value == wanted.value


positive = st.recursive(
    st.one_of(st.sampled_from([(name,) for name in NAMES]), st.fractions(Fraction(1, 9), 9, max_denominator=9)),
    lambda below: st.tuples(st.sampled_from([ADD, MULTIPLY, DIVIDE]), below, below),
    max_leaves=12,
)


def leaf_count(tree: Any) -> int:
    return 1 if isinstance(tree, Fraction) or len(tree) == 1 else sum(map(leaf_count, tree[1:]))


@pytest.mark.thorough
@settings(max_examples=150, deadline=None)
@given(positive, st.tuples(*[st.fractions(Fraction(1, 9), 9, max_denominator=64)] * 3))
def test_float_values_have_rounding_errors_only(tree: Any, numbers: tuple[Fraction, ...]) -> None:
    """Without differences every operation and every constant adds at most one relative error u."""
    root = graph_of(tree)[0]
    floats = dict(zip(NAMES, map(float, numbers), strict=True))
    wanted = value(tree, {name: Fraction(x) for name, x in floats.items()})
    found = evaluate([root], floats, FLOATS)(root)
    assert abs(Fraction(found) - wanted) <= 2 * leaf_count(tree) * U * wanted * (1 + 1e-10)


def test_twenty_thousand_levels_are_no_problem() -> None:
    """Halving forgets old errors, so the double is as good as after one step: 4 u."""
    graph = Graph()
    x = graph.symbol("x")
    deep = x
    for k in range(20_000):
        deep = deep * x + (k % 3 + 1)
    found = evaluate([deep], {"x": 0.5}, FLOATS)(deep)
    with mpmath.workdps(50):
        exact = evaluate([deep], {"x": mpmath.mpf("0.5")}, multiprecision(50))(deep)
        assert abs(found - exact) < 4 * U * exact


# Angles

halves = st.fractions(-4, 4, max_denominator=30)
radians = st.fractions(-4, 4, max_denominator=50)
factors = st.sampled_from([Fraction(1), Fraction(-1), Fraction(2), Fraction(1, 2), Fraction(-3, 2)])
angles = st.fixed_dictionaries(
    {"pi": halves, "radians": radians, "p": st.one_of(st.just(Fraction(0)), factors), "r": st.sampled_from([0, 1, -1])}
)


def real(x: Fraction) -> Any:
    return mpmath.mpf(x.numerator) / x.denominator


def angle(graph: Graph, parts: dict[str, Fraction]) -> Any:
    """A sum of a multiple of pi, of radians and of multiples of the variables p and r."""
    p, r = graph.symbol("p"), graph.symbol("r")
    return graph.pi * parts["pi"] + parts["radians"] + p * parts["p"] + r * parts["r"]


@pytest.mark.thorough
@settings(max_examples=150, deadline=None)
@given(angles, st.tuples(rationals, rationals))
def test_cosine_and_sine_keep_their_value(parts: dict[str, Fraction], numbers: tuple[Fraction, Fraction]) -> None:
    graph = Graph()
    circle = cosine_sine(graph, angle(graph, parts))
    many = multiprecision(50)
    with mpmath.workdps(60):
        p, r = map(real, numbers)
        whole = mpmath.pi * real(parts["pi"]) + real(parts["radians"]) + p * real(parts["p"]) + r * parts["r"]
        of = evaluate(circle, {"p": p, "r": r}, many)
        assert abs(of(circle[0]) - mpmath.cos(whole)) < 1e-45
        assert abs(of(circle[1]) - mpmath.sin(whole)) < 1e-45


def moduli(parts: dict[str, Fraction], field: ModularAngles, graph: Graph) -> tuple[int, int]:
    circle = cosine_sine(graph, angle(graph, parts))
    of = field.values(circle)
    return of(circle[0]).value, of(circle[1]).value


def turned(p: tuple[int, int], q: tuple[int, int]) -> tuple[int, int]:
    return (p[0] * q[0] - p[1] * q[1]) % PRIME, (p[0] * q[1] + p[1] * q[0]) % PRIME


@pytest.mark.thorough
@settings(max_examples=150, deadline=None)
@given(angles, angles, st.integers(0, 3))
def test_residues_of_angles_add_up(first: dict[str, Fraction], second: dict[str, Fraction], seed: int) -> None:
    """(cos, sin) is a homomorphism from sums of angles to turns of the circle, modulo the prime too."""
    graph, field = Graph(), ModularAngles(seed)
    together = {key: first[key] + second[key] for key in first}
    p, q = moduli(first, field, graph), moduli(second, field, graph)
    assert moduli(together, field, graph) == turned(p, q)
    assert (p[0] * p[0] + p[1] * p[1]) % PRIME == 1


@pytest.mark.parametrize("k", range(-9, 10))
def test_quarter_turns_by_pi_are_exact(k: int) -> None:
    graph = Graph()
    q = graph.symbol("q")
    wanted = ((1, 0), (0, 1), (-1, 0), (0, -1))[k % 4]
    quarter = graph.pi * Fraction(k, 2)
    assert cosine_sine(graph, quarter) == wanted
    assert cosine_sine(graph, graph.pi / 2 * k) == wanted
    c, s = cosine_sine(graph, q)
    assert (c.operation, s.operation) == (COS, SIN)
    turned = {0: (c, s), 1: (-s, c), 2: (-c, -s), 3: (s, -c)}[k % 4]
    before = len(graph)
    for whole in (q + quarter, quarter + q, quarter - -q):
        found = cosine_sine(graph, whole)
        assert found[0] is turned[0] and found[1] is turned[1]
    created = [n for n in list(graph._interned.values())[before:] if n.operation in (SIN, COS, COSPI)]
    assert created == []
    c_minus, s_minus = cosine_sine(graph, quarter - q)
    expected = {0: (c, -s), 1: (s, c), 2: (-c, s), 3: (-s, -c)}[k % 4]
    assert (c_minus, s_minus) == expected


@pytest.mark.parametrize("k", [*range(-40, 0), *range(1, 41), 999, 1000, -1001])
def test_floats_within_one_ulp_of_a_quarter_turn_are_exact(k: int) -> None:
    """k*math.pi/2 and its two neighbours; among them is the double nearest to k pi/2. No others."""
    graph = Graph()
    wanted = ((1, 0), (0, 1), (-1, 0), (0, -1))[k % 4]
    at = k * math.pi / 2
    near = [at, math.nextafter(at, math.inf), math.nextafter(at, -math.inf)]
    ulp = math.ulp(at)
    assert [cosine_sine(graph, Fraction(x)) for x in near] == [wanted] * 3
    with mpmath.workdps(60):
        assert float(k * mpmath.pi / 2) in near
    for x in (at + 2 * ulp, at - 2 * ulp, at + 1e-12, at - 1e-9):
        for entry in cosine_sine(graph, Fraction(x)):
            assert isinstance(entry, Expression) or (entry not in (0, 1, -1))


def test_tiny_angles_are_not_zero() -> None:
    graph = Graph()
    cosine, sine = cosine_sine(graph, Fraction(1e-17))
    assert isinstance(sine, Expression) and constant_value(sine) == 1e-17
    assert isinstance(cosine, Expression)
    assert cosine_sine(graph, 0) == cosine_sine(graph, Fraction(0)) == cosine_sine(graph, graph.pi - graph.pi) == (1, 0)


def test_thirds_and_sixths_are_rational_where_they_can_be() -> None:
    graph = Graph()
    assert cosine_sine(graph, graph.pi / 3)[0] == Fraction(1, 2)
    assert cosine_sine(graph, graph.pi / 6)[1] == Fraction(1, 2)
    assert cosine_sine(graph, graph.pi * Fraction(-5, 6))[1] == Fraction(-1, 2)
    assert cosine_sine(graph, graph.pi * Fraction(2, 3))[0] == Fraction(-1, 2)
    root = cosine_sine(graph, graph.pi / 3)[1]
    assert constant_value(root) == math.sqrt(3) / 2


@pytest.mark.thorough
@settings(max_examples=200, deadline=None)
@given(st.fractions(-3, 3, max_denominator=97), st.fractions(-3, 3, max_denominator=97))
def test_sums_of_rational_multiples_of_pi(first: Fraction, second: Fraction) -> None:
    """One angle, whichever way it is summed, and the double nearest to its cosine and sine."""
    graph = Graph()
    summed = cosine_sine(graph, graph.pi * first + graph.pi * second)
    for one, other in zip(summed, cosine_sine(graph, graph.pi * (first + second)), strict=True):
        assert one is other or one == other
    with mpmath.workdps(60):
        exact = mpmath.cospi(real(first + second))
        found = summed[0]
        assert (constant_value(found) if isinstance(found, Expression) else float(found)) == float(exact)


BIG = (1e15, -1e15, 123456789012345.6, 1e8, -7.5e11, 0.3)


@pytest.mark.parametrize("offset", [Fraction(37, 100), Fraction(-3, 2), Fraction(1, 3)])
@pytest.mark.parametrize("turn", [Fraction(0), Fraction(1, 2), Fraction(1, 3), Fraction(-7, 5)])
@pytest.mark.parametrize("q", BIG)
def test_offsets_cost_no_accuracy_at_large_angles(offset: Fraction, turn: Fraction, q: float) -> None:
    """The product form: within 8 u of the exact value, where cos(q + offset) in floats loses all digits."""
    graph = Graph()
    circle = cosine_sine(graph, graph.symbol("q") + graph.pi * turn + offset)
    of = evaluate(circle, {"q": q}, FLOATS)
    with mpmath.workdps(60):
        exact = mpmath.mpf(q) + mpmath.pi * real(turn) + real(offset)
        assert abs(of(circle[0]) - mpmath.cos(exact)) < 8 * U
        assert abs(of(circle[1]) - mpmath.sin(exact)) < 8 * U


@pytest.mark.parametrize("r", [0.7, -1e15, 3.3e9])
@pytest.mark.parametrize("q", BIG)
def test_sums_of_variables_cost_no_accuracy_at_large_angles(q: float, r: float) -> None:
    graph = Graph()
    circle = cosine_sine(graph, graph.symbol("q") - graph.symbol("r"))
    of = evaluate(circle, {"q": q, "r": r}, FLOATS)
    with mpmath.workdps(60):
        exact = mpmath.mpf(q) - mpmath.mpf(r)
        assert abs(of(circle[0]) - mpmath.cos(exact)) < 4 * U
        assert abs(of(circle[1]) - mpmath.sin(exact)) < 4 * U


# Other functions


@pytest.mark.parametrize("x", [Fraction(0), Fraction(1), Fraction(4), Fraction(9, 16), Fraction(10**20)])
def test_roots_of_squares_are_exact(x: Fraction) -> None:
    root = square_root(Graph(), x)
    assert root * root == x and not isinstance(root, Expression)


def test_other_roots_and_signs() -> None:
    graph = Graph()
    x = graph.symbol("x")
    assert constant_value(square_root(graph, 2)) == math.sqrt(2)
    assert square_root(graph, 2) is square_root(graph, Fraction(2))
    with pytest.raises(ValueError, match="square root of a negative"):
        square_root(graph, Fraction(-1, 4))
    assert [sign(graph, k) for k in (Fraction(1, 3), 0, -2)] == [1, 0, -1]
    assert sign(graph, -x) is -sign(graph, x)
    assert [FLOATS.operations["sign"](k) for k in (2.0, -0.5, 0.0)] == [1, -1, 0.0]
    assert math.isnan(FLOATS.operations["sign"](math.nan))
    assert arc_tangent(graph, 0, 1) == 0
    assert constant_value(arc_tangent(graph, 3, 4)) == math.atan2(3, 4)
    assert constant_value(arc_tangent(graph, 0, -1)) == math.pi


# The finite field


def test_the_group_has_the_order_that_the_angles_need() -> None:
    assert PRIME % 4 == 3 and (PRIME + 1) % (TORSION * finite_field.ELL) == 0
    assert pow(3, PRIME - 1, PRIME) == 1 == pow(5, PRIME - 1, PRIME)
    assert (
        math.prod(q**power for q, power in zip(finite_field.FACTORS, (10, 5, 6, 2, 1, 1, 1, 1, 1, 1, 1), strict=True))
        == TORSION
    )
    point = finite_field._power(circle_of_pi(Fraction(2, TORSION)), TORSION)
    assert point == (1, 0)
    for q in finite_field.FACTORS:
        assert finite_field._power(circle_of_pi(Fraction(2, TORSION)), TORSION // q) != (1, 0)


FITTING = [
    d for d in range(1, 400) if (TORSION // 2) % d == 0
]  # every denominator up to 36, all degrees, thousandths...


def test_denominators_that_fit() -> None:
    assert set(range(1, 37)) <= set(FITTING)
    assert {180, 360, 100} <= set(FITTING) and (TORSION // 2) % (180 * 1000) == 0


@settings(max_examples=150, deadline=None)
@given(st.sampled_from(FITTING), st.sampled_from(FITTING), st.integers(-50, 50), st.integers(-50, 50))
def test_multiples_of_pi_add_up_modulo_the_prime(d: int, e: int, m: int, n: int) -> None:
    first, second = Fraction(m, d), Fraction(n, e)
    assert turned(circle_of_pi(first), circle_of_pi(second)) == circle_of_pi(first + second)
    c, s = circle_of_pi(first)
    assert (c * c + s * s) % PRIME == 1


def test_named_angles_modulo_the_prime() -> None:
    assert circle_of_pi(Fraction(0)) == (1, 0)
    assert circle_of_pi(Fraction(1)) == (PRIME - 1, 0)
    assert circle_of_pi(Fraction(1, 2))[0] == 0
    assert 2 * circle_of_pi(Fraction(1, 3))[0] % PRIME == 1
    assert 2 * pow(circle_of_pi(Fraction(1, 4))[0], 2, PRIME) % PRIME == 1


@settings(max_examples=100, deadline=None)
@given(radians, radians)
def test_radians_add_up_modulo_the_prime(first: Fraction, second: Fraction) -> None:
    assert turned(circle_of_radians(first), circle_of_radians(second)) == circle_of_radians(first + second)


@pytest.mark.parametrize("d", [37, 41, 97, 121, 1009, 2**11, 5**8])
def test_denominators_that_do_not_fit_still_lie_on_a_circle(d: int) -> None:
    """An angle and its complement belong together, and small multiples add up."""
    assert (TORSION // 2) % d
    for m in range(1, 5):
        small = Fraction(m, 8 * d)
        c, s = circle_of_pi(small)
        assert (c * c + s * s) % PRIME == 1
        assert circle_of_pi(Fraction(1, 2) - small) == (s, c)
        assert turned((c, s), circle_of_pi(Fraction(1, 8 * d))) == circle_of_pi(Fraction(m + 1, 8 * d))


@given(st.integers(-(10**30), 10**30), st.integers(1, 10**20))
def test_residues_are_a_field(a: int, b: int) -> None:
    x, y = Residue(a), Residue(b)
    assert ((x / y) * y).value == x.value == (x + y - y).value == (0 - -x).value
    assert (2 / y).value == (Residue(2) / y).value
    assert (Residue(Fraction(a, b))).value == (x / y).value
    assert (Fraction(1, 2) + x - x).value == Residue(Fraction(1, 2)).value
    assert bool(Residue(PRIME * a)) is False
    with pytest.raises(ZeroDivisionError):
        x / Residue(PRIME)
