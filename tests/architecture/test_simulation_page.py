"""Programs and figures of docs/simulation.md are those of the two-axis machine."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

from symoro_elastic.codegen.integration.tableaus import METHODS
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.machine import Machine, Orientation
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import Traced, trace_models
from symoro_elastic.quantities.time_steps import TimeStep
from tests.golden import ROOT

PAGE = (ROOT / "docs" / "simulation.md").read_text(encoding="utf-8")


def snippets(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


def machine() -> Machine:
    return read_machine(ROOT / "examples" / "two_axis.toml")[0]


@cache
def asked() -> Traced:
    return trace_models(machine(), Scene(models=("direct_dynamics",), steps=("w2", "w3", "rk4")))


@cache
def floating(turned: Orientation = Orientation.QUATERNION) -> Traced:
    found = read_machine(ROOT / "examples" / "floating_arm.toml")[0]
    assert found.floating is not None
    described = replace(found, floating=replace(found.floating, orientation=turned))
    return trace_models(described, Scene(models=("direct_dynamics",), steps=("w3",)))


def test_figures_on_a_floating_base() -> None:
    sizes = []
    for turned in Orientation:
        count = {one.model.name: one.program.count for one in floating(turned).models}
        size = {name: c.mul + c.div + c.add for name, c in count.items()}
        sizes.append(size["base_displacement"] + size["base_rates"])
    by_matrix, by_quaternion = sizes
    text = " ".join(PAGE.split())
    assert f"a stage needs {by_quaternion} for the pose and its rates by quaternion, {by_matrix} by matrix" in text


def test_figures() -> None:
    count = {one.model.name: one.program.count for one in asked().models}
    size = {name: c.mul + c.div + c.add for name, c in count.items()}
    right, factors, solve = (size[name] for name in ("direct_dynamics", "implicit_factors", "implicit_solve"))
    text = " ".join(PAGE.split())
    assert f"the models of a step of `rk4` need {4 * right} products" in text
    assert f"of `w2` {2 * (right + solve) + factors}, of `w3` and `midpoint` {4 * (right + solve) + factors}." in text


def test_every_method_is_listed_with_its_order() -> None:
    rows = re.findall(r"^\| `(\w+)` \|[^|]+\| (\d) \|", PAGE, re.MULTILINE)
    assert {name: int(order) for name, order in rows} == {name: METHODS[name].order for name in TimeStep}


def test_tables_are_read() -> None:
    scene, friction, springs = snippets("toml")
    text = (ROOT / "examples" / "two_axis.toml").read_text(encoding="utf-8")
    assert "[friction]" not in text and "[scene]" not in text
    found = toml.read(f"{text}\n{scene}\n{friction}", "two_axis.toml")
    assert found.asked.scene is not None and found.asked.scene.steps == ("w3",)
    assert not found.joint(2).friction.creep.is_zero or any(not row.friction.creep.is_zero for row in found.joints)
    machine = (ROOT / "examples" / "backlash.toml").read_text(encoding="utf-8")
    (backlash,) = toml.read(machine[: machine.index("[springs]")] + springs, "backlash.toml").with_backlash
    assert backlash == 2
