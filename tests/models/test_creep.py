"""Dry friction made smooth by a creep velocity, in all models, their derivatives and linear models; 50 digits."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Body, Friction, Joint, Kind, Machine
from tests.closed_chains.machines import machine, situations
from tests.closed_chains.test_references import worst
from tests.closed_chains.test_small_motions import FEW_DIGITS
from tests.closed_chains.traced import results
from tests.models.test_derivatives import ARGUMENTS, DIRECT, EXACT, INVERSE, assert_close, differences, numbers, wanted
from tests.references.random_machines import random_machine, random_state
from tests.references.small_motions import forces
from tests.references.virtual_work import VirtualWork, small_motions

CREEP = Formula.parse("0.3")


def creeping(described: Machine) -> Machine:
    """The machine whose dry friction creeps at velocities that are not small, so that its slope matters everywhere."""
    laws = (
        replace(row.friction, creep=Formula.parse(0) if row.friction.coulomb.is_zero else CREEP)
        for row in described.joints
    )
    joints = tuple(replace(row, friction=law) for row, law in zip(described.joints, laws, strict=True))
    return replace(described, joints=joints)


MACHINES = [creeping(random_machine(s, joints=4, symbolic=True)) for s in range(2)]


def slide(**law: str) -> Machine:
    friction = Friction(**{name: Formula.parse(x) for name, x in law.items()})
    return Machine("one", (Joint("slide", 0, Kind.MOTOR, 1, "x", body=Body(Formula.parse(2)), friction=friction),))


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", [INVERSE, DIRECT])
@pytest.mark.parametrize("described", MACHINES, ids=lambda one: one.name)
def test_derivatives_by_velocities_are_differences(described: Machine, name: str) -> None:
    state = random_state(described, 3)
    for of, found in numbers(described, name, state).items():
        result, _, by = of.partition("_")
        k = ARGUMENTS[by]
        if found.size:
            expected = differences(
                lambda x, k=k, result=result: wanted(described, name, result, [*state[:k], x, *state[k + 1 :]]),
                state[k],
            )
            assert_close(found, expected, EXACT)


@pytest.mark.parametrize("described", MACHINES, ids=lambda one: one.name)
def test_damping_of_linear_models_holds_the_slope(described: Machine) -> None:
    q, qd, qdd = random_state(described, 5)[0], random_state(described, 5)[1], [0.3] * len(described.independent)
    found = numbers(described, "linearization", [q, qd, qdd])["D"]
    assert_close(found, differences(lambda x: forces(described, q, x, qdd), qd), EXACT)


@pytest.mark.parametrize("name", ["quick_return"])
def test_with_couplings_and_loops(name: str) -> None:
    described, situation = creeping(machine(name)), situations(name)[0]
    assert described != machine(name)
    at = VirtualWork(described, situation.state)
    udd = at.direct(situation.tau)[[at.chain.own.index(variable) for variable in at.chain.independent]]
    found = results(described, "linearization", situation.state, {"qdd": udd, "tau": situation.tau})
    for label, matrix in zip("MDK", small_motions(described, situation.state, situation.tau), strict=True):
        assert worst(found[label], matrix) < FEW_DIGITS, label


def test_a_joint_that_sticks_creeps_by_the_velocity_that_the_documentation_says() -> None:
    """v = vs tau / sqrt(Fs^2 - tau^2) under a constant force tau below Fs: 3 of 5 N."""
    velocity = Fraction("1e-4") * 3 / 4
    found = numbers(slide(coulomb="5", creep="0.0001"), "friction_forces", [[velocity]])["H"]
    assert_close(found, 3 + 0 * found, EXACT)


@pytest.mark.parametrize(
    ("law", "says"),
    [
        ({"coulomb": "3", "creep": "-1e-4"}, "is negative"),
        ({"coulomb": "3", "creep": "1 - 1"}, "is 0: leave it out, then dry friction jumps at rest"),
    ],
)
def test_a_creep_velocity_is_positive(law: dict[str, str], says: str) -> None:
    with pytest.raises(InputError, match=f"friction.*{says}|creep.*{says}"):
        check(slide(**law))


def test_creep_without_dry_friction_is_questioned() -> None:
    assert any("creep has no effect" in line for line in check(slide(viscous="1", creep="1e-4")))
