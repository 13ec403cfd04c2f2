"""Commands about vibration, what they write, and what they refuse in one line."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io

from symoro_elastic.analysis.vibration.comparison import compare
from symoro_elastic.analysis.vibration.export import labels, save_linearization
from symoro_elastic.analysis.vibration.modes import modes
from symoro_elastic.analysis.vibration.responses import frequency_response
from symoro_elastic.analysis.vibration.tracking import over_grid
from symoro_elastic.formats import write_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Kind
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from tests.analysis.vibration.machines import drive, linearized, machine_of, slide, spring
from tests.analysis.vibration.test_modes import PRINTED, two_axis
from tests.command_line import EXAMPLES, refused, run
from tests.compiled_models import cell
from tests.references.random_machines import random_machine

TWO_AXIS = EXAMPLES / "two_axis.toml"
AT = ("--at", "motor_x=0.3", "--at", "motor_y=0.1")


def figures(*arguments: object) -> Any:
    return json.loads(run(*arguments, "--json").stdout)


@pytest.mark.thorough
def test_modes_on_the_command_line(tmp_path: Path) -> None:
    found = figures("modes", TWO_AXIS, *AT)
    assert [round(f, 1) for f in found["frequencies"]] == PRINTED
    assert found["conclusion"].startswith(
        "the first vibration, 26.07 Hz, is limited by bed_yaw (70% of its strain energy)"
    )
    assert found["damping_ratios"][0] is None and len(found["frame_shapes"]["tool"]) == 12
    assert sum(found["kinetic_energy"][name][2] for name in found["kinetic_energy"]) == pytest.approx(1.0)
    shown = run("modes", TWO_AXIS, *AT, "--out", tmp_path / "m.npz", "--plots", tmp_path / "p").output
    assert "26.0732" in shown and "bed_yaw.stiffness +0.35" in shown and found["conclusion"] in shown
    with np.load(tmp_path / "m.npz") as saved:
        np.testing.assert_array_equal(saved["frequencies"], found["frequencies"])
    assert {path.name for path in (tmp_path / "p").iterdir()} == {"shapes.png", "energies.png", "pictures.png"}


@pytest.mark.thorough
def test_motors_held_or_under_control() -> None:
    held = figures("modes", TWO_AXIS, *AT, "--hold", "all")
    assert len(held["frequencies"]) == 10 and held["frequencies"][0] == pytest.approx(25.98789, rel=1e-6)
    controlled = figures("modes", TWO_AXIS, *AT, "--hold", "motor_x", "--pd", "motor_y=1e7:3e4")
    assert len(controlled["frequencies"]) == 11 and "motor_y (controller)" in controlled["strain_energy"]


@pytest.mark.thorough
def test_modes_over_positions(tmp_path: Path) -> None:
    over = ("modes", TWO_AXIS, "--at", "motor_x=0.3", "--along", "motor_y=0:0.4:3")
    found = figures(*over, "--plots", tmp_path)
    assert [round(row[5], 1) for row in found["frequencies"]] == [87.7, 98.9, 103.1]
    assert "mode 6 depends most on the position" in run(*over).stdout
    assert (tmp_path / "positions.png").stat().st_size > 1000
    assert (tmp_path / "shapes_over_positions.png").exists()
    two = over_grid(EquationsOfMotion(two_axis()), {"motor_x": [0.0, 1.0], "motor_y": [0.0, 0.2]})
    (axis, *_) = two.plot("frequency_6_over_motor_x_motor_y").axes
    assert axis.get_xlabel() == "motor_x, m" and axis.get_ylabel() == "motor_y, m"


@pytest.mark.thorough
def test_response_on_the_command_line(tmp_path: Path) -> None:
    asked = ("response", TWO_AXIS, *AT, "--input", "motor_x", "--output", "tool.x", "--band", "10:100:50")
    found = figures(*asked, "--out", tmp_path / "r.csv", "--plots", tmp_path)
    (transfer,) = found["transfers"]
    assert transfer["resonances"][0] == pytest.approx(26.0732, rel=1e-6) and found["points"] == 50
    header, *lines = (tmp_path / "r.csv").read_text().splitlines()
    assert header == "f [Hz],re tool.x / motor_x.tau,im tool.x / motor_x.tau"
    table = np.array([[float(x) for x in line.split(",")] for line in lines])
    linear = linearized(two_axis(), {"motor_x": 0.3, "motor_y": 0.1}, ["motor_x"], ["tool.x"])
    np.testing.assert_array_equal(table[:, 1], frequency_response(linear, table[:, 0]).values[:, 0, 0].real)
    assert (tmp_path / "bode_motor_x_tau.png").exists()
    assert "antiresonances" in run(*asked).stdout


@pytest.mark.thorough
def test_a_response_at_one_frequency_has_its_magnitude_and_phase() -> None:
    asked = ("response", TWO_AXIS, *AT, "--input", "motor_x", "--output", "tool.x", "--frequency", "5")
    linear = linearized(two_axis(), {"motor_x": 0.3, "motor_y": 0.1}, ["motor_x"], ["tool.x"])
    wanted = frequency_response(linear, [5.0]).values[0, 0, 0]
    (row,) = figures(*asked)["values"]
    assert (row["frequency"], row["input"], row["output"]) == (5.0, "motor_x.tau", "tool.x")
    assert row["magnitude"] == pytest.approx(abs(wanted), rel=1e-12)
    assert row["phase"] == pytest.approx(np.angle(wanted, deg=True), rel=1e-12)
    shown = run(*asked).stdout
    assert f"{abs(wanted):.4g}" in shown and "phase, deg" in shown
    assert figures(*asked[:-2], "--band", "10:100:50")["values"] == []


@pytest.mark.thorough
def test_signals_of_held_motors_are_left_out() -> None:
    held = ("--hold", "motor_x")
    found = figures("response", TWO_AXIS, *held, "--output", "motor_y.q", "--output", "tool.z")
    assert [(each["input"], each["output"], each["no_response"]) for each in found["transfers"]] == [
        ("motor_y.tau", "motor_y.q", False),
        ("motor_y.tau", "tool.z", True),
    ]
    said = "motor_x is held: its torque and its encoder are not signals"
    assert found["notes"] == [said, "no response: motor_y.tau has no effect on tool.z"]
    assert found["transfers"][1]["poles"] == found["transfers"][1]["resonances"] == []
    shown = run("response", TWO_AXIS, *held, "--output", "tool.z").stdout
    assert "no response  " in shown and found["notes"][1] in shown
    shown = run("linearize", TWO_AXIS, "--hold", "all").stdout
    assert "inputs: none; outputs: none\n" in shown and said in shown


@pytest.mark.thorough
def test_compare_on_the_command_line() -> None:
    found = figures("compare", TWO_AXIS, "--stroke", "0.01", "--duration", "0.02")
    assert found["frequencies"]["full"] == found["frequencies"]["reduced"] and found["frequencies"]["rigid"] == []
    assert "--ratio couples them" in found["conclusion"]
    shown = run("compare", TWO_AXIS, "--stroke", "0.01", "--duration", "0.02").stdout
    assert "rigid misses" in shown and found["conclusion"] in shown


@pytest.mark.thorough
def test_pictures_of_a_comparison(tmp_path: Path) -> None:
    """What the pictures show is what the table sums up."""
    write_machine(drive(), tmp_path / "drive.toml")
    run("compare", tmp_path / "drive.toml", "--duration", "0.1", "--plots", tmp_path / "p", "--json")
    assert {path.name for path in (tmp_path / "p").iterdir()} == {"torques.png", "accelerations.png"}
    found = compare(drive(), duration=0.1)
    torque, _ = found.losses
    values, missed = found.plot("torques").axes
    assert [line.get_label() for line in values.lines] == ["full", "reduced", "rigid"]
    reduced, rigid = (line.get_ydata() for line in missed.lines)
    assert not reduced.any() and abs(rigid).max() == torque.rigid[1] > 0


@pytest.mark.parametrize("suffix", ["npz", "mat"])
def test_a_linearization_in_a_file(suffix: str, tmp_path: Path) -> None:
    """The same bytes each time, and the arrays that the linearization has."""
    path, again = (tmp_path / f"{name}.{suffix}" for name in ("one", "two"))
    linear = linearized(drive(d=3.0), None, ["motor", "load.fz"], ["motor", "load.vz"])
    for each in (path, again):
        save_linearization(linear, each)
    assert path.read_bytes() == again.read_bytes()
    loaded = np.load(path) if suffix == "npz" else scipy.io.loadmat(path)
    for name, x in linear.arrays().items():
        found = loaded[name]
        if isinstance(x, list):
            assert [str(np.atleast_1d(y)[0]) for y in np.ravel(found)] == x
        else:
            np.testing.assert_array_equal(np.squeeze(found), np.squeeze(x))


def test_linearize_on_the_command_line(tmp_path: Path) -> None:
    out = tmp_path / "two.mat"
    shown = run("linearize", TWO_AXIS, *AT, "--output", "tool.ax", "--out", out).stdout
    assert "motor_y 1010.43 N" in shown and out.exists()
    found = figures("linearize", TWO_AXIS, "--as-given", "--at", "motor_x=0.3", "--rate", "motor_x=2")
    assert found["qd"][4] == 2.0 and len(found["A"]) == 24
    assert found["qdd"][1] == pytest.approx(-9.81), "nothing holds the machine against gravity"


@pytest.mark.thorough
def test_a_held_motor_is_called_held(tmp_path: Path) -> None:
    """Its torque is not an input, and its encoder no output: text, JSON and files say so."""
    note = "motor_x is held: its torque and its encoder are not signals"
    shown = run("linearize", TWO_AXIS, *AT, "--hold", "motor_x", "--out", tmp_path / "two.mat").stdout
    assert note in shown.splitlines() and "motor_y is held" not in shown
    found = figures("linearize", TWO_AXIS, *AT, "--hold", "motor_x")
    assert found["notes"] == [note] and found["inputs"] == ["motor_y.tau"] and found["outputs"] == ["motor_y.q"]
    assert len(found["B"][0]) == len(found["C"]) == 1
    assert note in run("response", TWO_AXIS, *AT, "--hold", "motor_x", "--band", "10:20:3").stdout
    assert (tmp_path / "two.mat").read_bytes().startswith(b"MATLAB 5.0 MAT-file; " + note.encode() + b"  ")
    alone = linearized(drive(), ins=["load.fz"], outs=["load"], held=["motor"])
    assert (
        alone.notes == ("motor is held: its torque and its encoder are not signals",)
        and linearized(drive()).notes == ()
    )
    save_linearization(linearized(drive()), tmp_path / "free.mat")
    assert scipy.io.loadmat(tmp_path / "free.mat")["notes"].size == 0


ALIKE = [
    "tool at (0.1, 0, 0).x", "tool at (-0.1, 0, 0).x", "tool at (0, 0.1, 2).x", "tool at (0, 0, 1.2).x",
    "tool at (L*2, 0, 0).x", "tool at (L/2, 0, 0).x",
]  # fmt: skip


def test_labels_of_other_programs_are_different_and_can_be_read() -> None:
    assert labels(["motor.tau", *ALIKE]) == [
        "motor_tau", "tool_at_0p1_0_0_x", "tool_at_minus_0p1_0_0_x", "tool_at_0_0p1_2_x", "tool_at_0_0_1p2_x",
        "tool_at_L_2_0_0_x", "tool_at_L_2_0_0_x_2",
    ]  # fmt: skip
    assert labels(["a b", "a_b", "a_b_2", "a-b"]) == ["a_b", "a_b_2", "a_b_2_2", "a_b_3"]


def test_wrenches_that_turn_with_their_bodies_have_no_real_modes() -> None:
    machine = random_machine(0, joints=5, kinds=("elastic",), friction=False)
    machine = replace(machine, source="pushed.toml")
    assert any(joint.wrench.force[0].tree != cell(0).tree for joint in machine.joints)
    with pytest.raises(InputError, match=r"pushed\.toml: modes: K is not symmetric"):
        modes(linearized(machine))


REFUSED = {
    "--at motor_z=1": "two_axis.toml: --at: no moving joint 'motor_z'; did you mean 'motor_y'?",
    "--torque motor_y=0": "equilibrium: there is none: nothing supports motor_y (1010 N)",
    "--torque bed_x=1": "--torque: bed_x has no motor: motors are motor_x, motor_y",
    "--hold ram": "--hold: ram has no motor: motors are motor_x, motor_y",
    "--hold motor_x --pd motor_x=1:1": "--pd: motor_x is held: remove --hold or --pd",
    "--pd motor_x=1": "--pd: 'motor_x=1' is not MOTOR=KP:KD",
    "--rate motor_x=1": "--rate: an equilibrium is at rest: add --as-given",
    "--value K=1": "two_axis.toml: --value: no parameter 'K'",
    "--along motor_y=0:1": "--along: 'motor_y=0:1': give LOW:HIGH:COUNT",
    "--along motor_y=0:1:20000": "--along: 20000 positions",
    "--along motor_y=0:1:3 --as-given": "--along: modes along positions are those of equilibria",
    "--along motor_y=0:1:3 --at motor_y=1": "--along: motor_y is at 1 by --at: remove one of the two",
    "--at motor_x=nan": "--at: 'motor_x=nan' is not NAME=NUMBER: nan is not finite",
    "--torque motor_x=1e300": "two_axis.toml: --torque: motor_x=1e+300 is out of range",
    "--value D4=nan": "--value: 'D4=nan' is not NAME=NUMBER: nan is not finite",
    "--pd motor_x=inf:1": "--pd: ",
    "--along ram=0:1:3": "--along: ram is not held, so its position is that of the equilibrium: give motors instead",
    "--out m.txt": "m.txt: --out: unknown format '.txt': end the name with .npz or .mat",
}


@pytest.mark.sampled(5)
@pytest.mark.parametrize("options", REFUSED)
def test_modes_refused(options: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    line = refused("modes", TWO_AXIS, *options.split())
    assert REFUSED[options] in line and "\n" not in line
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["two-axis.m", "2.m", "x.csv"])
def test_files_of_a_linearization_that_no_program_reads_are_refused(name: str, tmp_path: Path) -> None:
    line = refused("linearize", TWO_AXIS, "--out", tmp_path / name)
    reason = "end the name with .npz, .mat or .m" if name == "x.csv" else "MATLAB names the function by the file"
    assert f"{name}: --out: " in line and reason in line
    assert not list(tmp_path.iterdir())


SIGNALS = {
    "--hold all": "two_axis.toml: --input: no motor is free: name an input, such as sensor_head.fx",
    "--hold all --input tool.fx": "--output: no motor is free: name an input, such as sensor_head.x",
    "--hold motor_x --input motor_x": "--input: motor_x.tau is of a motor that is held, so nothing moves there",
    "--hold motor_x --output motor_x.qdd": "--output: motor_x.qdd is of a motor that is held, so nothing moves there",
    "--input ram": "--input: 'ram': ram has no motor",
    "--input tool.fq": "--input: 'tool.fq' is not NAME.QUANTITY",
    "--input tol.fx": "--input: 'tol.fx': no frame 'tol'; did you mean 'tool'?",
    "--output tool.q": "--output: 'tool.q': no moving joint 'tool'",
    "--output tool": "--output: 'tool' is not NAME.QUANTITY",
    "--output tool@at@(0,L9,0).x": "'L9' is not declared in [parameters]",
    "--output tool@at@(0,0).x": "a point has three coordinates",
    "--output tool@in@ram.x": "directions are axes of frame 0: leave out 'in ram'",
    "--band 10": "--band: '10': give LOW:HIGH:COUNT",
    "--band 10:1:5": "--band: from 10 to 1 Hz in 5 points",
    "--band 1:10:1000000000": "in 1000000000 points: give 1e-09 <= LOW < HIGH <= 1e+12 and 2 to 200000 points",
    "--damping -1": "--damping: -1 is not a damping ratio",
    "--out r.dat": "end the name with .csv, .npz or .mat",
    "--plots two_axis.toml": "two_axis.toml: --plots: is a file, not a folder",
}


@pytest.mark.sampled(6)
@pytest.mark.parametrize("options", SIGNALS)
def test_responses_refused(options: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "two_axis.toml").write_bytes(TWO_AXIS.read_bytes())
    words = [word.replace("@", " ") for word in options.split()]
    line = refused("response", "two_axis.toml", *words)
    assert SIGNALS[options] in line and "\n" not in line
    assert [path.name for path in tmp_path.iterdir()] == ["two_axis.toml"]


@pytest.mark.sampled(5)
@pytest.mark.parametrize(
    ("options", "said"),
    [
        ("--stroke nan", "--stroke: 'nan' is not a number: nan is not finite"),
        ("--duration 0", "--duration: 0 s is not a duration"),
        ("--duration 1e9", "--duration: 1e+09 s at 1105 Hz is too long to integrate: cut it to 45.2 s"),
        ("--ratio motor_y=20", "--ratio: motor_y is not a revolute motor with a rotor inertia"),
        ("--motion none.csv", "none.csv"),
        ("--value foo=1", "--value: no parameter 'foo'"),
        ("--value ram.mass=nan", "--value: 'ram.mass=nan' is not NAME=NUMBER: nan is not finite"),
    ],
)
def test_comparisons_refused(options: str, said: str) -> None:
    assert said in refused("compare", TWO_AXIS, *options.split())


def test_a_parameter_without_value_is_named(tmp_path: Path) -> None:
    machine = machine_of("open", slide("load", 0, Kind.ELASTIC, "M", spring=spring("K")), parameters={"M": 2, "K": 800})
    machine = replace(machine, parameters=tuple(replace(p, value=None) for p in machine.parameters))
    write_machine(machine, tmp_path / "open.toml")
    line = refused("modes", tmp_path / "open.toml")
    assert "parameters: M has no value (1 more as well): give it one in the file, or by --value M=X" in line
    found = figures("modes", tmp_path / "open.toml", "--value", "M=2", "--value", "K=800")
    assert found["frequencies"] == [pytest.approx(20 / (2 * np.pi), rel=1e-15)]
