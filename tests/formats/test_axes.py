"""Joints by axis and point are those of a table by hand, and of a URDF."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symoro_elastic.formats.polynomials import Polynomial
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.linear.grouping import base_parameters
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.examples import EXAMPLES, example
from tests.formats import by_axes
from tests.formats.robots.samples import ARM, random_robots
from tests.machine.samples import BY_AXIS

MODELS = ("inverse_dynamics", "inertia_matrix", "regressor")
LENGTHS = "D3 D4 R2 R3 RL4"


def read(text: str) -> Machine:
    machine = toml.read(text, "axes.toml")
    check(machine)
    return machine


def rewritten(name: str, joints: str, bodies: dict[str, str]) -> Machine:
    """An example with joints by axis and point, and bodies in axes of frame 0."""
    text = (EXAMPLES / f"{name}.toml").read_text()
    text = re.sub(r"(?ms)^joints = \[.*?^\]\n", lambda _: joints, text)
    for joint_name, body in bodies.items():
        text, count = re.subn(rf"(?m)^{joint_name} *= {{ mass.*$", lambda _, new=f"{joint_name} = {body}": new, text)
        assert count == 1
    return read(text)


@pytest.mark.thorough
def test_the_rx90_by_axes_is_the_table_by_hand() -> None:
    hand, machine = example("rx90.par"), read(by_axes.arm_of_six(by_axes.RX90, "D3 RL4", "joint"))
    for mine, theirs in zip(machine.joints, hand.joints, strict=True):
        assert (mine.alpha, mine.d, mine.theta, mine.r, mine.body) == (
            *(theirs.alpha, theirs.d, theirs.theta, theirs.r, theirs.body),
        )
    for model in MODELS:
        mine, theirs = (trace(one, model).program for one in (machine, hand))
        assert repr(mine.statements) == repr(theirs.statements)


@pytest.mark.parametrize(("name", "rows"), [("rx90", by_axes.RX90), ("puma560", by_axes.PUMA560)])
@pytest.mark.parametrize("axes", ["joint", "base"])
def test_arms_by_axes_need_no_more_operations(name: str, rows: str, axes: str) -> None:
    hand, machine = example(f"{name}.par"), read(by_axes.arm_of_six(rows, LENGTHS, axes))
    for model in MODELS:
        mine, theirs = (trace(one, model).program.count for one in (machine, hand))
        assert (mine == theirs) if name == "rx90" else (mine.mul < theirs.mul and mine.add < theirs.add)
    mine, theirs = (base_parameters(one) for one in (machine, hand))
    assert len(mine.formulas) == len(theirs.formulas)


@pytest.mark.thorough
@pytest.mark.parametrize(("name", "file"), [("two_axis", by_axes.TWO_AXIS), ("gantry", by_axes.GANTRY)])
def test_machine_tools_by_axes_have_programs_of_the_size_and_results_of_the_tables_by_hand(
    name: str, file: tuple[str, dict[str, str]]
) -> None:
    hand, machine = example(f"{name}.toml"), rewritten(name, *file)
    assert [one.name for one in machine.joints] == [one.name for one in hand.joints]
    models = ("inverse_dynamics", "direct_dynamics")
    for model in models:
        assert trace(machine, model).program.count == trace(hand, model).program.count
    assert len(base_parameters(machine).formulas) == len(base_parameters(hand).formulas)
    both = [numpy_model(one, models) for one in (hand, machine)]
    rng = np.random.default_rng(1)
    q, qd = rng.normal(size=(2, len(machine.independent))) * 0.1
    tau = rng.normal(size=len(machine.motors)) * 1e3
    hand_side, mine_side = (one.direct_dynamics(q, qd, tau) for one in both)
    assert np.allclose(mine_side, hand_side, rtol=0, atol=1e-11 * np.abs(hand_side).max())


def worst_error(text: str) -> float:
    """Of torques and frames of a robot that is written by axes and points, from Pinocchio's reading of its URDF."""
    pytest.importorskip("pinocchio")
    from tests.references.compared_robots import OfTable

    class ByAxes(OfTable):
        @property
        def own(self) -> list[str]:  # type: ignore[override]
            return [joint.name for joint in self.machine.joints if joint.variable]

    return ByAxes(text, read(by_axes.of_robot(text))).errors(states=2).worst


