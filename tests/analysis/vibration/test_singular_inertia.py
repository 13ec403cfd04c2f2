"""Motions without inertia: refused in one line that names the joints and the way out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.analysis.vibration.linearization import Linearization
from symoro_elastic.analysis.vibration.modes import damped_poles, modes
from symoro_elastic.analysis.vibration.responses import frequency_grid, frequency_response
from symoro_elastic.analysis.vibration.tracking import over_grid
from symoro_elastic.analysis.vibration.zeros import poles_and_zeros
from symoro_elastic.formats import write_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.equilibrium import given_state
from symoro_elastic.numerics.motion.inertia import massless_rows, rows_to_remove
from tests.analysis.vibration.machines import ZERO, drive, linearized, machine_of, slide, spring
from tests.command_line import refused, run
from tests.compiled_models import cell

pytestmark = pytest.mark.sampled(4)

BOTH = "singular here: nothing has inertia in a motion of motor and load; give motor an inertia or --hold motor"
YAW = "singular here: nothing has inertia in a motion of yaw; give yaw an inertia or --hold yaw"


def on_the_axis() -> Machine:
    """A point mass that hangs on the axis of a yaw motor while a second motor is at 0."""
    yaw = Joint("yaw", 0, Kind.MOTOR, 0, "q_yaw")
    pitch = Joint("pitch", 1, Kind.MOTOR, 0, "q_pitch", alpha=cell("pi/2"))
    bend = slide("bend", 2, Kind.ELASTIC, 1, alpha=cell("pi/2"), theta=ZERO, r=cell(1), spring=spring(100))
    return machine_of("sing", yaw, pitch, bend)


ASKED: dict[str, Callable[[Linearization], Any]] = {
    "space": lambda linear: linear.space,
    "modes": modes,
    "poles": damped_poles,
    "grid": frequency_grid,
    "response": lambda linear: frequency_response(linear, np.array([1.0])),
    "zeros": lambda linear: poles_and_zeros(linear, "motor.tau", "motor.q"),
}


@pytest.mark.parametrize("asked", ASKED)
def test_a_motor_without_inertia_is_named(asked: str) -> None:
    linear = linearized(drive(m1=0.0), None, ["motor"], ["motor"])
    with pytest.raises(InputError) as refusal:
        ASKED[asked](linear)
    assert str(refusal.value) == f"drive.toml: inertia matrix: {BOTH}"
    assert modes(linearized(drive(m1=0.0), held=["motor"])).frequencies == pytest.approx(np.sqrt(2e4 / 5) / 2 / np.pi)


def test_a_given_state_without_inertia() -> None:
    with pytest.raises(InputError, match=r"in a motion of motor and load; give motor an inertia$"):
        given_state(EquationsOfMotion(drive(m1=0.0)))


def test_a_negative_inertia_is_named() -> None:
    with pytest.raises(InputError, match="not positive here: the inertia is negative in a motion of motor and load"):
        modes(linearized(drive(m1=-3.0, m2=5.0)))


@pytest.mark.parametrize("ratio", [1e-9, 1e-12])
def test_a_small_inertia_is_one(ratio: float) -> None:
    found = modes(linearized(drive(ratio * 5, 5.0)))
    wanted = np.sqrt(2e4 / 5 * (1 + 1 / ratio)) / (2 * np.pi)
    np.testing.assert_allclose(found.frequencies[1], wanted, rtol=1e-3)


def test_the_fewest_joints_that_mend_it() -> None:
    """Three rows in one direction, a fourth without any inertia; rows that are preferred come first."""
    M = np.array([[1.0, 1, 1, 0], [1, 1, 1, 0], [1, 1, 2, 0], [0, 0, 0, 0]])
    rows, least = massless_rows(M)
    assert rows == [0, 1, 3] and abs(least) < 1e-15
    assert rows_to_remove(M, ()) == [0, 3] and rows_to_remove(M, (1,)) == [1, 3] and rows_to_remove(M, (3,)) == [3, 0]
    assert massless_rows(np.eye(3))[0] == [] == rows_to_remove(np.zeros((0, 0)), ())


def test_positions_of_a_grid_are_named() -> None:
    with pytest.raises(InputError) as refusal:
        over_grid(EquationsOfMotion(on_the_axis()), {"pitch": [-1.0, 0.0, 1.0]})
    assert str(refusal.value) == f"sing.toml: inertia matrix at pitch = 0: {YAW}"
    held = over_grid(EquationsOfMotion(on_the_axis()), {"pitch": [-1.0, 0.0, 1.0]}, held=["yaw"])
    assert held.frequencies.shape == (3, 2)


@pytest.mark.parametrize("command", ["linearize", "modes", "response"])
def test_nothing_is_printed_or_written(command: str, tmp_path: Path) -> None:
    write_machine(replace(on_the_axis(), source=""), tmp_path / "sing.toml")
    line = refused(command, tmp_path / "sing.toml", "--out", tmp_path / "out.npz")
    assert line.endswith(YAW) and [path.name for path in tmp_path.iterdir()] == ["sing.toml"]
    assert "bend" in run("linearize", tmp_path / "sing.toml", "--hold", "yaw").stdout


def test_joints_of_a_grid_are_named_once() -> None:
    assert "--along: motor_y is given twice: keep one" in refused(
        "modes",
        Path(__file__).parents[3] / "examples" / "two_axis.toml",
        "--along",
        "motor_y=0:1:3",
        "--along",
        "motor_y=0:1:2",
    )
    with pytest.raises(InputError, match="--along: pitch and q_pitch are the same joint"):
        over_grid(EquationsOfMotion(on_the_axis()), {"pitch": [0.1], "q_pitch": [0.2]})


@pytest.mark.parametrize(
    ("damping", "said"),
    [
        (2, " or write condense = true in [scene], which makes these springs in series one"),
        (
            1,
            " (condense = true cannot make these springs in series one: damping over stiffness is not the same at"
            " first and at last)",
        ),
    ],
)
def test_springs_in_series_are_to_be_condensed(damping: int, said: str) -> None:
    """Or the message says why they cannot be."""
    motor = slide("motor", 0, Kind.MOTOR, 1)
    first = slide("first", 1, Kind.ELASTIC, 0, spring=spring(100, 1))
    last = slide("last", 2, Kind.ELASTIC, 3, spring=spring(200, damping))
    with pytest.raises(InputError) as refusal:
        modes(linearized(machine_of("series", motor, first, last)))
    assert str(refusal.value).endswith(f"in a motion of first and last; give first an inertia{said}")
