"""Torques for a wanted motion over time: on the full elastic model they make it, and too little motion is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BSpline, CubicSpline, PPoly

from symoro_elastic.analysis.time_series.measurements import read_columns
from symoro_elastic.analysis.vibration.feed_forward import FeedForward, feed_forward, notes, orders
from symoro_elastic.analysis.vibration.reference_trajectory import along, move, read_reference, through, times
from symoro_elastic.codegen.integration.tableaus import RK4, step
from symoro_elastic.formats import read_machine, write_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Friction, Kind, Machine
from symoro_elastic.machine.restrict import restrict, rigid
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.analysis.vibration.machines import drive, machine_of, slide
from tests.command_line import EXAMPLES, refused, run
from tests.compiled_models import cell
from tests.models.test_feed_forward import with_springs
from tests.references.random_machines import random_machine

pytestmark = pytest.mark.sampled(4)

PROGRESSIVE = "2e4 + 1e9*q_load^2"
LOCKED = ("bed_yaw", "bed_y", "bed_x", "motor_secondary", "cart_yaw", "cart_x", "cart_y", "sensor_head")


def flex4() -> Machine:
    machine, _ = read_machine(EXAMPLES / "flex4.par")
    values = parameter_values(machine, 3)
    valued = tuple(replace(p, value=Formula.parse(values[p.name])) for p in machine.parameters)
    return replace(machine, parameters=valued)


def whole_two_axis() -> Machine:
    return read_machine(EXAMPLES / "two_axis.toml")[0]


def two_axis() -> Machine:
    return restrict(whole_two_axis(), Scene(locked=dict.fromkeys(LOCKED, ZERO)))


def outboard(machine: Machine, q: Any) -> Any:
    """y of each motor: on these machines springs turn as their motor does, and follow it in the table."""
    kinds = [machine.joints[j - 1].kind for j in machine.independent]
    first = [k for k, kind in enumerate(kinds) if kind is Kind.MOTOR]
    return np.stack([block.sum(axis=1) for block in np.split(q, first[1:], axis=1)], axis=1)


def simulated(found: FeedForward) -> Any:
    """q (N, n) under the torques alone, by the direct model; steps of two samples, so that stages are at samples."""
    model = numpy_model(found.machine)
    h, y = found.t[2] - found.t[0], np.array([found.q[0], found.qd[0]])

    def rate(t: float, y: Any) -> Any:
        return np.array([y[1], model.direct_dynamics(*y, found.tau[round(2 * t / h)])])

    positions = [y[0]]
    for k in range(0, len(found.t) - 2, 2):
        y = step(RK4, rate, k * h / 2, y, h)
        positions.append(y[0])
    return np.array(positions)


@pytest.mark.parametrize(
    ("machine", "duration", "rate", "best"),
    [
        (drive(), 0.4, 1000, 1e-9),
        (drive(k=PROGRESSIVE), 0.4, 1000, 2e-9),
        (flex4(), 1.0, 400, 2e-9),
        (two_axis(), 0.05, 10000, 5e-10),
    ],
    ids=["mass", "progressive", "flex4", "two_axis"],
)
def test_the_full_model_follows(machine: Machine, duration: float, rate: float, best: float) -> None:
    """The error is that of the integration, of fourth order: a sixteenth at half the step."""
    degree = max(orders(machine).values()) + 5
    errors = []
    for samples in (rate, 2 * rate):
        wanted = move(machine, {}, {"": 0.1}, duration, degree, samples)
        found = feed_forward(machine, wanted)
        y = np.stack(list(wanted.y.values()), axis=-1)[0]
        np.testing.assert_allclose(outboard(machine, found.q), y, rtol=0, atol=1e-15)
        errors.append(abs(outboard(machine, simulated(found)) - y[::2]).max())
    assert errors[1] < best and errors[0] / errors[1] == pytest.approx(16, rel=0.05)


def test_a_motion_that_no_deflection_balances_is_refused() -> None:
    """The spring softens: its force is never more than 172 N, at a deflection of 1/sqrt(6000) m."""
    soft = drive(k="2e4*(1 - 1000*q_load^2)")
    slow, fast = (move(soft, {}, {"": 0.1}, duration, 8, 1000) for duration in (1.0, 0.02))
    assert np.isfinite(feed_forward(soft, slow).tau).all()
    with pytest.raises(InputError, match=r"t = 0.\d+ s, motor: no position was found that .* balances the springs"):
        feed_forward(soft, fast)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [3, 5])
def test_random_trees_follow(seed: int) -> None:
    """All joints, springs in rows and in branches; without Coulomb's jumps the integration keeps its order."""
    stiff = random_machine(seed, joints=3, kinds=(Kind.MOTOR,), branching=0.3, prismatic=0.4, symbolic=False)
    sprung = with_springs(stiff, [1, 2], seed)
    rows = tuple(replace(joint, friction=Friction(joint.friction.viscous)) for joint in sprung.joints)
    machine = replace(sprung, joints=rows)
    errors = []
    for rate in (400, 800):
        found = feed_forward(machine, move(machine, {"": 0.1}, {"": 0.2}, 1.0, 13, rate))
        errors.append(abs(simulated(found) - found.q[::2]).max())
    assert errors[1] < 1e-6 and errors[0] / errors[1] == pytest.approx(16, rel=0.1)