def test_a_robot_by_axes_is_the_robot() -> None:
    assert worst_error(re.sub("<dynamics.*?/>", "", ARM)) < 1e-12


@given(random_robots())
@settings(max_examples=6, deadline=None)
def test_random_robots_by_axes_are_the_robots(text: str) -> None:
    """Odd and quarter turns, parallel, nearly parallel and coaxial axes, slides, branches."""
    assert worst_error(text) < 1e-12


def test_a_product_of_tiny_numbers_is_zero() -> None:
    """A frame 1e-89 m along an axis that leans by 1e-15 rad."""
    x = Polynomial.of(Formula.parse("1e-89")) * Polynomial.of(Formula.parse("1e-15"))
    assert x.formula.is_zero and (Polynomial.number(1e-104) + Polynomial.number(0.5)).formula.text == "0.5"


LENGTH = st.sampled_from(["0", "0.3", "A", "-B", "A + B", "A/2 - 0.1", "2*B", "-A", "A - B"])
VALUES = {"A": 0.37, "B": 0.21}


@st.composite
def chains(draw: st.DrawFn) -> list[tuple[str, int, list[str], int]]:
    """Axis, type, point and antecedent of each row of a tree; all axes along those of frame 0."""
    rows = range(draw(st.integers(1, 4)))
    axes = st.sampled_from(["x", "y", "z", "-x", "-y", "-z"])
    points = st.lists(LENGTH, min_size=3, max_size=3)
    return [(draw(axes), draw(st.sampled_from([0, 0, 1])), draw(points), draw(st.integers(0, k))) for k in rows]


def chain(rows: list[tuple[str, int, list[str], int]], values: dict[str, float] | None = None) -> Machine:
    """The machine of such rows, with names or with their values."""

    def cell(text: str) -> str:
        return f'"{text}"' if values is None else repr(float(eval(text, {}, dict(values))))

    lines = [
        f'{{ name = "j{j}", antecedent = {a}, kind = "motor", sigma = {sigma}, axis = "{axis}", '
        f"at = [{', '.join(map(cell, at))}] }},"
        for j, (axis, sigma, at, a) in enumerate(rows, start=1)
    ]
    body = "{ mass = 2, first_moments = [0.2, -0.3, 0.4], inertia_at_origin = [1, 0.01, 0.02, 1.1, 0.03, 1.2] }"
    bodies = [f"j{j} = {body}" for j in range(1, len(rows) + 1)]
    parameters = ["[parameters]", *(f"{name} = {x}" for name, x in VALUES.items())]
    return read("\n".join(["gravity = [1, 2, -9]", "joints = [", *lines, "]", *parameters, "[bodies]", *bodies]))


@pytest.mark.thorough
@given(chains())
@settings(max_examples=25, deadline=None)
def test_names_in_points_stay_names_with_the_results_of_their_values(
    rows: list[tuple[str, int, list[str], int]],
) -> None:
    """Parallel axes that are apart by two names take a fixed row between."""
    pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model

    symbols, numbers = chain(rows), chain(rows, VALUES)
    q = np.linspace(0.3, 1.1, len(rows))
    pair = (pinocchio_model.inertia_matrix(one, q, VALUES) for one in (symbols, numbers))
    assert np.allclose(*pair, rtol=0, atol=1e-12)
    pair = (pinocchio_model.bias_forces(one, q, 2 * q, VALUES) for one in (symbols, numbers))
    assert np.allclose(*pair, rtol=0, atol=1e-11)
    texts = [str(getattr(one, key)) for one in symbols.joints for key in ("b", "d", "r")]
    assert not any("atan2" in text or "sqrt" in text for text in texts)


def test_a_fixed_row_is_between_parallel_axes_that_two_names_place() -> None:
    machine = chain([("z", 0, ["0", "0", "0"], 0), ("z", 0, ["A", "-B", "0.3"], 1)])
    assert [joint.name for joint in machine.joints] == ["j1", "j2_seat", "j2"]
    assert {str(machine.joints[1].d), str(machine.joints[2].d)} in ({"A", "-B"}, {"A", "B"})


