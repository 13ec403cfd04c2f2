"""Starts of loops that give some joints: the rest is found, and said; where several are possible one more is asked."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.checks.loop_descriptions import described_loops
from symoro_elastic.models.loops.plan import plan_of
from tests.command_line import run
from tests.formats.robots.test_mjcf import OURS

WHOLE = "q1 = 1.0, q2 = -0.6, q3 = 1.6"


def started(start: str) -> Machine:
    machine = toml.read(OURS.replace(WHOLE, start), "m.toml")
    check(machine)
    return machine


def position(machine: Machine) -> dict[str, Any]:
    return {str(machine.joint(j).variable): x for j, x in plan_of(machine).positions[0].items()}


@pytest.mark.parametrize(("given", "found"), [("q1 = 1.0, q2 = -0.6", ["q3"]), ("q1 = 1.0, q3 = 1.4", ["q2"])])
def test_what_a_start_leaves_out_is_found(given: str, found: list[str]) -> None:
    """The independent joint and one more tell the branch: the position is that of the whole start."""
    machine = started(given)
    assert position(machine) == pytest.approx(position(started(WHOLE)), abs=1e-9)
    (loop,) = described_loops(machine)
    assert list(loop.found) == found and not described_loops(started(WHOLE))[0].found


def test_independent_joints_that_are_left_out_are_moved_where_loops_do_not_close_with_them_at_zero() -> None:
    """Given are the rod and the rocker; the crank is where it closes the loop."""
    machine = started("q2 = -0.6, q3 = 1.6")
    found = position(machine)
    assert found["q2"] == pytest.approx(-0.6, abs=0.2) and found["q3"] == pytest.approx(1.6, abs=0.2)
    at = [0.15 * np.exp(1j * found["q1"]) + 0.45 * np.exp(1j * (found["q1"] + found["q2"]))]
    assert at[0] == pytest.approx(0.5 + 0.3 * np.exp(1j * found["q3"]), abs=1e-9)


def test_two_positions_are_refused_by_the_joint_that_tells_them_apart() -> None:
    with pytest.raises(InputError) as error:
        plan_of(started("q1 = 1.0"))
    what = "the loops close in 2 positions (q2 = "
    assert str(error.value).startswith(f"m.toml: loop bars, start: {what}")
    assert str(error.value).endswith(": give q2 there")


@pytest.mark.thorough
def test_show_says_what_was_found(tmp_path: Path) -> None:
    file = tmp_path / "m.toml"
    file.write_text(OURS.replace(WHOLE, "q1 = 1.0, q2 = -0.6"))
    ran = run("show", file)
    assert "  found, as start does not give them: q3 = " in ran.stdout
    import json

    loop = json.loads(run("show", file, "--json").stdout)["loops"]["bars"]
    assert list(loop["found"]) == ["q3"]
