"""Loops in space whose dependent joints inverse geometry gives, against positions closed in 70 digits."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.loops.assembly import Position
from symoro_elastic.models.loops.plan import Form, Plan, plan_of
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from tests.closed_chains.machines import FILES, machine
from tests.references.closed_chains import Chain, State, in_many_digits

pytestmark = pytest.mark.sampled(5)

EXACT = 1e-13
UNIVERSAL_JOINT = """
name = "universal_joint"
joints = [
  { name = "input", antecedent = 0, kind = "motor", sigma = 0, theta = "q_in" },
  { name = "yoke", antecedent = "input", kind = "passive", sigma = 0, alpha = "pi/2", theta = "a1" },
  { name = "cross", antecedent = "yoke", kind = "cut", sigma = 0, alpha = "pi/2", theta = "a2" },
  { name = "output", antecedent = 0, kind = "passive", sigma = 0, alpha = "bend", theta = "q_out" },
  { name = "fork", antecedent = "output", kind = "fixed", sigma = 2, alpha = "pi/2", theta = "pi/2" },
]
[loops]
joint = { cut = "cross", meets = "fork", start = { q_in = 0.2, a1 = 0.3, q_out = 0.2, a2 = 0.0 } }
[parameters]
bend = { value = 0.4 }
"""
SLIDER_BEHIND_A_BALL = """
name = "slider_behind_a_ball"
joints = [
  { name = "crank", antecedent = 0, kind = "motor", sigma = 0, theta = "q1" },
  { name = "cross", antecedent = "crank", kind = "passive", sigma = 0, d = 0.1, alpha = 0.4, theta = "a1" },
  { name = "rod", antecedent = "cross", kind = "passive", sigma = 0, alpha = "pi/2", theta = "a2" },
  { name = "ball", antecedent = "rod", kind = "cut", sigma = 2, d = 0.5 },
  { name = "slide", antecedent = 0, kind = "passive", sigma = 1, alpha = 0.9, d = 0.05, r = "s" },
  { name = "socket", antecedent = "slide", kind = "fixed", sigma = 2, d = 0.03, r = 0.02 },
]
[loops]
rod = { cut = "ball", meets = "socket", closes = "point", start = { q1 = 0.2, a1 = -1.0, a2 = 0.3, s = 0.4 } }
"""
ARM_WITH_A_WRIST = """
name = "arm_with_a_wrist"
joints = [
  { name = "drive", antecedent = 0, kind = "motor", sigma = 0, theta = "q1" },
  { name = "shoulder", antecedent = "drive", kind = "passive", sigma = 0, d = 0.3, alpha = "pi/2", theta = "q2" },
  { name = "elbow", antecedent = "shoulder", kind = "passive", sigma = 0, d = 0.4, theta = "q3" },
  { name = "roll", antecedent = "elbow", kind = "passive", sigma = 0, d = 0.3, alpha = "pi/2", theta = "q4" },
  { name = "pitch", antecedent = "roll", kind = "passive", sigma = 0, alpha = "pi/2", theta = "q5" },
  { name = "yaw", antecedent = "pitch", kind = "passive", sigma = 0, alpha = 1, theta = "q6" },
  { name = "pin", antecedent = "yaw", kind = "cut", sigma = 0, d = 0.3, alpha = 0.7, theta = "q7" },
  { name = "pin_end", antecedent = 0, kind = "fixed", sigma = 2, b = 0.2, d = 0.4, alpha = 0.5 },
]
[loops]
arm = { cut = "pin", meets = "pin_end", start = { q1=0.3, q2=0.7, q3=-1.6, q4=0.3, q5=0.4, q6=0.5, q7=0.2 } }
"""
ALONG = 'antecedent = {}, kind = "passive", sigma = 1, gamma = "pi/2", alpha = "pi/2"'
LEG_OF_A_HEXAPOD = f"""
name = "leg_of_a_hexapod"
joints = [
  {{ name = "along_x", {ALONG.format(0)}, r = "px" }},
  {{ name = "along_y", {ALONG.format('"along_x"')}, r = "py" }},
  {{ name = "along_z", {ALONG.format('"along_y"')}, r = "pz" }},
  {{ name = "tilt_x", antecedent = "along_z", kind = "passive", sigma = 0, theta = "tx" }},
  {{ name = "tilt_y", antecedent = "tilt_x", kind = "passive", sigma = 0, alpha = "pi/2", theta = "ty" }},
  {{ name = "platform", antecedent = "tilt_y", kind = "passive", sigma = 0, alpha = "pi/2", theta = "tz" }},
  {{ name = "swing", antecedent = 0, kind = "passive", sigma = 0, gamma = 1, d = 0.5, alpha = "pi/2", theta = "a" }},
  {{ name = "lift", antecedent = "swing", kind = "passive", sigma = 0, alpha = "pi/2", theta = "b" }},
  {{ name = "leg", antecedent = "lift", kind = "motor", sigma = 1, alpha = "pi/2", r = "length" }},
  {{ name = "ball", antecedent = "leg", kind = "cut", sigma = 2 }},
  {{ name = "socket", antecedent = "platform", kind = "fixed", sigma = 2, gamma = 1.2, d = 0.3 }},
]
[loops.leg]
cut = "ball"
meets = "socket"
closes = "point"
dependent = ["a", "b", "length"]
start = {{ px = 0, py = 0, pz = 1, tx = 0.1, ty = 1.6, tz = 0.2, a = 0.3, b = 1.2, length = 1.0 }}
"""
WRITTEN = (UNIVERSAL_JOINT, SLIDER_BEHIND_A_BALL, ARM_WITH_A_WRIST, LEG_OF_A_HEXAPOD)


def read(text: str) -> Machine:
    return toml.read(text, "machine.toml")


MACHINES = {m.name: m for m in (*map(read, WRITTEN), machine("delta"), machine("spatial_four_bar"))}


def positions(plan: Plan, described: Machine, count: int) -> Iterator[Position]:
    """Positions about the start, on its branch: each is followed from there in steps."""
    source, start = random.Random(described.name), plan.positions[0]
    reach = {0: 0.5, 1: 0.1}
    for _ in range(count):
        target = {j: start[j] + source.uniform(-1, 1) * reach[described.joint(j).sigma] for j in described.independent}
        found = plan.assembly.position_at(start, target)
        if found is not None:
            yield found


def given(described: Machine, at: Position) -> Mapping[str, float]:
    values = {p.name: p.value.value() for p in described.parameters if p.value}
    return values | dict(zip(Bound(described).arguments()["q"], [at[j] for j in described.independent], strict=True))


def closed_form(described: Machine, at: Position) -> list[float]:
    (result,) = trace(described, "dependent_coordinates").program.outputs
    value = evaluate(result.entries, given(described, at), FLOATS)
    return [float(value(x)) for x in result.entries]


@in_many_digits
def closed(described: Machine, at: Position) -> list[Any]:
    """Own variables in 70 digits, by Newton's method of the reference."""
    values = {p.name: p.value.value() for p in described.parameters if p.value}
    chain = Chain(described, values)
    guess = {str(described.joint(j).variable): at[j] for j in described.dependent}
    found = chain.assemble(State([at[j] for j in described.independent], [0.0] * len(described.independent), guess))
    return [found[variable] for variable in chain.own]


