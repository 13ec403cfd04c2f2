"""Machines at the limits: long chains, graded masses, springs without end, bodies without mass, levers, gimbals."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from symoro_elastic.formats import read_machine
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Base, Body, Joint, Kind, Machine, Parameter, Spring
from symoro_elastic.models.parameters.base_parameters import base_grouping
from tests.compiled_models import cell, vector

EXAMPLES = Path(__file__).parents[2] / "examples"
GRAVITY = Base(gravity=(Formula.parse("3.125"), Formula.parse(9), Formula.parse(-2)))
QUARTER_TURNS = ("0", "pi/2", "-pi/2")
Mass = Callable[[int, int], float]
"""Mass of link j of n, from 0."""


# Masses along a chain


def equal(j: int, n: int) -> float:
    return 1.0


def growing(j: int, n: int) -> float:
    return 10.0 ** (6 * j / (n - 1))


def shrinking(j: int, n: int) -> float:
    return 10.0 ** (-6 * j / (n - 1))


def heavy_tip(j: int, n: int) -> float:
    return 1e6 if j == n - 1 else 1.0


def light_tip(j: int, n: int) -> float:
    return 1e-6 if j == n - 1 else 1.0


def alternating(j: int, n: int) -> float:
    return (1.0, 1e6)[j % 2]


MASSES: dict[str, Mass] = {
    "equal": equal,
    "1 to 1e6": growing,
    "1 to 1e-6": shrinking,
    "tip 1e6 heavier": heavy_tip,
    "tip 1e6 lighter": light_tip,
    "1 and 1e6 in turn": alternating,
}


def short(mass: float) -> float:
    """A mass of eight bits, so that its products with lengths are exact in any precision and in any peer."""
    fraction, exponent = math.frexp(mass)
    return math.ldexp(round(fraction * 256) / 256, exponent)


def links(n: int, mass: Mass = equal, alphas: Sequence[str] = QUARTER_TURNS) -> Machine:
    """A serial chain of motors without rotors and of slender links 1 m long; masses M1, M2 ... are parameters."""
    names = [f"M{j}" for j in range(1, n + 1)]
    joints = [_link(j, name, alphas[j % len(alphas)]) for j, name in enumerate(names)]
    parameters = tuple(Parameter(name, cell(short(mass(j, n))), "kg") for j, name in enumerate(names))
    return Machine(f"links{n}", tuple(joints), parameters, GRAVITY)


def general_alphas(n: int) -> tuple[str, ...]:
    """Inclinations without a quarter turn among them."""
    return tuple(repr(round(0.7 * (-1) ** j + 0.01 * (j % 50), 2)) for j in range(n))


def _link(j: int, mass: str, alpha: str) -> Joint:
    inertia = tuple(map(cell, (f"{mass}/128", 0, 0, f"11*{mass}/128", 0, f"11*{mass}/128")))
    body = Body(cell(mass), vector(0.5, 0, 0), inertia, central=True)  # type: ignore[arg-type]
    return Joint(f"link{j + 1}", j, Kind.MOTOR, 0, f"q{j + 1}", alpha=cell(alpha), d=cell(1 if j else 0), body=body)


# Arms


def six_axes(base_parameters: bool = True) -> Machine:
    """The RX90 with links and rotors of the size of a PUMA 560 (Armstrong, Khatib and Burdick 1986)."""
    machine, _ = read_machine(EXAMPLES / "rx90.par")
    values = {"D3": 0.4318, "RL4": 0.4331, "G3": -9.81} | _arm_bodies()
    parameters = tuple(Parameter(p.name, cell(values.get(p.name, 0.0)), p.unit) for p in machine.parameters)
    valued = replace(machine, parameters=parameters, name="rx90")
    return base_grouping(valued).machine if base_parameters else valued


ARM_MASSES = (0.0, 17.4, 4.8, 0.82, 0.34, 0.09)
ARM_CENTRES = ((0, 0, 0), (0.068, 0.006, -0.016), (0, -0.07, 0.014), (0, 0, -0.019), (0, 0, 0), (0, 0, 0.032))
ARM_INERTIAS = (
    (0, 0, 0.35),
    (0.13, 0.524, 0.539),
    (0.066, 0.0125, 0.086),
    (1.8e-3, 1.8e-3, 1.3e-3),
    (3e-4, 3e-4, 4e-4),
    (1.5e-4, 1.5e-4, 4e-5),
)
ARM_ROTORS = (1.14, 4.71, 0.83, 0.2, 0.179, 0.193)


def _arm_bodies() -> dict[str, float]:
    values: dict[str, float] = {}
    for j, (mass, centre, central, rotor) in enumerate(
        zip(ARM_MASSES, ARM_CENTRES, ARM_INERTIAS, ARM_ROTORS, strict=True), start=1
    ):
        c = np.array(centre, dtype=float)
        tensor = np.diag(central) + mass * (c @ c * np.eye(3) - np.outer(c, c))
        six = dict(zip(("XX", "XY", "XZ", "YY", "YZ", "ZZ"), tensor[np.triu_indices(3)].tolist(), strict=True))
        moments = dict(zip(("MX", "MY", "MZ"), (mass * c).tolist(), strict=True))
        values |= {f"{name}{j}": value for name, value in (six | moments | {"M": mass, "IA": rotor}).items()}
    return values


# Small machines


COMPACT = Body(cell(2), vector("0.1", "-0.05", "0.2"), tuple(map(cell, (0.5, 0.01, -0.02, 0.4, 0.03, 0.3))), True)  # type: ignore[arg-type]


def elastic_arm(stiffness: float) -> Machine:
    """Two motors, each followed by a spring whose stiffness K is a parameter."""
    parameters = (Parameter("K", cell(stiffness), "N m/rad"),)
    rows = [
        _row(j, Kind.ELASTIC if j % 2 else Kind.MOTOR, alpha="pi/2" if j % 2 else "0.3", d=0.25 if j else 0)
        for j in range(4)
    ]
    springs = [replace(row, spring=Spring(cell("K"))) if row.kind == Kind.ELASTIC else row for row in rows]
    return Machine("elastic_arm", tuple(springs), parameters, GRAVITY)


def gimbal() -> Machine:
    """A body in a gimbal: three axes through a point, the two rings without mass."""
    rows = [
        _row(0, Kind.PASSIVE, body=Body()),
        _row(1, Kind.PASSIVE, alpha="pi/2", body=Body()),
        _row(2, Kind.PASSIVE, alpha="-pi/2"),
    ]
    return Machine("gimbal", tuple(rows), (), GRAVITY)


def nearly_parallel(angle: float) -> Machine:
    """Two springs on crossing axes an angle ALPHA apart, a massless body between them."""
    rows = [
        _row(0, Kind.MOTOR),
        replace(_row(1, Kind.ELASTIC, alpha="0.4", body=Body()), sigma=1, spring=Spring(cell(1000))),
        replace(_row(2, Kind.ELASTIC, alpha="ALPHA"), sigma=1, spring=Spring(cell(1000))),
    ]
    return Machine("nearly_parallel", tuple(rows), (Parameter("ALPHA", cell(angle), "rad"),), GRAVITY)


def lever(ratio: float) -> Machine:
    """Three axes, then a body of 1 m radius of gyration that far (R) from the last one."""
    body = Body(cell(2), vector("R", 0, 0), tuple(map(cell, (2, 0, 0, 2, 0, 2))), True)  # type: ignore[arg-type]
    rows = [_row(0, Kind.MOTOR), _row(1, Kind.MOTOR, alpha="pi/2", d=0.25), _row(2, Kind.MOTOR, alpha="0.5", d="R")]
    return Machine("lever", (*rows[:2], replace(rows[2], body=body)), (Parameter("R", cell(ratio), "m"),), GRAVITY)


def _row(j: int, kind: Kind, alpha: str = "0", d: float | str = 0.0, body: Body = COMPACT) -> Joint:
    return Joint(f"joint{j + 1}", j, kind, 0, f"q{j + 1}", alpha=cell(alpha), d=cell(d), body=body)


def spindle() -> Machine:
    """Two axes, then a slender shaft that turns about itself and carries a mass on its axis, 1 m from the others."""
    body = Body(cell(2), vector(0, 0, 0), tuple(map(cell, ("1e-9", 0, 0, "1e-9", 0, "1e-9"))))  # type: ignore[arg-type]
    shaft = replace(_row(2, Kind.MOTOR, alpha="pi/2", body=body), r=cell(1))
    return Machine("spindle", (_row(0, Kind.MOTOR), _row(1, Kind.MOTOR, alpha="pi/2"), shaft), (), GRAVITY)


# Machines that cannot be modelled


def series_springs() -> Machine:
    """Two sliding springs in a row, nothing between them."""
    rows = [_row(0, Kind.MOTOR), _row(1, Kind.ELASTIC, body=Body()), _row(2, Kind.ELASTIC)]
    springs = [replace(row, sigma=1, spring=Spring(cell(1000))) if row.kind == Kind.ELASTIC else row for row in rows]
    return Machine("series_springs", tuple(springs), (), GRAVITY)


def massless_tip() -> Machine:
    return Machine("massless_tip", (_row(0, Kind.MOTOR), _row(1, Kind.PASSIVE, alpha="pi/2", body=Body())), (), GRAVITY)


def point_on_axis() -> Machine:
    """A point mass on the axis that is to turn it."""
    point = Body(cell(2), vector(0, 0, 1), tuple(map(cell, (2, 0, 0, 2, 0, 0))))  # type: ignore[arg-type]
    return Machine("point_on_axis", (_row(0, Kind.MOTOR), _row(1, Kind.PASSIVE, alpha="pi/2", body=point)), (), GRAVITY)


def no_stiffness() -> Machine:
    return Machine(
        "no_stiffness", (_row(0, Kind.MOTOR), replace(_row(1, Kind.ELASTIC), spring=Spring(ZERO))), (), GRAVITY
    )
