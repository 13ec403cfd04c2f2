"""Machines and programs of docs/closed_chains.md run as they stand."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.loops.plan import FORMS, Form
from symoro_elastic.models.packaging import trace_models
from tests.closed_chains.machines import machine
from tests.golden import ROOT

PAGE = (ROOT / "docs" / "closed_chains.md").read_text(encoding="utf-8")
MODELS = ("direct_dynamics", "dependent_coordinates", "coupling_matrix", "constraint_forces")


def snippets(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("program", snippets("python"))
def test_programs_run(program: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (bars,) = (toml.read(text, "four_bar.toml") for text in snippets("toml"))
    for described, models in ((bars, MODELS), (machine("ring"), ("direct_dynamics", "assemble"))):
        folder = tmp_path / "generated" / described.name
        folder.mkdir(parents=True)
        for name, text in render_numpy(trace_models(described, Scene(models)).package).items():
            (folder / name).write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    for name in [name for name in sys.modules if name.partition(".")[0] == "generated"]:
        monkeypatch.delitem(sys.modules, name)
    exec(program, {})
    for name in [name for name in sys.modules if name.partition(".")[0] == "generated"]:
        monkeypatch.delitem(sys.modules, name)


def test_there_are_programs() -> None:
    assert len(snippets("python")) == 2 and len(snippets("toml")) == 1


def test_every_form_of_a_loop_is_listed() -> None:
    table = PAGE.split("| form | loop |")[1].split("\n\n")[0]
    assert re.findall(r"^\| ([^|]+) \|", table, re.MULTILINE) == [form.value for form in Form]
    assert set(FORMS.values()) < set(Form)


@pytest.mark.parametrize("name", re.findall(r"`(?:examples/)?(\w+\.(?:toml|par))`", PAGE))
def test_machines_that_are_named_are_read(name: str) -> None:
    found, warnings = read_machine(ROOT / "examples" / name)
    assert found.is_coupled and warnings == []
