"""URDF of machines with rotors and springs: left out on request, with a remark that names the joints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symoro_elastic as se
from tests.command_line import refused, run

ARM = """
name = "arm"
gravity = [0, 0, -9.81]
joints = [
  { name = "waist", kind = "motor", sigma = 0, theta = "q1", r = 0.3 },
  { name = "twist", kind = "elastic", sigma = 0, theta = "q2" },
  { name = "shoulder", kind = "motor", sigma = 0, alpha = "pi/2", theta = "q3" },
  { name = "ram", kind = "elastic", sigma = 1, alpha = "pi/2", d = 0.4, r = "q4" },
]
[bodies]
waist = { mass = 3, inertia = [0.1, 0.1, 0.2] }
twist = { mass = 2, center_of_mass = [0.1, 0, 0], inertia = [0.1, 0.1, 0.2] }
shoulder = { mass = 2, center_of_mass = [0.2, 0, 0], inertia = [0.01, 0.1, 0.1] }
ram = { mass = 1, center_of_mass = [0, 0.1, 0], inertia = [0.02, 0.02, 0.02] }
SPRINGS
MOTORS
"""
SPRINGS = (
    '[springs]\ntwist = { stiffness = 1e4, neutral = 0.25 }\nram = { stiffness = 1e5, neutral = "5 mm", damping = 3 }'
)
MOTORS = "[motors]\nwaist = { rotor_inertia = 1e-4, ratio = 100 }\nshoulder = { rotor_inertia = 0.5 }"
STIFF = (
    ARM.replace(
        'name = "twist", kind = "elastic", sigma = 0, theta = "q2"', 'name = "twist", kind = "fixed", theta = 0.25'
    )
    .replace('name = "ram", kind = "elastic", sigma = 1,', 'name = "ram", kind = "fixed",')
    .replace('r = "q4"', "r = 0.005")
)
LINES = [
    "left out: the springs of twist, ram; elastic joints are fixed where these are neutral",
    "left out: the rotors of waist, shoulder, whose inertia is lost",
]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("arm.toml").write_text(ARM.replace("SPRINGS", SPRINGS).replace("MOTORS", MOTORS))
    Path("stiff.toml").write_text(STIFF.replace("SPRINGS", "").replace("MOTORS", ""))


def test_the_robot_is_the_machine_without_them() -> None:
    """Its torques are those of the table in which the joints are fixed by hand, and no rotor stands."""
    ran = run("convert", "arm.toml", "arm.urdf", "--drop", "rotors,springs")
    assert [line.removeprefix("note: ") for line in ran.stderr.splitlines()] == LINES
    state = np.array([0.3, -0.7]), np.array([0.4, 1.1]), np.array([-2.0, 0.6])
    of_robot, by_hand = (
        se.load(se.read(path, warn=lambda _: None), "inverse_dynamics").inverse_dynamics(*state)
        for path in ("arm.urdf", "stiff.toml")
    )
    np.testing.assert_allclose(of_robot[0], by_hand[0], rtol=1e-12)
    with pytest.warns(se.MachineWarning) as warned:
        se.write("arm.toml", "python.urdf", drop=["springs", "rotors"])
    assert [str(one.message) for one in warned] == LINES
    assert Path("python.urdf").read_bytes() == Path("arm.urdf").read_bytes()


def test_what_is_asked_for_is_left_out_and_no_more() -> None:
    assert "motor" not in refused("convert", "arm.toml", "arm.urdf") and not Path("arm.urdf").exists()
    assert "URDF has no springs: write .toml, or leave them out by --drop springs" in refused(
        "convert", "arm.toml", "arm.urdf", "--drop", "rotors"
    )
    assert "--drop rotors" in refused("convert", "arm.toml", "arm.urdf", "--drop", "springs")
    assert "--drop: unknown 'bodies': choose from rotors, springs, loops" in refused(
        "convert", "arm.toml", "arm.urdf", "--drop", "bodies"
    )
    assert run("convert", "stiff.toml", "same.toml", "--drop", "springs,rotors").stderr == ""
    assert se.read("same.toml").joints == se.read("stiff.toml").joints


def test_without_loops_the_tree_is_left() -> None:
    """Its torques are those of the tree in which all joints have motors; the frames that should meet are links."""
    Path("bars.toml").write_text(FOUR_BAR)
    assert "loop bars: URDF has no closed loops: write .toml, or leave them out by --drop loops" in refused(
        "convert", "bars.toml", "bars.urdf"
    )
    ran = run("convert", "bars.toml", "bars.urdf", "--drop", "loops")
    lines = [
        "left out: the loops bars (pin and end), which are open: the frames in brackets should meet",
        "joints of the loops without motors are driven like others: rod, rocker",
    ]
    assert [line.removeprefix("note: ") for line in ran.stderr.splitlines()] == lines
    text = Path("bars.urdf").read_text()
    assert all(f"<!-- {line} -->" in text for line in lines)
    Path("tree.toml").write_text(TREE)
    state = np.array([0.3, -0.7, 0.5]), np.array([0.4, 1.1, 2.0]), np.array([-2.0, 0.6, 1.0])
    of_robot, by_hand = (
        se.load(se.read(path, warn=lambda _: None), "inverse_dynamics").inverse_dynamics(*state)[0]
        for path in ("bars.urdf", "tree.toml")
    )
    np.testing.assert_allclose(of_robot, by_hand, rtol=1e-12)
    assert {"pin", "end"} <= {joint.name for joint in se.read("bars.urdf", warn=lambda _: None).joints}


FOUR_BAR = """
name = "bars"
gravity = [0, 0, -9.81]
joints = [
  { name = "crank",  kind = "motor",   sigma = 0, alpha = "pi/2", theta = "q1" },
  { name = "rod",    kind = "passive", sigma = 0, d = 0.15, theta = "q2" },
  { name = "rocker", antecedent = 0, kind = "passive", sigma = 0, alpha = "pi/2", d = 0.5, theta = "q3" },
  { name = "pin",    antecedent = "rod", kind = "cut", sigma = 0, d = 0.45, theta = "q4" },
  { name = "end",    antecedent = "rocker", kind = "fixed", d = 0.3 },
]
[loops]
bars = { cut = "pin", meets = "end", start = { q1 = 1.0, q2 = -0.6, q3 = 1.6 } }
[bodies]
crank  = { mass = 1, center_of_mass = [0.07, 0, 0], inertia = [0.001, 0.003, 0.003] }
rod    = { mass = 1, center_of_mass = [0.22, 0, 0], inertia = [0.001, 0.02, 0.02] }
rocker = { mass = 1, center_of_mass = [0.15, 0, 0], inertia = [0.001, 0.01, 0.01] }
"""
TREE = (
    FOUR_BAR.replace("passive", "motor")
    .replace('kind = "cut", sigma = 0, d = 0.45, theta = "q4"', 'kind = "fixed", d = 0.45')
    .replace("[loops]", "")
    .replace("bars = {", "# ")
)


def test_springs_beside_motors_are_left_out_and_the_motors_stay() -> None:
    """MJCF has both on a joint."""
    pytest.importorskip("mujoco")
    from tests.formats.robots.mjcf_samples import SPRUNG_MOTORS

    turned = SPRUNG_MOTORS.replace("1 -2 -9", "0 0 -9.81")
    Path("sprung.xml").write_text(turned)
    Path("bare.xml").write_text(turned.replace('stiffness="40"', "").replace('stiffness="200"', ""))
    ran = run("convert", "sprung.xml", "sprung.urdf", "--drop", "springs,rotors")
    assert "left out: the springs of j1, j2, j3" in ran.stderr
    run("convert", "bare.xml", "bare.urdf", "--drop", "rotors")
    first, second = (se.read(path, warn=lambda _: None) for path in ("sprung.urdf", "bare.urdf"))
    assert first.joints == second.joints