def test_rows_by_axis_and_by_parameters_stand_beside_each_other() -> None:
    """A row of parameters after one by axis is in the frame at its point; in = gives axis and at in frames of rows."""
    mixed = read("""
joints = [
  { name = "turn", kind = "motor", sigma = 0, alpha = "pi/2", d = "L1", theta = "q1 + pi/2" },
  { name = "slide", kind = "motor", sigma = 1, axis = "z", at = [0.1, 0, 0], in = "turn", variable = "q2" },
  { name = "wheel", kind = "motor", sigma = 0, alpha = "pi/2", d = 0.2, theta = "q3", r = 0.3 },
  { name = "gear", antecedent = "slide", kind = "coupled", sigma = 0, axis = "x", theta = "3*q3" },
  { name = "tip", antecedent = "gear", kind = "fixed", axis = "x", at = [0, 0, 0.4], in = "slide" },
]
[parameters]
L1 = 0.5
[frames]
camera = { on = "slide", at = [0.1, 0.2, 0.3], rpy = [0, 0, 0.4] }
[bodies]
turn = { mass = 1, center_of_mass = [0, 0, 1], inertia = [1, 2, 3], axes = "base" }
slide = { mass = 1, center_of_mass = [1, 2, 3], inertia = [1, 2, 3] }
[wrenches]
slide = { force = [1, 2, 3], moment = [4, 5, 6] }
""")
    frames = {joint.name: T for joint, T in zip(mixed.joints, placements(mixed), strict=True)}
    # turn: x is y0 turned by theta, z is -y0; its point is (L1, 0, 0)
    assert np.allclose(frames["turn"], [[0, -1, 0, 0.5], [0, 0, -1, 0], [1, 0, 0, 0], [0, 0, 0, 1]])
    assert np.allclose(frames["slide"][:3, 2], [0, -1, 0])
    point = np.array([0.5, 0, 0.1])
    assert np.allclose(np.cross(frames["slide"][:3, 3] - point, [0, 1, 0]), 0)
    # wheel: Rot(x, pi/2) Trans(x, 0.2) Trans(z, 0.3) in axes of frame 0 at the point of the slide
    assert np.allclose(frames["wheel"][:3, 2], [0, -1, 0]) and np.allclose(frames["wheel"][:3, 3], [0.7, -0.3, 0.1])
    assert np.allclose(frames["tip"][:3], [[0, 0, 1, 0.5], [1, 0, 0, 0], [0, 1, 0, 0.5]])
    slide, row = mixed.joints[1], frames["slide"]
    center = [x.value() for x in slide.body.moments]
    assert np.allclose(row @ [*center, 1], [1.5, 2, 3.1, 1])
    (camera,) = mixed.frames
    assert np.allclose(row @ [*(x.value() for x in camera.at), 1], [0.6, 0.2, 0.4, 1])
    yaw = by_axes.turn("z", 0.4)
    roll, pitch, turned = (x.value() for x in camera.rpy)
    own = by_axes.turn("z", turned) @ by_axes.turn("y", pitch) @ by_axes.turn("x", roll)
    assert np.allclose(row[:3, :3] @ own, yaw)
    force, moment = ([x.value() for x in vector] for vector in (slide.wrench.force, slide.wrench.moment))
    assert np.allclose(row[:3, :3] @ force, [1, 2, 3])
    assert np.allclose(row[:3, :3] @ moment, np.cross(point - row[:3, 3], [1, 2, 3]) + np.array([4, 5, 6]))
    turn = frames["turn"][:3, :3] @ [x.value() for x in mixed.joints[0].body.moments]
    assert np.allclose(turn, [0, 0, 1])
    assert str(mixed.joints[3].theta).startswith("3*q3")


