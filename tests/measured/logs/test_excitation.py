"""Exciting trajectories: on the command line, as files, and as what a controller may follow."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("scipy")

import symoro_elastic as se
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import generate
from symoro_elastic.machine.limits import Range
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.machine.scene import Scene
from symoro_elastic.measured.logs.excitation import Response, within_torques
from symoro_elastic.measured.logs.fourier_motion import FourierMotion, Limits, Started, from_rest, random_motion
from symoro_elastic.measured.logs.trajectory import limits_of, trajectory
from symoro_elastic.measured.logs.views import neutral_positions
from symoro_elastic.numerics.linear.regressor import regressor
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.command_line import run
from tests.generated_code import imported
from tests.references.random_machines import chain

TWO_R = Path(__file__).parents[3] / "examples" / "planar_2r.toml"
LIMITS = Limits.of([-1.5, -0.2], [1.0, 2.0], [3, 1], [15, 25])
BOUNDS = ("--position", "-1.5:1.2", "--velocity", 3, "--acceleration", 20, "--acceleration", "elbow=25")
QUICK = (*BOUNDS, "--fundamental", 0.5, "--harmonics", 3, "--sample-rate", 200)


def whole(motion: FourierMotion, periods: int) -> Started:
    """The motion from rest to rest."""
    found = from_rest(motion, LIMITS)
    assert found is not None and found.motion.a.tolist() == motion.a.tolist()
    return replace(found, periods=periods)


def refused(*arguments: object) -> str:
    with pytest.raises(InputError) as error:
        run("excite", TWO_R, *arguments)
    return str(error.value)


def excited(out: Path, *more: object) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(run("excite", TWO_R, *QUICK, "--out", out, "--json", *more).stdout)
    return found


@pytest.mark.parametrize("seed", range(6))
def test_from_rest_to_rest_within_limits(seed: int) -> None:
    """Limits are kept at every sample, the derivatives are those of q, and it ends where it began."""
    harmonics, periods = 1 + seed, 1 + seed % 3
    motion = random_motion(LIMITS, 0.3, harmonics, seed)
    found = trajectory(whole(motion, periods), 2000.0)
    assert (found.q >= LIMITS.low - 1e-9).all() and (found.q <= LIMITS.high + 1e-9).all()
    assert (abs(found.qd) <= LIMITS.velocity).all() and (abs(found.qdd) <= LIMITS.acceleration).all()
    for ends in (found.qd[[0, -1]], found.qdd[[0, -1]], found.q[0] - found.q[-1]):
        assert abs(ends).max() < 0.02
    step = found.t[1]
    for block, slope in ((found.q, found.qd), (found.qd, found.qdd)):
        differences = (block[2:] - block[:-2]) / (2 * step)
        assert abs(differences - slope[1:-1]).max() < 1e-3 * abs(slope).max()


def test_the_motion_itself_runs_in_between() -> None:
    motion = random_motion(LIMITS, 0.5, 4, 3)
    found = trajectory(whole(motion, 2), 500.0)
    inside = (found.t > found.start) & (found.t < found.start + 2 * motion.period)
    for block, wanted in zip((found.q, found.qd, found.qdd), motion.at(found.t[inside] - found.start / 2), strict=True):
        np.testing.assert_allclose(block[inside], wanted, atol=1e-12)
    assert found.t[-1] == pytest.approx(2 * found.start + 2 * motion.period)


@pytest.mark.thorough
def test_a_trajectory_file_and_its_figures(tmp_path: Path) -> None:
    """CSV and NPZ hold the same; the same seed makes the same file; limits are those that were given."""
    found = excited(tmp_path / "a.csv", "--evaluations", 60)
    assert found["condition"] < found["condition_before"]
    excited(tmp_path / "b.csv", "--evaluations", 60)
    excited(tmp_path / "c.npz", "--evaluations", 60)
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    with (tmp_path / "a.csv").open(encoding="utf-8") as file:
        titles = file.readline().strip().split(",")
    assert titles[::2] == ["t [s]", "q_elbow [rad]", "qd_elbow [rad/s]", "qdd_elbow [rad/s2]"]
    header = [title.split(" ")[0] for title in titles]
    assert header == ["t", "q_shoulder", "q_elbow", "qd_shoulder", "qd_elbow", "qdd_shoulder", "qdd_elbow"]
    table = np.loadtxt(tmp_path / "a.csv", delimiter=",", skiprows=1)
    with np.load(tmp_path / "c.npz") as arrays:
        np.testing.assert_allclose(np.column_stack([arrays[name] for name in header]), table, rtol=1e-11, atol=1e-11)
    assert len(table) == found["samples"] and table[-1, 0] == found["duration"]
    elbow = found["motors"]["elbow"]
    assert (elbow["acceleration_limit"], elbow["position_limits"]) == (25, [-1.5, 1.2])
    assert elbow["velocity"] == pytest.approx(abs(table[:, 4]).max(), rel=1e-11)
    assert len(elbow["a"]) == len(elbow["b"]) == 3


@pytest.mark.thorough
def test_what_it_excites_is_identified(tmp_path: Path) -> None:
    """The trajectory with the torques of the generated model added: `identify` finds the parameters back."""
    excited(tmp_path / "motion.csv", "--evaluations", 30, "--known", "FS1", "--known", "FS2")
    machine, _ = read_machine(TWO_R)
    generate(machine, Scene(("inverse_dynamics",)), ["numpy"], tmp_path)
    t, *rest = np.loadtxt(tmp_path / "motion.csv", delimiter=",", skiprows=1).T
    q, qd, qdd = (np.stack(rest[2 * k : 2 * k + 2], axis=1) for k in range(3))
    tau, _ = imported(tmp_path / "planar_2r").inverse_dynamics(q, qd, qdd)
    header = "t,q_shoulder,q_elbow,qd_shoulder,qd_elbow,qdd_shoulder,qdd_elbow,tau_shoulder,tau_elbow"
    np.savetxt(tmp_path / "data.csv", np.column_stack([t, q, qd, qdd, tau]), delimiter=",", header=header, comments="")
    found = json.loads(run("identify", TWO_R, tmp_path / "data.csv", "--json").stdout)["estimates"]
    value = {p.name: p.value.value() for p in machine.parameters if p.value}
    for label, wanted in (("MX2", "lc2*m2"), ("ZZ2", "I2 + lc2^2*m2")):
        exact = value["lc2"] * value["m2"] if label == "MX2" else value["I2"] + value["lc2"] ** 2 * value["m2"]
        assert found[label]["value"] == pytest.approx(exact, rel=1e-3), wanted


@pytest.mark.thorough
def test_tables_and_pictures(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    ran = run(
        "excite", TWO_R, *QUICK, "--out", tmp_path / "a.csv", "--evaluations", 12, "--plots", tmp_path / "pictures"
    )
    assert all(word in ran.stdout for word in ("shoulder", "-1.5 : 1.2", "condition number", "wrote", "MX2"))
    assert {path.name for path in (tmp_path / "pictures").iterdir()} == {"trajectory.png", "search.png"}


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("--position", "elbo=1"), "--position: no motor 'elbo'; did you mean 'elbow'?"),
        (("--position", "shoulder=1"), "--position: no limit for elbow: give one for all, or elbow=..."),
        (("--position", "1:-1"), "all=1:-1 is not a range"),
        (("--position", "a:b"), "is not a limit"),
        (("--position", "1", "--velocity", "shoulder=1:2"), "--velocity: shoulder: one number"),
        (
            ("--position", "1", "--sample-rate", "5"),
            "--sample-rate: 5 Hz is slow for harmonics up to 0.5 Hz: sample at 10 Hz",
        ),
        (("--position", "1", "--sample-rate", "1e9"), "is the limit"),
        (("--position", "1", "--known", "MX22"), "--known, MX22: there is no such parameter; did you mean 'MX2'"),
        (("--position", "1", "--value", "m1"), "'m1' is not NAME=NUMBER"),
    ],
)
def test_excitations_that_cannot_be_had(arguments: tuple[str, ...], reason: str, tmp_path: Path) -> None:
    said = refused("--velocity", "2", "--acceleration", "10", "--out", tmp_path / "a.csv", *arguments)
    assert reason in said and "\n" not in said and not list(tmp_path.iterdir())


def test_limits_without_end_are_refused() -> None:
    with pytest.raises(InputError, match="velocity: shoulder=-inf:inf is not a range"):
        se.excite(TWO_R, (-1, 1), {"shoulder": np.inf})


def test_files_are_refused_before_the_search(tmp_path: Path) -> None:
    assert ".csv or .npz" in refused(*QUICK, "--out", tmp_path / "a.txt")
    assert "does not exist" in refused(*QUICK, "--out", tmp_path / "there" / "a.csv")


def test_limits_by_variable_and_by_name() -> None:
    ranges = {"--position": {"": (-1.0, 1.0), "q2": (0.0, 2.0)}, "--velocity": {"": (-3.0, 3.0)}}
    found = limits_of(chain(3), {**ranges, "--acceleration": {"joint1": (-5.0, 5.0), "": (-7.0, 7.0)}})
    assert found.low.tolist() == [-1, 0, -1] and found.high.tolist() == [1, 2, 1]
    assert found.velocity.tolist() == [3, 3, 3] and found.acceleration.tolist() == [5, 7, 7]


def test_neutral_positions_in_words() -> None:
    machine, _ = read_machine(TWO_R)
    found: Any = SimpleNamespace(machine=machine, neutral={"elbow": (0.1, 0.0012)})
    assert neutral_positions(found) == ["neutral position of elbow: 0.1 rad, std 0.0012"]


LIMITED = """
[limits]
shoulder = { position = [-1.5, 1.2], velocity = [-3, 4], acceleration = 20TORQUE }
elbow    = { position = [-1.5, 1.2], velocity = 3, acceleration = 25 }
"""
FEW = {"fundamental": 0.5, "harmonics": 3, "sample_rate": 200, "evaluations": 40}


def limited(folder: Path, torque: str = "") -> Path:
    """The machine with limits of its joints, and perhaps of a torque."""
    file = folder / "limited.toml"
    file.write_text(without_limits() + LIMITED.replace("TORQUE", torque), encoding="utf-8")
    return file


def without_limits() -> str:
    """The text of the machine without its own limits, which stand at its end."""
    return TWO_R.read_text(encoding="utf-8").partition("[limits]")[0]


@pytest.mark.thorough
def test_what_no_option_gives_is_taken_from_the_limits_of_the_machine(tmp_path: Path) -> None:
    """The same file as with options; an option wins over the limits, of one motor or of all."""
    file, free = limited(tmp_path), tmp_path / "free.toml"
    free.write_text(without_limits(), encoding="utf-8")
    run("excite", free, *QUICK, "--out", tmp_path / "given.csv", "--evaluations", 20)
    options = ("--fundamental", 0.5, "--harmonics", 3, "--sample-rate", 200, "--evaluations", 20)
    run("excite", file, "--out", tmp_path / "own.csv", *options)
    assert (tmp_path / "own.csv").read_bytes() == (tmp_path / "given.csv").read_bytes()
    found = se.excite(file, velocity={"elbow": 2}, acceleration=9, **FEW)
    elbow, shoulder = (next(x for x in found.motors if x.name == name) for name in ("elbow", "shoulder"))
    assert (elbow.velocity_limit, shoulder.velocity_limit, shoulder.acceleration_limit) == (2, 3, 9)
    assert shoulder.position_limits == (-1.5, 1.2) and shoulder.torque_limits is None


def test_motors_without_limits_are_named_with_both_ways_out(tmp_path: Path) -> None:
    file = tmp_path / "free.toml"
    file.write_text(without_limits(), encoding="utf-8")
    with pytest.raises(InputError) as error:
        run("excite", file, "--position", "-1:1", "--out", tmp_path / "a.csv")
    message = str(error.value)
    what = "give one for all, or shoulder=..., or velocity in [limits] of the machine"
    assert f"--velocity: no limit for shoulder, elbow: {what}" in message


def said(found: Any) -> str:
    return "\n".join(part for part in found.parts() if isinstance(part, str))


def torques_of(found: Any, folder: Path) -> np.ndarray:
    """Torques of the motors by the generated inverse model, along the whole trajectory."""
    generate(found.machine, Scene(("inverse_dynamics",)), ["numpy"], folder)
    tau, _ = imported(folder / found.machine.name).inverse_dynamics(
        found.sampled.q, found.sampled.qd, found.sampled.qdd
    )
    return np.asarray(tau)


@pytest.mark.thorough
def test_torques_keep_the_limits_of_the_machine(tmp_path: Path) -> None:
    """By the generated inverse model, in all periods, whether or not the range is around zero."""
    free = se.excite(limited(tmp_path), **FEW)
    reached = float(np.abs(torques_of(free, tmp_path / "free")[:, 0]).max())
    low, high = -0.6 * reached, 0.4 * reached
    found = se.excite(limited(tmp_path, f", torque = [{low!r}, {high!r}]"), **FEW)
    tau = torques_of(found, tmp_path / "kept")[:, 0]
    inside = (found.sampled.t > found.sampled.start) & (found.sampled.t < found.sampled.t[-1] - found.sampled.start)
    assert low <= tau[inside].min() and tau[inside].max() <= high
    (shoulder,) = (motor for motor in found.motors if motor.name == "shoulder")
    assert shoulder.torque_limits == (low, high)
    assert shoulder.torque == pytest.approx((tau[inside].min(), tau[inside].max()), rel=0.02)
    assert f"shoulder {shoulder.torque[0]:.4g} : {shoulder.torque[1]:.4g} of {low:.4g} : {high:.4g} N m" in said(found)


@pytest.mark.parametrize("allowed", [(5.0, 22.0), (0.0, 18.0), (-20.0, 16.0)])
def test_motions_are_made_no_smaller_than_torques_need(allowed: tuple[float, float]) -> None:
    """They touch an end of the range, but for a margin between samples; smaller motions stay as they are."""
    machine, _ = read_machine(TWO_R)
    response = Response(machine, regressor(machine))
    motion = random_motion(LIMITS, 0.8, 4, 2)
    kept = within_torques(motion, (Range(*allowed), None), response)
    fine = motion.period * np.arange(5000) / 5000
    tau = regressor(machine).torques(*kept.at(fine), range(len(response.Y.columns)), response._values)[:, 0]
    (low, high), half = allowed, (allowed[1] - allowed[0]) / 2
    assert low <= tau.min() and tau.max() <= high
    assert min(tau.min() - low, high - tau.max()) < 0.03 * half
    assert kept.a.any() and within_torques(kept, (Range(*allowed), None), response) is kept
    assert within_torques(motion, (None, None), response) is motion


@pytest.mark.thorough
def test_torques_that_gravity_alone_takes_leave_no_motion(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"limits: gravity alone requires more than the torques in \[limits\]"):
        se.excite(limited(tmp_path, ", torque = [1e6, 2e6]"), **FEW)


def test_torques_of_parameters_without_value_are_not_promised(tmp_path: Path) -> None:
    file = limited(tmp_path, ", torque = 1e-3")
    text = re.sub(r"m2 += .*", "m2 = nan", file.read_text(encoding="utf-8"))
    file.write_text(text, encoding="utf-8")
    found = se.excite(file, **FEW)
    assert "limits of torques are not kept, for parameters have no value: " in said(found)
    assert all(motor.torque is None for motor in found.motors)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(2))
def test_frames_stay_in_their_box_at_times_that_the_search_did_not_see(seed: int) -> None:
    """The tip by hand, l1 and l2 along the arms, at 20 samples for each that the search has; payload doubled."""
    machine, _ = read_machine(TWO_R)
    box = {"tip.x": (0.1, 0.6), "tip.y": (-0.2, 0.5)}
    bounds = {"position": (-1.5, 2.5), "velocity": 3.0, "acceleration": 20.0, "fundamental": 0.5, "harmonics": 3}
    found = se.excite(
        machine, **bounds, workspace=box, evaluations=40, seed=seed, sample_rate=1000.0, values={"m2": 4.0}
    )
    q = np.array(found.sampled.q)
    value = {p.name: p.value.value() for p in machine.parameters if p.value}
    x = value["l1"] * np.cos(q[:, 0]) + value["l2"] * np.cos(q.sum(axis=1))
    y = value["l1"] * np.sin(q[:, 0]) + value["l2"] * np.sin(q.sum(axis=1))
    for tip, (low, high) in zip((x, y), box.values(), strict=True):
        assert low <= tip.min() and tip.max() <= high
    free = se.excite(machine, **bounds, evaluations=40, seed=seed, sample_rate=1000.0)
    assert found.best.condition > free.best.condition


@pytest.mark.thorough
def test_boxes_that_cannot_be_kept_are_refused(tmp_path: Path) -> None:
    for box, said in (
        ("tip.x=5:6", "at rest, a frame is outside its box"),
        ("tip.vx=0:1", "--workspace: tip.vx is not a position of a frame"),
        ("tip.x=1:0", "tip.x=1:0 is not a range"),
        ("tool.x=0:1", "--workspace: 'tool.x': no frame 'tool'"),
    ):
        assert said in refused(*QUICK, "--out", tmp_path / "a.csv", "--workspace", box, "--evaluations", 5)


@pytest.mark.thorough
def test_torques_are_kept_with_payloads_between_the_ends_of_their_range(tmp_path: Path) -> None:
    """By the inverse dynamic model at payloads that no end is, two of them unseen."""
    file = limited(tmp_path, ", torque = [-40, 40]")
    free, found = se.excite(file, **FEW), se.excite(file, **FEW, payload={"m2": (1.0, 4.0)})
    largest = {}
    for name, motion in (("free", free), ("kept", found)):
        t, start = motion.sampled.t, motion.sampled.start
        inside = (t > start) & (t < t[-1] - start)
        models = [
            numpy_model(with_values(se.read(file), {"m2": x}), ("inverse_dynamics",)) for x in (1.0, 2.2, 3.1, 4.0)
        ]
        x = motion.sampled.q, motion.sampled.qd, motion.sampled.qdd
        largest[name] = max(np.abs(np.asarray(one.inverse_dynamics(*x)[0])[inside, 0]).max() for one in models)
    assert largest["free"] > 40 > largest["kept"]
    assert "with payloads m2 1 : 4" in said(found)


@pytest.mark.parametrize(
    ("payload", "said"),
    [
        ("m3=0:1", "--payload: unknown 'm3'"),
        ("m2=2:1", "m2=2:1 is not a range"),
        ("l2=0.1:0.2", "l2: joint 3 (tip) has it in its geometry: give a mass or an inertia"),
        (
            "lc2=0.1:0.2",
            "lc2: the inertia of joint 2 (elbow) is not linear in it, so ends of a range do not bound torques",
        ),
    ],
)
def test_ranges_that_do_not_bound_torques_are_refused(tmp_path: Path, payload: str, said: str) -> None:
    assert said in refused(*QUICK, "--out", tmp_path / "a.csv", "--payload", payload)


ARM: dict[str, Any] = {
    "name": "arm",
    "gravity": [0, -9.81, 0],
    "joints": [
        {"name": "a", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"},
        {"name": "b", "antecedent": "a", "kind": "motor", "sigma": 0, "theta": "q2", "d": 0.5},
    ],
    "bodies": {
        "a": {"mass": 3, "center_of_mass": [0.2, 0, 0], "inertia": [0.01, 0.1, 0.1]},
        "b": {"mass": 2, "center_of_mass": [0.2, 0.02, 0], "inertia": [0.01, 0.05, 0.05]},
    },
}
SMOOTH = {"a": {"viscous": 1, "coulomb": 2}, "b": {"viscous": 0.5, "coulomb": 1}}
WITH_LAWS: dict[str, Any] = ARM | {
    "friction": {"a": SMOOTH["a"] | {"load": 0.3}, "b": SMOOTH["b"] | {"static": 1.8, "stribeck": 0.2}},
    "motors": {"a": {"cogging": 0.8, "cogging_order": 4, "cogging_phase": 0.4}},
}
WITHIN: dict[str, Any] = {"position": (-1, 1), "velocity": 2, "acceleration": 9, "sample_rate": 100.0}


def own_laws(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What friction and cogging of WITH_LAWS add (N, 2), and its columns (N, 2, 4) of FL1, FB2, CC1, CS1."""
    rigid, *_ = np.atleast_2d(se.load(se.read(ARM), ["inverse_dynamics"]).inverse_dynamics(q, qd, qdd))
    columns = np.zeros((len(q), 2, 4))
    columns[:, 0, 0] = np.abs(rigid.reshape(len(q), 2)[:, 0]) * np.sign(qd[:, 0])
    columns[:, 1, 1] = np.sign(qd[:, 1]) / (1 + (qd[:, 1] / 0.2) ** 2)
    columns[:, 0, 2:] = -np.column_stack([np.cos(4 * q[:, 0]), np.sin(4 * q[:, 0])])
    return columns @ [0.3, 0.8, 0.8 * np.sin(0.4), 0.8 * np.cos(0.4)], columns


