"""The command simulate: what it prints, writes and refuses, and who reads what it writes."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.analysis.simulation.compiled_steps import CompiledSteps
from symoro_elastic.foundation.array_types import Array
from tests.cli.test_every_command import ODD
from tests.closed_chains.machines import FILES
from tests.command_line import EXAMPLES, Ended, ended, refused, run

MACHINE = """
joints = [
  { name = "motor", kind = "motor", sigma = 1, r = "q1" },
  { name = "load", kind = "elastic", sigma = 1, r = "q2" },
  { name = "tool", kind = "fixed" },
]
[bodies]
motor = { mass = 3 }
load = { mass = "M2" }
[springs]
load = { stiffness = 2e4, damping = 10 }
[parameters]
M2 = 5
"""
MOTION = """
[motion]
duration = 0.25
moves = [{ motor = "motor", by = 0.05, in = 0.15 }]
"""
SERVO = "servo = { motor = { bandwidth = 20, damping = 0.8 } }\n"
FORCES = 'forces = [{ at = "tool", fz = 100, in = 0.1 }]\n'
WANTED = '[wanted]\ntolerance = 1e-6\noutputs = ["tool.z"]\n'


@pytest.fixture(autouse=True)
def _in_a_folder_with_a_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drive.toml").write_text(MACHINE)


def scene(text: str = MOTION + WANTED) -> tuple[str, ...]:
    Path("scene.toml").write_text(text)
    return ("drive.toml", "--scene", "scene.toml")


def simulated(text: str, *options: str) -> list[dict[str, object]]:
    found: list[dict[str, object]] = json.loads(run("simulate", *scene(text), *options, "--json").stdout)["motions"]
    return found


def columns(path: str) -> dict[str, Array]:
    names = Path(path).read_text().split("\n", 1)[0].split(",")
    return dict(zip(names, np.loadtxt(path, delimiter=",", skiprows=1).T, strict=True))


@pytest.mark.thorough
def test_error_is_within_the_tolerance_and_was_predicted() -> None:
    """Both are estimates of the same error: within a factor of 2, as the prediction promises."""
    (found,) = simulated(MOTION + WANTED)
    error, predicted = found["errors"]["tool.z"], found["predicted"]["tool.z"]  # type: ignore[index]
    assert found["within_tolerance"] and error <= 1e-6 and 0.5 < error / predicted < 2


@pytest.mark.thorough
def test_table_says_method_steps_errors_energy_and_damped_vibrations() -> None:
    text = run("simulate", *scene(), "--method", "w3").stdout
    for said in ("w3", "operations", "tool.z, m", "1.00e-06", "ok", "J put in", "are damped, not followed"):
        assert said in text


@pytest.mark.thorough
def test_exit_code_is_one_above_a_wanted_tolerance_only() -> None:
    coarse = ("--method", "w2", "--step", "0.01")
    assert ended("simulate", *scene(), *coarse).code == 1
    assert ended("simulate", *scene(MOTION), *coarse).code == 0


@pytest.mark.thorough
def test_motion_may_stand_in_the_machine_file() -> None:
    Path("drive.toml").write_text(MACHINE + MOTION)
    assert "load.q, m" in run("simulate", "drive.toml", "--step", "1e-3").stdout


@pytest.mark.thorough
def test_values_of_parameters_change_the_motion() -> None:
    light, heavy = (simulated(MOTION, "--step", "1e-3", "--value", f"M2={x}")[0] for x in (1, 20))
    assert heavy["largest_deviation"]["load.q"] > 3 * light["largest_deviation"]["load.q"]  # type: ignore[index]


@pytest.mark.thorough
def test_locked_joints_are_left_out() -> None:
    """A rigid drive under a servo: its motor is the only joint."""
    (found,) = simulated(MOTION + SERVO + "[scene]\nlocked = { load = 0 }\n", "--step", "1e-3")
    assert list(found["errors"]) == ["motor.q"]  # type: ignore[call-overload]


@pytest.mark.thorough
def test_periods_hold_whole_numbers_of_steps() -> None:
    text = MOTION + SERVO + WANTED + "period = 1e-2\ntime = 5e-3\n"
    (found,) = simulated(text, "--method", "w3")
    whole = 1e-2 / found["step"]  # type: ignore[operator]
    assert whole > 1 and abs(whole - found["steps_of_period"]) < 1e-9  # type: ignore[operator]
    said = run("simulate", *scene(text), "--step", "2.5e-3").stdout
    assert "a period of 10 ms needs 4 steps" in said and "within the 5 ms that [wanted] allows" in said


# Files


@pytest.mark.thorough
def test_several_motions_have_a_block_and_files_each() -> None:
    two = MOTION.replace("[motion]", "[[motion]]") + MOTION.replace("[motion]", "[[motion]]").replace("0.05", "0.02")
    text = run("simulate", *scene(two), "--step", "1e-3", "--out", "move.csv").stdout
    assert "motion 1" in text and "motion 2" in text and not Path("move.csv").exists()
    assert columns("move_1.csv")["q_motor"][-1] == 0.05 and columns("move_2.csv")["q_motor"][-1] == 0.02
    assert "move_1.csv: --out: exists already" in refused("simulate", *scene(two), "--out", "move.csv")


def test_identify_reads_what_is_written_and_finds_the_masses() -> None:
    """Its filters leave some 1e-4 of the masses."""
    run("simulate", *scene(MOTION + SERVO), "--method", "w3", "--step", "1e-3", "--out", "move.csv")
    assert list(columns("move.csv")) == [
        "t",
        "q_motor",
        "q_load",
        "qd_motor",
        "qd_load",
        "qdd_motor",
        "qdd_load",
        "tau_motor",
        "power_motor",
        "energy_kinetic",
        "energy_gravity",
        "energy_elastic",
    ]
    Path("drive.toml").write_text(MACHINE.replace("mass = 3", 'mass = "M1"').replace("M2 = 5", "M1 = 1\nM2 = 1"))
    text = run("identify", "drive.toml", "move.csv").stdout
    masses = [float(re.findall(rf"^{name} +1 +([\d.]+)", text, re.MULTILINE)[0]) for name in (r"M1 \+ IA1", "M2")]
    assert masses == pytest.approx([3, 5], rel=1e-3)


@pytest.mark.thorough
def test_compare_reads_what_is_written_and_plots_are_drawn() -> None:
    run("simulate", *scene(), "--step", "1e-3", "--out", "move.npz", "--plots", "plots")
    named = {"outputs", "deviation", "torques", "powers", "torque_speed", "spectrum", "energy"}
    assert {path.stem for path in Path("plots").iterdir()} == named
    found = json.loads(run("compare", "drive.toml", "--motion", "move.npz", "--json").stdout)
    assert "move.npz" in json.dumps(found)


def test_an_interrupted_run_writes_nothing_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(CompiledSteps, "_call", interrupted)
    found = ended("simulate", *scene(), "--step", "1e-3", "--out", "move.csv", "--plots", "plots")
    assert (found.code, found.out) == (130, "") and "note: interrupted, nothing was written\n" in found.err
    assert sorted(path.name for path in Path().iterdir()) == ["drive.toml", "scene.toml"]


# Steps that are adapted


def test_adapted_steps_find_events_and_stop_there() -> None:
    """The move is symmetric: at half of its time it has made half of its way, with its largest velocity 35/16 by/in."""
    (found,) = simulated(MOTION + WANTED, "--adaptive", "--event", "motor.q=0.025", "--event", "motor.qd=0.5")
    events = {(x["signal"], x["upwards"]): x["t"] for x in found["events"]}  # type: ignore[attr-defined]
    assert found["within_tolerance"] and events.keys() == {("motor.q", True), ("motor.qd", True), ("motor.qd", False)}
    assert events["motor.q", True] == pytest.approx(0.075, abs=1e-12)
    assert events["motor.qd", True] + events["motor.qd", False] == pytest.approx(0.15, abs=1e-12)
    run("simulate", *scene(), "--adaptive", "--event", "motor.q=0.025", "--stop", "--out", "move.csv")
    assert columns("move.csv")["t"][-1] == pytest.approx(0.075, abs=1e-12)


@pytest.mark.thorough
def test_adapted_steps_take_forces() -> None:
    """At rest again the force is that of the spring, and of the motor."""
    text = MOTION.replace("0.25", "0.6") + FORCES + WANTED
    run("simulate", *scene(text), "--adaptive", "--value", "M2=0.1", "--out", "move.csv")
    found = columns("move.csv")
    assert found["q_load"][-1] == pytest.approx(100 / 2e4, rel=1e-6)
    assert found["tau_motor"][-1] == pytest.approx(-100, rel=1e-6)


# Refusals


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        (MOTION, ("--step", "0"), "scene.toml: --step: 0 s is not a time"),
        (MOTION, ("--step", "-1"), "-1 s is not a time: give a positive number"),
        (MOTION, ("--step", "nan"), "--step: 'nan' is not a number"),
        (
            MOTION,
            ("--step", "1e-13"),
            "2.5e+12 steps, some 694 h of work: 1e+08 is the limit, so give at least 2.5e-09 s",
        ),
        (MOTION.replace("0.25", "1e9"), (), "steps, some"),
        (MOTION, ("--method", "rk5"), "--method: unknown 'rk5': choose from w3, w2, rk4, rodas4, midpoint"),
        (
            MOTION + WANTED + "period = 3e-3",
            (),
            "wanted, period: 0.003 s is not a whole part of the motion of 0.25 s: make its duration 0.249 s",
        ),
        (
            MOTION + WANTED + "period = 1e-2",
            ("--step", "3e-3"),
            "--step: 0.003 s is not a whole part of the period of 0.01 s: give 0.0025 s",
        ),
        (
            MOTION + WANTED + "period = 5e-2",
            ("--step", "0.1", "--method", "rk4"),
            "--step: 0.1 s is not a whole part of the period of 0.05 s: give 0.025 s",
        ),
        (
            MOTION.replace("0.25", "1e9") + WANTED + "period = 1e-3",
            (),
            "1.33e+11 steps, some 37 h, 5e+06 is the limit; give at most 3.73e+04 s, or leave that part out",
        ),
        (MOTION, ("--event", "motor.q=0.1"), "--event: even steps find no events: add --adaptive"),
        (MOTION, ("--adaptive", "--stop"), "--stop: needs an event: name one by --event"),
        (MOTION, ("--adaptive", "--step", "1e-3"), "--adaptive: choose even steps (--method, --step) or adapted ones"),
        (
            MOTION,
            ("--adaptive", "--event", "motor.qdd=1"),
            "--event: motor.qdd is not a position or velocity of a joint",
        ),
        (MOTION, ("--adaptive", "--event", "moter.q=1"), "no moving joint 'moter'"),
        ("", (), "scene.toml: motion: missing: write a table [motion] with duration and moves"),
        (MOTION + "[scene]\nlocked = { motor = 0 }\n", (), "motor is locked by the scene"),
    ],
)
def test_refused_in_one_line(text: str, options: tuple[str, ...], said: str) -> None:
    assert said in refused("simulate", *scene(text), *options)
    assert not Path("move.csv").exists()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (MOTION + WANTED + "period = 3e-3", "wanted, period: 0.003 s is not a whole part of the motion of 0.25 s"),
        (MOTION + WANTED + "[scene]\nlocked = { load = 0 }\n", "every joint is a motor that follows exactly"),
    ],
)
def test_the_ladder_refuses_the_same_before_it_predicts(text: str, said: str) -> None:
    assert said in refused("ladder", *scene(text))


@pytest.mark.thorough
def test_forces_on_frames_in_even_steps() -> None:
    """100 N bend the spring of 2e4 N/m by 5 mm, and by twice that at most while it swings."""
    (found,) = simulated(
        MOTION.replace("0.25", "0.6").replace("by = 0.05", "by = 1e-6") + FORCES + WANTED, "--method", "w3"
    )
    assert found["within_tolerance"] and found["method"] == "w3"
    assert 5e-3 < found["largest_deviation"]["tool.z"] < 1e-2  # type: ignore[index]


def test_explicit_steps_beyond_their_limit_are_refused_with_the_largest() -> None:
    """|1 + z + z^2/2 + z^3/6 + z^4/24| = 1 for z = pole h; the limit is printed with three digits."""
    said = refused("simulate", *scene(), "--method", "rk4", "--step", "0.1")
    largest = float(re.findall(r"give at most ([\d.e-]+) s", said)[0])
    pole = np.roots([5, 10, 2e4])[0]
    below, above = (abs(np.polyval([1 / 24, 1 / 6, 1 / 2, 1, 1], pole * largest * x)) for x in (0.995, 1.005))
    assert below < 1 < above


@pytest.mark.parametrize(
    ("machine", "motor", "said"),
    [
        (ODD["floating"].replace("body =", 'known = "acceleration"\nbody ='), "a", "base, known: the acceleration"),
        (ODD["all_elastic"], "a", "no joint has a motor"),
    ],
)
def test_machines_that_are_not_simulated_are_named(machine: str, motor: str, said: str) -> None:
    Path("drive.toml").write_text(machine)
    assert said in refused("simulate", *scene(MOTION.replace('"motor"', f'"{motor}"')))


GANTRY = """
[motion]
duration = 0.1
moves = [{ motor = "carriage_1", by = 0.02, in = 0.08 }, { motor = "carriage_2", by = 0.02, in = 0.08 }]
[motion.servo]
carriage_1 = { kp = 1e6, kd = 2e4 }
carriage_2 = { kp = 1e6, kd = 2e4 }
cross_slide = { bandwidth = 20, damping = 0.8 }
ram = { bandwidth = 20, damping = 0.8 }
[wanted]
tolerance = { "carriage_2.q" = 1e-6 }
period = 1e-3
time = 1e-3
"""


@pytest.mark.thorough
def test_motors_that_follow_from_loops_are_simulated_and_written() -> None:
    """A period of a controller too; `compare` reads the motion of the motors, dependent ones among them."""
    text = re.sub(r"coulomb = \d+", "coulomb = 0", FILES["gantry_rigid"].read_text())
    Path("drive.toml").write_text(text)
    said = run("simulate", *scene(GANTRY), "--out", "move.csv").stdout
    assert "a period of 1 ms needs 2 steps" in said and "carriage_2.q, m" in said
    written = columns("move.csv")
    np.testing.assert_allclose(written["q_carriage_2"], written["q_carriage_1"], rtol=0, atol=1e-15)
    assert {"qdd_carriage_2", "tau_carriage_1", "tau_carriage_2", "q_ram"} <= written.keys()
    assert "carriage_2" in run("compare", "drive.toml", "--motion", "move.csv").stdout


def test_nothing_moves_without_motors() -> None:
    Path("drive.toml").write_text(ODD["all_elastic"])
    assert "no joint has a motor" in refused("simulate", *scene("[motion]\nduration = 1\n"))


def test_par_files_hold_no_motion() -> None:
    assert "give --scene FILE" in refused("simulate", EXAMPLES / "four_bar.par")


@pytest.mark.thorough
def test_loops_and_couplings_are_simulated_without_a_prediction() -> None:
    """A ball screw with elastic parts, a linkage; the table says that nothing was predicted."""
    text = (
        MOTION.replace("moves = [", "moves = []\n#")
        + 'wobbles = [{ motor = "drive", amplitude = 0.01, frequency = 20 }]\n'
    )
    Path("scene.toml").write_text(text)
    found: Ended = ended("simulate", EXAMPLES / "linkage.toml", "--scene", "scene.toml", "--json")
    (motion,) = json.loads(found.out)["motions"]
    assert found.code == 0 and motion["within_tolerance"] and motion["predicted"] == {}
