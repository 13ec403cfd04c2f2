"""Cells that hold the variables of other joints, and closed loops: what is read, written and locked."""

from __future__ import annotations

import itertools
import math
import random
import re
from dataclasses import replace

import pytest
from hypothesis import given, settings

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.loops import Closing
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from tests.machine.samples import COUPLED, coupled_machines

parse = Formula.parse


def read(text: str) -> Machine:
    return toml.read(text, "arm.toml")


def cells_of(*cells: str, variables: dict[int, str] | None = None) -> Machine:
    """Revolute motors in a chain with these cells."""
    named = {j: f', variable = "{name}"' for j, name in (variables or {}).items()}
    rows = [
        f'{{ name = "j{j}", kind = "motor", sigma = 0, theta = "{cell}"{named.get(j, "")} }},'
        for j, cell in enumerate(cells, start=1)
    ]
    return read("joints = [\n" + "\n".join(rows) + "\n]\n[parameters]\nN = 3\n")


def test_rows_own_the_variables_that_no_other_row_owns() -> None:
    machine = read(COUPLED)
    own = ["q1", None, "q2", "q3", "q4", "qm", "q5", "q6", None, None]
    assert [joint.variable for joint in machine.joints] == own
    assert machine.joint(5).theta == parse("qm/N1") and machine.joint(2).theta == parse("N1*q1")
    assert (machine.independent, machine.dependent) == ((1, 3, 5, 6), (4, 7))
    assert check(machine) == []


@pytest.mark.parametrize("order", [*itertools.permutations(range(3))])
def test_the_order_of_rows_is_free(order: tuple[int, ...]) -> None:
    cells = ("a", "b - N*a", "2*b + c")
    machine = cells_of(*(cells[k] for k in order))
    assert [(j.variable, j.theta.text) for j in machine.joints] == [
        [("a", "0"), ("b", "-N*a"), ("c", "2*b")][k] for k in order
    ]


def test_a_row_may_say_which_variable_is_its_own() -> None:
    machine = cells_of("a + b", "c + b", variables={1: "b", 2: "c"})
    assert [(joint.variable, joint.theta.text) for joint in machine.joints] == [("b", "a"), ("c", "b")]


@pytest.mark.parametrize("cell", ["-N + q1", "- N + q1", "q1 - N", "(q1 - N)", "q1 -N"])
def test_offsets_with_a_sign_survive_writing(cell: str) -> None:
    machine = cells_of(cell)
    assert machine.joints[0].theta.text == "-N"
    assert toml.read(toml.write(machine), "arm.toml") == machine


def test_a_loop_is_read_by_names_and_by_variables() -> None:
    (loop,) = read(COUPLED).loops
    assert (loop.name, loop.cut, loop.meets, loop.closes) == ("ring", 8, 9, Closing.FRAME)
    assert loop.dependent == ("forearm", "rod")
    assert loop.start["qm"] == parse("2.5*N1") and [*loop.start] == ["q2", "q3", "q4", "qm", "q5"]
    machine = read(COUPLED)
    assert machine.with_variable_in(loop) == (3, 4, 5, 6, 7)
    assert replace(machine, loops=(replace(loop, dependent=()),)).dependent == (4, 7)


def test_a_machine_with_loops_survives_writing() -> None:
    machine = read(COUPLED)
    text = toml.write(machine)
    assert toml.read(text, "arm.toml") == machine
    assert 'variable = "q4" }' in text and "ring = { cut" in text and "closes" not in text
    point = replace(machine, loops=(replace(machine.loops[0], closes=Closing.POINT, dependent=(), start={}),))
    assert 'ring = { cut = "pin", meets = "pin_end", closes = "point" }' in toml.write(point)
    assert toml.read(toml.write(point), "arm.toml") == point


@given(coupled_machines())
@settings(max_examples=100, deadline=None)
@pytest.mark.thorough
def test_random_coupled_machines_survive_writing(machine: Machine) -> None:
    assert toml.read(toml.write(machine), "") == machine


@pytest.mark.thorough
@given(coupled_machines())
@settings(max_examples=100, deadline=None)
def test_own_variables_that_are_not_named_are_found_or_in_doubt(machine: Machine) -> None:
    """A row never gets the variable of another."""
    text = re.sub(r', variable = "\w+" }', " }", toml.write(machine))
    try:
        assert toml.read(text, "") == machine
    except InputError as error:
        assert re.search(r"the cell holds .* (both|all) new: write variable = ", str(error))


def positions(machine: Machine, values: dict[str, float]) -> dict[str, float]:
    """Value of the cell that sigma selects, by joint: its own variable plus the rest, that of a fixed frame too."""
    found = {}
    for joint in machine.joints:
        cell = "r" if joint.name.startswith("slide") else "theta"
        own = values[joint.variable] if joint.variable else 0.0
        found[joint.name] = own + getattr(joint, cell).value(values)
    return found