def test_motions_excite_friction_by_load_and_cogging() -> None:
    """Their columns are sought, and better determined than on a motion that is designed without them."""
    few = WITHIN | {"evaluations": 300, "seed": 0}
    plain, asked = ARM | {"friction": SMOOTH}, {"load_friction": ["a"], "stribeck": {"b": 0.2}, "cogging": {"a": 4}}
    found, without = se.excite(WITH_LAWS, **few), se.excite(plain, **few)
    assert set(found.best.columns) - set(without.best.columns) == {"FL1", "FB2", "CC1", "CS1"}
    assert se.excite(plain, **WITHIN, evaluations=1, **asked).best.columns == found.best.columns
    regressor = se.load(se.read(plain), ["regressor"]).regressor

    def stacked(one: Any) -> np.ndarray:
        states = (one.sampled.q, one.sampled.qd, one.sampled.qdd)
        W = np.concatenate([regressor(*states), own_laws(*states)[1]], axis=2).reshape(-1, 14)
        return np.asarray(W[:, np.linalg.norm(W, axis=0) > 1e-9])

    lengths = np.linalg.norm(stacked(without), axis=0)
    worst = []
    for one in (found, without):
        W = stacked(one) / lengths
        worst.append(np.sqrt(np.diag(np.linalg.pinv(W.T @ W))[-4:]).max())
    assert worst[0] < 0.8 * worst[1]


