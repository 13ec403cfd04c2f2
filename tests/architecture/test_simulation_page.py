"""Programs and figures of docs/simulation.md are those of the two-axis machine."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.codegen.integration.methods import METHODS
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.machine import Machine, Orientation
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.traced import Traced, trace_models
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


@pytest.fixture
def generated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A folder `generated` with the machines of the page, to import from."""
    for package in (asked().package, floating().package):
        folder = tmp_path / "generated" / package.name
        folder.mkdir(parents=True)
        for name, text in render_numpy(package).items():
            (folder / name).write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    _forget(monkeypatch)
    yield
    _forget(monkeypatch)


def _forget(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] == "generated"]:
        monkeypatch.delitem(sys.modules, name)


def test_programs_run(generated: None) -> None:
    rows, motors, state = np.zeros((4, 2)), np.ones(2), np.zeros((3, 12))
    given = {**dict.fromkeys(("tau", "r", "rd", "y", "yd", "ydd"), rows), **dict.fromkeys(("kp", "kd"), motors)}
    given |= {"h": 1e-4, "q": state, "qd": state}
    fixed, on_base = snippets("python")
    exec(fixed, given)
    assert given["q"].shape == given["qd"].shape == (3, 12) and given["error"].shape == (3, 24)
    base = {"f0": np.zeros((4, 6)), "Q0": np.array([1.0, 0, 0, 0]), "P0": np.zeros(3), "V0": np.ones(6)}
    free = {"tau": rows, "h": 1e-4, "q": np.zeros((3, 2)), "qd": np.zeros((3, 2))} | base
    exec(on_base, free)
    assert [free[name].shape for name in ("q", "Q0", "P0", "V0")] == [(3, 2), (3, 4), (3, 3), (3, 6)]


def test_figures_on_a_floating_base() -> None:
    sizes = []
    for turned in Orientation:
        count = {one.model.name: one.program.count for one in floating(turned).models}
        size = {name: c.mul + c.div + c.add for name, c in count.items()}
        sizes.append(size["base_displacement"] + size["base_rates"])
    by_matrix, by_quaternion = sizes
    text = " ".join(PAGE.split())
    assert f"a stage takes {by_quaternion} for the pose and its rates by quaternion, {by_matrix} by matrix" in text


def test_figures() -> None:
    count = {one.model.name: one.program.count for one in asked().models}
    size = {name: c.mul + c.div + c.add for name, c in count.items()}
    right, factors, solve = (size[name] for name in ("direct_dynamics", "implicit_factors", "implicit_solve"))
    text = " ".join(PAGE.split())
    assert f"the models of a step of `rk4` take {4 * right} products" in text
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