def random_couplings(seed: int) -> tuple[Machine, dict[str, float]]:
    """A chain whose joints follow those before them in a random order, with values of variables and parameters."""
    rng = random.Random(seed)
    rows, order = [], rng.sample(range(1, 7), 6)
    for j in range(1, 7):
        slides = rng.random() < 0.3
        rows.append(Joint(f"{'slide' if slides else 'turn'}{j}", j - 1, Kind.MOTOR, int(slides), f"x{j}"))
    for place, j in enumerate(order):
        leaders = [f"x{k}" for k in order[:place] if rows[k - 1].variable]
        if not leaders:
            continue
        first, second = rng.choice(leaders), rng.choice(leaders)
        text = rng.choice(["N*{0}", "N*{0} - {1}/3", "sin({0}/N)*{1}", "2*({0} + N*{1}) + pi", "-{0}/N"])
        cell = parse(text.format(first, second))
        kind = rng.choice([Kind.MOTOR, Kind.ELASTIC, Kind.COUPLED])
        variable = None if kind is Kind.COUPLED else f"x{j}"
        rows[j - 1] = replace(rows[j - 1], kind=kind, variable=variable).with_selected(cell)
        if kind is Kind.ELASTIC:
            spring = replace(rows[j - 1].spring, stiffness=parse(f"1000 + {first}^2"))
            rows[j - 1] = replace(rows[j - 1], spring=spring)
    machine = toml.read('joints = [{ name = "a", kind = "fixed" }]\n[parameters]\nN = 1.5\n', "arm.toml")
    values = {f"x{j}": rng.uniform(-2, 2) for j in range(1, 7)}
    return replace(machine, joints=tuple(rows)), {**values, "N": 1.5}


@pytest.mark.parametrize("seed", range(30))
def test_locked_variables_are_constants_in_all_cells(seed: int) -> None:
    """Positions and stiffnesses are those of the whole machine where its variables have these values."""
    machine, values = random_couplings(seed)
    rng = random.Random(seed)
    locked = {
        machine.joint(j).name: values[str(machine.joint(j).variable)] for j in machine.independent if rng.random() < 0.5
    }
    still = restrict(machine, Scene(locked={name: parse(x) for name, x in locked.items()}))
    check(still)
    before, after = positions(machine, values), positions(still, values)
    assert after == pytest.approx(before, rel=1e-14, abs=1e-14)
    kept = [machine.joint(j) for j in machine.independent if machine.joint(j).name not in locked]
    assert [joint.name for joint in still.independent_joints] == [joint.name for joint in kept]
    for joint, other in zip(still.independent_joints, kept, strict=True):
        assert joint.kind is other.kind
        assert joint.spring.stiffness.value(values) == pytest.approx(other.spring.stiffness.value(values), rel=1e-14)
    assert not {*still.variables} & {str(j.variable) for j in machine.joints if j.name in locked}


def test_a_locked_joint_that_follows_others_is_coupled() -> None:
    still = restrict(read(COUPLED), Scene(locked={"crank": parse("0.1")}))
    crank = still.joint(5)
    assert (crank.kind, crank.sigma, crank.variable, crank.theta.text) == (Kind.COUPLED, 0, None, "(qm/N1) + (0.1)")
    assert crank.spring.stiffness.is_zero and still.independent == (1, 3, 6)
    assert check(still) == []
    assert [*still.loops[0].start] == ["q2", "q3", "qm", "q5"]


def test_joints_that_follow_locked_ones_only_are_fixed() -> None:
    still = restrict(read(COUPLED), Scene(locked={"waist": parse("pi/4")}))
    rotor = still.joint(2)
    assert (rotor.kind, rotor.sigma) == (Kind.FIXED, 2)
    assert rotor.theta.value({"N1": 100}) == pytest.approx(25 * math.pi)


def test_a_loop_with_all_its_independent_joints_locked_is_consistent() -> None:
    locked = {"arm": parse(1), "crank": parse(0), "drive": parse(2.5)}
    still = restrict(read(COUPLED), Scene(locked=locked))
    assert check(still) == []
    assert (still.independent, still.dependent) == ((1,), (4, 7))
    assert [*still.loops[0].start] == ["q3", "q5"]


@pytest.mark.parametrize(
    ("joint", "said"),
    [
        ("rod", "its variable follows from loop ring: lock an independent joint of the loop: q2, q4, qm"),
        ("pin", "its variable follows from loop ring: lock an independent joint of the loop: q2, q4, qm"),
        ("rotor", "a coupled joint follows q1: lock that"),
        ("pin_end", "a fixed frame has no variable to lock"),
    ],
)
def test_joints_that_cannot_be_locked_are_named(joint: str, said: str) -> None:
    expected = f"arm.toml: scene, locked, {joint}: {said}"
    with pytest.raises(InputError) as caught:
        restrict(read(COUPLED), Scene(locked={joint: parse(0)}))
    assert str(caught.value) == expected
    with pytest.raises(InputError) as caught:
        read(f"{COUPLED}[scene]\nlocked = {{ {joint} = 0 }}")
    assert str(caught.value) == expected
