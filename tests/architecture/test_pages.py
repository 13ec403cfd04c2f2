"""Pages of the documentation: what they show is what is printed; the site is built without a warning."""

from __future__ import annotations

import re
import runpy
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from symoro_elastic.models.programs.catalogue import MODELS
from symoro_elastic.pages.models_page import models_page
from tests.documented_pages import Run, beside_examples, differences, output, runs, wrong_blocks
from tests.golden import ROOT

pytestmark = pytest.mark.sampled(5)

PAGES = (
    "index",
    "python",
    "guarantees",
    "drives",
    "machine_tool",
    "identification",
    "updating",
    "robots",
    "cpp",
    "cuda",
    "fmu",
    "sweeps",
    "batches",
    "simulation",
    "flexible",
)
NEEDED = {"python": ("matplotlib",), "robots": ("mujoco",), "fmu": ("fmpy",)}
ELSEWHERE = {
    "backends": "test_backends_page",
    "scenes": "test_scenes_page",
    "closed_chains": "test_closed_chains_page",
    "matlab": "test_matlab_page",
    "controllers": "test_controllers_page",
}
"""Pages with tests of their own."""


FETCHED = re.compile(r'<(?:script|img|iframe)[^>]+src="https?:[^"]*"|<link[^>]+stylesheet[^>]+https?:')


def text(page: str) -> str:
    return (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")


@pytest.mark.sampled(30)
@pytest.mark.parametrize("page", PAGES)
def test_commands_and_programs_print_what_is_shown(page: str, tmp_path: Path) -> None:
    pytest.importorskip("scipy")
    for package in NEEDED.get(page, ()):
        pytest.importorskip(package)
    if page == "cpp" and shutil.which("c++") is None:
        pytest.skip("no C++ compiler")
    with beside_examples(tmp_path):
        assert wrong_blocks(text(page)) == {}


def test_every_page_with_programs_is_run() -> None:
    pages = {path.stem for path in (ROOT / "docs").glob("*.md") if runs(path.read_text(encoding="utf-8"))}
    assert pages <= {*PAGES, *ELSEWHERE}
    assert all((Path(__file__).parent / f"{name}.py").is_file() for name in ELSEWHERE.values())


def test_the_page_of_models_has_every_model() -> None:
    page = models_page()
    assert all(f"### `{name}`" in page for name in MODELS)


def test_modules_whose_docstrings_pages_show_exist() -> None:
    named = [
        name for page in ROOT.glob("docs/*.md") for name in re.findall(r"^::: (\S+)", page.read_text(), re.MULTILINE)
    ]
    assert named
    assert [name for name in named if find_spec(name) is None] == []


@pytest.mark.thorough
def test_the_site_is_built_without_a_warning(tmp_path: Path) -> None:
    """Strictly: a link that leads nowhere is an error; no page asks another host for anything."""
    pytest.importorskip("zensical")
    command = [sys.executable, "-m", "docs.site", "--without-pictures", "--out", str(tmp_path / "site")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "No issues found" in done.stdout + done.stderr, done.stdout + done.stderr
    pages = [*(tmp_path / "site").rglob("*.html")]
    assert len(pages) > 60 and (tmp_path / "site" / "commands" / "modes.html").is_file()
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert not FETCHED.findall(text), page


def test_every_page_is_in_the_navigation() -> None:
    listed = {*re.findall(r'"([\w/]+\.md)"', (ROOT / "zensical.toml").read_text(encoding="utf-8"))}
    own = {path.name for path in (ROOT / "docs").glob("*.md")}
    tutorials = {f"tutorials/{path.stem}.md" for path in (ROOT / "docs" / "tutorials").glob("*.py")}
    assert listed == own | tutorials | {"models.md", "gallery.md"}


@pytest.mark.thorough
@pytest.mark.parametrize("name", [path.stem for path in sorted((ROOT / "docs" / "tutorials").glob("*.py"))])
def test_tutorials_run(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("matplotlib").use("agg")
    with beside_examples(tmp_path):
        runpy.run_path(str(ROOT / "docs" / "tutorials" / f"{name}.py"))


def test_the_program_of_the_readme_prints_what_it_shows(tmp_path: Path) -> None:
    pytest.importorskip("scipy")
    programs = [run for run in runs((ROOT / "README.md").read_text(encoding="utf-8")) if run.language == "python"]
    with beside_examples(tmp_path):
        assert [differences(run.shown, output(run)) for run in programs] == [[]]


@pytest.mark.thorough
def test_the_first_command_of_the_readme_prints_what_it_shows(tmp_path: Path) -> None:
    """Its two parts, run here; the set-up is what continuous integration does."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    command, shown = re.findall(r"^```sh\n(.*?)\n```\n\n```\n(.*?)^```$", readme, re.DOTALL | re.MULTILINE)[0]
    parts = [part.removeprefix(".venv/bin/") for part in command.split(" && ") if "symoro-elastic" in part]
    with beside_examples(tmp_path):
        printed = "".join(output(Run("sh", f"{part}\n", ""), {}) for part in parts)
    assert len(parts) == 2 and differences(shown, printed) == []