def placements(machine: Machine) -> list[np.ndarray]:
    """Frames of the rows in frame 0 at position zero."""
    found, values = [np.eye(4)], {p.name: p.value.value() for p in machine.parameters if p.value}
    values |= dict.fromkeys(machine.variables, 0.0)
    for joint in machine.joints:
        keys = ("gamma", "b", "alpha", "d", "theta", "r")
        gamma, b, alpha, d, theta, r = (getattr(joint, key).value(values) for key in keys)
        T = np.eye(4)
        for axis, angle, shift in (("z", gamma, [0, 0, b]), ("x", alpha, [d, 0, 0]), ("z", theta, [0, 0, r])):
            step = np.eye(4)
            step[:3, :3], step[:3, 3] = by_axes.turn(axis, angle), shift
            T = T @ step
        found.append(found[joint.antecedent] @ T)
    return found[1:]


def test_a_row_needs_no_more_than_its_axis() -> None:
    machine = read('joints = [{ name = "y_axis", kind = "motor", sigma = 1, axis = "y" }]\ngravity = [0, 0, 0]')
    assert machine.joints[0].variable == "q1" and np.allclose(placements(machine)[0][:3, 2], [0, 1, 0])


def test_a_table_by_axes_is_written_as_the_parameters_that_it_became() -> None:
    machine = rewritten("gantry", *by_axes.GANTRY)
    again = toml.read(toml.write(machine), "axes.toml")
    assert again.joints == machine.joints and again.loops == machine.loops


BAD = [
    ('axis = "z"', 'axis = "w"', "joint 1 (a), axis", "'w' is not an axis: write \"x\""),
    ('axis = "z"', 'axis = "xy"', "joint 1 (a), axis", "is not an axis"),
    ('axis = "z"', "axis = 3", "joint 1 (a), axis", "is not an axis"),
    ('axis = "z"', "axis = [0, 0, 0]", "joint 1 (a), axis", "is zero"),
    ('axis = "z"', "axis = [0, 3, 4]", "joint 1 (a), axis", "has length 5: write the unit vector [0, 0.6, 0.8]"),
    ('axis = "z"', "axis = [0, 1]", "joint 1 (a), axis", "has 2 entries, expected 3"),
    ('axis = "z"', 'axis = ["L", 0, 1]', "joint 1 (a), axis", "'L' is a name"),
    ('axis = "z"', "axis = [nan, 0, 1]", "joint 1 (a), axis", "not finite"),
    ('axis = "z"', 'axis = "z", alpha = 0', "joint 1 (a), alpha", "leave it out, or axis"),
    ('axis = "z"', 'axis = "z", gamma = 0', "joint 1 (a), gamma", "leave it out, or axis"),
    ('axis = "z"', 'axis = "z", theta = "q1"', "joint 1 (a), theta", "variable names its variable"),
    ('axis = "z", ', "", "joint 1 (a), axis", 'is missing: write axis = "x"'),
    ('axis = "z", at = ["L", 0, 0]', "alpha = 0, at = [0, 0, 0]", "joint 1 (a), alpha", "leave it out, or at"),
    ('["L", 0, 0]', '["M", 0, 0]', "joint 1 (a), at", "'M' is not declared in [parameters]"),
    ('["L", 0, 0]', '["q1", 0, 0]', "joint 1 (a), at", "'q1' is not declared in [parameters]"),
    ('["L", 0, 0]', '["1/0", 0, 0]', "joint 1 (a), at", "divides by zero"),
    ('["L", 0, 0]', '["1 kg", 0, 0]', "joint 1 (a), at", "where m is needed"),
    ('["L", 0, 0]', "[\"__import__('os')\", 0, 0]", "joint 1 (a), at", "not arithmetic"),
    ('["L", 0, 0]', '["(L + 1)*(L + 2)^64", 0, 0]', "joint 1 (a), ", ""),
    ('in = "a"', 'in = "z"', "joint 2 (b), in", "no joint 'z'"),
    ('in = "a"', 'in = "t"', "joint 2 (b), in", "row 4 is not above this row"),
    ('in = "a"', "in = -1", "joint 2 (b), in", "row -1 is not above this row"),
    ('in = "a"', 'in = "a", variable = "L"', "joint 2 (b), variable", "'L' is a parameter"),
    ('in = "a"', 'in = "a", variable = "2*x"', "joint 2 (b), variable", "is not a name"),
    ('in = "a"', 'in = "a", antecedent = 3', "joint 2 (b), antecedent", "row 3 is not above"),
    ('"2*q1"', '"2*q1 + 0.1"', "joint 3 (c), theta", "is '0.1' where variables are 0"),
    ('axis = "-x"', 'axis = "-x", variable = "q"', "joint 4 (t), variable", "leave it out"),
    ('axis = "-x"', 'theta = "beta", sigma = 2', "joint 4 (t), theta", "must be a number"),
    ("[1, 2, 3] }", '[1, 2, 3], axes = "world" }', "joint 2 (b), axes", "there are: base, joint"),
    ("rpy = [0, 0, 0.1]", 'rpy = [0, 0, "L"]', "frame 'eye', rpy", "angles must be numbers"),
]


