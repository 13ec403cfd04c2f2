"""Static stiffness and worst peak of a frame under a force on it, and the springs that limit them."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from tests.golden import ROOT

pytest.importorskip("scipy")
K, C, M = (4e4, 1e4), (20.0, 10.0), (2.0, 1.0)


def masses() -> dict[str, Any]:
    """A motor, and two masses on springs in a row behind it."""
    axis = {"sigma": 1, "alpha": "0"}
    return {
        "name": "masses",
        "joints": [
            {"name": "motor", "kind": "motor", "r": "q1", **axis},
            {"name": "first", "antecedent": "motor", "kind": "elastic", "r": "q2", **axis},
            {"name": "second", "antecedent": "first", "kind": "elastic", "r": "q3", **axis},
        ],
        "bodies": {"motor": {"mass": 5.0}, "first": {"mass": M[0]}, "second": {"mass": M[1]}},
        "springs": {"first": {"stiffness": K[0], "damping": C[0]}, "second": {"stiffness": K[1], "damping": C[1]}},
    }


def response(**more: Any) -> Any:
    return se.response(masses(), inputs=["second.fz"], outputs=["second.z", "second.vz"], **more)


def test_springs_in_a_row() -> None:
    """Compliances add up, and so do energies F^2 / 2 k; the peak is that of the matrices on a fine grid."""
    found = response(hold=["all"])
    (one,) = found.stiffnesses
    assert one.output == "second.z" and one.stiffness_unit == "N/um"
    assert one.static == pytest.approx(1 / K[0] + 1 / K[1], rel=1e-12)
    assert one.held_by == pytest.approx({"second": 0.8, "first": 0.2}, rel=1e-9)
    assert next(iter(one.held_by)) == "second"
    stiff, damp = (np.array([[x[0] + x[1], -x[1]], [-x[1], x[1]]]) for x in (K, C))
    f = np.linspace(0.98, 1.02, 4001) * one.frequency
    s = 2j * np.pi * f[:, None, None]
    u = np.linalg.solve(stiff + s * damp + s * s * np.diag(M), np.array([[0.0], [1.0]], dtype=complex))[..., 0]
    k = np.abs(u[:, 1]).argmax()
    assert one.peak == pytest.approx(np.abs(u[k, 1]), rel=1e-6) and f[k] == pytest.approx(one.frequency, rel=1e-4)
    x = (u[k] / u[k, 1]).real
    energies = np.array(K) * np.array([x[0], x[1] - x[0]]) ** 2
    assert one.shaken_by["second"] == pytest.approx(energies[1] / energies.sum(), rel=1e-3)
    assert "second.z under second.fz: 0.008 N/um at rest, limited by second (80%" in "\n".join(map(str, found.parts()))
    assert found.as_json()["stiffnesses"][0]["held_by"]["first"] == pytest.approx(0.2)


def test_a_free_motor_holds_nothing_and_an_undamped_peak_has_no_height() -> None:
    (free,) = response().stiffnesses
    assert np.isnan(free.static) and not free.held_by and "at rest" not in free.sentence
    undamped = masses()
    undamped["springs"] = {"first": {"stiffness": K[0]}, "second": {"stiffness": K[1]}}
    found = se.response(undamped, inputs=["second.fz"], outputs=["second.z"], hold=["all"])
    (one,) = found.stiffnesses
    assert np.isinf(one.peak) and re.search(r"undamped resonance at .* Hz, limited by second", one.sentence)
    lowest = se.modes(undamped, hold=["all"]).frequencies[0]
    assert one.frequency == pytest.approx(lowest, rel=1e-6)
    assert found.plots().plot("stiffness_second_z").figure().axes[1].patches


def test_a_free_arm_is_held_by_nothing() -> None:
    arm = str(ROOT / "examples" / "floating_arm.toml")
    (one,) = se.response(arm, inputs=["elbow.fx"], outputs=["elbow.x"], hover=True).stiffnesses
    assert one.sentence == "elbow.x under elbow.fx: nothing holds it"


def test_other_directions_have_none() -> None:
    assert not se.response(masses(), inputs=["second.fz"], outputs=["first.z"], hold=["all"]).stiffnesses