@pytest.mark.parametrize("name", MACHINES)
def test_on_the_branch_of_start(name: str) -> None:
    described = MACHINES[name]
    plan = plan_of(described)
    assert {one.form for one in plan.loops} == {Form.INVERSE}
    count = 0
    for at in positions(plan, described, 4):
        count += 1
        for j, found, wanted in zip(
            described.with_variable, closed_form(described, at), closed(described, at), strict=True
        ):
            error = float(found - wanted)
            error = math.remainder(error, 2 * math.pi) if described.joint(j).sigma == 0 else error
            assert abs(error) < EXACT, (described.joint(j).name, at)
    assert count >= 3


def test_each_start_has_its_branch() -> None:
    """The rocker on either side, and the coupler bent either way: four positions at one of the crank."""
    described, source = MACHINES["spatial_four_bar"], random.Random(4)
    plan = plan_of(described)
    branches = set()
    for _ in range(12):
        guess = {j: source.uniform(-math.pi, math.pi) for j in described.dependent}
        at, error = plan.assembly.assembled_position({**plan.positions[0], **guess}, described.dependent)
        if error < 1e-11:
            other = started(described, at)
            branches.add(tuple(round(math.cos(at[j] - 0.1), 6) for j in described.dependent))
            turns = (np.exp(1j * np.array(x)) for x in (closed_form(other, at), [at[j] for j in other.with_variable]))
            np.testing.assert_allclose(*turns, rtol=0, atol=1e-9)
    assert len(branches) == 4