def test_a_move_in_closed_form() -> None:
    """k (q_motor - y) = m2 ydd and tau = (m1 + m2) ydd + m1 m2 ydddd / k; y a bell of velocity between rests."""
    m1, m2, k = 3.0, 5.0, 2e4
    wanted = move(drive(m1, m2, k), {"motor": 0.3}, {"": -0.2}, 0.5, 5, 200)
    y = wanted.y["motor"]
    found = feed_forward(drive(m1, m2, k), wanted)
    assert found.orders == {"motor": 4} and wanted.order("motor") == 5
    np.testing.assert_allclose(found.at_motors(found.q)[:, 0], y[0] + m2 * y[2] / k, rtol=0, atol=1e-15)
    torque = (m1 + m2) * y[2] + m1 * m2 * y[4] / k
    np.testing.assert_allclose(found.tau[:, 0], torque, rtol=0, atol=1e-14 * abs(torque).max())
    np.testing.assert_allclose(y[:5, [0, -1]].T, [[0.3, 0, 0, 0, 0], [0.1, 0, 0, 0, 0]], rtol=0, atol=1e-12)


def test_a_spline_of_just_the_degree() -> None:
    """Of degree 4 the torque jumps and the load still follows, as far as steps of a jump do; so with other values."""
    errors = []
    for rate in (2000, 4000):
        wanted = move(drive(), {}, {"": 0.1}, 0.4, 4, rate)
        found = feed_forward(drive(), wanted, {"load.stiffness": 1e4})
        assert wanted.order("motor") == found.orders["motor"] == 4
        softer = simulated(replace(found, machine=drive(k=1e4)))
        errors.append(abs(outboard(drive(), softer)[:, 0] - wanted.y["motor"][0, ::2]).max())
    assert errors[0] < 2e-5 and errors[0] / errors[1] == pytest.approx(2, rel=0.02)


# Motions from files


def written(path: Path, columns: dict[str, Any]) -> Path:
    if path.suffix == ".npz":
        np.savez(path, **columns)
    else:
        table = np.column_stack(list(columns.values()))
        np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt="%.15g")
    return path


def columns(order: int, degree: int = 9, letter: str = "y") -> dict[str, Any]:
    wanted = move(drive(), {}, {"": 0.1}, 0.4, degree, 500)
    return {"t": wanted.t} | {f"{letter}{'d' * k}_motor": wanted.y["motor"][k] for k in range(order + 1)}


@pytest.mark.parametrize("name", ["w.csv", "w.npz"])
@pytest.mark.parametrize("letter", ["y", "q"])
def test_columns_of_a_file(name: str, letter: str, tmp_path: Path) -> None:
    machine = drive()
    found = feed_forward(machine, read_reference(written(tmp_path / name, columns(4, letter=letter)), machine))
    wanted = feed_forward(machine, move(machine, {}, {"": 0.1}, 0.4, 9, 500))
    np.testing.assert_allclose(found.tau, wanted.tau, rtol=0, atol=1e-12 * abs(wanted.tau).max())


