"""A wheel built from this tree, installed elsewhere, does what the checkout does."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

from tests.generated_code import COMPILERS
from tests.golden import GENERATED, ROOT

pytest.importorskip("hatchling")
pytest.importorskip("build")
pytest.importorskip("pip")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built without network."""
    out = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(out), str(ROOT)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    (found,) = out.glob("*.whl")
    return found


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fresh environment that holds the wheel; what it depends on is borrowed from this one."""
    environment = tmp_path_factory.mktemp("environment")
    venv.create(environment, with_pip=False)
    python = environment / ("Scripts" if os.name == "nt" else "bin") / "python"
    command = [sys.executable, "-m", "pip", "--python", str(python), "install", "-q", "--no-deps", "--no-index"]
    subprocess.run([*command, "--disable-pip-version-check", str(wheel)], check=True)
    site = next(environment.rglob("symoro_elastic/__init__.py")).parents[1]
    borrowed = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}
    (site / "borrowed.pth").write_text("\n".join(sorted(borrowed)) + "\n")
    return python


def tracked(folder: str) -> list[Path]:
    """Files of a folder, without what programs leave there."""
    return [path for path in (ROOT / folder).rglob("*.*") if "__pycache__" not in path.parts]


def outside(*command: object, folder: Path) -> subprocess.CompletedProcess[str]:
    variables = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    return subprocess.run(
        list(map(str, command)), capture_output=True, text=True, check=False, cwd=folder, env=variables
    )


@pytest.mark.thorough
def test_the_wheel_holds_code_templates_examples_and_nothing_else(wheel: Path) -> None:
    names = set(zipfile.ZipFile(wheel).namelist())
    code = {str(path.relative_to(ROOT)) for path in (ROOT / "symoro_elastic").rglob("*.py")}
    templates = {f"symoro_elastic/{path.relative_to(ROOT)}" for path in (ROOT / "templates").rglob("*.*")}
    assert code | templates <= names and len(templates) >= 5
    examples = {f"symoro_elastic/{path.relative_to(ROOT)}" for path in tracked("examples")}
    assert examples <= names and len(examples) > 20
    others = {name for name in names - code - templates - examples if ".dist-info/" not in name}
    assert others == {"symoro_elastic/py.typed"}
    licences = {name.partition("/licenses/")[2] for name in names if "/licenses/" in name}
    assert licences == {"LICENSE", "LICENSES/three.js.txt"}


@pytest.mark.thorough
def test_the_installed_package_generates_the_committed_files(installed: Path, tmp_path: Path) -> None:
    """From another folder, by the command and by `python -m`; the templates are those of the wheel."""
    shutil.copy(ROOT / "examples" / "planar_2r.toml", tmp_path)
    where = outside(installed, "-c", "import symoro_elastic; print(symoro_elastic.__file__)", folder=tmp_path)
    assert str(installed.parents[1]) in where.stdout
    site = Path(where.stdout.strip()).parents[1]
    (site / "templates" / "c").mkdir(parents=True, exist_ok=True)  # of some other package
    programs = [[installed.parent / "symoro-elastic"]]
    programs += [[installed, "-m", module] for module in ("symoro_elastic", "symoro_elastic.cli")]
    copied = outside(*programs[0], "new", "copy", "--example", "planar_2r", folder=tmp_path)
    assert (
        copied.returncode == 0 and (tmp_path / "copy.toml").read_bytes() == (tmp_path / "planar_2r.toml").read_bytes()
    )
    for k, command in enumerate(programs):
        run = outside(*command, "generate", "planar_2r.toml", "--out", f"out{k}", "--json", folder=tmp_path)
        assert run.returncode == 0 and run.stderr == "", run.stderr
        for path in map(Path, json.loads(run.stdout)["written"]):
            committed = GENERATED / path.relative_to(f"out{k}")
            assert (tmp_path / path).read_bytes() == committed.read_bytes(), path


@pytest.mark.thorough
@pytest.mark.skipif(not COMPILERS, reason="needs a C compiler")
def test_the_installed_package_checks_the_example(installed: Path, tmp_path: Path) -> None:
    shutil.copy(ROOT / "examples" / "planar_2r.toml", tmp_path)
    run = outside(installed, "-m", "symoro_elastic", "check", "planar_2r.toml", "--json", folder=tmp_path)
    assert run.returncode == 0 and json.loads(run.stdout)["ok"] is True, run.stderr


def test_missing_templates_are_reported_with_both_places(tmp_path: Path) -> None:
    """A package without templates names the places where it looked."""
    shutil.copytree(ROOT / "symoro_elastic", tmp_path / "symoro_elastic", ignore=shutil.ignore_patterns("__pycache__"))
    code = "from symoro_elastic.codegen.templates import template_folder; template_folder()"
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=tmp_path, env=environment
    )
    said = run.stderr.splitlines()[-1]
    assert str(tmp_path / "templates") in said and str(tmp_path / "symoro_elastic" / "templates") in said
