"""Lemma 8: errors of accelerations through the inertia matrix, attacked by eliminations that are carried out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import symoro_elastic as se
from symoro_elastic.codegen.precision import DOUBLE, SINGLE, Precision
from symoro_elastic.generation.pipeline import certificates, certified_in_form, programs
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.scene import AUTO, INERTIA, RECURSION, Scene
from symoro_elastic.mechanics.factorization import factorization, share_or_one, solution
from symoro_elastic.models.programs.linear_system import OF_TERM, LinearSystem, linear_system
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.guarantees.certificate import Subject
from symoro_elastic.numerics.guarantees.certificates import Effort, subject_of
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.inverse_on_cells import verified_bounds
from symoro_elastic.numerics.guarantees.linear_solver import (
    SystemBounds,
    by_intervals,
    by_rotors,
    entries_by_intervals,
    on_cells,
    x_bounds,
)
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Operand
from tests.benchmarks.certificates import exceeded
from tests.numerics.guarantees.attack import Attack, results_as_printed
from tests.numerics.guarantees.boxes import limits_of_test
from tests.references.random_machines import chain, random_machine

EXAMPLES = Path(__file__).parents[3] / "examples"
Array = NDArray[np.float64]
DOUBLES = arithmetic(np.float64)


def dense_system(size: int) -> LinearSystem:
    """The elimination of a full matrix; its nodes are of no account here."""
    below = np.triu(np.ones((size, size)), 1)
    nothing: Sequence[Operand] = (0,) * size
    counts = below.T @ below, below.sum(axis=0), below.sum(axis=1)
    return LinearSystem(tuple(range(size)), (nothing,) * size, nothing, nothing, nothing, *counts, OF_TERM)


def eliminated(A: Array, b: Array) -> tuple[list[np.float32], list[np.float32]]:
    """x and the pivots of A x = b in single precision, as the generated code computes them."""
    order = range(len(b))
    rows = [[np.float32(x) for x in row] for row in A]
    factors = factorization(order, rows, share_or_one)
    x = solution(factors, {j: np.float32(b[j]) for j in order})
    return [x[j] for j in order], [factors.pivots[j] for j in order]


def nearly(draw: np.random.Generator, x: Array, error: Array) -> Array:
    """Numbers of single precision that are off by nearly as much as they may."""
    sign = np.sign(draw.normal(size=x.shape))
    sign = np.triu(sign) + np.triu(sign, 1).T if x.ndim == 2 else sign
    found: Array = (x + 0.9 * error * sign).astype(np.float32).astype(float)
    assert (np.abs(found - x) <= error).all()
    return found


@pytest.mark.sampled(2)
@pytest.mark.parametrize("spread", [1.0, 30.0])
def test_errors_of_an_elimination_stay_below_the_bound(spread: float) -> None:
    draw = np.random.default_rng(0)
    worst = []
    for size in (2, 3, 6) * 60:
        half = draw.normal(size=(size, size)) * spread ** draw.uniform(-1, 1, (size, 1))
        A, b = half @ half.T + 0.1 * np.eye(size), draw.normal(size=size) * 10
        share = draw.uniform(0.5, 1, (size, size))
        A_error = 4e-6 * np.maximum(share, share.T) * np.sqrt(np.outer(np.diag(A), np.diag(A)))
        b_error = 4e-6 * draw.uniform(0.5, 1, size) * np.abs(b)
        unknown = np.full((size, 1), np.inf)
        given = SystemBounds(
            Interval(A[..., None], A[..., None]),
            A_error[..., None],
            Interval(b[:, None], b[:, None]),
            b_error[:, None],
            unknown,
        )
        inverse = (np.abs(np.linalg.inv(A)) * (1 + 1e-9))[..., None]
        entries = inverse if draw.random() < 0.5 else np.full_like(inverse, np.inf)
        found = x_bounds(dense_system(size), given, [inverse], entries, ROUNDINGS["single"])
        if np.isfinite(found.error).all():
            x, pivots = eliminated(nearly(draw, A, A_error), nearly(draw, b, b_error))
            error = np.abs(np.array(x, float) - np.linalg.solve(A, b))
            assert (error <= found.error[:, 0]).all()
            assert (abs(np.linalg.solve(A, b)) <= found.magnitude[:, 0]).all()
            exact = factorization(range(size), A.tolist()).pivots.values()
            off = np.array(pivots, float) - [float(p) for p in exact]  # type: ignore[arg-type]
            assert (np.abs(off) <= found.pivot_error[:, 0]).all()
            worst.append(float((error / found.error[:, 0]).max()))
    assert len(worst) > 100
    assert max(worst) > 0.05  # it is not a bound of anything


def planar(scale: float) -> DescribedMachine:
    machine = se.read(EXAMPLES / "planar_2r.toml")
    return replace(DescribedMachine.of(machine), limits=limits_of_test(machine, scale))


def matrices(subject: Subject, states: int, seed: int) -> Array:
    """Inertia matrices of a direct model at drawn states, (states, n, n)."""
    assert subject.solver is not None
    rows = subject.solver.system.A
    value = evaluate([x for row in rows for x in row], subject.box.states(states, np.random.default_rng(seed)), DOUBLES)
    found = np.array([np.broadcast_to(value(x), states) for row in rows for x in row])
    return np.moveaxis(found.reshape(len(rows), len(rows), states), -1, 0)


def with_slide() -> DescribedMachine:
    """Two joints that turn and one that slides between them."""
    machine = chain(3, prismatic=(2,), symbolic=False)
    return replace(DescribedMachine.of(machine), limits=limits_of_test(machine, 0.5))


@pytest.mark.parametrize("machine", [planar(1.0), planar(0.2), with_slide()], ids=["turns", "arcs", "slide"])
def test_bounds_of_the_inverse_hold_everywhere(machine: DescribedMachine) -> None:
    asked = programs(machine, Scene(models=("direct_dynamics",), form=INERTIA))
    subject = subject_of(asked, machine, machine.limits, asked.package.functions[0], ROUNDINGS["double"])
    assert subject.solver is not None
    A = matrices(subject, 20_000, 1)
    size = A.shape[-1]
    assert np.ptp(A, axis=0).max() > 0
    direction = np.linspace(1.0, -0.4, size)
    cells = on_cells(subject.solver.system.A, subject.box, 2000, direction)
    assert cells is not None
    inverse = np.linalg.inv(A)
    largest = np.abs(inverse).max(axis=0)
    assert (largest <= cells.W[..., 0]).all()
    assert (np.abs(inverse @ direction).max(axis=0) <= cells.solution[:, 0]).all()
    assert np.diagonal(cells.W[..., 0]) == pytest.approx(np.diagonal(largest), rel=0.6)
    ends = Interval(A.min(axis=0)[..., None], A.max(axis=0)[..., None])
    assert (largest <= entries_by_intervals(ends)[..., 0]).all()
    drawn = np.random.default_rng(2).normal(size=(20_000, size))
    W = by_intervals(ends)[..., 0]
    bound = np.einsum("ki,ij,kj->k", np.abs(drawn), W, np.abs(drawn))
    assert np.isinf(W).all() or (np.einsum("ki,kij,kj->k", drawn, inverse, drawn) <= bound).all()


def test_an_inverse_that_is_not_bounded_is_told() -> None:
    G = np.array([[[0.5, 0.6], [0.6, 0.5]], [[0.1, 0.2], [0.2, 0.1]]])
    found = verified_bounds(np.tile(np.eye(2), (2, 1, 1)), G, np.tile(np.eye(2), (2, 1, 1)))
    assert np.isinf(found[0]).all()
    assert found[1] == pytest.approx(np.linalg.inv(np.eye(2) - G[1]), rel=1e-5)


def test_rotors_bound_the_inverse_by_themselves() -> None:
    W = by_rotors({3: np.array([0.5]), 1: np.array([2.0])}, (3, 1))
    assert W[..., 0] == pytest.approx(np.diag([2.0, 0.5]), rel=1e-5)
    assert np.isinf(by_rotors({3: np.array([0.5])}, (3, 1))[1, 1, 0])


@pytest.mark.thorough
@pytest.mark.parametrize(("scale", "precision", "ratio"), [(1.0, SINGLE, 1000), (0.2, DOUBLE, 100)])
def test_an_arm_with_rotors_is_certified_through_its_inertia_matrix(
    scale: float, precision: Precision, ratio: float
) -> None:
    machine = se.read(EXAMPLES / "puma560_measured.toml")
    whole = replace(DescribedMachine.of(machine), limits=limits_of_test(machine, scale))
    scene = Scene(models=("direct_dynamics",), form=INERTIA)
    (found,) = certificates(whole, scene, [precision], Effort(16)).certificates
    assert not found.overflows
    assert all(pivot.least > 0.19 for pivot in found.pivots)
    program = programs(whole, scene).package.functions[0].program
    worst = Attack(results_as_printed(program), found.box, found.precision).run(500)
    assert not exceeded(found, worst)
    assert all(entry.error < ratio * error for entry, error in zip(found.entries, worst.error, strict=True))


@pytest.mark.thorough
def test_the_form_that_proves_more_is_certified() -> None:
    machine = random_machine(201, joints=6, kinds=("motor",), prismatic=0)  # heavy: the recursion proves little of it
    whole = replace(DescribedMachine.of(machine), limits=limits_of_test(machine, 0.2))
    scene = Scene(models=("direct_dynamics",), form=AUTO)
    asked, found = certified_in_form(whole, scene, effort=Effort(1))
    assert asked.scene.form == INERTIA
    assert found.doubt < certificates(whole, replace(scene, form=RECURSION), effort=Effort(1)).doubt


@pytest.mark.thorough
def test_the_recursion_is_certified_where_it_is_bounded() -> None:
    scene = Scene(models=("direct_dynamics",), form=AUTO)
    assert certified_in_form(planar(1.0), scene, effort=Effort(1))[0].scene.form == RECURSION


def test_a_number_that_two_quantities_share_is_no_matrix_of_the_program() -> None:
    table = {
        "name": "merged",
        "joints": [
            {"name": "a", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"},
            {"name": "b", "antecedent": "a", "kind": "motor", "sigma": 0, "alpha": "90 deg", "d": 0.3, "theta": "q3"},
            {"name": "x", "antecedent": "b", "kind": "motor", "sigma": 1, "alpha": "90 deg", "d": 0.05, "r": "q4"},
        ],
        "bodies": {
            "a": {"mass": 2, "inertia": [0.01, 0.02, 0.02]},
            "b": {"mass": 1.5, "center_of_mass": [0.1, 0.05, 0], "inertia": [0.01, 0.02, 0.02]},
            "x": {"mass": 0.5, "center_of_mass": [0, 0.1, 0.2], "inertia": [0.001, 0.002, 0.002]},
        },
    }
    asked = programs(se.read(table), Scene(models=("direct_dynamics",), form=INERTIA))
    assert linear_system(asked.machine, asked.package.functions[0].program) is None
