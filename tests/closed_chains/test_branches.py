"""Models stay on the branch of the start of a loop: next to positions where branches meet, and far from the start."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.loops.plan import Form, plan_of
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.evaluation.assembled_states import start_of
from symoro_elastic.numerics.evaluation.closed_positions import Followed
from symoro_elastic.numerics.evaluation.values import given_values
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from tests.closed_chains.machines import FILES, machine

pytestmark = pytest.mark.sampled(5)

CRANK, BASE, ROCKER = 0.15, 0.5, 0.3
CHANGE_POINT = BASE - CRANK + ROCKER
"""Length of the rod with which crank, rod and rocker lie on the base all at once: there the branches meet."""
FOUR_BAR = """
name = "four_bar"
joints = [
  {{ name = "crank", antecedent = 0, kind = "motor", sigma = 0, theta = "q1" }},
  {{ name = "rod", antecedent = "crank", kind = "passive", sigma = 0, d = 0.15, theta = "q2" }},
  {{ name = "rocker", antecedent = 0, kind = "passive", sigma = 0, d = 0.5, theta = "q3" }},
  {{ name = "pin", antecedent = "rod", kind = "cut", sigma = 0, d = {rod!r}, theta = "q4" }},
  {{ name = "end", antecedent = "rocker", kind = "fixed", sigma = 2, d = 0.3 }},
]
[loops]
bars = {{ cut = "pin", meets = "end", start = {{ q1 = {q1!r}, q2 = {q2!r}, q3 = {q3!r} }} }}
[bodies]
rod = {{ mass = 1, center_of_mass = [0.2, 0, 0], inertia = [0.001, 0.02, 0.02] }}
"""
EXACT = 2e-15


def closed_by_circles(rod: float, q1: float, side: int) -> tuple[float, float]:
    """q2 and q3 where the circles about the tip of the crank and the axis of the rocker meet, on either side."""
    x, y = BASE - CRANK * math.cos(q1), -CRANK * math.sin(q1)
    distance = math.hypot(x, y)
    along = (rod**2 - ROCKER**2 + distance**2) / (2 * rod * distance)
    angle = math.atan2(y, x) + side * math.acos(min(1.0, along))
    pin = CRANK * math.cos(q1) + rod * math.cos(angle) - BASE, CRANK * math.sin(q1) + rod * math.sin(angle)
    return angle - q1, math.atan2(pin[1], pin[0])


def four_bar(rod: float, q1: float, side: int) -> Machine:
    q2, q3 = closed_by_circles(rod, q1, side)
    return toml.read(FOUR_BAR.format(rod=rod, q1=q1, q2=q2, q3=q3), "four_bar.toml")


def dependent(described: Machine, positions: Sequence[float]) -> list[list[float]]:
    """q2 and q3 by the closed form at positions of the crank."""
    (result,) = trace(described, "dependent_coordinates").program.outputs
    values = (evaluate(result.entries, {"q1": q1}, FLOATS) for q1 in positions)
    return [[float(value(x)) for x in result.entries[1:]] for value in values]


def gap_and_area(rod: float, q1: float, q2: float, q3: float) -> tuple[float, float]:
    """Distance of both ends of the pin, and twice the area of the triangle of rod and rocker, with its sign."""
    of_rod = np.array([math.cos(q1 + q2), math.sin(q1 + q2)])
    of_rocker = np.array([math.cos(q3), math.sin(q3)])
    tip = CRANK * np.array([math.cos(q1), math.sin(q1)])
    gap = tip + rod * of_rod - np.array([BASE, 0]) - ROCKER * of_rocker
    return float(np.linalg.norm(gap)), float(rod * ROCKER * (of_rod[0] * of_rocker[1] - of_rod[1] * of_rocker[0]))


@given(st.floats(0.6, 11), st.floats(-1, 1), st.sampled_from([1, -1]))
@settings(max_examples=12, deadline=None)
def test_a_four_bar_near_its_change_point_is_a_triangle_on_its_branch(near: float, q1: float, side: int) -> None:
    """Rods shorter than that of the change point by 0.25 m to 1e-11 m: closed at all positions, never turned over."""
    rod = CHANGE_POINT - 10**-near
    described = four_bar(rod, q1, side)
    (loop,) = plan_of(described).loops
    assert loop.form is Form.TRIANGLE
    positions = (q1, 0.0, 1e-6, -1e-4, 0.3, -0.8)
    for at, (q2, q3) in zip(positions, dependent(described, positions), strict=True):
        gap, area = gap_and_area(rod, at, q2, q3)
        assert gap < EXACT and side * area > 0, at


@pytest.mark.parametrize(("q1", "side"), [(0.5, 1), (0.01, -1), (-0.01, 1)])
def test_the_change_point_itself_bounds_the_branch(q1: float, side: int) -> None:
    described = four_bar(CHANGE_POINT, q1, side)
    assert plan_of(described).loops[0].form is Form.TRIANGLE
    positions = (q1, 0.9, -0.9)
    for at, (q2, q3) in zip(positions, dependent(described, positions), strict=True):
        gap, area = gap_and_area(CHANGE_POINT, at, q2, q3)
        assert gap < EXACT and side * area > 0


def test_a_flat_start_tells_no_branch() -> None:
    """q_dep tells it then: the models take that."""
    described = toml.read(FOUR_BAR.format(rod=CHANGE_POINT, q1=0.0, q2=0.0, q3=0.0), "four_bar.toml")
    assert plan_of(described).loops[0].form is Form.ASSEMBLED


@pytest.mark.parametrize("opened", [0.0, 1e-9, -1e-3, 0.3])
def test_a_parallelogram_that_starts_flat_is_one(opened: float) -> None:
    """Crossed bars begin at the flat position too; a constant map passes it."""
    text = FILES["sr400"].read_text(encoding="utf-8")
    at = {"th2": -1.0, "th7": opened - 1.0, "th3": opened - math.pi / 2, "th8": -opened}
    start = ", ".join(f"{name} = {x!r}" for name, x in at.items())
    described = toml.read(re.sub(r"start = \{[^}]*\}", f"start = {{ {start} }}", text), "sr400.toml")
    assert plan_of(described).loops[0].form is Form.MAP


STEPS, SHORTEST, LONGEST_STEP = 320, 1.5 / 320, 0.08
"""Of the independent variable, number and length, rad; longest step of a dependent one, rad or m."""


def in_small_steps(described: Machine) -> Iterator[list[float]]:
    """q_dep at the start and at each step of its only independent variable, by the generated `assemble`."""
    program, start = trace(described, "assemble").program, start_of(described)
    found = start.q_dep.tolist()
    yield found
    for k in range(1, STEPS + 1):
        values = [float(start.q[0]) + k * SHORTEST], found
        symbols: dict[str, float] = dict(given_values(described))
        for argument, block in zip(program.inputs, values, strict=True):
            symbols |= zip(argument.symbols, block, strict=True)
        value = evaluate(program.outputs[0].entries, symbols, FLOATS)
        found = [float(value(x)) for x in program.outputs[0].entries]
        yield found


def test_far_positions_are_on_the_branch_of_the_start() -> None:
    """A loop that nearly folds on the way, asked for at positions up to 1.5 rad from the start."""
    described = machine("ring_with_slide")
    wanted = np.array(list(in_small_steps(described)))
    assert np.abs(np.diff(wanted, axis=0)).max() < LONGEST_STEP
    asked = np.arange(0, STEPS + 1, 16)
    found = Followed(described, given_values(described)).at(start_of(described).q + SHORTEST * asked[:, None])
    np.testing.assert_allclose(found, wanted[asked], rtol=0, atol=1e-11)


def test_beyond_its_fold_a_branch_has_no_position() -> None:
    """The motor of the ring turns its loop flat 0.3 rad from the start: other branches, farther on, are not taken."""
    described = machine("ring")
    q = start_of(described).q + np.linspace(-1.5, 1.5, 31)[:, None] * [1, 0]
    lost = np.isnan(Followed(described, given_values(described)).at(q)).any(axis=1)
    assert lost.tolist() == sorted(lost.tolist()) and lost.any() and not lost[:16].any()