def test_positions_of_a_file(tmp_path: Path) -> None:
    """A spline through positions of a smooth motion finds its torques; units are read."""
    machine = drive()
    t = np.linspace(0, 1, 41)
    path = written(tmp_path / "w.csv", {"t [ms]": 1e3 * t, "y_motor [mm]": 50 * np.cos(3 * t)})
    found = feed_forward(machine, read_reference(path, machine, usual=9, rate=100))
    torque = 0.05 * (-9 * 8 + 81 * 15 / 2e4) * np.cos(3 * found.t)
    np.testing.assert_allclose(found.tau[:, 0], torque, rtol=0, atol=1e-6 * abs(torque).max())
    assert not notes(found)[0].startswith("motor: derivative")


def test_a_spline_of_rounded_points_is_in_doubt() -> None:
    t = np.linspace(0, 1, 1001)
    rounded = through(t, {"motor": np.round(0.05 * np.cos(3 * t), 9)}, 5)
    assert rounded.doubts["motor"][0] == 3
    assert notes(feed_forward(drive(), rounded))[0].startswith("motor: derivative 3 of its spline changes by ")
    assert not any("spline" in line for line in notes(feed_forward(rigid(drive()), rounded)))


FEW = "2 derivatives of its motion are given, feed_forward needs 4: give columns up to ydddd_motor, or positions alone "


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        (columns(2), f"motor: {FEW}and a spline of degree 4 or more"),
        (columns(2, 2) | {"yddd_motor": np.zeros(201), "ydddd_motor": np.zeros(201)},
         "motor: 2 derivatives of its motion are given (derivative 2 changes by "),
        ({"t": columns(0)["t"]}, "y_motor: missing"),
        ({x: y for x, y in columns(4).items() if x != "ydd_motor"}, "ydd_motor: missing"),
        (columns(0) | {"q_load": columns(0)["t"]}, "q_load: only motors and their springs have a trajectory"),
        (columns(0) | {"y_load": columns(0)["t"]}, "y_load: load has no motor: motors are motor"),
        (columns(0) | {"t": columns(0)["t"][::-1]}, "t: does not increase at sample 2"),
        (columns(0) | {"y_motor": np.full(201, np.nan)}, "y_motor: NaN or infinity"),
        ({x: y[:4] for x, y in columns(0).items()}, "t: 4 points are too few for a spline of degree 5"),
    ],
)  # fmt: skip
def test_files_refused(columns: dict[str, Any], said: str, tmp_path: Path) -> None:
    machine = drive()
    with pytest.raises(InputError) as error:
        feed_forward(machine, read_reference(written(tmp_path / "w.npz", columns), machine))
    assert f"w.npz: {said}" in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("curve", "given"),
    [
        (PPoly(np.array([[0.5, 0.0, -0.5], [0, 1, 1], [0, 0.5, 1.5]]), np.array([0.0, 1, 2, 3])), 2),
        (CubicSpline([0, 0.5, 1, 1.5, 3], [0, 1, 0, 2, 1]), 3),
        (BSpline(np.repeat([0.0, 1, 3], [6, 3, 6]), np.arange(9.0), 5), 3),
        (BSpline(np.repeat([0.0, 1, 3], [6, 1, 6]), np.arange(7.0), 5), 5),
    ],
    ids=["trapezoid of velocity", "cubic", "triple knots", "quintic"],
)
def test_how_smooth_a_curve_is(curve: Any, given: int) -> None:
    """The first derivative that jumps is the last that is given."""
    wanted = along({"motor": curve}, times(0, 3, 10))
    assert wanted.order("motor") == given
    np.testing.assert_array_equal(wanted.y["motor"][2], curve.derivative(2)(wanted.t))
    if given < 4:
        said = f"motion: motor: {given} derivatives of its motion are given, feed_forward needs 4: give a spline of deg"
        with pytest.raises(InputError, match=said):
            feed_forward(drive(), wanted)


