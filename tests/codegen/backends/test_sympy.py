"""Models as SymPy expressions: textbook formulas, exact numbers, the values of numpy."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import sympy

import symoro_elastic as se
from symoro_elastic.codegen.backends.sympy_expressions import expressions
from tests.codegen.backends.compared import apart, each_state, inputs, loaded, machine, on

pytestmark = pytest.mark.sampled(6)

PLANAR = ("inertia_matrix", "inverse_dynamics", "geometric_model")


def on_sympy(example: str, *models: str, **options: Any) -> Any:
    return se.load(machine(example), *models, backend="sympy", **options)


@pytest.fixture(scope="module")
def planar() -> Any:
    return on_sympy("planar_2r.toml", *PLANAR)


def test_the_inertia_matrix_of_two_links_is_that_of_textbooks(planar: Any) -> None:
    m1, m2, l1, lc1, lc2, I1, I2, q2 = sympy.symbols("m1 m2 l1 lc1 lc2 I1 I2 q2")
    elbow = I2 + m2 * lc2**2
    coupled = elbow + m2 * l1 * lc2 * sympy.cos(q2)
    whole = I1 + m1 * lc1**2 + I2 + m2 * (l1**2 + lc2**2 + 2 * l1 * lc2 * sympy.cos(q2))
    found = planar.inertia_matrix()
    assert (found - sympy.Matrix([[whole, coupled], [coupled, elbow]])).expand() == sympy.zeros(2, 2)
    assert str(found[0, 0]) == "I1 + I2 + l1**2*m2 + 2*l1*lc2*m2*cos(q2) + lc1**2*m1 + lc2**2*m2"
    assert str(planar.geometric_model()[2, 0, 3]) == "l1*cos(q1) + l2*cos(q1 + q2)"


def test_numbers_of_the_file_are_exact() -> None:
    """I2 + m2 lc2^2 = 0.012 + 1.5 0.15^2, and half of m2 l1 lc2 beside it."""
    model = on_sympy("planar_2r.toml", "inertia_matrix", fold=["all"])
    elbow = sympy.Rational(12, 1000) + sympy.Rational(3, 2) * sympy.Rational(15, 100) ** 2
    assert model.inertia_matrix([0, sympy.pi / 3])[1, :] == sympy.Matrix([[elbow + sympy.Rational(45, 1000), elbow]])


def test_arguments_are_expressions_of_any_kind(planar: Any) -> None:
    """Functions of time, matrices, numbers; what is left out stays a symbol."""
    t = sympy.Symbol("t")
    q = sympy.Matrix([sympy.Function("a")(t), sympy.Function("b")(t)])
    tau, _ = planar.inverse_dynamics(q, q.diff(t), q.diff(t, 2))
    assert tau.has(sympy.cos(q[1])) and tau.has(sympy.Symbol("m2")) and not tau.has(sympy.Symbol("q2"))
    assert planar.inverse_dynamics.symbols["qdd_motor"] == sympy.symbols("qdd1 qdd2")
    with pytest.raises(ValueError, match="q has 3 entries: 2 are expected"):
        planar.inertia_matrix([0, 0, 0])
    with pytest.raises(TypeError, match="arguments are real numbers, not text"):
        planar.inertia_matrix(["1/2", 0])
    assert planar.inertia_matrix([0, Fraction(1, 2)])[0, 1].has(sympy.cos(sympy.Rational(1, 2)))


@pytest.mark.parametrize("example", ["planar_2r.toml", "flex4.par", "sr400.par"])
def test_expressions_and_their_lines_have_the_values_of_numpy(example: str) -> None:
    """Nested expressions at numbers; the lines, one after the other."""
    function = on(expressions, example).direct_dynamics
    lines, (result,) = function.cse()
    for arguments in each_state(inputs(example, "direct_dynamics")):
        expected = loaded(example).direct_dynamics(*arguments)
        assert apart(np.array(function(*arguments), dtype=float), expected) <= 64
        symbols = [x for entries in function.symbols.values() for x in entries]
        values = dict(zip(symbols, np.concatenate(arguments), strict=True))
        for symbol, x in lines:
            values[symbol] = float(x.xreplace(values))
        assert apart(np.array(result.xreplace(values), dtype=float), expected) <= 64
