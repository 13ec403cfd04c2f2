"""Determinants in factors: equal to the determinant, and those of the literature; what happens where one vanishes."""

from __future__ import annotations

import random

import numpy as np
import pytest
import sympy

import symoro_elastic as se
from symoro_elastic.analysis.singularities.singularities import condition, factors
from symoro_elastic.foundation.errors import InputError
from tests.command_line import EXAMPLES, refused, run
from tests.references.random_machines import chain

Q2, Q3, Q5, A, B, D = sympy.symbols("q2 q3 q5 a b d")
sin, cos = sympy.sin, sympy.cos


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("product", "count"),
    [
        (A * B * sin(Q2), 1),
        (sin(Q2) ** 2 * cos(Q3), 3),
        (sin(Q5) * cos(Q3) * (A * cos(Q2) - B * sin(Q2 + Q3)), 3),
        ((A * sin(Q3) + B * cos(Q3)) * (D * cos(Q2) + A * cos(Q2 + Q3) - B * sin(Q2 + Q3)) * sin(Q5), 3),
        (1 + cos(Q2), 1),
        ((1 - cos(Q2)) * sin(Q2), 2),
        (A + B * cos(Q2), 1),
        ((cos(Q2) + sin(Q2)) * (cos(Q2) - 2 * sin(Q2)), 2),
        (A * B, 0),
    ],
)
def test_factors_are_found_again(product: sympy.Expr, count: int) -> None:
    """The product of the factors is the determinant at random values, to rounding."""
    constant, found = factors(sympy.expand(sympy.expand_trig(product)), [Q2, Q3, Q5])
    assert len(found) == count
    values = {x: random.Random(1).uniform(-2, 2) + k for k, x in enumerate((Q2, Q3, Q5, A, B, D))}
    expected = float(product.subs(values))
    assert float((constant * sympy.Mul(*found)).subs(values)) == pytest.approx(expected, rel=1e-12)


def test_conditions_are_words() -> None:
    assert condition(sin(Q5)) == "q5 = 0 or pi" and condition(cos(Q3)) == "q3 = pi/2 or -pi/2"
    assert condition(A * cos(Q2) - B * sin(Q2 + Q3)) == "a*cos(q2) = b*sin(q2 + q3)"


@pytest.mark.thorough
def test_the_rx90_has_the_three_of_the_literature() -> None:
    """Khalil and Dombre 2002, 5.3: shoulder, elbow, wrist."""
    found = se.singularities(EXAMPLES / "rx90.par")
    assert {position.condition for position in found.positions} == {
        "th5 = 0 or pi",
        "th3 = pi/2 or -pi/2",
        "D3*cos(th2) = RL4*sin(th2 + th3)",
    }
    wrist = next(position for position in found.positions if position.condition == "th5 = 0 or pi")
    assert wrist.alike == ("j4", "j6")


@pytest.mark.thorough
def test_the_puma_has_an_elbow_of_its_own() -> None:
    """tan q3 = -RL4/D4, where the wrist is in line with the shoulder and the elbow."""
    found = se.singularities(EXAMPLES / "puma560.par")
    assert "D4*sin(th3) + RL4*cos(th3) = 0" in {position.condition for position in found.positions}
    assert len(found.positions) == 3


@pytest.mark.thorough
def test_the_factored_determinant_is_that_of_the_jacobian() -> None:
    machine = EXAMPLES / "puma560.par"
    model, found = se.load(machine, "jacobian_determinant"), se.singularities(machine)
    rng = np.random.default_rng(1)
    for _ in range(5):
        q, p = rng.uniform(-2, 2, 6), rng.uniform(0.2, 0.9, len(model.PARAMETERS))
        values = {f"th{k}": x for k, x in enumerate(q, 1)} | dict(zip(model.PARAMETERS, p, strict=True))
        factored = float(sympy.sympify(found.determinant).subs(values))
        assert factored == pytest.approx(model.jacobian_determinant(q, p)[0], rel=1e-11)


def test_the_command_prints_sentences() -> None:
    shown = run("singularities", EXAMPLES / "planar_2r.toml", "--component", "tip.x", "--component", "tip.y").stdout
    assert "det J = l1*l2*sin(q2)" in shown and "q2 = 0 or pi: shoulder and elbow move them alike" in shown


@pytest.mark.thorough
def test_what_is_too_long_or_not_square_is_refused() -> None:
    with pytest.raises(InputError, match="too long to be factored"):
        se.singularities(chain(6, seed=1))
    assert "choose 2 of them, as in tip.x, tip.y" in refused("singularities", EXAMPLES / "planar_2r.toml")
