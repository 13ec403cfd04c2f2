"""The journey: its stages in the order of the figure of CONTRIBUTING.md, each stretch of it written once."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import MOST_WARNINGS, CodeOptions, generate, prepare, programs, render, verify
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from tests.golden import ROOT

TWO_R = ROOT / "examples" / "planar_2r.toml"
STAGES = ["read", "check", "group", "trace", "prune", "schedule", "render", "compile", "verify"]


def warned(line: str) -> None:
    pytest.fail(line)


def test_the_figure_shows_the_stages() -> None:
    figure = (ROOT / "examples" / "journey.svg").read_text(encoding="utf-8")
    assert re.findall(r'font-weight="bold"[^>]*>(\w+)<', figure) == STAGES
    assert f'aria-label="{", ".join(STAGES)}"' in figure
    assert f"![{', '.join(STAGES)}](examples/journey.svg)" in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


@pytest.mark.thorough
def test_verified_code_goes_through_all_stages_in_order() -> None:
    announced: list[str] = []
    machine = prepare(TWO_R, warned, base=True, announce=announced.append)
    assert verify(machine, Scene(), announce=announced.append).ok
    assert announced == STAGES


def test_files_of_code_are_written_after_render(tmp_path: Path) -> None:
    announced: list[str] = []
    machine = prepare(TWO_R, warned, announce=announced.append)
    generate(machine, Scene(), ("numpy",), tmp_path, CodeOptions(announce=announced.append))
    assert announced == ["read", "check", *STAGES[3:7], "write"]


def test_warnings_come_before_an_error_of_the_grouping(tmp_path: Path) -> None:
    """One line each, also those of the grouping."""
    doubtful = tmp_path / "arm.toml"
    lines_of_file = TWO_R.read_text(encoding="utf-8").splitlines(keepends=True)
    doubtful.write_text("".join(x for x in lines_of_file if not x.startswith("gravity")), encoding="utf-8")
    lines: list[str] = []
    prepare(doubtful, lines.append, base=True)
    assert len(lines) == 1 and "no gravity is given" in lines[0]


def test_stages_give_what_traced_gives() -> None:
    machine = prepare(TWO_R, warned)
    scene = Scene(models=("direct_dynamics", "energy"), fold="all", gravity=False)
    stages, whole = programs(machine, scene), trace_models(machine, scene)
    assert [one.program.count for one in stages.models] == [one.program.count for one in whole.models]
    assert stages.folded == whole.folded and stages.machine == whole.machine
    assert stages.package.scene == "without gravity"


@pytest.mark.thorough
def test_a_machine_is_restricted_traced_and_packaged_in_one_place() -> None:
    """Only `packaging` has `package`; only it and the pipeline import the tracing of a scene."""
    importers: dict[str, set[str]] = {"package": set(), "trace_scene": set()}
    for path in (ROOT / "symoro_elastic").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                for name in {alias.name for alias in node.names} & set(importers):
                    importers[name].add(path.stem)
    assert importers == {"package": set(), "trace_scene": {"packaging", "pipeline"}}


def test_a_degenerate_machine_is_refused_before_it_is_traced() -> None:
    machine = prepare(ROOT / "examples" / "two_axis_printed.par", lambda line: None)
    announced: list[str] = []
    with pytest.raises(InputError, match="joint"):
        programs(machine, Scene(), announced.append)
    assert announced == []


def test_products_out_of_range_are_refused_before_any_file_is_written() -> None:
    """Of a machine built in Python: files with such numbers are refused as they are read."""
    text = TWO_R.read_text(encoding="utf-8").replace('d = "l1"', "d = 1e200").replace('mass = "m2"', "mass = 1e200")
    asked = programs(toml.read(text, "huge.toml"), Scene())
    with pytest.raises(InputError, match="numbers of the table: their products are out of the range of double"):
        render(asked.package, ["c"], "huge.toml")


def test_many_warnings_are_counted(tmp_path: Path) -> None:
    """A chain of motors about one axis has a warning for each but the first."""
    motors = 30
    rows = [f'{{ name = "j{k}", kind = "motor", sigma = 0, theta = "q{k}" }},' for k in range(motors)]
    (tmp_path / "chain.toml").write_text("\n".join(["joints = [", *rows, "]"]))
    found: list[str] = []
    prepare(tmp_path / "chain.toml", found.append)
    assert len(found) == MOST_WARNINGS + 1 and found[-1] == f"{motors - 1 - MOST_WARNINGS} more like these"
