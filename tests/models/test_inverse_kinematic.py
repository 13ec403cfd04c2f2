"""Inverse kinematic models put back into the Jacobian, by numpy; determinants of the literature."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.inverse_kinematics import adjugate, determinant, determinant_factors, solve_square
from tests.closed_chains.machines import FILES
from tests.command_line import EXAMPLES
from tests.references.random_machines import chain

INVERSE = ("jacobian_determinant", "inverse_jacobian", "inverse_velocity_model", "inverse_acceleration_model")
ALL = ("x", "y", "z", "rx", "ry", "rz")


def parameters(models: Any) -> tuple[Any, ...]:
    """Lengths between 0.2 and 0.8 for all parameters, if there are some."""
    return (np.linspace(0.2, 0.8, len(models.PARAMETERS)),) if models.PARAMETERS else ()


def loaded(machine: Machine | Path, frame: str, components: tuple[str, ...], seen: str = "", *models: str) -> Any:
    """Inverse models of some components, and the Jacobian of the whole frame."""
    asked = [f"{frame}.{x}{seen}" for x in components] or [f"{frame}{seen}"]
    whole = [f"{frame}{seen}"]
    outputs = dict.fromkeys(models or INVERSE, asked) | {"jacobian": whole, "jacobian_dot_qd": whole}
    return se.load(machine, *outputs, only=outputs)


def rows(components: tuple[str, ...]) -> list[int]:
    return sorted(ALL.index(x) for x in components or ALL)


SIX = [
    pytest.param(chain(6, seed=4, prismatic=(2,), symbolic=False), "joint6", (), "", id="general chain"),
    pytest.param(chain(6, seed=5, symbolic=False), "joint6", (), " in joint4", id="seen from a link"),
    pytest.param(EXAMPLES / "rx90.par", "6", (), "", id="spherical wrist"),
    pytest.param(EXAMPLES / "rx90.par", "6", (), " at (0.1, -0.2, 0.3)", id="tool beyond the wrist"),
    pytest.param(chain(3, seed=6, symbolic=False), "joint3", ("x", "y", "z"), " at (0.2, 0.1, 0.3)", id="position"),
    pytest.param(chain(2, seed=7, symbolic=False), "joint2", ("z", "x"), " at (0.3, 0.1, 0)", id="two components"),
    pytest.param(FILES["sr400"], "b6", (), "", id="loop"),
]


@pytest.mark.thorough
@pytest.mark.parametrize(("machine", "frame", "components", "seen"), SIX)
def test_square_models_invert_the_jacobian(
    machine: Machine | Path, frame: str, components: tuple[str, ...], seen: str
) -> None:
    """J J^-1 = 1, det J, J qd = V and J qdd + (dJ/dt) qd = Vd, within the rounding of a matrix of its condition."""
    models = loaded(machine, frame, components, seen)
    rng, p = np.random.default_rng(1), parameters(models)
    n = len(models.JOINTS)
    for _ in range(20):
        q, qd = rng.uniform(-2, 2, n), rng.uniform(-1, 1, n)
        J = models.jacobian(q, *p)[0][rows(components)]
        bound = 300 * np.finfo(float).eps * np.linalg.cond(J)
        wanted = rng.uniform(-1, 1, len(J))
        assert models.jacobian_determinant(q, *p)[0] == pytest.approx(np.linalg.det(J), rel=bound)
        np.testing.assert_allclose(J @ models.inverse_jacobian(q, *p), np.eye(len(J)), atol=bound)
        np.testing.assert_allclose(J @ models.inverse_velocity_model(q, wanted, *p), wanted, atol=bound)
        qdd = models.inverse_acceleration_model(q, qd, wanted, *p)
        bias = models.jacobian_dot_qd(q, qd, *p)[0][rows(components)]
        np.testing.assert_allclose(J @ qdd + bias, wanted, atol=bound * (1 + np.abs(bias).max()))


@pytest.mark.thorough
@pytest.mark.sampled(2)
@pytest.mark.parametrize("components", [("x", "y", "z"), ("x",), ALL])
def test_redundant_models_have_the_least_weighted_norm(components: tuple[str, ...]) -> None:
    """qd = W^-1 J^T (J W^-1 J^T)^-1 V by numpy, and J qdd + (dJ/dt) qd = Vd."""
    models = loaded(
        chain(7, seed=3, symbolic=False),
        "joint7",
        components,
        " at (0.3, 0.1, 0.2)",
        *("inverse_velocity_model", "inverse_acceleration_model"),
    )
    rng = np.random.default_rng(2)
    for _ in range(10):
        q, qd = rng.uniform(-2, 2, 7), rng.uniform(-1, 1, 7)
        J, weights = models.jacobian(q)[0][rows(components)], rng.uniform(0.1, 10, 7)
        wanted = rng.uniform(-1, 1, len(J))
        scaled = J / weights
        N = scaled @ J.T
        bound = 300 * np.finfo(float).eps * np.linalg.cond(N)
        expected = scaled.T @ np.linalg.solve(N, wanted)
        np.testing.assert_allclose(models.inverse_velocity_model(q, wanted, weights), expected, rtol=0, atol=10 * bound)
        bias = models.jacobian_dot_qd(q, qd)[0][rows(components)]
        expected = scaled.T @ np.linalg.solve(N, wanted - bias)
        found = models.inverse_acceleration_model(q, qd, wanted, weights)
        np.testing.assert_allclose(found, expected, rtol=0, atol=100 * bound)


def test_the_determinant_of_the_rx90_is_that_of_the_literature() -> None:
    """det J = -D3 RL4 C3 S5 (S23 RL4 - C2 D3) (Khalil and Dombre 2002, 5.3)."""
    models = loaded(EXAMPLES / "rx90.par", "6", ())
    (p,) = parameters(models)
    value = dict(zip(models.PARAMETERS, p, strict=True))
    for q in np.random.default_rng(3).uniform(-3, 3, (20, 6)):
        D3, RL4, q2, q3, q5 = value["D3"], value["RL4"], *q[[1, 2, 4]]
        expected = -D3 * RL4 * np.cos(q3) * np.sin(q5) * (np.sin(q2 + q3) * RL4 - np.cos(q2) * D3)
        assert models.jacobian_determinant(q, p)[0] == pytest.approx(expected, rel=1e-12, abs=1e-16)


def test_a_wrist_splits_the_problem() -> None:
    """Two blocks of three, even where the tool is beyond the wrist."""
    asked = {"inverse_velocity_model": ["6"]}
    at_wrist = se.load(EXAMPLES / "rx90.par", "inverse_velocity_model", only=asked)
    beyond = se.load(
        EXAMPLES / "rx90.par", "inverse_velocity_model", only={"inverse_velocity_model": ["6 at (0.1, -0.2, 0.3)"]}
    )
    assert "52x 26+" in at_wrist.inverse_velocity_model.__doc__
    assert "107x 63+" in beyond.inverse_velocity_model.__doc__
    assert (
        "wanted velocities j6.x, j6.y, j6.z, j6.rx, j6.ry, j6.rz, in axes of frame 0"
        in beyond.inverse_velocity_model.__doc__
    )


def test_expansions_are_those_of_numpy() -> None:
    """Whole numbers are exact."""
    rng = np.random.default_rng(5)
    for size in range(1, 7):
        matrix = rng.integers(-4, 5, (size, size))
        as_ints = [[int(x) for x in row] for row in matrix]
        assert determinant(as_ints) == round(np.linalg.det(matrix))
        assert (matrix @ np.array(adjugate(as_ints)) == determinant(as_ints) * np.eye(size, dtype=int)).all()


def test_blocks_are_found_in_any_order() -> None:
    """A block triangular matrix with rows and columns permuted: the product of the factors keeps the sign."""
    rng = np.random.default_rng(6)
    for _ in range(30):
        matrix = np.tril(rng.integers(1, 9, (5, 5)))[rng.permutation(5)][:, rng.permutation(5)]
        factors = determinant_factors(matrix.tolist())
        assert len(factors) == 5 and np.prod(factors) == round(np.linalg.det(matrix))
        np.testing.assert_allclose(matrix @ solve_square(matrix.tolist(), [1.0, 2, 3, 4, 5]), [1, 2, 3, 4, 5])


@pytest.mark.parametrize(
    ("outputs", "said"),
    [
        (["joint2.w"], "write a component as one of x, y, z, rx, ry, rz"),
        (["joint2.x", "joint3.y"], "components of one frame are asked for"),
        (["joint3"], "3 joints move joint3.x, joint3.y, joint3.z, joint3.rx, joint3.ry, joint3.rz, 6 components"),
        (
            ["joint3.x at (1, 2, 3)", "joint3.y at (1, 2, 3)"],
            "so the Jacobian is not square: lock joints in a scene, or ask for",
        ),
        (["joint1.x"], "no joint changes x: choose among rz"),
    ],
)
def test_what_cannot_be_inverted_is_refused(outputs: list[str], said: str) -> None:
    with pytest.raises(InputError) as error:
        se.load(chain(3, seed=1, symbolic=False), "inverse_jacobian", only={"inverse_jacobian": outputs})
    assert said in str(error.value) and "\n" not in str(error.value)


def test_components_that_always_depend_on_each_other_are_refused() -> None:
    """Two slides along one line."""
    slides = [
        {"name": f"slide{j}", "antecedent": j - 1, "kind": "motor", "sigma": 1, "r": f"q{j}", "alpha": 2 - j}
        for j in (1, 2)
    ]
    machine = {"name": "line", "joints": slides, "bodies": {"slide2": {"mass": 1}}}
    for model in INVERSE:
        with pytest.raises(InputError, match=r"slide2\.y, slide2\.z depend on each other at every position: choose"):
            se.load(machine, model, only={model: ["slide2"]})
