"""Commands and programs of docs/scenes.md, run from the first to the last, print what the page shows."""

from __future__ import annotations

import importlib
import re
import shutil
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.command_line import EXAMPLES
from tests.documented_pages import BELOW, BLOCK, differences, output, runs
from tests.golden import ROOT

PAGE = (ROOT / "docs" / "scenes.md").read_text(encoding="utf-8")
SCENE, REDUCED = (text for language, text in BLOCK.findall(PAGE) if language == "toml")
IN_REAL_TIME = sys.platform.startswith("linux") and shutil.which("cc")
pytestmark = pytest.mark.skipif(not IN_REAL_TIME, reason="the loop is for Linux and its compiler")

RUNS = runs(PAGE)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder beside the examples, as the page assumes."""
    (tmp_path / "examples").symlink_to(EXAMPLES)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_scene_is_that_of_the_examples() -> None:
    assert (EXAMPLES / "scenes" / "two_axis_move.toml").read_text(encoding="utf-8").endswith(SCENE)


@pytest.mark.thorough
def test_commands_print_what_the_page_shows(folder: Path) -> None:
    """Numbers to the last digit shown, texts but for times; the scene that `ladder` writes, the labels of the plot."""
    assert len(RUNS) >= 6
    found = {run.text: differences(run.shown, output(run)) for run in RUNS}
    assert {text: wrong for text, wrong in found.items() if wrong} == {}
    written, shown = (tomllib.loads(x) for x in ((folder / "reduced.toml").read_text(encoding="utf-8"), REDUCED))
    assert written.pop("scene")["steps"] == shown["scene"]["steps"]
    static = tomllib.loads((folder / "reduced.toml").read_text(encoding="utf-8"))["scene"]["static"]
    assert static == pytest.approx(shown.pop("scene")["static"], abs=float(BELOW))
    assert written == shown
    for drawn, kept in (("plots/rungs.svg", "scenes_rungs.svg"), ("light/budget.svg", "scenes_budget.svg")):
        assert labels(folder / drawn) == labels(ROOT / "docs" / kept)


def test_a_budget_saves_a_tenth_of_the_operations() -> None:
    """Of those with springs alone left out, and the errors that are measured stay within the tolerance."""
    saved = [int(x) for x in re.findall(r"(\d+)% fewer operations than with springs alone", PAGE)]
    assert min(saved) >= 10 and max(map(float, re.findall(r"([\d.]+)% +measured", PAGE))) <= 100


def labels(plot: Path) -> list[str]:
    return re.findall("<!-- .* -->", plot.read_text(encoding="utf-8"))


def test_the_loop_ends_where_numpy_does(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the nanometre that it prints; the same steps, the same numbers of its first lines."""
    (folder / "reduced.toml").write_text(REDUCED, encoding="utf-8")
    *_, generate, _check, _start, build, loop = RUNS
    for run in (generate, build):
        output(run)
    printed = output(loop).splitlines()[-1]
    monkeypatch.syspath_prepend(folder / "generated")
    monkeypatch.delitem(sys.modules, "two_axis", raising=False)
    two_axis = importlib.import_module("two_axis")
    monkeypatch.delitem(sys.modules, "two_axis")
    q, qd, h = np.array(array("start")), np.zeros(6), 1e-3
    hold, kp, kd = (np.array(array(name)) for name in ("hold", "kp", "kd"))
    for k in range(250):
        r, rd = wanted(np.array([k * h, (k + 1) * h]))
        q, qd = two_axis.step_w2_servo(np.tile(hold, (2, 1)), r, rd, kp, kd, h, q, qd)
    r, rd = (x[0] for x in wanted(np.array([250 * h])))
    motors = list(two_axis.MOTORS)
    qdd = two_axis.direct_dynamics(q, qd, hold + kp * (r - q[motors]) + kd * (rd - qd[motors]))
    T = two_axis.geometric_model_with_deflections(q, two_axis.static_deflections(q, qd, qdd))
    expected = [*q[motors], *T[two_axis.FRAMES.index("tool"), :3, 3]]
    assert [float(x) for x in re.findall(r"-?\d+\.\d{9}", printed)] == pytest.approx(expected, abs=0.6e-9)


def array(name: str) -> list[float]:
    """The numbers of an array in the loop's source."""
    source = (EXAMPLES / "realtime_two_axis.c").read_text(encoding="utf-8")
    found = re.search(rf"double {name}\[\w+\] = {{(.*?)}}", source)
    assert found
    return [float(x) for x in found[1].split(",")]


def wanted(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities of the motors, (N, 2)."""
    x = np.minimum(t / 0.15, 1.0)[:, None]
    by = np.array([0.08, 0.05])
    course = np.polynomial.Polynomial([0, 0, 0, 0, 35, -84, 70, -20])
    return np.array([0.0, 0.1]) + by * course(x), by * course.deriv()(x) / 0.15
