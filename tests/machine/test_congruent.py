"""Congruent limbs: found whatever their numbers, rejected where their structure differs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from symoro_elastic.machine.congruent import congruent_joints, congruent_symbols
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine
from tests.benchmarks.machines import arm_6, chain, humanoid, quadruped, two_axis
from tests.references.limbs import with_limbs


def branches(lengths: Sequence[int], kind: Kind = Kind.MOTOR) -> Machine:
    """Branches of so many joints on the base."""
    table: list[Joint] = []
    for number, length in enumerate(lengths):
        for k in range(length):
            mass = Formula.parse(f"M{len(table) + 1}")
            antecedent = len(table) if k else 0
            sigma = 2 if kind is Kind.FIXED else 0
            variable = None if sigma == 2 else f"q{len(table) + 1}"
            table.append(Joint(f"branch{number}_{k}", antecedent, kind, sigma, variable, body=Body(mass)))
    return Machine("branches", tuple(table))


def test_limbs_of_a_humanoid_and_a_quadruped() -> None:
    of_legs = [(j, j + 6) for j in range(1, 7)]
    assert set(congruent_joints(humanoid())) == {*of_legs, *((j, j + 7) for j in range(16, 23))}
    assert set(congruent_joints(quadruped())) == {(4, 7, 10, 13), (5, 8, 11, 14), (6, 9, 12, 15)}


@pytest.mark.parametrize("machine", [arm_6(), two_axis(), chain(9)], ids=lambda machine: machine.name)
def test_serial_machines_have_none(machine: Machine) -> None:
    assert congruent_joints(machine) == ()
    assert congruent_symbols(machine, ()) == ()


def test_six_are_four_and_two_and_a_seventh_stays_alone() -> None:
    assert congruent_joints(branches([1] * 7)) == ((1, 2, 3, 4), (5, 6))
    assert {*congruent_joints(branches([2, 1, 2, 1, 3]))} == {(1, 4), (2, 5), (3, 6)}


def test_fixed_frames_alone_are_no_limbs() -> None:
    assert congruent_joints(branches([1, 1], Kind.FIXED)) == ()


@pytest.mark.parametrize("seed", range(6))
def test_numbers_and_signs_may_differ_but_no_zero(seed: int) -> None:
    machine = with_limbs(seed, 2)
    count = (len(machine.joints) - 2) // 2
    assert set(congruent_joints(machine)) >= {(3, 3 + count)}
    last = machine.joint(3)
    other = replace(last, gamma=Formula.parse("0.123")), replace(last, body=replace(last.body, mass=ZERO))
    for joint in other:
        joints = (*machine.joints[:2], joint, *machine.joints[3:])
        assert all(3 not in group for group in congruent_joints(replace(machine, joints=joints)))


def test_symbols_follow_the_joints() -> None:
    machine = humanoid()
    symbols = congruent_symbols(machine, congruent_joints(machine))
    assert {("q2", "q8"), ("qd2", "qd8"), ("qdd2", "qdd8"), ("MX2", "MX8"), ("D1", "D7"), ("IA22", "IA29")} <= {
        *symbols
    }
    names = [name for cycle in symbols for name in cycle]
    assert len(names) == len({*names})


def test_a_parameter_of_both_limbs_is_its_own_image() -> None:
    machine = branches([1, 1])
    shared = tuple(replace(joint, body=Body(Formula.parse("M"))) for joint in machine.joints)
    machine = replace(machine, joints=shared)
    assert all("M" not in cycle for cycle in congruent_symbols(machine, congruent_joints(machine)))
