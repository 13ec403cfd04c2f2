"""Tables of standard Denavit-Hartenberg parameters: frames by the product of their rows, inertia by Jacobians."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from symoro_elastic.formats.reading import read_machine
from symoro_elastic.formats.robots.modified_dh import machine_of
from symoro_elastic.formats.robots.standard_dh import describe
from symoro_elastic.formats.robots.toolbox import of_robot
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.formats.robots import samples as xml

Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass
class Link:
    """A link as the Robotics Toolbox has it."""

    theta: float = 0.0
    d: float = 0.0
    a: float = 0.0
    alpha: float = 0.0
    offset: float = 0.0
    sigma: int = 0
    mdh: bool = False
    m: float = 0.0
    r: Array = field(default_factory=lambda: np.zeros(3))
    I: Array = field(default_factory=lambda: np.zeros((3, 3)))  # noqa: E741
    Jm: float = 0.0
    G: float = 0.0
    B: float = 0.0
    Tc: tuple[float, float] = (0.0, 0.0)
    isflip: bool = False


def turn(axis: int, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    i, k = [other for other in range(3) if other != axis]
    T = np.eye(4)
    T[i, i] = T[k, k] = c
    T[i, k], T[k, i] = (-s, s) if axis != 1 else (s, -s)
    return T


def move(axis: int, by: float) -> Array:
    T = np.eye(4)
    T[axis, 3] = by
    return T


def frames(robot: Any, q: Array) -> tuple[list[Array], list[Array]]:
    """The frames of the links and those on the axes of the joints, by the definition of the parameters."""
    T, links, axes = np.asarray(robot.base, float), [], []
    for link, moved in zip(robot.links, q, strict=True):
        x = -moved if link.isflip else moved
        theta, d = (link.theta, link.d + x + link.offset) if link.sigma else (link.theta + x + link.offset, link.d)
        along_x, along_z = turn(0, link.alpha) @ move(0, link.a), turn(2, theta) @ move(2, d)
        axes.append(T @ along_x if link.mdh else T)
        T = T @ along_x @ along_z if link.mdh else T @ along_z @ along_x
        links.append(T)
    return links, axes


def jacobians(robot: Any, q: Array) -> Iterator[tuple[Any, Array, Array, Array]]:
    """Each link with its frame, and the Jacobians (3, n) of its centre of mass and its rotation."""
    links, axes = frames(robot, q)
    n = len(q)
    for k, (link, T) in enumerate(zip(robot.links, links, strict=True)):
        center = T[:3, :3] @ link.r + T[:3, 3]
        Jv, Jw = np.zeros((3, n)), np.zeros((3, n))
        for j in range(k + 1):
            z, o = axes[j][:3, 2] * (-1 if robot.links[j].isflip else 1), axes[j][:3, 3]
            Jv[:, j], Jw[:, j] = (z, 0) if robot.links[j].sigma else (np.cross(z, center - o), z)
        yield link, T, Jv, Jw


def inertia_matrix(robot: Any, q: Array) -> Array:
    """Sum over the links of m Jv^T Jv + Jw^T I Jw, and rotors."""
    A = np.diag([link.Jm * link.G**2 for link in robot.links])
    for link, T, Jv, Jw in jacobians(robot, q):
        A = A + link.m * Jv.T @ Jv + Jw.T @ (T[:3, :3] @ link.I @ T[:3, :3].T) @ Jw
    return A


def gravity_torques(robot: Any, q: Array) -> Array:
    """Torques that hold the links against `gravity`, the acceleration of gravity in axes of the world."""
    return -sum((link.m * Jv.T @ np.asarray(robot.gravity) for link, _, Jv, _ in jacobians(robot, q)), np.zeros(len(q)))


def random_robot(seed: int, modified: bool) -> Any:
    rng = np.random.default_rng(seed)
    quarters = np.pi / 2 * np.array([0, 1, -1, 2, 0.3])
    links = []
    for sigma in (0, 0, 1, 0, 0, 1):
        points = rng.normal(size=(5, 3)) * 0.1
        tensor = sum(((p @ p) * np.eye(3) - np.outer(p, p) for p in points), np.zeros((3, 3)))
        theta, d, a, alpha = rng.choice(quarters), *rng.choice([0, 0.1, -0.3], 2), rng.choice(quarters)
        numbers = {"Jm": 2e-4, "G": -60.0, "B": 1e-3, "Tc": (0.4, -0.4)}
        place = (theta * sigma, d, a, alpha, rng.normal(), sigma, modified)
        links.append(Link(*place, m=rng.uniform(1, 5), r=rng.normal(size=3) * 0.1, I=tensor, **numbers))
    links[1].isflip = links[5].isflip = True
    base, tool = turn(1, 0.4) @ move(0, 0.2), move(2, 0.1) @ turn(0, 1.1)
    ends = {"base": base, "tool": SimpleNamespace(A=tool)}
    return SimpleNamespace(links=links, name="random robot", gravity=[1.0, -9.0, 3.0], **ends)


@pytest.mark.parametrize("modified", [False, True], ids=["standard", "modified"])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_robots_of_the_toolbox_are_what_their_parameters_define(seed: int, modified: bool) -> None:
    pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model

    robot = random_robot(seed, modified)
    machine = of_robot(robot)
    check(machine)
    q = np.random.default_rng(seed).normal(size=6)
    tool = frames(robot, q)[0][-1] @ robot.tool.A
    assert pinocchio_model.frames(machine, q)[-1] == pytest.approx(tool, rel=0, abs=1e-13)
    wanted = inertia_matrix(robot, q)
    assert pinocchio_model.inertia_matrix(machine, q) == pytest.approx(wanted, rel=0, abs=1e-12 * wanted.max())
    held = gravity_torques(robot, q)
    assert pinocchio_model.bias_forces(machine, q, 0 * q) == pytest.approx(held, rel=0, abs=1e-12 * np.abs(held).max())
    row = machine.joints[0]
    assert machine.name == "random_robot" and [x.name for x in machine.joints][-1] == "tool"
    found = [x.value() for x in (row.rotor_inertia, row.friction.viscous, row.friction.coulomb)]
    assert found == pytest.approx([2e-4 * 3600, 1e-3 * 3600, 0.4 * 60])


def test_a_robot_without_gravity_stands_upright() -> None:
    assert gravity_of(of_robot(SimpleNamespace(links=[Link(a=1, m=1)]), "arm")) == [0, 0, -9.81]
    assert gravity_of(of_robot(SimpleNamespace(links=[Link(a=1, m=1)], gravity=[0, 0, 9.8]), "two link")) == [0, 0, 9.8]


def gravity_of(machine: Machine) -> list[float]:
    return [x.value() for x in machine.base.gravity]


PENDULUM = xml.robot(xml.link("foot"), xml.link("arm"), xml.joint("swing", "foot", "arm", axis=(0, 1, 0)), name="hung")


@pytest.mark.parametrize("stored", ["string", "file"])
def test_robots_of_a_urdf_are_read_from_it(stored: str, tmp_path: Path) -> None:
    pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model

    path = tmp_path / "hung.urdf"
    path.write_text(PENDULUM, encoding="utf-8")
    given = {"urdf_string": PENDULUM} if stored == "string" else {"urdf_string": "", "urdf_filepath": path}
    links = [SimpleNamespace(ets=1), SimpleNamespace(ets=1)]
    base = turn(1, 0.4) @ move(0, 0.2)
    read = of_robot(SimpleNamespace(links=links, name="hung", gravity=[0, 0, -9.8], tool=np.eye(4), base=base, **given))
    own = read_machine(path)[0]
    rotation = base[:3, :3]
    turned = replace(own.base, gravity=tuple(map(Formula.parse, (rotation.T @ [0, 0, -9.8]).tolist())))
    q = np.array([0.7])
    wanted = pinocchio_model.bias_forces(replace(own, base=turned), q, 0 * q)
    assert pinocchio_model.bias_forces(read, q, 0 * q) == pytest.approx(wanted, rel=1e-12)
    axis_and_origin = (base @ pinocchio_model.frames(own, q)[-1])[:, 2:]
    assert pinocchio_model.frames(read, q)[-1][:, 2:] == pytest.approx(axis_and_origin, abs=1e-14)


def test_a_tool_of_a_robot_of_a_urdf_is_refused() -> None:
    with pytest.raises(InputError, match="hung: tool: a robot of a URDF may have several ends"):
        of_robot(SimpleNamespace(links=[], name="hung", urdf_string=PENDULUM, tool=move(2, 0.1)))


def test_friction_that_differs_by_direction_is_taken_at_its_mean_and_said() -> None:
    machine = of_robot(SimpleNamespace(links=[Link(a=1, m=1, G=10, Tc=(0.5, -0.3))]), "arm")
    assert machine.joints[0].friction.coulomb.value() == pytest.approx(4.0)
    assert machine.origin.remarks == ("joint1: dry friction differs by direction: its mean is taken",)


@pytest.mark.parametrize(
    ("robot", "why"),
    [
        (SimpleNamespace(links=[Link(), Link(a="q")]), "arm: joint2: a = 'q' is not a number"),  # type: ignore[arg-type]
        (SimpleNamespace(links=[Link(d=float("inf"))]), "arm: joint1: d = 'inf' must be 1 finite numbers"),
        (SimpleNamespace(links=[Link(r=np.zeros(2))]), "arm: joint1: r = '[0. 0.]' must be 3 finite numbers"),
        (SimpleNamespace(links=[SimpleNamespace(ets=0)]), "arm: joint1: a SimpleNamespace has no Denavit-Hartenberg"),
        (SimpleNamespace(links=[Link()], gravity=(0, 9.81)), "arm: gravity: it = '(0, 9.81)' must be 3 finite numbers"),
        (SimpleNamespace(links=[], urdf_filepath="/no.urdf"), "arm: urdf_filepath: '/no.urdf' cannot be read"),
        (SimpleNamespace(links=[Link()], tool=np.eye(3)), "arm: tool: must be a matrix (4, 4)"),
    ],
)
def test_robots_that_are_no_table_are_refused(robot: Any, why: str) -> None:
    with pytest.raises(InputError) as error:
        of_robot(robot, "arm")
    assert str(error.value).startswith(why)


# CSV

TABLE = """
# an arm with a slide
# convention = standard
name, type, theta [deg], d [mm], a, alpha [deg], mass, cx, iyy, izz, rotor_inertia, ratio, viscous
turn, R,    0,           300,    0, 90,          5,    0,  0.1, 0.2, 2e-4,          100,   0.8
lift, P,    90,          0,      0, -90,         2,    ,   0.1, 0.1, ,              ,
,     ,     ,            100,    0.4, 0,         1,    -0.2, 0.02, 0.02, ,          ,
"""


def read(text: str) -> Machine:
    return machine_of(describe(text, "arm.csv"), "arm.csv")


def test_a_csv_table_is_the_robot_of_its_parameters() -> None:
    pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model

    rows = [
        Link(d=0.3, alpha=np.pi / 2, m=5, I=np.diag([0, 0.1, 0.2]), Jm=2e-4, G=100),
        Link(theta=np.pi / 2, alpha=-np.pi / 2, sigma=1, m=2, I=np.diag([0, 0.1, 0.1])),
        Link(d=0.1, a=0.4, m=1, r=np.array([-0.2, 0, 0]), I=np.diag([0, 0.02, 0.02])),
    ]
    robot, q = SimpleNamespace(links=rows, base=np.eye(4)), np.array([0.3, -0.2, 0.7])
    machine = read(TABLE)
    assert [(row.name, row.kind) for row in machine.joints] == [
        *((name, Kind.MOTOR) for name in ("turn", "lift", "joint3")),
        ("tool", Kind.FIXED),
    ]
    assert pinocchio_model.frames(machine, q)[-1] == pytest.approx(frames(robot, q)[0][-1], rel=0, abs=1e-14)
    assert pinocchio_model.inertia_matrix(machine, q) == pytest.approx(inertia_matrix(robot, q), rel=0, abs=1e-13)
    assert machine.joints[0].friction.viscous.value() == 0.8


def placed(machine: Machine, q: Array) -> dict[str, Array]:
    """The frames by name, by the generated model."""
    model = numpy_model(machine, ("geometric_model",))
    return dict(zip(model.FRAMES, model.geometric_model(q), strict=True))


MODIFIED = """# convention: modified
# gravity = [1, -9, 0.5]
name, type, theta, d, a, alpha, mass, cx
pedestal, fixed, 0.3, 0.2, 0.1, 0.4, ,
turn, R, 0.1, 0.3, 0, pi/2, 5, 0.1
lift, P, pi/2, 0.1, 0.2, -pi/2, 2, -0.2
wrist, R, 0, 0.1, 0.4, 0.7, 1, 0.3
flange, F, 0.2, 0.1, 0.05, 0.3, 0.5, 0.02
"""


def test_a_modified_table_has_fixed_rows_and_gravity_and_frames_that_are_its_own() -> None:
    """Base and tool are fixed rows; each joint has the frame that its row defines."""
    pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model

    rows = [
        Link(theta=0.3, d=0.2, a=0.1, alpha=0.4),
        Link(offset=0.1, d=0.3, alpha=np.pi / 2, m=5, r=np.array([0.1, 0, 0])),
        Link(theta=np.pi / 2, d=0.1, a=0.2, alpha=-np.pi / 2, sigma=1, m=2, r=np.array([-0.2, 0, 0])),
        Link(d=0.1, a=0.4, alpha=0.7, m=1, r=np.array([0.3, 0, 0])),
        Link(theta=0.2, d=0.1, a=0.05, alpha=0.3, m=0.5, r=np.array([0.02, 0, 0])),
    ]
    for row in rows:
        row.mdh = True
    robot = SimpleNamespace(links=rows, base=np.eye(4), gravity=[1, -9, 0.5])
    machine, q = read(MODIFIED), np.array([0.3, -0.2, 0.7])
    assert [row.name for row in machine.joints] == ["turn", "lift", "wrist", "tool"] and not machine.origin.remarks
    full = np.array([0.0, *q, 0.0])
    wanted = dict(zip(("pedestal", "turn", "lift", "wrist", "flange"), frames(robot, full)[0], strict=True))
    for name, found in placed(machine, q).items():
        assert found == pytest.approx(wanted["flange" if name == "tool" else name], rel=0, abs=1e-14)
    moving = slice(1, 4)
    A, held = inertia_matrix(robot, full)[moving, moving], gravity_torques(robot, full)[moving]
    assert pinocchio_model.inertia_matrix(machine, q) == pytest.approx(A, rel=0, abs=1e-13)
    assert pinocchio_model.bias_forces(machine, q, 0 * q) == pytest.approx(held, rel=0, abs=1e-12)


def test_rows_may_have_conventions_of_their_own() -> None:
    mixed = MODIFIED.replace("# convention: modified\n", "").replace("cx\n", "cx, convention\n")
    lines = [line + (",modified" if k > 1 else "") for k, line in enumerate(mixed.strip().splitlines())]
    q = np.array([0.3, -0.2, 0.7])
    found, wanted = placed(read("\n".join(lines)), q), placed(read(MODIFIED), q)
    assert all(found[name] == pytest.approx(wanted[name], abs=1e-15) for name in wanted)
    standard = "\n".join(line.replace("modified", "standard") for line in lines)
    assert placed(read(standard), q)["tool"] != pytest.approx(wanted["tool"], abs=1e-3)


def test_a_table_without_a_convention_says_by_which_it_is_read() -> None:
    (remark,) = read(TABLE.replace("# convention = standard\n", "")).origin.remarks
    assert remark.startswith("no convention is given: read as standard (distal) parameters")


HEADER = "name,type,theta,d,a,alpha,mass\n"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "line 1: the table needs a header line and a row"),
        (HEADER, "line 1: the table needs a header line and a row"),
        ("a,d\n1,2\n", "line 1: the column alpha is missing"),
        ("a,d,alpha,a\n1,2,3,4\n", "line 1: the column a is given twice"),
        ("a,d,alfa\n1,2,3\n", "line 1: 'alfa' is not a column of a table; did you mean 'alpha'?"),
        ("a,d [deg],alpha\n1,2,3\n", "line 1: 'd [deg]': 'deg' cannot be converted to m"),
        ("a,d,alpha,mass [gg]\n1,2,3,4\n", "line 1: 'mass [gg]': 'gg' is not a known unit"),
        (HEADER + "x,R,0,0,0,0\n", "row 1: 6 cells under 7 columns"),
        (HEADER + "x,B,0,0,0,0,0\n", "row 1: type = 'B' must be one of R, P"),
        (HEADER + "x,R,0,0,0,0,0\nx,R,0,0,nan,0,0\n", "row 2, a: 'nan': nan is not finite"),
        (HEADER + "x,R,0,0,two,0,0\n", "row 1, a: 'two': 'two' is a name"),
        (HEADER + "x,R,0,0,__import__('os'),0,0\n", "row 1, a: \"__import__('os')\": "),
        ("a,d [mm],alpha\n-1e308,100,0\n0.1,0,0\n", "joint 'joint2': placement holds a number that is not finite"),
        (HEADER + "x,R,0,0,1e60,0,0\n", "joint 'tool joint': placement holds a number that is not finite"),
        (HEADER + "x,R,0,0,0,0,-1\n", "row 1, mass: it is negative: -1"),
        (HEADER + "x,R,0,0,0,0,1\n" * 1001, "line 1000: more than 1000 rows"),
        (HEADER + "x,R,0,0,0,0,1\n" * 2, "joint 'x': the name is given twice"),
    ],
)
def test_tables_that_are_none_are_refused_by_their_place(text: str, why: str) -> None:
    with pytest.raises(InputError) as error:
        read(text)
    assert str(error.value).startswith(f"arm.csv: {why}")


def test_a_table_of_semicolons_and_decimal_commas_is_that_of_commas() -> None:
    rows = [line for line in TABLE.splitlines() if line.strip()]
    assert all('"' not in line and ";" not in line for line in rows)
    cells = [line.split(",") for line in rows]
    commas = "\n".join(";".join(re.sub(r"(?<=\d)\.(?=\d)", ",", cell) for cell in row) for row in cells)
    assert commas.count(",") > 3 and read(commas) == read(TABLE) == read("\n".join(map(";".join, cells)))
    with pytest.raises(InputError, match=r"^arm\.csv: row \d: numbers with decimal commas and with decimal points"):
        read(commas.replace(",", ".", 1))
