"""Regressors: Y X = tau and h X = E in 50 digits, labels, and operation counts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from mpmath import mpf

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import NO_VECTOR, Base, Body, Joint, Kind, Machine, Wrench
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Result
from symoro_elastic.models.dynamics.identification import IDENTIFICATION, linear_parameters
from symoro_elastic.models.parameters.base_parameters import base_grouping
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.program import OperationCount, Output, build
from tests.examples import example
from tests.references import multiprecision as reference
from tests.references.random_machines import chain, first_joint_elastic, planar_2r, random_machine, two_children

pytestmark = pytest.mark.sampled(6)

MODELS = {model.name: model for model in IDENTIFICATION}
EXACT = 1e-40


def run(machine: Machine, name: str, asked: tuple[int, ...] = ()) -> tuple[Bound, Result]:
    bound = Bound(machine)
    (result,) = MODELS[name].run(bound, asked or machine.independent).values()
    assert len(result.entries) == int(np.prod(result.shape))
    assert len(result.column_labels) == result.shape[-1] == len(set(result.column_labels))
    return bound, result


def count(machine: Machine, name: str) -> OperationCount:
    bound, result = run(machine, name)
    return build([], [Output("Y", result.shape, result.entries)], bound.names).count


def numbers(bound: Bound, result: Result, *state: list[float]) -> tuple[Any, Any]:
    """The result and X of its columns, at a state (q, qd and qdd), in 50 digits."""
    arithmetic = multiprecision(50)
    symbols = {p.name: p.value.evaluate({}, {}, arithmetic.number) for p in bound.machine.parameters if p.value}
    for names, entries in zip((bound.q, bound.qd, bound.qdd), state, strict=False):
        symbols |= {symbol.operands[0]: arithmetic.number(x) for symbol, x in zip(names.values(), entries, strict=True)}
    value_of = {parameter.label: parameter.value for parameter in linear_parameters(bound)}
    X = [value_of[label] for label in result.column_labels]
    value = evaluate([*result.entries, *X], symbols, arithmetic)
    found = np.array([value(x) for x in result.entries], dtype=object).reshape(result.shape)
    return found, np.array([value(x) for x in X], dtype=object)


def a_state(machine: Machine, seed: int = 0) -> tuple[list[float], list[float], list[float]]:
    q, qd, qdd = np.random.default_rng(seed).uniform(-1.5, 1.5, (3, len(machine.independent))).tolist()
    return q, qd, qdd


def spring_forces(machine: Machine, q: list[float], qd: list[float]) -> Any:
    """k (q - q0) + d qd, where tau is zero."""
    return -reference._joint_forces(reference._read(machine, None), q, qd)


def worst(entries: Any, wanted: Any) -> float:
    entries, wanted = np.atleast_1d(np.array(entries, dtype=object)), np.atleast_1d(np.array(wanted, dtype=object))
    return float(max(np.abs(entries - wanted)) / max([mpf(1), *np.abs(wanted)]))


MACHINES = [
    *(random_machine(s, joints=2 + s % 8, symbolic=s % 2 == 0, moving_base=s % 4 == 3) for s in range(24)),
    chain(6),
    first_joint_elastic(),
    two_children(symbolic=True),
    planar_2r(elastic=(2,)),
    example("two_axis.toml"),
    example("planar_2r.toml"),
]
VARIOUS = [pytest.param(machine, id=f"{machine.name}-{k}") for k, machine in enumerate(MACHINES)]


@pytest.mark.parametrize("machine", VARIOUS)
def test_regressor_times_parameters_is_torque(machine: Machine) -> None:
    """Inertia, gravity, rotors, friction, springs, dampers and external wrenches, against Jacobians in frame 0."""
    state = a_state(machine)
    Y, X = numbers(*run(machine, "regressor"), *state)
    q, qd, qdd = state
    with reference.mpmath.workdps(50):
        wanted = np.array(reference.generalized_forces(machine, q, qd, qdd), dtype=object)
        assert worst(Y @ X, wanted + spring_forces(machine, q, qd)) < EXACT


@pytest.mark.parametrize("machine", VARIOUS[::3])
def test_base_regressor_gives_the_same_torques(machine: Machine) -> None:
    regrouped = base_grouping(machine).machine
    state = a_state(machine, 1)
    Y, X = numbers(*run(machine, "regressor"), *state)
    Y_base, X_base = numbers(*run(regrouped, "regressor"), *state)
    assert Y_base.shape[1] <= Y.shape[1]
    assert worst(Y_base @ X_base, Y @ X) < 1e-13


@pytest.mark.parametrize("machine", [machine for machine in VARIOUS if machine.values[0].base.velocity == NO_VECTOR])  # type: ignore[attr-defined]
def test_energy_regressor(machine: Machine) -> None:
    """Differences of energy between two states, against A and the frames of the reference."""
    bound, result = run(machine, "energy_regressor")
    first, second = (a_state(machine, seed)[:2] for seed in (2, 3))
    with reference.mpmath.workdps(50):
        found = []
        for state in (first, second):
            h, X = numbers(bound, result, *state)
            found.append(h @ X)
        wanted = energy(machine, *second) - energy(machine, *first)
        assert worst(found[1] - found[0], wanted) < EXACT


def energy(machine: Machine, q: list[float], qd: list[float]) -> Any:
    numbers = reference._read(machine, None)
    A = np.array(reference.inertia_matrix(machine, q), dtype=object)
    rates = np.array([mpf(x) for x in qd], dtype=object)
    total = rates @ A @ rates / 2
    placed = reference.geometric_model(machine, q)
    for joint, frame in zip(numbers.joints, placed, strict=True):
        T = np.array(frame, dtype=object)
        weight = joint.body.mass * T[:3, 3] + T[:3, :3] @ joint.body.first_moment
        total -= numbers.base.gravity @ weight
    for k, x in zip(numbers.moving, q, strict=True):
        joint = numbers.joints[k]
        total += joint.stiffness * (mpf(x) - joint.neutral) ** 2 / 2
    return total


@pytest.mark.parametrize(("base", "products", "sums"), [(False, 766, 441), (True, 577, 336)])
def test_regressor_of_rx90_is_shorter_than_that_of_opensymoro(base: bool, products: int, sums: int) -> None:
    machine = example("rx90.par")
    found = count(base_grouping(machine).machine if base else machine, "regressor")
    assert found.products <= products
    assert found.add <= sums


def test_columns_have_the_names_of_the_machine() -> None:
    machine = example("rx90.par")
    _, general = run(machine, "regressor")
    assert general.shape == (6, 55)
    assert general.column_labels[:4] == ("ZZ1", "IA1", "XX2", "XY2")
    assert "M1" not in general.column_labels and "M2" not in general.column_labels
    _, base = run(base_grouping(machine).machine, "regressor")
    assert base.shape == (6, 40)
    assert base.column_labels[:3] == ("ZZR1", "XXR2", "XY2")
    assert base.column_labels == tuple(parameter.name for parameter in base_grouping(machine).parameters)


def test_every_kind_of_column() -> None:
    machine = two_children(symbolic=True)
    body = replace(machine.joints[0], wrench=Wrench(force=(Formula.parse(1), Formula.parse(0), Formula.parse(0))))
    friction = replace(body, friction=replace(body.friction, viscous=Formula.parse(2), coulomb=Formula.parse(3)))
    machine = replace(machine, joints=(friction, *machine.joints[1:]))
    _, result = run(machine, "regressor")
    columns = np.array(result.entries, dtype=object).reshape(result.shape).T
    by_label = dict(zip(result.column_labels, columns, strict=True))
    assert {"FV1", "FS1", "K2", "DA2", "KQ2", "IA1", "ZZ6"} <= by_label.keys()
    assert "FX1" not in by_label  # it passes through the axis
    assert list(by_label["KQ2"]) == [0, -1, 0, 0, 0, 0]


def test_base_parameters_are_a_model_of_the_parameters_alone() -> None:
    machine = chain(4)
    _, result = run(machine, "base_parameters")
    values = {p.name: p.value.value() for p in machine.parameters if p.value}
    arithmetic = multiprecision(50)
    value = evaluate(result.entries, {name: arithmetic.number(x) for name, x in values.items()}, arithmetic)
    wanted = base_grouping(machine).values(values)
    for label, x in zip(result.column_labels, result.entries, strict=True):
        assert float(value(x)) == pytest.approx(wanted[label], rel=1e-14, abs=1e-15)


def test_rows_that_are_not_asked_for_take_their_columns_with_them() -> None:
    _, result = run(example("rx90.par"), "regressor", asked=(6,))
    assert result.shape[0] == 1
    assert set(result.column_labels) == {"XX6", "XY6", "XZ6", "YY6", "YZ6", "ZZ6", "MX6", "MY6", "IA6"}


def test_a_parameter_in_two_cells_has_two_columns() -> None:
    machine = planar_2r()
    twin = replace(machine.joints[1], body=replace(machine.joints[1].body, mass=Formula.parse("M1")))
    shared = replace(twin, body=replace(twin.body, inertia=machine.joints[0].body.inertia))
    _, result = run(replace(machine, joints=(machine.joints[0], shared)), "regressor")
    assert {"ZZ1", "ZZ_2", "M_2"} <= set(result.column_labels)  # ZZ2 and M2 are other parameters of the table


def test_a_machine_without_mass_has_no_regressor() -> None:
    machine = Machine("m", (Joint("j", 0, Kind.MOTOR, 0, "q1", body=Body()),), base=Base())
    for name in MODELS:
        with pytest.raises(InputError, match="give masses"):
            run(machine, name)
