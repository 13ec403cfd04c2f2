"""Commands whose operations on files fail, one after another: `tests/faults.py` does that and says what is wrong."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.faults import COMMANDS

ROOT = Path(__file__).parents[2]
QUICK = [("generate over older", "--every", "19", "--fault", "SIGKILL"), ("convert --force", "--every", "9")]
"""A process that imports all that commands need, and then copies of it: the first copy is the expensive one."""


@pytest.mark.sampled(12)
@pytest.mark.parametrize(
    "given",
    [*QUICK, *(pytest.param((name, "--every", "4"), marks=pytest.mark.thorough) for name in COMMANDS)],
    ids=" ".join,
)
def test_commands_leave_old_or_new_files_whatever_fails(given: tuple[str, ...]) -> None:
    """Old ones whole or new ones whole; after a kill a mixture that is detected, and that the next run replaces."""
    command = [sys.executable, "-m", "tests.faults", *given]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{given[0]}: " in done.stdout.splitlines()[-1]