@pytest.mark.thorough
def test_torques_of_friction_by_load_and_cogging_keep_the_limits() -> None:
    """By own formulas of these laws; without them the motion takes more than is allowed."""
    limits = {"limits": {"a": {"torque": [-30, 30]}}}
    found = se.excite(WITH_LAWS | limits, **WITHIN, evaluations=40)
    smooth = se.read(ARM | {"friction": SMOOTH})
    states = (found.sampled.q, found.sampled.qd, found.sampled.qdd)
    tau, *_ = se.load(smooth, ["inverse_dynamics"]).inverse_dynamics(*states)
    whole = np.asarray(tau).reshape(-1, 2) + own_laws(*states)[0]
    assert 0.9 * 30 < np.abs(whole[:, 0]).max() < 30
    low, high = found.best.torques[0]
    assert low <= whole[:, 0].min() and whole[:, 0].max() <= high
    with pytest.raises(InputError, match="gravity alone requires more"):
        se.excite(WITH_LAWS | {"limits": {"a": {"torque": [-10, 10]}}}, **WITHIN, evaluations=5)


@pytest.mark.sampled(12)
@pytest.mark.parametrize(
    "friction", [{"coulomb": 5}, {"coulomb": 2, "static": 8, "stribeck": 0.02}, {"coulomb": 1, "load": 0.4}]
)
@pytest.mark.parametrize("about", [-np.pi / 2, -np.pi / 2 + 0.5])
def test_torques_keep_the_limits_between_samples_at_reversals_and_from_rest_to_rest(
    friction: dict[str, float], about: float
) -> None:
    """A pendulum by hand, near resonance: gravity, which accelerations balance, stays where it starts and stops."""
    body = {"mass": 3, "center_of_mass": [0.4, 0, 0], "inertia": [0.1, 0.1, 0.1]}
    joint = {"name": "a", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"}
    pendulum = {"name": "pendulum", "gravity": [0, -9.81, 0], "joints": [joint], "bodies": {"a": body}}
    pendulum |= {"friction": {"a": friction}, "limits": {"a": {"torque": 16}}}
    within = {"position": (about - 1, about + 1), "velocity": 20, "acceleration": 100, "fundamental": 0.35}
    found = se.excite(pendulum, **within, harmonics=3, evaluations=20, sample_rate=4000.0, seed=2)
    q, qd, qdd = (x[:, 0] for x in (found.sampled.q, found.sampled.qd, found.sampled.qdd))
    rigid = (0.1 + 3 * 0.4**2) * qdd + 3 * 9.81 * 0.4 * np.cos(q)
    more = (friction.get("static", friction["coulomb"]) - friction["coulomb"]) / (
        1 + (qd / friction.get("stribeck", 1)) ** 2
    )
    dry = friction["coulomb"] + more + friction.get("load", 0.0) * np.abs(rigid)
    tau = rigid + np.sign(qd) * dry
    assert 0.6 * 16 < np.abs(tau).max() <= 16
    ((low, high),) = found.best.torques
    assert low <= tau.min() and tau.max() <= high
    assert found.sampled.qdd[[0, -1]].max() < 0.1


def test_springs_that_a_motion_is_too_fast_for_are_named() -> None:
    """A load on a spring of k = 40 N m/rad and 0.1 kg m2: sqrt(k / J) / (2 pi) = 3.18 Hz."""
    joints = [
        {"name": "a", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"},
        {"name": "b", "antecedent": "a", "kind": "elastic", "sigma": 0, "theta": "q2"},
    ]
    soft = {"name": "soft", "joints": joints, "bodies": {"b": {"mass": 1, "inertia": [0.1, 0.1, 0.1]}}}
    soft |= {"springs": {"b": {"stiffness": 40}}, "motors": {"a": {"rotor_inertia": 0.1}}}
    slow, fast = (se.excite(soft, **WITHIN, fundamental=f, harmonics=2, evaluations=2) for f in (0.3, 1.0))
    assert slow.best.natural == pytest.approx(np.sqrt(40 / 0.1) / (2 * np.pi))
    assert "are near the first natural frequency of the springs, 3.183 Hz" in said(fast)
    assert "natural frequency" not in said(slow)


@pytest.mark.thorough
def test_only_a_payload_is_sought() -> None:
    """Its parameters alone are excited and identified, where the rest of the machine is known."""
    joints = [*ARM["joints"], {"name": "load", "antecedent": "b", "kind": "fixed", "sigma": 2, "d": 0.4}]
    arm = ARM | {"joints": joints, "friction": SMOOTH}
    loaded = arm | {"bodies": ARM["bodies"] | {"load": {"mass": 2, "center_of_mass": [0.03, 0, 0]}}}
    empty = arm | {"bodies": ARM["bodies"] | {"load": {"mass": 1e-9, "inertia": [1e-9, 1e-9, 1e-9]}}}
    found = se.excite(empty, **WITHIN, evaluations=20, seek=["load"])
    assert set(found.best.columns) == {"ZZ3", "MX3", "MY3", "M3"}
    states = found.sampled.q, found.sampled.qd, found.sampled.qdd
    tau = np.asarray(se.load(se.read(loaded), ["inverse_dynamics"]).inverse_dynamics(*states)[0])
    noise = np.random.default_rng(0).normal(0, 0.02, tau.shape)
    log = {"t": found.sampled.t} | {f"q_{x}": states[0][:, k] for k, x in enumerate("ab")}
    log |= {f"tau_{x}": (tau + noise)[:, k] for k, x in enumerate("ab")}
    by_label = {e.unknown.label: e for e in se.identify(empty, log, seek=["load"], offsets="never").found.estimates}
    for label, true in (("ZZ3", 2 * 0.03**2), ("MX3", 0.06), ("MY3", 0.0), ("M3", 2.0)):
        assert abs(by_label[label].value - true) < 4 * by_label[label].std < 0.02
    with pytest.raises(InputError, match="seek: unknown 'lod'"):
        se.identify(empty, log, seek=["lod"])