def started(described: Machine, at: Position) -> Machine:
    """The machine with another start of its loops."""
    values = {str(described.joint(j).variable): Formula.parse(x) for j, x in at.items()}
    return replace(described, loops=tuple(replace(loop, start=values) for loop in described.loops))


def test_the_branch_stays_where_lengths_are_numbers() -> None:
    """Which solution is meant is found again for each choice of folded parameters; positions are closed to 1e-11."""
    text = (
        FILES["delta"].read_text(encoding="utf-8").replace('d = "La", theta = "b1"', 'd = "La", r = "e", theta = "b1"')
    )
    described = toml.read(text.replace("Rb = {", "e = { value = 0 }\nRb = {"), "delta.toml")
    at = plan_of(described).positions[1]
    for folded in ([], ["e"], [p.name for p in described.parameters]):
        variables = Bound(described, folded).variables
        value = evaluate(variables.values(), given(described, at), FLOATS)
        for j, x in variables.items():
            assert abs(float(value(x)) - at[j]) < 1e-10, (folded, j)


def test_a_universal_joint_turns_as_the_textbook_says() -> None:
    """tan q_out = tan q_in / cos bend; the output's axis of the cross is a quarter turn behind its zero."""
    described = MACHINES["universal_joint"]
    for q_in in (0.1, 0.5, 1.1, -0.9):
        _, _, q_out = closed_form(described, {described.independent[0]: q_in})
        wanted = math.tan(q_in) / math.cos(0.4)
        assert math.isclose(math.tan(q_out + math.pi / 2), wanted, rel_tol=4e-15 / abs(math.sin(2 * q_in)))


SCREWS = """
name = "screws"
gravity = [0.3, -4, -9]
joints = [
  { name = "table", antecedent = 0, kind = "motor", sigma = 0, alpha = 0.3, theta = "q1" },
  { name = "nut", antecedent = "table", kind = "coupled", sigma = 1, r = "0.1*q1" },
  { name = "slide", antecedent = 0, kind = "coupled", sigma = 1, alpha = 0.3, r = "0.1*q1" },
  { name = "ring", antecedent = "slide", RING },
  { name = "pin", antecedent = "nut", kind = "cut", sigma = 2, r = 0.1, theta = 0.4 },
  { name = "pin_end", antecedent = "ring", kind = "fixed", sigma = 2, r = 0.1 },
]
[bodies]
table = { mass = 2, center_of_mass = [0.1, 0.05, 0.02], inertia = [0.1, 0.2, 0.2] }
ring = { mass = 1, center_of_mass = [0.1, 0, 0.1], inertia = [0.1, 0.2, 0.3] }
nut = { mass = 3, center_of_mass = [0.1, 0.2, 0.1], inertia = [0.1, 0.2, 0.3] }
"""


def test_a_single_turn_undoes_all_other_joints() -> None:
    """The ring turns with the table, 0.4 rad ahead, as it does where its cell says so."""
    by_loop = SCREWS.replace("RING", 'kind = "passive", sigma = 0, theta = "q2"')
    by_loop += '[loops]\nbridge = { cut = "pin", meets = "pin_end", start = { q1 = 0.3, q2 = 0.7 } }\n'
    by_cell = SCREWS.replace("RING", 'kind = "coupled", sigma = 0, theta = "q1 + 0.4"')
    by_cell = "\n".join(line for line in by_cell.split("\n") if "pin" not in line)
    described = toml.read(by_loop, "screws.toml")
    assert [plan.form for plan in plan_of(described).loops] == [Form.ONE]
    one, other = (se.load(toml.read(text, "screws.toml"), "inverse_dynamics") for text in (by_loop, by_cell))
    for q in (0.3, -2.0, 1.2):
        assert closed_form(described, {described.independent[0]: q})[-1] == pytest.approx(q + 0.4, abs=1e-15)
        state = [np.array([x]) for x in (q, 1.3, -0.7)]
        np.testing.assert_allclose(one.inverse_dynamics(*state), other.inverse_dynamics(*state), rtol=1e-13)