@pytest.mark.parametrize(("old", "new", "place", "reason"), BAD, ids=[f"{new} at {place}" for _, new, place, _ in BAD])
def test_wrong_axes_and_points_are_named(old: str, new: str, place: str, reason: str) -> None:
    assert old in BY_AXIS and read(BY_AXIS)
    with pytest.raises(InputError) as caught:
        read(BY_AXIS.replace(old, new, 1))
    said = str(caught.value)
    assert said.startswith(f"axes.toml: {place}") and reason in said and "\n" not in said and len(said) < 500


def test_a_rotor_by_axis_follows_by_a_ratio_that_is_a_name() -> None:
    """A row of parameters after a joint by axis may have one, too."""
    machine = read("""gravity = [0, 0, -9.81]
joints = [
  { name = "a", kind = "motor", sigma = 0, axis = "x", at = [0, 0, "L"] },
  { name = "b", kind = "coupled", sigma = 0, axis = "y", theta = "N1*q1" },
  { name = "c", antecedent = "a", kind = "coupled", sigma = 1, alpha = "pi/2", r = "N1*q1 + L" },
]
[parameters]
N1 = 100
L = 0.2
""")
    frames = placements(machine)
    assert np.allclose(frames[1][:3, 2], [0, 1, 0]) and "N1*q1" in str(machine.joints[1].theta)
    # c: Rot(x, pi/2) Trans(z, L) in axes of frame 0 at the point of a, L above
    assert np.allclose(frames[2][:3, 2:], [[0, 0], [-1, -0.2], [0, 0.2]]) and "N1*q1" in str(machine.joints[2].r)


FOUR_BAR = """gravity = [9.81, 0, -3]
joints = [
  { name = "crank",  antecedent = 0, kind = "motor", sigma = 0, axis = "y" },
  { name = "rod",    kind = "passive", sigma = 0, axis = "y", at = [0, 0, "A"] },
  { name = "rocker", antecedent = 0, kind = "passive", sigma = 0, axis = "y", at = ["B", 0, 0] },
  { name = "pin",    antecedent = "rod", kind = "cut", sigma = 0, axis = "y", at = ["B", 0, "2*A"] },
  { name = "pin_end", antecedent = "rocker", kind = "fixed", axis = "y", at = ["B", 0, "2*A"] },
]
[loops]
bar = { cut = "pin", meets = "pin_end", start = { q1 = 0, q2 = 0, q3 = 0 } }
[parameters]
A = 0.3
B = 0.8
[bodies]
rod = { mass = 2, center_of_mass = ["B/2", 0, "A/2"], inertia = [0.01, 0.1, 0.1] }
"""


def test_loops_by_axes_are_closed_where_all_joints_are_at_zero() -> None:
    machine = read(FOUR_BAR)
    (loop,) = machine.loops
    frames = placements(machine)
    assert np.allclose(frames[loop.cut - 1], frames[loop.meets - 1], rtol=0, atol=1e-15)
    still = np.zeros(len(machine.independent))
    tau = np.ravel(numpy_model(machine, ("inverse_dynamics",)).inverse_dynamics(still, still, still)[0])
    # by virtual work: at zero the rod moves along x, by 0.3 m/rad of the crank; along x its weight is 2 kg 9.81 m/s2
    assert tau == pytest.approx([-2 * 9.81 * 0.3], rel=1e-12)
