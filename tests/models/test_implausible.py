"""Warnings about machines that are hardly meant, and none about machines that are."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from symoro_elastic.generation.pipeline import prepare
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Base, Body, Friction, Joint, Kind, Machine, Spring, Wrench
from symoro_elastic.models.checks.implausible import implausible_motions
from symoro_elastic.numerics.evaluation.values import parameter_values
from tests.command_line import EXAMPLES
from tests.compiled_models import cell, vector
from tests.references.numbers_of_machine import numbers_of
from tests.references.random_machines import random_machine

HEAVY = Body(cell(2))
DOWN = Base(gravity=vector(0, 0, -9.81))
R, P = 0, 1
Array = NDArray[Any]


def row(name: str, antecedent: int, sigma: int, kind: Kind = Kind.MOTOR, body: Body = HEAVY, **cells: str) -> Joint:
    written = {key: Formula.parse(text) for key, text in cells.items()}
    spring = Spring(cell(100)) if kind is Kind.ELASTIC else Spring()
    return Joint(name, antecedent, kind, sigma, f"q_{name}", body=body, spring=spring, **written)


def machine(*rows: Joint, base: Base = DOWN) -> Machine:
    return Machine("tried", rows, base=base)


def warned(found: Machine) -> list[str]:
    return [*check(found), *implausible_motions(found)]


# Two motors with the same effect


@pytest.mark.parametrize("turns", [["0", "0"], ["pi/2", "-pi/2"], ["0.3", "0 - 0.3"], ["pi", "0"]])
def test_parallel_slides_are_named(turns: list[str]) -> None:
    """With a spring that turns between them, which is at its neutral position."""
    first, second = turns
    found = machine(
        row("bed", 0, P, alpha="0.4"), row("yaw", 1, R, Kind.ELASTIC, alpha=first), row("ram", 2, P, alpha=second)
    )
    (line,) = warned(found)
    assert line.startswith("joint 3 (ram): slides parallel to joint 1 (bed) at every position")
    assert line.endswith("the same direction: check the angles of the rows after 1 up to 3")


def test_slides_that_are_not_parallel_everywhere_are_not_named() -> None:
    """At right angles; or with a turning motor between them."""
    assert warned(machine(row("bed", 0, P), row("ram", 1, P, alpha="pi/2"))) == []
    assert warned(machine(row("bed", 0, P), row("table", 1, R, alpha="pi/2"), row("ram", 2, P, alpha="-pi/2"))) == []
    assert warned(machine(row("one", 0, P), row("other", 0, P))) == []


def test_coincident_axes_are_named() -> None:
    found = machine(row("one", 0, R), row("lift", 1, P), row("other", 2, R, r="0.5"))
    (line,) = warned(found)
    assert line.startswith("joint 3 (other): turns about the axis of joint 1 (one) at every position")
    assert warned(machine(row("one", 0, R), row("other", 1, R, d="0.5"))) == []
    assert warned(machine(row("one", 0, R), row("screw", 1, P))) == []


# No mass beyond a motor


def test_motors_without_mass_beyond_are_named() -> None:
    bare = row("last", 1, R, body=Body(), alpha="pi/2")
    said = "joint 2 (last): no body beyond this motor has mass or inertia"
    assert warned(machine(row("first", 0, R), bare)) == [said]
    assert warned(machine(row("first", 0, R), replace(bare, rotor_inertia=cell(0.1)))) == [said]
    slide = row("last", 1, P, body=Body(inertia=(cell(1),) + (cell(0),) * 5), alpha="pi/2")
    assert "joint 2 (last): no body beyond this motor has mass" in warned(machine(row("first", 0, R), slide))
    held = (row("first", 0, R), bare, row("tip", 2, R, Kind.PASSIVE, d="1"))
    assert warned(machine(*held)) == []
    assert warned(machine(replace(held[0], body=Body()), bare)) == []  # geometry only


# Nothing that holds a mass


def test_masses_that_nothing_holds_are_named() -> None:
    door = row("door", 1, P, Kind.PASSIVE, alpha="pi/2")
    arm = row("arm", 0, P, alpha="-pi/2")
    (line,) = warned(machine(arm, door))
    assert line.startswith("joint 2 (door): nothing holds what it carries: it slides along gravity")
    for held in (
        replace(door, kind=Kind.MOTOR),
        replace(door, kind=Kind.ELASTIC, spring=Spring(cell(100))),
        replace(door, friction=Friction(coulomb=cell(3))),
        replace(door, friction=Friction(viscous=cell(3))),
        replace(door, wrench=Wrench(force=vector(0, 0, 5))),
        replace(door, body=Body()),
        replace(door, alpha=cell("pi/3")),
    ):
        assert warned(machine(arm, held)) == []
    assert warned(machine(arm, door, base=Base())) == []
    assert warned(machine(replace(arm, kind=Kind.PASSIVE), door)) == []  # no motor at all: geometry


# No false alarm


def test_examples_raise_no_alarm_but_the_table_with_a_misprint() -> None:
    lines: dict[str, list[str]] = {}
    for path in sorted(EXAMPLES.glob("*.toml")) + sorted(EXAMPLES.glob("*.par")):
        prepare(path, lines.setdefault(path.name, []).append)
    (printed,) = lines.pop("two_axis_printed.par")
    assert printed.startswith("joint 9 (motor_y): slides parallel to joint 5 (motor_x)")
    assert lines and not any(lines.values())


def screw(axis: int, angle: float, shift: float) -> Array:
    i, j = (1, 2) if axis == 0 else (0, 1)
    T = np.eye(4)
    T[i, i] = T[j, j] = np.cos(angle)
    T[j, i], T[i, j], T[axis, 3] = np.sin(angle), -np.sin(angle), shift
    return T


def placed(found: Machine, rng: np.random.Generator) -> list[Array]:
    """0T of the base and every frame at a random position, springs at their neutral positions."""
    frames = [np.eye(4)]
    for joint in numbers_of(found, values=parameter_values(found)).joints:
        q = joint.neutral if joint.kind is Kind.ELASTIC else rng.uniform(-3, 3)
        turn, slide = (q, 0) if joint.sigma == R else (0, q) if joint.sigma == P else (0, 0)
        before = screw(2, joint.gamma, joint.b) @ screw(0, joint.alpha, joint.d)
        frames.append(frames[joint.antecedent] @ before @ screw(2, joint.theta + turn, joint.r + slide))
    return frames


def alike(found: Machine, frames: list[Array]) -> set[tuple[int, int]]:
    """Motors whose twists, about the origin of frame 0, are multiples of each other."""
    twists = {}
    for j in found.motors:
        z, origin = frames[j][:3, 2], frames[j][:3, 3]
        slides = found.joint(j).sigma == P
        twists[j] = np.concatenate([z, 0 * z] if slides else [np.cross(origin, z), z])
    pairs = set()
    for j in found.motors:
        k = found.joint(j).antecedent
        while k:
            if k in twists and np.linalg.matrix_rank([twists[k], twists[j]], tol=1e-9) == 1:
                pairs.add((k, j))
            k = found.joint(k).antecedent
    return pairs


def expected(found: Machine) -> set[int]:
    """Motors that move what is beyond them as one before them does, at each of three random positions."""
    rng = np.random.default_rng(0)
    return {j for _, j in set.intersection(*(alike(found, placed(found, rng)) for _ in range(3)))}


@pytest.mark.thorough
def test_random_machines_are_warned_about_where_numbers_say_so() -> None:
    """200 machines: those whose motors have twists of their own and masses beyond them raise no alarm."""
    right = 0
    for seed in range(200):
        found = random_machine(seed, joints=3 + seed % 5, symbolic=seed % 3 == 0)
        lines = warned(found)
        wrong = expected(found)
        assert {int(line.split()[1]) for line in lines if "same direction" in line} == wrong, found.name
        assert len(lines) == len(wrong), lines
        right += not lines
    assert right > 180
