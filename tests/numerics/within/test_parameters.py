"""Parameters set to zero: all models keep their structure, the inertia matrix stays positive definite."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from symoro_elastic.generation.pipeline import prepare
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.machine.within import Tolerance
from symoro_elastic.models.programs.catalogue import trace_scene
from symoro_elastic.numerics.linear.grouping import grouping_by_rank
from symoro_elastic.numerics.within.reduction import without_parameters
from symoro_elastic.numerics.within.results import Reduction
from symoro_elastic.numerics.within.tape import Kind
from symoro_elastic.numerics.within.trials import Requirements
from symoro_elastic.symbolic.program import Output, Program, build

from .cases import EXAMPLES, Case, drawn, of_expressions, puma, results_of


@cache
def machine() -> Machine:
    """The PUMA 560 with its base parameters as symbols."""
    return prepare(EXAMPLES / "puma560_measured.toml", print, base=True, free=("bodies", "motors"))


def program(of: Machine, model: str, fold: tuple[str, ...] | str = ()) -> Program:
    (found,) = trace_scene(of, Scene((model,), fold=fold), grouping_by_rank)
    return found.program


@cache
def values() -> dict[str, float]:
    return {p.name: p.value.value() for p in machine().parameters if p.value is not None}


@cache
def reduced(tolerance: float) -> Reduction:
    inverse = program(machine(), "inverse_dynamics")
    tolerances = {output.name: Tolerance(tolerance) for output in inverse.outputs}
    inertia = program(machine(), "inertia_matrix")
    required = Requirements(states=20_000, confident=False)
    return without_parameters(inverse, puma().box, tolerances, values(), inertia, required)


def zeroed(found: Reduction) -> Machine:
    gone = {one.term for one in found.left_out}
    return replace(
        machine(), parameters=tuple(replace(p, value=ZERO) if p.name in gone else p for p in machine().parameters)
    )


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("tolerance", "most"),
    [
        pytest.param(0.001, 336, marks=pytest.mark.thorough),
        (0.01, 279),
        pytest.param(0.05, 243, marks=pytest.mark.thorough),
    ],
)
def test_parameters_of_the_puma(tolerance, most) -> None:
    """The reduced program is the model of the machine with zeros, within the tolerance of the whole one."""
    found = reduced(tolerance)
    assert found.left_out and all(one.kind is Kind.FREEZE and one.constant == 0.0 for one in found.left_out)
    assert {one.term for one in found.left_out} < {*values()}
    other, case = zeroed(found), puma()
    again = program(other, "inverse_dynamics", ALL)
    assert again.count.mul + again.count.add <= most
    symbols = drawn(case, 20_000, 7)
    constants = {name: np.full(20_000, value) for name, value in values().items()}
    with_zeros, there, exact = (
        results_of(again, symbols),
        results_of(found.reduced, symbols | constants),
        results_of(case.program, symbols),
    )
    assert np.abs(with_zeros - there).max() <= 1e-12 * np.abs(exact).max()
    allowed = {(one.output, one.index): one.tolerance for one in found.errors}
    errors = np.abs(with_zeros - exact).max(axis=1)
    keys = [(output.name, k) for output in case.program.outputs for k in range(len(output.entries))]
    assert all(error <= allowed[key] for key, error in zip(keys, errors, strict=True) if key in allowed)


def test_the_inertia_matrix_stays_symmetric_and_positive_definite() -> None:
    A = program(zeroed(reduced(0.01)), "inertia_matrix", ALL)
    matrices = results_of(A, drawn(puma(), 1000, 8)).T.reshape(-1, 6, 6)
    assert (matrices == np.swapaxes(matrices, 1, 2)).all() and (np.linalg.eigvalsh(matrices) > 0).all()


def test_a_parameter_without_which_the_inertia_is_singular_stays() -> None:
    """Of 10 y + p x, p is small; but without it the inertia of x is zero."""

    def make(v1, v2, p1, p2):
        return [v1 * 10 + v2 * p1 + v1 * p2]

    box = {"v1": (-1, 1), "v2": (-1, 1), "p1": (0.01, 0.01), "p2": (0.01, 0.01)}
    case: Case = of_expressions(make, box)
    values, graph = {"p1": 0.01, "p2": 0.01}, case.program.nodes[0].graph
    p1, p2 = (graph.symbol(name) for name in values)
    inertia = build(case.program.inputs, [Output("A", (2, 2), (p2 + 10, 0, 0, p1))], case.names)
    moving = {name: case.box[name] for name in ("v1", "v2")}
    found = without_parameters(case.program, moving, case.tolerances(0.01), values, inertia, Requirements(states=5000))
    assert [one.term for one in found.left_out] == ["p2"]
    free = without_parameters(case.program, moving, case.tolerances(0.01), values, required=Requirements(states=5000))
    assert {one.term for one in free.left_out} == {"p1", "p2"}
