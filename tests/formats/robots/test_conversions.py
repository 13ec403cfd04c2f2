"""Springs behind motors, snapped tables and names, by the commands that users give."""

from __future__ import annotations

import tomllib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.formats.format import Conversion, SpringOnJoint
from symoro_elastic.formats.reading import read
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.valid_names import with_valid_names
from symoro_elastic.models.packaging import reserved_words
from tests.command_line import EXAMPLES, ended, refused, run
from tests.formats.robots.samples import ARM, GRIPPER, joint, link, robot

SKEW = robot(
    *map(link, "abc"), joint("one", "a", "b", rpy=(1.57079632679, 0, 0)), joint("two", "b", "c", xyz=(0, 1e-11, 1))
)


@pytest.fixture(autouse=True)
def _in_a_folder_with_robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text in (("arm", ARM), ("gripper", GRIPPER), ("skew", SKEW)):
        Path(f"{name}.urdf").write_text(text, encoding="utf-8")


def test_a_spring_stands_behind_the_motor_of_its_joint() -> None:
    """A of the elastic arm is that of the rigid one for the sum of both positions, and the rotor's."""
    pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model

    rigid = read("arm.urdf")
    springs = {"elbow": SpringOnJoint(4e4, 0.3), "slide": SpringOnJoint(9e6, 20.0)}
    elastic = read("arm.urdf", conversion=Conversion(springs=springs))
    kinds = {row.name: row.kind for row in elastic.joints if row.kind is not Kind.FIXED}
    assert [*kinds] == ["waist", "shoulder", "elbow", "elbow_spring", "slide", "slide_spring"]
    assert [name for name, kind in kinds.items() if kind is Kind.ELASTIC] == ["elbow_spring", "slide_spring"]
    rows = {row.name: row for row in elastic.joints}
    assert rows["elbow"].body.mass.is_zero and rows["elbow_spring"].spring.stiffness.value() == 4e4
    assert rows["slide"].friction.viscous.value() == 12.0 and rows["slide_spring"].friction.viscous.is_zero
    sums = np.array([[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 1, 1, 0, 0], [0, 0, 0, 0, 1, 1]])
    q = np.array([0.3, -0.4, 0.7, 0.02, 0.1, 0.01])
    wanted = sums.T @ pinocchio_model.inertia_matrix(rigid, sums @ q) @ sums + np.diag([0, 0, 0.3, 0, 20.0, 0])
    assert pinocchio_model.inertia_matrix(elastic, q) == pytest.approx(wanted, rel=0, abs=1e-12 * wanted.max())


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (("--elastic", "elbo=4e4:1"), "arm.urdf: --elastic: no moving joint 'elbo'; did you mean 'elbow'?"),
        (("--elastic", "flange=4e4:1"), "arm.urdf: --elastic: no moving joint 'flange'"),
        (
            ("--elastic", "elbow=4e4"),
            "arm.urdf: joint 'elbow': its motor would have no inertia: give --elastic elbow=K:IA",
        ),
        (("--elastic", "elbow"), "symoro-elastic: --elastic: 'elbow' is not JOINT=K or JOINT=K:IA"),
        (
            ("--elastic", "elbow=0:1"),
            "arm.urdf: joint 'elbow': --elastic elbow: stiffness and inertia of the rotor must",
        ),
        (("--elastic", "elbow=1:-1"), "arm.urdf: joint 'elbow': --elastic elbow: stiffness and"),
        (("--elastic", "elbow=1:2:3"), "symoro-elastic: --elastic: 'elbow=1:2:3' is not JOINT=K or JOINT=K:IA"),
    ],
)
def test_joints_that_cannot_be_split_are_refused(options: tuple[str, ...], why: str) -> None:
    assert refused("convert", "arm.urdf", "out.toml", *options).startswith(why)
    assert not Path("out.toml").exists()


def test_joints_that_follow_others_or_are_followed_are_not_split() -> None:
    said = refused("convert", "gripper.urdf", "out.toml", "--elastic", "right_finger=1:1")
    assert said.startswith("gripper.urdf: joint 'right_finger': it has no motor")
    said = refused("convert", "gripper.urdf", "out.toml", "--elastic", "left_finger=1:1")
    assert said.startswith("gripper.urdf: joint 'left_finger': joint 'right_finger' follows it")


def test_other_machines_are_not_converted() -> None:
    said = refused("convert", EXAMPLES / "planar_2r.toml", "out.toml", "--elastic", "a=1:1")
    assert said.endswith("file: --elastic is for robots as links and joints, not for TOML files")


def test_xacro_files_are_to_be_expanded() -> None:
    Path("arm.urdf.xacro").write_text(ARM, encoding="utf-8")
    said = refused("show", "arm.urdf.xacro")
    assert said == "arm.urdf.xacro: file: xacro, not URDF: expand it first, by `xacro FILE > robot.urdf`"


