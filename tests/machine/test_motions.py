"""Tables [motion] and [wanted]: read from scenes and machine files, written back, and refused in one line."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from symoro_elastic.formats import read_machine, read_scene
from symoro_elastic.formats.par import reading as par
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.formats.toml.motions import read_motions, read_wanted
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.described import Wanted
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import AppliedForce, Bandwidth, Gains, Move, PrescribedMotion, Wobble
from symoro_elastic.machine.scene import Scene
from tests.command_line import EXAMPLES, run
from tests.machine.samples import COUPLED, PAR

MOTION = """
[motion]
start    = { motor_x = 0, q9 = "0.05*2" }
duration = 0.25
moves    = [ { motor = "q5", by = 0.08, in = 0.15 }, { motor = "9", by = -5e-2, from = 0.1, in = 0.15 } ]
wobbles  = [ { motor = "motor_y", amplitude = 1e-3, frequency = 25 } ]
file     = "move.csv"
servo    = { motor_x = { bandwidth = 25, damping = 0.8 }, motor_y = { kp = 2e6, kd = 3e4 } }
forces   = [ { at = "tool", fx = 200, mz = -3, from = 0.1, in = 0.01 } ]
"""
WANTED = """
[wanted]
tolerance = { "tool.x" = 1e-6, "motor_x.tau" = 5 }
outputs   = ["tool.x", "tool at (0.1, 0, L12).y"]
period    = 1e-3
time      = 50e-6
"""
AS_READ = PrescribedMotion(
    duration=0.25,
    start={"motor_x": 0.0, "motor_y": 0.1},
    moves=(Move("motor_x", 0.08, 0.0, 0.15), Move("motor_y", -0.05, 0.1, 0.15)),
    wobbles=(Wobble("motor_y", 1e-3, 25.0),),
    file="move.csv",
    servo={"motor_x": Bandwidth(25.0, 0.8), "motor_y": Gains(2e6, 3e4)},
    forces=(AppliedForce("tool", (200.0, 0.0, 0.0, 0.0, 0.0, -3.0), 0.1, 0.01),),
)
AS_WANTED = Wanted({"tool.x": 1e-6, "motor_x.tau": 5.0}, ("tool.x", "tool at (0.1, 0, L12).y"), period=1e-3, time=50e-6)


@pytest.fixture
def machine() -> Machine:
    return read_machine(EXAMPLES / "two_axis.toml")[0]


def written(text: str, folder: Path) -> Path:
    (folder / "scene.toml").write_text(text, encoding="utf-8")
    return folder / "scene.toml"


def test_joints_by_any_name_and_formulas_of_numbers(machine: Machine, tmp_path: Path) -> None:
    path = written(MOTION + WANTED, tmp_path)
    assert read_motions(path, machine) == (AS_READ,)
    assert read_wanted(path) == AS_WANTED
    assert read_motions(path, machine)[0].path == tmp_path / "move.csv"


def test_several_motions(machine: Machine, tmp_path: Path) -> None:
    two = MOTION.replace("[motion]", "[[motion]]") + "[[motion]]\nduration = 1\n"
    assert read_motions(written(two, tmp_path), machine) == (AS_READ, PrescribedMotion(1.0))
    with pytest.raises(InputError, match=r"scene\.toml: motion 2, duration: 0 s is not a duration"):
        read_motions(written(two.replace("= 1\n", "= 0\n"), tmp_path), machine)


@pytest.mark.parametrize("head", ["gravity = false\n", "[scene]\ngravity = false\n"])
def test_the_scene_beside_them_is_read_as_without(head: str, machine: Machine, tmp_path: Path) -> None:
    assert read_scene(written(head + MOTION + WANTED, tmp_path), machine) == Scene(gravity=False)
    assert read_motions(written(head, tmp_path), machine) == () and read_wanted(tmp_path / "scene.toml") is None


def test_they_change_nothing_in_generated_code(tmp_path: Path) -> None:
    """Neither in a scene nor in the machine file."""
    scenes = {"with": f'fold = ["L12"]\n{MOTION}{WANTED}', "without": 'fold = ["L12"]\n'}
    example = EXAMPLES / "two_axis.toml"
    (tmp_path / "two_axis.toml").write_text(example.read_text(encoding="utf-8") + MOTION + WANTED, encoding="utf-8")
    for name, text in scenes.items():
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
        machine = tmp_path / "two_axis.toml" if name == "with" else example
        asked = ("--model", "geometric_model", "--scene", tmp_path / f"{name}.toml", "--out", tmp_path / name)
        run("generate", machine, *asked)
    files = {path.relative_to(tmp_path / "with") for path in (tmp_path / "with").rglob("*") if path.is_file()}
    assert files
    for file in files:
        assert (tmp_path / "with" / file).read_bytes() == (tmp_path / "without" / file).read_bytes()


@pytest.mark.parametrize("form", [toml, par], ids=["toml", "par"])
def test_a_machine_file_keeps_them(form, machine: Machine) -> None:
    text = (EXAMPLES / "two_axis.toml").read_text(encoding="utf-8")
    two = MOTION.replace("[motion]", "[[motion]]")
    with_both = toml.read(text + two + two.replace("0.08", "0.01") + WANTED, "two_axis.toml")
    assert [motion.moves[0].by for motion in with_both.asked.motions] == [
        0.08,
        0.01,
    ] and with_both.asked.wanted == AS_WANTED
    assert form.read(form.write(with_both), "two_axis.toml") == with_both


# Refusals


WRONG_MOTIONS = [
    ("duration = 0.25", "", "motion, duration: is missing"),
    ("duration = 0.25", "duration = -1", "motion, duration: -1 s is not a duration"),
    ("duration = 0.25", "duration = nan", "motion, duration: nan is not finite"),
    ("duration = 0.25", 'duration = "L12"', "motion, duration: 'L12' is a name: only numbers and formulas"),
    ("duration", "durration", "motion, durration: no such key here; did you mean 'duration'?"),
    ("motor_x = 0,", "motor_z = 0,", "motion, start: no joint 'motor_z'; did you mean"),
    ("motor_x = 0,", "tool = 0,", "motion, start: tool does not move by itself: independent joints are bed_yaw,"),
    ("motor_x = 0,", "motor_y = 0,", "motion, start: a joint is given twice, by two of its names"),
    ("motor_x = 0,", "motor_x = 2e9,", "motion, start, motor_x: 2e+09 is out of range: give a number up to 1e+09"),
    ('"q5"', '"motr_x"', "motion, moves 1, motor: no joint 'motr_x'; did you mean 'motor_x'?"),
    ('"q5"', '"cart_y"', "motion, moves 1, motor: cart_y has no motor: motors are motor_x, motor_y"),
    ("by = 0.08, ", "", "motion, moves 1, by: is missing"),
    ("by = 0.08", "by = inf", "motion, moves 1, by: inf is not finite"),
    ("from = 0.1, in = 0.15", "from = 0.11, in = 0.15",
     "motion, moves 2 (motor_y), in: it ends at 0.26 s, the motion at 0.25 s: move it, or give a longer duration"),
    ("from = 0.1, in = 0.15", "from = -0.1, in = 0.15",
     "motion, moves 2 (motor_y), from: -0.1 s is before the motion, which begins at 0"),
    ("in = 0.15 }, {", "in = 0 }, {", "motion, moves 1 (motor_x), in: 0 s is not a duration"),
    ("moves    = [", "moves = 3 # [", "motion, moves: must be a list of tables"),
    ("frequency = 25", "frequency = 7.9",
     "motion, wobbles 1 (motor_y), frequency: 7.9 Hz has 1.98 periods in 0.25 s, it needs 2 to fade in and out"),
    ("frequency = 25", "frequency = 0", "motion, wobbles 1 (motor_y), frequency: 0 Hz is not a frequency"),
    ("amplitude = 1e-3", "amplitude = 1e10", "motion, wobbles 1 (motor_y), amplitude: 1e+10 is out of range"),
    ("bandwidth = 25", "bandwidth = -25", "motion, servo, motor_x, bandwidth: -25 Hz is not a bandwidth"),
    ("damping = 0.8", "damping = -0.8", "motion, servo, motor_x, damping: -0.8 is negative"),
    ("kp = 2e6", "kp = -2e6", "motion, servo, motor_y, kp: -2e+06 is negative: such a servo destabilizes the motor"),
    ("kd = 3e4", "kd = -3e4", "motion, servo, motor_y, kd: -30000 is negative"),
    ("kp = 2e6, kd = 3e4", "kp = 2e6, damping = 1", "motion, servo, motor_y: give kp and kd, or bandwidth and damping"),
    ("motor_y = { kp", "ram = { kp", "motion, servo: ram has no motor: motors are motor_x, motor_y"),
    ('at = "tool"', 'at = "tol"', "motion, forces 1, at: no frame 'tol'; did you mean 'tool'?"),
    ("in = 0.01", "in = 0.2", "motion, forces 1 (tool), in: it ends at 0.3 s, the motion at 0.25 s"),
    ("fx = 200, mz = -3, ", "", "motion, forces 1 (tool): it has no component: give fx, fy, fz, mx, my, mz, or leave"),
    ("fx = 200", "fx = 1e12", "motion, forces 1 (tool): 1e+12 is out of range"),
    ("fx = 200", "force = 200", "motion, forces 1, force: no such key here"),
]  # fmt: skip
WRONG_WANTED = [
    ("5 }", "0 }", "wanted, tolerance, motor_x.tau: 0 is not a tolerance: give a positive number"),
    ("5 }", "-5 }", "wanted, tolerance, motor_x.tau: -5 is not a tolerance"),
    ("5 }", "inf }", "wanted, tolerance, motor_x.tau: inf is not finite"),
    ('{ "tool.x" = 1e-6, "motor_x.tau" = 5 }', "-1", "wanted, tolerance: -1 is not a tolerance"),
    ("period    = 1e-3", "period = 0", "wanted, period: 0 s is not a duration"),
    ("period    = 1e-3", "", "wanted, time: it is that of the steps of a period: give period too"),
    ("time      = 50e-6", "time = 2e-3", "wanted, time: 0.002 s is more than the period of 0.001 s"),
    ('["tool.x",', '[1, "tool.x",', "wanted, outputs: must be a list of texts"),
]


@pytest.mark.sampled(2)
@pytest.mark.parametrize(("old", "new", "said"), WRONG_MOTIONS, ids=[said[:50] for _, _, said in WRONG_MOTIONS])
def test_motions_refused(old: str, new: str, said: str, machine: Machine, tmp_path: Path) -> None:
    assert old in MOTION
    path = written(MOTION.replace(old, new, 1), tmp_path)
    with pytest.raises(InputError) as caught:
        read_motions(path, machine)
    assert str(caught.value).startswith(f"{path}: {said}") and "\n" not in str(caught.value)


@pytest.mark.parametrize(("old", "new", "said"), WRONG_WANTED, ids=[said[:50] for _, _, said in WRONG_WANTED])
def test_what_cannot_be_wanted_is_refused(old: str, new: str, said: str, tmp_path: Path) -> None:
    assert old in WANTED
    path = written(WANTED.replace(old, new, 1), tmp_path)
    with pytest.raises(InputError) as caught:
        read_wanted(path)
    assert str(caught.value).startswith(f"{path}: {said}") and "\n" not in str(caught.value)


def test_cut_joints_carry_no_force_and_dependent_ones_no_start() -> None:
    motion = '\n[motion]\nduration = 1\nforces = [{ at = "pin", fx = 1, in = 0.1 }]\n'
    with pytest.raises(
        InputError, match="motion, forces 1, at: pin is the cut joint of loop ring: name the frame that"
    ):
        toml.read(COUPLED + motion, "ring.toml")
    with pytest.raises(InputError, match="motion, start: rod does not move by itself"):
        toml.read(COUPLED + "\n[motion]\nduration = 1\nstart = { rod = 1 }\n", "ring.toml")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("(*! motion = 3 *)", "x.par: motion: must be"),
        ("(*! motion = {duration = 1, moves = {{motor = q2, by = 1, in = 1}}} *)", "motion, moves 1, motor: j2 has no"),
        ("(*! wanted = {tolerance = -1} *)", "x.par: wanted, tolerance: -1 is not a tolerance"),
    ],
)
def test_lines_of_par_refused(line: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        par.read(PAR + line, "x.par")
    assert said in str(caught.value)


@pytest.mark.parametrize("number", [99, -1, 9, 1])
def test_names_are_looked_up_in_machines_that_nothing_has_checked(number: int) -> None:
    motion = '\n[motion]\nduration = 1\nstart = { q1 = 1 }\nforces = [{ at = "tip", fx = 1, in = 0.1 }]\n'
    damaged = re.sub(r"antecedent = \S+,", f"antecedent = {number},", COUPLED + motion.replace("tip", "rod"), count=1)
    assert f"antecedent = {number}" in damaged
    with pytest.raises(InputError, match=r"^damaged\.toml: joint 1 .*, antecedent: "):
        check(toml.read(damaged, "damaged.toml"))
