"""The oldest packages that pyproject.toml promises to work with, as constraints of pip, and the core of the tests.

`python -m tests.lowest --write` writes tests/lowest.txt anew; `python -m tests.lowest --run` runs the core in the
environment of this Python, in which they were installed:

    python3 -m venv .venv-lowest
    .venv-lowest/bin/pip install -c tests/lowest.txt -e '.[all]' pytest pytest-xdist hypothesis jsonschema
    .venv-lowest/bin/python -m tests.lowest --run

There are wheels of all of them for Python 3.11. For later ones `uv pip compile --resolution lowest-direct
--only-binary :all:` finds the oldest that have wheels.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
CONSTRAINTS = ROOT / "tests" / "lowest.txt"
HEAD = "# The lower bounds of pyproject.toml, for pip install -c: python -m tests.lowest --write\n"
REQUIREMENT = re.compile(r"(?P<name>[A-Za-z0-9._-]+)(?:\[[^]]*\])?\s*>=\s*(?P<bound>[0-9.]+)")
CORE = (
    "tests/api/test_arguments.py",
    "tests/api/test_session.py",
    "tests/api/test_pickling.py",
    "tests/analysis/vibration/test_responses.py",
    "tests/analysis/vibration/test_modes.py",
    "tests/analysis/sweeps/test_sweep.py",
    "tests/analysis/time_series",
    "tests/analysis/poses",
    "tests/analysis/ladder/test_torque_tolerances.py",
    "tests/measured/vibration_tests",
    "tests/cli/test_vibration_commands.py",
    "tests/cli/test_formats_commands.py",
    "tests/codegen/backends/test_casadi.py",
    "tests/foundation",
    "tests/formats/robots/test_mjcf.py",
    "tests/numerics/test_accuracy.py",
)
"""Tests that call every dependency and every extra."""


def project() -> dict[str, object]:
    """The table [project] of pyproject.toml."""
    found: dict[str, object] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return found


def requirements(*extras: str) -> list[str]:
    """What the package and some extras need, through extras that name others."""
    table = project()
    by_extra: dict[str, list[str]] = table["optional-dependencies"]  # type: ignore[assignment]
    needed: list[str] = [*table["dependencies"]] if not extras else []  # type: ignore[misc]
    for one in (line for extra in extras for line in by_extra[extra]):
        named = re.fullmatch(r"symoro-elastic\[(.*)\]", one)
        needed += requirements(*named[1].split(",")) if named else [one]
    return needed


def bounds() -> Iterator[str]:
    """The lower bound of each package that users install, as a constraint."""
    for one in dict.fromkeys([*requirements(), *requirements("all")]):
        found = REQUIREMENT.fullmatch(one)
        if found is None:
            raise SystemExit(f"pyproject.toml: {one!r} has no lower bound alone")
        yield f"{found['name']}=={found['bound']}"


def text() -> str:
    """The text of tests/lowest.txt."""
    return HEAD + "".join(f"{line}\n" for line in sorted(bounds()))


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        CONSTRAINTS.write_text(text(), encoding="utf-8")
    elif sys.argv[1:] == ["--run"]:
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *CORE]
        raise SystemExit(subprocess.run(command, cwd=ROOT, check=False).returncode)
    else:
        raise SystemExit(__doc__)