# The command


@pytest.mark.thorough
def test_the_command(tmp_path: Path) -> None:
    """Its file is read as a motion of the whole machine; the same bytes each time."""
    path = tmp_path / "flex4.toml"
    write_machine(flex4(), path)
    asked = ("feed-forward", path, "--stroke", "0.2", "--stroke", "j3=-0.1", "--duration", 1, "--sample-rate", 200)
    shown = run(*asked, "--out", tmp_path / "a.csv", "--plots", tmp_path / "p")
    for name in ("b.csv", "c.npz"):
        run(*asked, "--out", tmp_path / name)
    assert "6 / 7" in shown.stdout and "in motion" not in shown.stdout and "wrote" in shown.stderr
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    assert {x.name for x in (tmp_path / "p").iterdir()} == {"feed_forward.png", "torque_speed.png"}
    machine, _ = read_machine(path)
    rows, same = (read_columns(tmp_path / name, machine) for name in ("a.csv", "c.npz"))
    assert list(rows) == ["t", *(f"{x}_j{j}" for x in ("q", "qd") for j in range(1, 5)), "tau_j1", "tau_j3"]
    found = feed_forward(machine, move(machine, {}, {"": 0.2, "j3": -0.1}, 1.0, 7, 200))
    for read in (rows, same):
        np.testing.assert_array_equal(np.column_stack([read["tau_j1"], read["tau_j3"]]), found.tau)
    figures = json.loads(run(*asked, "--json").stdout)
    assert figures["motors"]["j1"]["order"] == 6 and figures["motors"]["j1"]["torque"] == abs(found.tau[:, 0]).max()


def test_a_motion_that_begins_in_motion(tmp_path: Path) -> None:
    t = np.linspace(0, 1, 101)
    write_machine(drive(), tmp_path / "drive.toml")
    path = written(tmp_path / "w.csv", {"t": t, "y_motor": 0.1 * np.sin(4 * t)})
    shown = run("feed-forward", tmp_path / "drive.toml", "--motion", path).stdout
    assert "motor begins in motion: derivative 1 is not zero" in shown and "motor ends in motion" in shown


def test_dry_friction_makes_the_torque_jump() -> None:
    rubbing = slide("rubbing", 0, Kind.MOTOR, 2.0, friction=Friction(cell(0), cell(3.0)))
    machine = machine_of("two", rubbing, slide("smooth", 1, Kind.MOTOR, 1.0))
    found = feed_forward(machine, move(machine, {}, {"": 0.1}, 1.0, 5))
    assert found.tau[0, 0] == 0 and found.tau[1, 0] > 3
    what = "has dry friction, none at rest: its torque jumps where it starts, stops or reverses"
    assert notes(found) == [f"rubbing {what}"]


REFUSED = {
    "--degree 3": "drive.toml, move: motor: 3 derivatives of its motion are given, feed_forward needs 4: "
    "give a spline of degree 4 or more (--degree 5: smooth torques)",
    "--degree 40": "--degree: 40 is not a degree of a spline here: give 1 to 13",
    "--duration 0": "--duration: 0 s is not a duration",
    "--stroke nan": "--stroke: 'nan' is not NAME=NUMBER: nan is not finite",
    "--stroke moter=1": "--stroke: no motor 'moter'; did you mean 'motor'?",
    "--start load=1": "--start: no motor 'load'",
    "--sample-rate 0": "--sample-rate: 0 Hz for",
    "--sample-rate 1e12": "--sample-rate: 1e+12 Hz for",
    "--motion none.csv": "none.csv: file: no such file",
    "--out x.mat": "x.mat: --out: unknown format '.mat': end the name with .csv or .npz",
    "--value load.stifness=3": "no parameter 'load.stifness'",
    "--scene none.toml": "none.toml",
}


@pytest.mark.parametrize("options", REFUSED)
def test_commands_refused(options: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_machine(drive(), "drive.toml")
    line = refused("feed-forward", "drive.toml", *options.split())
    assert REFUSED[options] in line and "\n" not in line
    assert [path.name for path in tmp_path.iterdir()] == ["drive.toml"]