def test_snapping_says_both_errors_and_simplifies() -> None:
    found = ended("convert", "skew.urdf", "out.toml", "--snap")
    assert found.code == 0 and found.out == "wrote out.toml\n"
    (line,) = [line for line in found.err.splitlines() if "snapped" in line]
    assert line.startswith(
        "warning: angles and lengths are snapped within 1e-09: frames at position 0 are up to 4.9e-12 rad"
    )
    assert line.split("exact table ")[1].startswith(("0.0e+00 rad", "1.")), line
    written = tomllib.loads(Path("out.toml").read_text(encoding="utf-8"))
    assert [row["alpha"] for row in written["joints"]] == ["pi/2", 0]
    assert line.removeprefix("warning: ") in written["notes"]
    run("convert", "skew.urdf", "exact.toml")
    exact = tomllib.loads(Path("exact.toml").read_text(encoding="utf-8"))
    assert exact["joints"][0]["alpha"] == 1.57079632679


def test_a_tolerance_may_be_given() -> None:
    for tolerance, alphas in (("1e-13", [1.57079632679]), ("1e-6", ["pi/2"])):
        run("convert", "skew.urdf", "out.toml", "--snap", tolerance, "--force")
        rows = tomllib.loads(Path("out.toml").read_text(encoding="utf-8"))["joints"]
        assert [row["alpha"] for row in rows[:1]] == alphas
    for tolerance in ("0", "-1", "0.5", "nan", "x"):
        assert ended("convert", "skew.urdf", "out.toml", "--snap", tolerance, "--force").code == 2


@pytest.mark.sampled(2)
@pytest.mark.parametrize("command", [("show",), ("generate",), ("linearize",), ("equations", "--model", "bias_forces")])
def test_commands_read_robots(command: tuple[str, ...]) -> None:
    name, *options = command
    found = ended(name, "arm.urdf", *options)
    assert found.code == 0, found.err
    assert (
        found.err.splitlines()[0]
        == "warning: meshes, package:// and others, are not read: a model needs masses; view draws those it finds"
    )


def test_robots_go_through_all_formats() -> None:
    run("convert", "arm.urdf", "arm.toml")
    run("convert", "arm.toml", "again.urdf")
    run("convert", "again.urdf", "again.toml")
    first, second = (read_machine(name)[0] for name in ("arm.toml", "again.toml"))
    assert [row.name for row in first.joints] == [row.name for row in second.joints]
    said = refused("convert", "arm.urdf", "out.csv")
    assert said == "out.csv: FILE: DH table files can be read, but not written: use .toml, .par, .urdf or .xml"


def test_python_reads_robots_and_converts_them() -> None:
    import symoro_elastic as se

    with pytest.warns(se.MachineWarning, match="angles and lengths are snapped within 1e-09"):
        machine = se.read("skew.urdf", snap=1e-9, elastic={"one": (2e3, 0.1), "two": [1e3, 0.2]})
    assert [row.kind.value for row in machine.joints] == ["motor", "elastic"] * 2
    with pytest.raises(se.InputError, match=r"symoro_elastic: snap: 0\.5 is not a tolerance"):
        se.read("arm.urdf", snap=0.5)
    link = SimpleNamespace(a=0.4, mdh=True, m=2.0, r=[0.2, 0, 0], I=np.eye(3))
    with pytest.warns(se.MachineWarning, match="'for' is for_"):
        arm = se.read(SimpleNamespace(name="for", links=[link, link]))
    assert arm.name == "for_" and len(arm.independent) == 2


# Names


def named(*names: str, machine: str = "robot") -> Machine:
    rows = [Joint(name, j, Kind.MOTOR, 0, f"q{j + 1}") for j, name in enumerate(names)]
    return DescribedMachine(machine, tuple(rows))


def test_names_that_code_cannot_take_are_changed_and_said() -> None:
    """Intermediate quantities, double underscores, keywords, models, names twice, variables of others."""
    given = ("g1_left", "iris__rotor_0", "for", "inertia_matrix", "a-b", "a_b", "q2", "ä", "q8_", "x" * 80)
    found = with_valid_names(named(*given, machine="3 arms!"), reserved_words())
    names = [row.name for row in found.joints]
    assert len({*names}) == len(names) and names[5] == "a_b" and names[4] != "a_b"
    assert with_valid_names(found, reserved_words()) == found
    (remark,) = found.origin.remarks
    assert remark.startswith("names that are invalid in generated code are changed: '3 arms!' is ")
    assert "'iris__rotor_0' is iris_rotor_0" in remark and "'q2' is" in remark


def test_valid_names_stay() -> None:
    machine = named("waist", "elbow", "q3")
    assert with_valid_names(machine, reserved_words()) == machine and with_valid_names(machine).origin.remarks == ()


def test_what_follows_keeps_its_variable_when_names_change() -> None:
    rows = (Joint("tau", 0, Kind.MOTOR, 0, "q1"), Joint("all", 1, Kind.COUPLED, 0, theta=Formula.parse("2*q1")))
    found = with_valid_names(DescribedMachine("robot", rows), reserved_words())
    assert [row.name for row in found.joints] == ["tau_", "all_"] and found.joints[1].theta.text == "2*q1"
