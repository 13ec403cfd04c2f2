"""Grouping where the rules are wrong: forged ones that group too much, too little, or with wrong coefficients."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.formats import read_machine, write_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine, Parameter
from symoro_elastic.machine.scene import Scene
from symoro_elastic.mechanics import base_parameters as rules
from symoro_elastic.mechanics.base_parameters import GroupingRule
from symoro_elastic.models.parameters.base_parameters import ZeroPosition
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.linear.grouping import NOTE, base_formulas, base_machine, checked_grouping
from tests.command_line import run
from tests.references.multiprecision import generalized_forces
from tests.references.random_machines import chain, random_machine, random_state, two_children

pytestmark = pytest.mark.sampled(6)

EXAMPLES = Path(__file__).parents[2] / "examples"
RX90 = EXAMPLES / "rx90.par"
TORQUES = 1e-12
REVOLUTE = rules._rules_revolute


def too_much(*arguments: Any) -> Iterator[GroupingRule]:
    """XZ has no effect."""
    yield from REVOLUTE(*arguments)
    yield GroupingRule({"XZ": 1})


def too_little(*arguments: Any) -> Iterator[GroupingRule]:
    """MZ stays."""
    return (rule for rule in REVOLUTE(*arguments) if rule.eliminated != "MZ")


def wrongly(*arguments: Any) -> Iterator[GroupingRule]:
    """YY is grouped with twice XX."""
    for rule in REVOLUTE(*arguments):
        yield replace(rule, combination={"YY": 1, "XX": 2}) if "XX" in rule.combination else rule


FORGED = {"XZ": too_much, "MZ": too_little, "XX": wrongly}


@pytest.fixture(params=FORGED)
def forged(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """One wrong rule; the parameter that it is wrong about."""
    monkeypatch.setattr(rules, "_rules_revolute", FORGED[request.param])
    return str(request.param)


MACHINES = [
    chain(5, symbolic=True),
    chain(4, prismatic=(2,)),
    two_children(symbolic=True),
    random_machine(3, joints=7, symbolic=True),
    random_machine(4, joints=6, symbolic=True, moving_base=True),
]


@pytest.mark.sampled(12)
@pytest.mark.parametrize("machine", MACHINES, ids=lambda machine: machine.name)
def test_torques_stay_where_a_rule_is_wrong(machine: Machine, forged: str) -> None:
    """Against an independent model of both machines, at 50 digits: only coefficients in double precision differ."""
    regrouped, warnings = base_machine(machine)
    assert len(warnings) == 1 and "QR" in warnings[0] and forged in warnings[0] and "\n" not in warnings[0]
    check(regrouped)
    assert regrouped.is_grouped
    values = parameter_values(machine)
    for seed in range(3):
        q, qd, _ = random_state(machine, seed)
        qdd = np.random.default_rng(seed).uniform(-5, 5, len(q)).tolist()
        before = generalized_forces(machine, q, qd, qdd, values)
        after = generalized_forces(regrouped, q, qd, qdd, parameter_values(regrouped))
        assert max(abs(x - y) for x, y in zip(before, after, strict=True)) < TORQUES * max(map(abs, before))


def test_the_geometry_is_constant_and_the_bodies_are_not(forged: str) -> None:
    machine = chain(5, symbolic=True)
    bodies = {name for joint in machine.joints for x in (joint.body.mass, *joint.body.inertia) for name in x.names}
    nameless = tuple(replace(p, value=None) if p.name in bodies else p for p in machine.parameters)
    regrouped, _ = base_machine(replace(machine, parameters=nameless))
    geometry = set(ZeroPosition(machine).geometry)
    assert geometry and not geometry & {p.name for p in regrouped.parameters}
    assert ZeroPosition(regrouped).geometry == []
    assert NOTE in regrouped.origin.notes
    assert "XXR4" in {p.name for p in regrouped.parameters if p.value is None}


@pytest.mark.thorough
def test_grouping_again_changes_no_cell(forged: str, tmp_path: Path) -> None:
    once, _ = base_machine(two_children(symbolic=True))
    path = tmp_path / "once.toml"
    write_machine(once, path)
    again, _ = base_machine(read_machine(path)[0])
    assert (again.joints, again.origin.notes) == (once.joints, once.origin.notes)


@pytest.mark.thorough
def test_scenes_follow_the_constants(forged: str) -> None:
    """Constants of the geometry leave `fold`, and stand in the values and points that named them."""
    machine = chain(3, symbolic=True)
    scene = Scene(
        models=("jacobian",),
        outputs={"jacobian": ("joint3 at (D2, 0, 2*D3)",)},
        locked={"joint1": Formula.parse("2*AL2")},
        fold=("D2", "FV1"),
    )
    machine = replace(machine, parameters=(*machine.parameters, Parameter("FV1", Formula.parse(1))))
    machine = DescribedMachine.of(machine).asking(scene=scene)
    d2, d3, turn = (str(p.value) for name in ("D2", "D3", "AL2") for p in machine.parameters if p.name == name)
    kept = base_machine(machine)[0].asked.scene
    assert kept is not None
    assert kept.fold == ("FV1",)
    assert kept.outputs == {"jacobian": (f"joint3 at ({d2}, 0, 2*({d3}))",)}
    assert kept.locked == {"joint1": Formula.parse(f"2*({turn})")}


def test_missing_values_are_named(forged: str) -> None:
    machine, _ = read_machine(RX90)
    with pytest.raises(InputError, match=r"rx90.par: --base: .* one geometry only: give values to D3, RL4, G3$"):
        base_machine(machine)
    grouping, found = checked_grouping(machine)
    assert found.refused and base_formulas(grouping, found) == {}


def test_rules_that_agree_are_silent() -> None:
    machine = chain(4, symbolic=True)
    regrouped, warnings = base_machine(machine)
    assert warnings == () and NOTE not in regrouped.origin.notes
    assert {"D2", "AL2"} <= {p.name for p in regrouped.parameters}


def nearly_parallel(angle: str) -> Machine:
    """Two revolute joints with an angle between them that numbers hardly see."""
    machine = chain(2)
    return replace(machine, joints=(machine.joints[0], replace(machine.joints[1], alpha=Formula.parse(angle))))


def test_where_numbers_see_less_than_the_rules_torques_decide() -> None:
    """At 1e-10 rad QR would change torques, and the rules do not; at 1e-15 rad nobody can tell."""
    kept, warnings = base_machine(nearly_parallel("1e-10"))
    assert "the QR grouping changes torques by" in warnings[0] and "the grouping by the rules is used" in warnings[0]
    fewer, warnings = base_machine(nearly_parallel("1e-15"))
    assert "the QR grouping is used" in warnings[0]
    assert [j.body for j in fewer.joints] != [j.body for j in kept.joints]


@pytest.mark.thorough
def test_commands_follow(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """show, convert, generate and check: the warning on stderr, and code that is right."""
    monkeypatch.setattr(rules, "_rules_revolute", too_little)
    machine = tmp_path / "machine.toml"
    write_machine(two_children(symbolic=True), machine)
    shown = json.loads(run("show", machine, "--json").stdout)
    assert "QR" in shown["base_parameters_check"]
    assert len(shown["base_parameters"]) <= 30 and np.isfinite(shown["base_parameters_condition"])
    written = run("convert", machine, tmp_path / "base.toml", "--base")
    assert "warning: " in written.stderr and "the QR grouping is used" in written.stderr
    base, _ = read_machine(tmp_path / "base.toml")
    assert base.is_grouped and not {"D2", "D3"} & {p.name for p in base.parameters}
    made = run("generate", machine, "--base", "--target", "numpy", "--out", tmp_path / "out")
    assert made.exit_code == 0 and "the QR grouping is used" in made.stderr
    checked = run("check", machine, "--base", "--model", "inverse_dynamics")
    assert checked.exit_code == 0 and "the QR grouping is used" in checked.stderr


@pytest.mark.thorough
def test_sums_that_are_too_long_are_refused_in_one_line(tmp_path: Path) -> None:
    """The square of a long sum, times another."""
    names = [f"x{k}" for k in range(30)]
    total = "+".join(names)
    text = f"""
joints = [
  {{ name = "a", kind = "motor", sigma = 0, theta = "q1" }},
  {{ name = "b", kind = "motor", sigma = 0, theta = "q2", d = "{total}", alpha = "pi/2" }},
]
bodies = {{ a = {{ mass = 1 }}, b = {{ mass = "{total}" }} }}
parameters = {{ {", ".join(f"{name} = nan" for name in names)} }}
"""
    (tmp_path / "sums.toml").write_text(text)
    machine, _ = read_machine(tmp_path / "sums.toml")
    with pytest.raises(InputError, match="base inertial parameters: their sums are too long") as error:
        base_machine(machine)
    assert "\n" not in str(error.value)
