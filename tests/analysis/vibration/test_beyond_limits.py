"""Motions that leave the limits of joints are said by joint, quantity and time; others are not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("scipy")

import symoro_elastic as se
from symoro_elastic.analysis.vibration.beyond_limits import beyond_limits
from symoro_elastic.formats.toml import reading as toml
from tests.generated_code import COMPILERS

AXIS: dict[str, Any] = {
    "name": "axis",
    "joints": [
        {"name": "drive", "antecedent": 0, "kind": "motor", "sigma": 1, "r": "x"},
        {"name": "load", "antecedent": "drive", "kind": "elastic", "sigma": 1, "r": "y"},
    ],
    "bodies": {"drive": {"mass": 10.0}, "load": {"mass": 2.0}},
    "springs": {"load": {"stiffness": 8e4, "damping": 40.0}},
}
MOVE = {"motion": {"duration": 0.4, "moves": [{"motor": "drive", "by": 0.1, "in": 0.4}]}}
PEAK = 2.1875 * 0.1 / 0.4
"""Largest velocity of the move, m/s: of 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7 at the middle, 35/16 times stroke by time."""


def test_the_first_time_and_the_farthest_value_are_found() -> None:
    machine = se.read({**AXIS, "limits": {"drive": {"position": [-0.2, 0.5], "velocity": 1}, "load": {"position": 1}}})
    t = np.linspace(0.0, 10.0, 1001)
    motion = {"position": {"drive": -0.8 * np.sin(t), "load": np.sin(t)}, "velocity": {"drive": -0.8 * np.cos(t)}}
    (found,) = beyond_limits(machine, t, motion)
    assert (found.joint, found.quantity, found.unit) == ("drive", "position", "m")
    assert np.sin(found.t - 0.01) <= 0.25 < np.sin(found.t)
    assert found.value == pytest.approx(-0.8, abs=1e-4)
    said = f"drive leaves its limits: position up to -0.8 m, -0.2 to 0.5 m, first at {found.t:.4g} s"
    assert str(found) == said


def test_ends_belong_to_ranges_but_for_rounding() -> None:
    machine = se.read({**AXIS, "limits": {"drive": {"velocity": [-3, 0.1 + 0.2]}}})
    for x, count in ((0.3, 0), (0.3 * (1 + 1e-12), 0), (0.3 * (1 + 1e-6), 1), (-3.0, 0), (-3.0001, 1), (np.nan, 0)):
        found = beyond_limits(machine, np.zeros(1), {"velocity": {"drive": np.array([x])}})
        assert len(found) == count


@pytest.mark.thorough
@pytest.mark.parametrize(("share", "count"), [(1.001, 0), (0.999, 1)])
def test_compare_says_so(share: float, count: int) -> None:
    machine = se.read({**AXIS, "limits": {"drive": {"velocity": share * PEAK}}})
    found = se.compare(machine, stroke=0.1, duration=0.4)
    said = [note for note in found.notes if note.startswith("drive leaves its limits: velocity up to 0.5469 m/s")]
    assert len(said) == count and len(found.beyond) == count


@pytest.mark.thorough
@pytest.mark.skipif(not COMPILERS, reason="needs a C compiler")
def test_simulate_says_so_of_motions_torques_and_springs() -> None:
    """Of a motor that follows exactly: velocity, and the torque that the mass of both bodies takes."""
    free = se.simulate({**AXIS, **MOVE}, step=1e-4)[0]
    torque, spring = float(np.abs(free.motion.tau).max()), float(np.abs(free.motion.q[:, 1]).max())
    assert free.beyond == ()
    for share in (0.99, 1.01):
        limits = {"drive": {"velocity": share * PEAK, "torque": share * torque}, "load": {"position": share * spring}}
        found = se.simulate({**AXIS, **MOVE, "limits": limits}, step=1e-4)[0]
        left = [(one.joint, one.quantity) for one in found.beyond]
        assert left == ([("drive", "velocity"), ("drive", "torque"), ("load", "position")] if share < 1 else [])
        lines = [part for part in found.parts() if isinstance(part, str) and "leaves its limits" in part]
        assert lines == [*map(str, found.beyond)]
        assert [one["quantity"] for one in found.as_json()["beyond_limits"]] == [quantity for _, quantity in left]


def test_machines_without_limits_say_nothing() -> None:
    machine = toml.read('name = "m"\njoints = [ { name = "a", kind = "motor", sigma = 1, r = "q1" } ]\n', "m.toml")
    assert beyond_limits(machine, np.zeros(1), {"position": {"a": np.array([1e9])}}) == ()
