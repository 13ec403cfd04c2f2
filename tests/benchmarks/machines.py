"""The machines of the benchmarks, with values for every parameter; deterministic.

Bodies have all ten inertial parameters. Joints are in depth-first order, the order of every peer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from symoro_elastic.formats import read_machine
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Base, Body, Joint, Kind, Machine, Parameter, Spring
from symoro_elastic.models.parameters.base_parameters import base_grouping

EXAMPLES = Path(__file__).parents[2] / "examples"
WEIGHT = Base(gravity=(ZERO, ZERO, Formula.parse("-9.81")))
BODY = ("M", "MX", "MY", "MZ", "XX", "XY", "XZ", "YY", "YZ", "ZZ")


def arm_6() -> Machine:
    """RX90, rotor inertias included."""
    machine = example("rx90.par")
    values = {"D3": 0.45, "RL4": 0.45, "G3": -9.81}
    for j, (mass, size) in enumerate(((20, 0.3), (18, 0.45), (11, 0.35), (7, 0.4), (2.5, 0.15), (0.8, 0.1)), start=1):
        values |= body_values(j, mass, size) | {f"IA{j}": round(0.6 / j, 4)}
    valued = [replace(p, value=Formula.parse(values[p.name])) for p in machine.parameters]
    return replace(machine, parameters=tuple(valued))


def arm_7() -> Machine:
    """An arm of 7 revolute joints, shoulder, elbow and wrist spherical."""
    alpha = ("0", "pi/2", "-pi/2", "-pi/2", "pi/2", "pi/2", "-pi/2")
    length = (0.34, 0, 0.4, 0, 0.4, 0, 0.13)
    mass = (5, 6, 4, 4, 3, 2.5, 0.8)
    rows = [Row(f"joint{j}", j - 1, alpha[j - 1], r=length[j - 1], mass=mass[j - 1]) for j in range(1, 8)]
    return built("arm_7", rows)


def humanoid() -> Machine:
    """29 revolute joints on a held pelvis: legs of 6, waist of 3, arms of 7."""
    rows: list[Row] = []
    for side, sign in (("left", 1), ("right", -1)):
        rows += limb(f"{side}_leg", LEG, 0, len(rows), sign)
    rows += limb("waist", WAIST, 0, len(rows), 1)
    chest = len(rows)
    for side, sign in (("left", 1), ("right", -1)):
        rows += limb(f"{side}_arm", ARM, chest, len(rows), sign)
    return built("humanoid", rows)


def quadruped() -> Machine:
    """15 revolute joints: a trunk on three, and four legs of 3."""
    rows = [*limb("trunk", WAIST, 0, 0, 1)]
    trunk = len(rows)
    for end, sign in (("front", 1), ("hind", -1)):
        for side in ("left", "right"):
            rows += limb(f"{end}_{side}", LEG_OF_FOUR, trunk, len(rows), sign if side == "left" else 1.1 * sign)
    return built("quadruped", rows)


def two_axis() -> Machine:
    """The machine tool of the paper: two motors, ten springs."""
    return example("two_axis.toml")


def elastic_arm() -> Machine:
    """Four revolute joints, the second and the fourth elastic."""
    machine = example("flex4.par")
    values = {"L2": 0.4, "G3": -9.81, "k2": 4e4, "k4": 9e3, "IA1": 0.3, "IA3": 0.1}
    for j, mass in enumerate((8, 6, 3, 1), start=1):
        values |= body_values(j, mass, 0.3)
    valued = [replace(p, value=Formula.parse(values[p.name])) for p in machine.parameters]
    return replace(machine, parameters=tuple(valued))


def rigid(machine: Machine) -> Machine:
    """The same bodies and joints, a motor at every joint and no spring."""
    joints = [
        joint if joint.sigma == 2 else replace(joint, kind=Kind.MOTOR, spring=Spring()) for joint in machine.joints
    ]
    return replace(machine, name=f"{machine.name}_rigid", joints=tuple(joints))


def chain(n: int) -> Machine:
    """A general serial chain: alpha 0 and quarter turns, d and r, all ten inertial parameters and Ia, symbolic."""
    alpha = ("0", "pi/2", "-pi/2")
    rows = [Row(f"joint{j}", j - 1, alpha[(j - 1) % 3], d=0.2, r=0.15) for j in range(2, n + 1)]
    return built(f"chain{n}", [Row("joint1", 0, "0"), *rows])


def with_base_parameters(machine: Machine) -> Machine:
    """The machine with base inertial parameters, and their values."""
    return base_grouping(machine).machine


MACHINES: dict[str, Callable[[], Machine]] = {
    "6R arm": arm_6,
    "7R arm": arm_7,
    "humanoid, 29 joints": humanoid,
    "quadruped, 15 joints": quadruped,
    "two-axis machine": two_axis,
}


def example(name: str) -> Machine:
    machine, _ = read_machine(EXAMPLES / name)
    return machine


class Row:
    """What a builder tells of a joint; the rest follows from it."""

    def __init__(
        self, name: str, antecedent: int, alpha: str, *, d: float = 0, r: float = 0, b: float = 0, mass: float = 2
    ) -> None:
        self.name, self.antecedent, self.alpha = name, antecedent, alpha
        self.d, self.r, self.b, self.mass = d, r, b, mass


Part = tuple[str, str, float, float, float]
"""Name, alpha, d, r, mass."""
LEG: tuple[Part, ...] = (
    ("hip_yaw", "0", 0.09, -0.1, 1.4),
    ("hip_roll", "pi/2", 0, 0, 2.2),
    ("hip_pitch", "-pi/2", 0, 0.05, 4.5),
    ("knee", "0", 0.32, 0, 2.6),
    ("ankle_pitch", "0", 0.3, 0, 0.3),
    ("ankle_roll", "pi/2", 0, 0, 0.8),
)
LEG_OF_FOUR: tuple[Part, ...] = (
    ("hip_roll", "pi/2", 0.2, 0.05, 0.7),
    ("hip_pitch", "-pi/2", 0.08, 0.1, 1.2),
    ("knee", "0", 0.21, 0, 0.3),
)
WAIST: tuple[Part, ...] = (
    ("yaw", "0", 0, 0.08, 0.8),
    ("roll", "pi/2", 0, 0, 0.7),
    ("pitch", "-pi/2", 0, 0.04, 11.0),
)  # fmt: skip
ARM: tuple[Part, ...] = (
    ("shoulder_pitch", "pi/2", 0.25, 0.12, 0.8),
    ("shoulder_roll", "pi/2", 0, 0, 0.9),
    ("shoulder_yaw", "-pi/2", 0, 0.2, 0.8),
    ("elbow", "pi/2", 0.02, 0, 0.7),
    ("wrist_roll", "-pi/2", 0, 0.18, 0.4),
    ("wrist_pitch", "pi/2", 0, 0, 0.4),
    ("wrist_yaw", "-pi/2", 0.04, 0, 0.3),
)


def limb(name: str, parts: Sequence[Part], antecedent: int, before: int, sign: float) -> Iterator[Row]:
    """Rows of a limb that hangs on a body; the first one is mirrored by `sign`."""
    for k, (part, alpha, d, r, mass) in enumerate(parts):
        on = antecedent if k == 0 else before + k
        yield Row(f"{name}_{part}", on, alpha, d=d * (sign if k == 0 else 1), r=r, mass=mass)


def built(name: str, rows: Sequence[Row]) -> Machine:
    """The machine of these rows; lengths, bodies and rotor inertias are parameters with values."""
    values: dict[str, float] = {}

    def cell(parameter: str, value: float) -> Formula:
        if value:
            values[parameter] = value
        return Formula.parse(parameter) if value else ZERO

    joints = []
    for j, row in enumerate(rows, start=1):
        d, r = cell(f"D{j}", row.d), cell(f"R{j}", row.r)
        mass, x, y, z, *inertia = [cell(k, v) for k, v in body_values(j, row.mass, 0.25).items()]
        xx, xy, xz, yy, yz, zz = inertia
        rotor = cell(f"IA{j}", round(0.05 * row.mass, 4))
        body = Body(mass, (x, y, z), (xx, xy, xz, yy, yz, zz))
        joints.append(
            Joint(
                row.name,
                row.antecedent,
                Kind.MOTOR,
                0,
                f"q{j}",
                alpha=Formula.parse(row.alpha),
                body=body,
                rotor_inertia=rotor,
                d=d,
                r=r,
            )
        )
    parameters = tuple(Parameter(name, Formula.parse(value)) for name, value in values.items())
    return Machine(name, tuple(joints), parameters, WEIGHT)


def body_values(j: int, mass: float, size: float) -> dict[str, float]:
    """Ten inertial parameters, by name, of five point masses within `size` of the origin: a body that can be."""
    rng = np.random.default_rng([j, 5])
    masses = mass * rng.dirichlet(np.full(5, 4.0))
    points = rng.uniform(-size, size, (5, 3))
    inertia = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, points, strict=True))
    numbers = [mass, *(masses @ points), *np.asarray(inertia)[np.triu_indices(3)]]
    return {f"{entry}{j}": float(f"{number:.6g}") for entry, number in zip(BODY, numbers, strict=True)}
