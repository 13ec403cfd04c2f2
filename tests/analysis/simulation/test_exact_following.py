"""Machines whose motors all follow exactly: torques, powers and energies of the motion, without integration."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.time_series.measurements import named_columns
from tests.closed_chains.machines import FILES
from tests.command_line import EXAMPLES, ended, refused, run

pytest.importorskip("scipy")

ARM = EXAMPLES / "planar_2r.toml"
JOINTS = ("shoulder", "elbow")
MOTION = {
    "duration": 1.0,
    "moves": [{"motor": "shoulder", "by": 0.5, "in": 0.8}, {"motor": "elbow", "by": -0.3, "in": 0.6}],
}


@pytest.mark.thorough
def test_torques_are_those_of_the_inverse_model() -> None:
    (found,) = se.simulate(ARM, {"motion": MOTION})
    model, motion = se.load(ARM, "inverse_dynamics"), found.motion
    for k in range(0, len(motion.t), 50):
        tau = model.inverse_dynamics(motion.q[k], motion.qd[k], motion.qdd[k])
        tau = tau[0] if isinstance(tau, tuple) else tau
        np.testing.assert_allclose(motion.tau[k], tau, rtol=1e-13, atol=1e-13)
    assert found.names == ("shoulder.tau", "elbow.tau") and np.array_equal(found.outputs, motion.tau)
    assert found.is_exact and found.is_within and not found.deviation.any()
    np.testing.assert_allclose(motion.q[[0, -1]], [[0.0, 0.0], [0.5, -0.3]], rtol=1e-14)
    np.testing.assert_array_equal(found.powers, motion.tau * motion.qd)
    assert {"power_shoulder", "tau_elbow", "elbow.tau", "energy_kinetic"} <= {*found.to_frame().columns}


@pytest.mark.thorough
@pytest.mark.parametrize("machine", ["planar_2r", "delta", "five_bar"])
def test_what_motors_put_in_is_stored(machine: str) -> None:
    """The energy model does not know of torques: its change is their work, by Simpson's rule."""
    path: Path | str = ARM if machine == "planar_2r" else FILES[machine]
    motors = [joint.name for joint in se.read(path, warn=lambda _: None).motor_joints]
    tables = {"motion": {"duration": 0.5, "moves": [{"motor": name, "by": 0.05, "in": 0.4} for name in motors]}}
    (found,) = se.simulate(path, tables)
    energy = found.energy
    assert energy.largest > 1e-4 and abs(energy.left_over) <= 1e-7 * max(energy.largest, abs(energy.stored))


@pytest.mark.thorough
def test_forces_on_frames_are_carried_by_the_motors() -> None:
    force = {"at": "tip", "fy": 100.0, "in": 0.1}
    (found,) = se.simulate(ARM, {"motion": {**MOTION, "forces": [force]}})
    (free,) = se.simulate(ARM, {"motion": MOTION})
    (q1, q2), l1, l2 = found.motion.q[-1], 0.4, 0.3
    tip = np.array([l1 * np.cos(q1) + l2 * np.cos(q1 + q2), l2 * np.cos(q1 + q2)])
    np.testing.assert_allclose(found.motion.tau[-1] - free.motion.tau[-1], -100.0 * tip, rtol=1e-12)


@pytest.mark.thorough
def test_the_command_writes_and_draws_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("move.toml").write_text(
        '[motion]\nduration = 1\nmoves = [{ motor = "shoulder", by = 0.5, in = 0.8 }]\n[wanted]\noutputs = ["tip.x"]\n'
    )
    asked = ("simulate", ARM, "--scene", "move.toml")
    out = run(*asked, "--step", "0.01", "--out", "move.csv", "--plots", "plots").stdout
    assert "motors that follow exactly move every joint" in out and "peak power, W" in out and "J put in" in out
    header, *rows = Path("move.csv").read_text().splitlines()
    assert len(rows) == 101
    columns = dict(zip(header.split(","), np.array([row.split(",") for row in rows], dtype=float).T, strict=True))
    ends = ["power_shoulder", "power_elbow", "energy_kinetic", "energy_gravity", "energy_elastic"]
    assert [*columns][-5:] == ends
    np.testing.assert_array_equal(columns["power_shoulder"], columns["tau_shoulder"] * columns["qd_shoulder"])
    energy = se.load(ARM, "energy").energy(*(np.array([columns[f"{x}_{j}"][50] for j in JOINTS]) for x in ("q", "qd")))
    assert [columns[name][50] for name in ends[2:]] == pytest.approx(energy, rel=1e-14)
    (motion,) = json.loads(run(*asked, "--step", "0.01", "--json").stdout)["motions"]
    shoulder = motion["motors"]["shoulder"]
    assert shoulder["largest_torque"] == np.abs(columns["tau_shoulder"]).max()
    assert shoulder["largest_power"] == np.abs(columns["power_shoulder"]).max()
    assert shoulder["work"] == pytest.approx(motion["energy"]["put_in"], rel=1e-4)
    record = named_columns(columns, se.read(ARM), "move.csv")
    assert not record[1] and ("tau", "elbow") in record[0]
    assert {path.stem for path in Path("plots").iterdir()} == {"outputs", "torques", "powers", "torque_speed", "energy"}
    assert ended(*asked, "--json").code == 0 and run(*asked, "--json").stdout.count('"method": "exact"') == 1
    assert "--adaptive: every joint is a motor that follows exactly" in refused(*asked, "--adaptive")
    assert "--method: every joint is a motor that follows exactly" in refused(*asked, "--method", "rk4")
    assert "--step: 0 s is not a time" in refused(*asked, "--step", "0")


@pytest.mark.thorough
def test_motions_are_a_list_with_tables_a_frame_and_plots() -> None:
    shorter = {**MOTION, "duration": 0.9}
    scene = {"motion": [MOTION, shorter], "wanted": {"outputs": ["tip.x"]}}
    found = se.simulate(ARM, scene)
    assert isinstance(found, list) and found[1].motion.t[-1] == 0.9
    assert repr(found).startswith("<Simulations of planar_2r")
    columns = found.columns()
    assert [int(np.sum(columns["motion"] == k)) for k in (1, 2)] == [len(one.motion.t) for one in found]
    np.testing.assert_array_equal(columns["tip.x"][columns["motion"] == 2], found[1].outputs[:, 0])
    assert len(found.parts()) == sum(len(one.parts()) for one in found) and len(found.as_json()["motions"]) == 2
    assert {"outputs_1", "energy_2"} <= {*found.plots()} and "t_2" in found.arrays()
    one = se.simulate(ARM, {"motion": MOTION})
    assert "motion" not in one.columns() and [*one.plots()] == [*one[0].plots()]
