"""Machines to try the models on: random trees, generic chains, and small ones that have been got wrong elsewhere.

A random machine is never singular, whatever its position. Every body is made of point masses in general position,
so it resists any motion, but for some massless ones, allowed only where the motion of their joint is resisted by
- the rotor of the motor,
- a body with mass welded to it (a fixed frame), or
- a joint that follows, with a body with mass and on another axis: the two axes keep their relative place, so no
  position aligns them.
A leaf moved by a joint has mass; a fixed leaf has mass or its antecedent has.
Decimals are short, so files written from these machines are readable; equal arguments give equal machines.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import (
    NO_VECTOR,
    Base,
    Body,
    Friction,
    Inertia6,
    Joint,
    Kind,
    Machine,
    Parameter,
    Spring,
    Vector3,
    Wrench,
)

Array = NDArray[np.float64]

ALL_KINDS = (Kind.MOTOR, Kind.ELASTIC, Kind.PASSIVE, Kind.FIXED)
QUARTER_TURNS = ("pi/2", "-pi/2", "0", "pi")
INERTIA_NAMES = ("XX", "XY", "XZ", "YY", "YZ", "ZZ")
MOMENT_NAMES = ("MX", "MY", "MZ")
WEIGHT = Base(gravity=(ZERO, ZERO, Formula.parse("-9.81")))
NO_WEIGHT = Base()
APART = 0.2  # least |sin| between two axes, or distance in m, for them to be "another axis"


@dataclass
class _Cells:
    """Makes the cells of a table: numbers, or named parameters that have these values."""

    symbolic: bool
    parameters: list[Parameter] = field(default_factory=list)

    def cell(self, name: str, value: float, digits: int = 6) -> Formula:
        if not value:
            return ZERO
        number = Formula.parse(float(f"{value:.{digits}g}"))
        if not self.symbolic:
            return number
        self.parameters.append(Parameter(name, number))
        return Formula.parse(name)

    def vector(self, names: Sequence[str], values: Sequence[float] | Array) -> Vector3:
        x, y, z = (self.cell(name, value) for name, value in zip(names, values, strict=True))
        return x, y, z

    def inertia(self, names: Sequence[str], values: Sequence[float] | Array) -> Inertia6:
        xx, xy, xz, yy, yz, zz = (self.cell(name, value) for name, value in zip(names, values, strict=True))
        return xx, xy, xz, yy, yz, zz


@dataclass(frozen=True)
class _Row:
    """What is drawn of a row before its masses."""

    antecedent: int
    kind: Kind
    sigma: int
    gamma: str
    b: float
    alpha: str
    d: float
    theta: str
    r: float


def random_machine(
    seed: int,
    *,
    joints: int = 6,
    kinds: Sequence[Kind | str] = ALL_KINDS,
    gamma: bool = True,
    branching: float = 0.4,
    prismatic: float = 0.35,
    massless: float = 0.3,
    friction: bool = True,
    wrenches: bool = True,
    symbolic: bool = False,
    moving_base: bool = False,
) -> Machine:
    """A tree of `joints` rows (fixed frames count) that is regular at every position.

    `kinds`: what joints are drawn from; the first rows show each kind once. `branching`, `prismatic` and
    `massless` are chances: to hang on any earlier body instead of the last, to slide, to try a body without mass.
    `symbolic`: inertias, lengths, springs, frictions and wrenches are named parameters (XX3, MX3, M3, D3, K3 ...) that
    have values; otherwise numbers, and some inertias are given about the centre of mass.
    """
    rng = np.random.default_rng([seed, joints])
    rows = _draw_rows(
        rng, joints, [Kind(kind) for kind in kinds], gamma=gamma, branching=branching, prismatic=prismatic
    )
    virtual = _draw_massless(rng, rows, massless)
    cells = _Cells(symbolic)
    table = []
    for j, row in enumerate(rows, start=1):
        joint = _joint(rng, cells, j, row, friction)
        body = Body() if j in virtual else _body(rng, cells, j, central=not symbolic and rng.random() < 0.2)
        wrench = _wrench(rng, cells, j) if wrenches and rng.random() < 0.4 else Wrench()
        table.append(replace(joint, body=body, wrench=wrench))
    return Machine(f"random{seed}", tuple(table), tuple(cells.parameters), _base(rng, moving_base))


def chain(
    n: int,
    *,
    seed: int = 0,
    elastic: Sequence[int] = (),
    prismatic: Sequence[int] = (),
    quarter_turns: bool = False,
    symbolic: bool = True,
    base: Base = WEIGHT,
) -> Machine:
    """Generic serial chain of n joints: alpha, d, r and the ten inertial parameters of every body, Ia of the motors.

    `elastic`, `prismatic`: numbers (from 1) of such joints, otherwise motors and revolute. Frame 1 is frame 0 at
    q = 0, as usual. Symbolic: AL2, D2, R2, XX1 ... M1, IA1, K1, parameters with values; else the values themselves.
    """
    rng = np.random.default_rng([seed, n])
    cells = _Cells(symbolic)
    table = []
    for j in range(1, n + 1):
        kind, sigma = Kind.ELASTIC if j in elastic else Kind.MOTOR, int(j in prismatic)
        angle, d, r = rng.uniform(0.4, 1.2), rng.uniform(0.1, 0.5), rng.uniform(0.1, 0.5)
        turn = Formula.parse(QUARTER_TURNS[j % 2])
        generic = j > 1
        joint = Joint(
            f"joint{j}",
            j - 1,
            kind,
            sigma,
            f"q{j}",
            alpha=(turn if quarter_turns else cells.cell(f"AL{j}", angle, 3)) if generic else ZERO,
            d=cells.cell(f"D{j}", d, 3) if generic else ZERO,
            r=cells.cell(f"R{j}", r, 3) if generic and not sigma else ZERO,
            body=_body(rng, cells, j),
        )
        table.append(_with_law(rng, cells, j, joint))
    return Machine(f"chain{n}", tuple(table), tuple(cells.parameters), base)


def first_joint_elastic(n: int = 4, *, seed: int = 0, symbolic: bool = False) -> Machine:
    """A chain whose first joint is a spring: nothing rigid between it and the base."""
    return replace(chain(n, seed=seed, elastic=(1, *range(4, n + 1, 2)), symbolic=symbolic), name="first_joint_elastic")


def two_children(*, seed: int = 0, symbolic: bool = False, base: Base = WEIGHT) -> Machine:
    """Seven rows: two bodies carry two children each, elastic and motor, prismatic and revolute; a tool frame.

    1 (motor) carries 2 (elastic) and 3 (motor, prismatic); 3 carries 4 (elastic, prismatic) and 5 (passive),
    6 (motor) hangs on 2; 7 is fixed on 6, massless.
    """
    rng = np.random.default_rng([seed, 7])
    motor, elastic, passive, fixed = ALL_KINDS
    rows = [
        _Row(0, motor, 0, "0", 0.0, "0", 0.0, "0", 0.4),
        _Row(1, elastic, 0, "0.3", 0.15, "pi/2", 0.25, "0.2", 0.1),
        _Row(1, motor, 1, "-0.5", 0.2, "-pi/2", 0.3, "pi/2", 0.1),
        _Row(3, elastic, 1, "0", 0.0, "pi/2", 0.0, "-pi/2", 0.05),
        _Row(3, passive, 0, "pi/2", 0.1, "0.37", 0.2, "0", 0.0),
        _Row(2, motor, 0, "0", 0.0, "-pi/2", 0.0, "0", 0.3),
        _Row(6, fixed, 2, "0", 0.0, "0", 0.1, "0.4", 0.2),
    ]
    cells = _Cells(symbolic)
    table = [
        replace(_joint(rng, cells, j, row, False), body=_body(rng, cells, j) if j < 7 else Body())
        for j, row in enumerate(rows, start=1)
    ]
    return Machine("two_children", tuple(table), tuple(cells.parameters), base)


def planar_2r(*, elastic: Sequence[int] = ()) -> Machine:
    """Two parallel revolute joints in the x-y plane, gravity -G along y; symbolic L1, G, ZZ1, MX1, MY1, M1, IA1 ..."""
    cells = _Cells(symbolic=True)
    table = []
    for j, (zz, mx, my, mass) in enumerate(((0.31, 1.2, 0.1, 4.0), (0.11, 0.6, -0.05, 2.5)), start=1):
        body = Body(
            cells.cell(f"M{j}", mass),
            (cells.cell(f"MX{j}", mx), cells.cell(f"MY{j}", my), ZERO),
            (ZERO, ZERO, ZERO, ZERO, ZERO, cells.cell(f"ZZ{j}", zz)),
        )
        length = cells.cell("L1", 0.5) if j == 2 else ZERO
        if j in elastic:
            spring = Spring(cells.cell(f"K{j}", 800), cells.cell(f"DA{j}", 0.3))
            joint = Joint(f"joint{j}", j - 1, Kind.ELASTIC, 0, f"q{j}", d=length, body=body, spring=spring)
        else:
            rotor = cells.cell(f"IA{j}", 0.05)
            joint = Joint(f"joint{j}", j - 1, Kind.MOTOR, 0, f"q{j}", d=length, body=body, rotor_inertia=rotor)
        table.append(joint)
    cells.cell("G", 9.81)
    base = Base(gravity=(ZERO, Formula.parse("-G"), ZERO))
    return Machine("planar_2r", tuple(table), tuple(cells.parameters), base)


def random_state(machine: Machine, seed: int) -> tuple[list[float], ...]:
    """(q, qd, tau or qdd_motor) as floats: angles within +-pi, slides within +-0.5 m, rates +-2, torques +-20."""
    rng = np.random.default_rng([seed, len(machine.joints)])
    moving = [joint for joint in machine.joints if joint.sigma != 2]
    motors = sum(joint.kind == Kind.MOTOR for joint in moving)
    q = [float(rng.uniform(-1, 1)) * (math.pi if joint.sigma == 0 else 0.5) for joint in moving]
    return q, rng.uniform(-2, 2, len(moving)).tolist(), rng.uniform(-20, 20, motors).tolist()


def _draw_rows(
    rng: np.random.Generator, joints: int, kinds: list[Kind], *, gamma: bool, branching: float, prismatic: float
) -> list[_Row]:
    weights = np.array([{Kind.MOTOR: 3, Kind.ELASTIC: 3, Kind.PASSIVE: 1, Kind.FIXED: 1}[kind] for kind in kinds])
    drawn = [kinds[k] for k in rng.choice(len(kinds), size=max(0, joints - len(kinds)), p=weights / weights.sum())]
    drawn = [kinds[k] for k in rng.permutation(len(kinds))][:joints] + drawn
    rows = []
    for j, kind in enumerate(drawn, start=1):
        antecedent = int(rng.integers(0, j)) if rng.random() < branching else j - 1
        sigma = 2 if kind == Kind.FIXED else int(rng.random() < prismatic)
        turned = gamma and rng.random() < 0.5
        lengths = [round(float(rng.uniform(-0.5, 0.5)) * int(rng.random() < 0.7), 3) for _ in range(3)]
        angles = [_angle(rng) for _ in range(3)]
        rows.append(
            _Row(
                antecedent,
                kind,
                sigma,
                gamma=angles[0] if turned else "0",
                b=lengths[0] if turned else 0.0,
                alpha=angles[1],
                d=lengths[1],
                theta=angles[2] if rng.random() < 0.5 else "0",
                r=lengths[2],
            )
        )
    return rows


def _angle(rng: np.random.Generator) -> str:
    """A quarter turn twice out of three, else a general angle, decimal or a fraction of pi."""
    if rng.random() < 0.66:
        return str(rng.choice(QUARTER_TURNS, p=[0.4, 0.4, 0.15, 0.05]))
    return str(rng.choice([f"{rng.uniform(-1.5, 1.5):.2f}", "pi/6", "-pi/3", "2*pi/5", "atan2(3, 4)"]))


def _draw_massless(rng: np.random.Generator, rows: list[_Row], chance: float) -> set[int]:
    """Numbers of the bodies without mass, by the rules at the top; children are settled before antecedents."""
    virtual: set[int] = set()
    needed: set[int] = set()
    for j in range(len(rows), 0, -1):
        row = rows[j - 1]
        children = [k for k, other in enumerate(rows, start=1) if other.antecedent == j]
        if j in needed or rng.random() >= chance:
            continue
        if row.kind == Kind.FIXED or (row.kind == Kind.MOTOR and children):
            safe = True
        else:
            safe = any(k not in virtual and _another_axis(rows[k - 1], row.sigma) for k in children)
        if safe:
            virtual.add(j)
            if row.kind == Kind.FIXED and not children:
                needed.add(row.antecedent)
    return virtual


def _another_axis(row: _Row, sigma_before: int) -> bool:
    """Whether the axis of a row and that of its antecedent are, at every position, different screws."""
    inclined = abs(math.sin(Formula.parse(row.alpha).value())) > APART
    if row.sigma == 2 or row.sigma != sigma_before:
        return True
    return inclined or (row.sigma == 0 and abs(row.d) > APART)


def _joint(rng: np.random.Generator, cells: _Cells, j: int, row: _Row, friction: bool) -> Joint:
    joint = Joint(
        f"joint{j}" if row.sigma != 2 else f"frame{j}",
        row.antecedent,
        row.kind,
        row.sigma,
        f"q{j}" if row.sigma != 2 else None,
        gamma=Formula.parse(row.gamma),
        b=cells.cell(f"B{j}", row.b, 3),
        alpha=Formula.parse(row.alpha),
        d=cells.cell(f"D{j}", row.d, 3),
        theta=Formula.parse(row.theta),
        r=cells.cell(f"R{j}", row.r, 3),
    )
    if friction and row.sigma != 2 and rng.random() < 0.6:
        viscous, coulomb = rng.uniform(0.1, 1, 2)
        joint = replace(joint, friction=Friction(cells.cell(f"FV{j}", viscous, 3), cells.cell(f"FS{j}", coulomb, 3)))
    return _with_law(rng, cells, j, joint)


def _with_law(rng: np.random.Generator, cells: _Cells, j: int, joint: Joint) -> Joint:
    """The rotor of a motor, the spring of an elastic joint."""
    if joint.kind == Kind.MOTOR:
        return replace(joint, rotor_inertia=cells.cell(f"IA{j}", rng.uniform(0.2, 2), 3))
    if joint.kind != Kind.ELASTIC:
        return joint
    stiffness, damping, neutral = rng.uniform(50, 2000), rng.uniform(0.1, 2), rng.uniform(-0.3, 0.3)
    spring = Spring(
        cells.cell(f"K{j}", stiffness, 3), cells.cell(f"DA{j}", damping, 3), cells.cell(f"Q0{j}", neutral, 2)
    )
    return replace(joint, spring=spring)


def with_springs_beside_motors(machine: Machine, seed: int = 0) -> Machine:
    """The machine with a spring beside each motor that can have it; its values are parameters (KM3, QM3)."""
    rng, table, cells = np.random.default_rng(seed), [], _Cells(True)
    for j, joint in enumerate(machine.joints, start=1):
        spring = joint.spring
        if joint.kind is Kind.MOTOR:
            stiffness, neutral = cells.cell(f"KM{j}", rng.uniform(20, 200)), cells.cell(f"QM{j}", rng.uniform(0.1, 0.5))
            spring = Spring(stiffness, neutral=neutral)
        table.append(replace(joint, spring=spring))
    parameters = (*machine.parameters, *cells.parameters)
    return replace(machine, name=f"{machine.name}_sprung", joints=tuple(table), parameters=parameters)


def _body(rng: np.random.Generator, cells: _Cells, j: int, *, central: bool = False) -> Body:
    """Six point masses within 0.3 m of a point within 0.2 m of the origin: a physical body with all ten parameters."""
    masses = rng.uniform(0.2, 1.5, 6)
    points = rng.uniform(-0.3, 0.3, (6, 3)) + rng.uniform(-0.2, 0.2, 3)
    mass, moments = masses.sum(), masses @ points
    if central:
        points = points - moments / mass
    inertia = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, points, strict=True))
    six = np.asarray(inertia)[np.triu_indices(3)]
    return Body(
        cells.cell(f"M{j}", mass),
        cells.vector([f"{name}{j}" for name in MOMENT_NAMES], moments / mass if central else moments),
        cells.inertia([f"{name}{j}" for name in INERTIA_NAMES], six),
        central,
    )


def _wrench(rng: np.random.Generator, cells: _Cells, j: int) -> Wrench:
    force, moment = rng.uniform(-20, 20, 3), rng.uniform(-5, 5, 3)
    return Wrench(
        cells.vector([f"F{x}{j}" for x in "XYZ"], force.round(1)),
        cells.vector([f"C{x}{j}" for x in "XYZ"], moment.round(2)),
    )


def _base(rng: np.random.Generator, moving: bool) -> Base:
    """Gravity of 9.81 m/s2 in a general direction; a base that moves when asked for."""
    direction = rng.normal(size=3)
    numbers = _Cells(symbolic=False)
    gravity = numbers.vector("xyz", 9.81 * direction / np.linalg.norm(direction))
    if not moving:
        return Base(gravity, NO_VECTOR, NO_VECTOR, NO_VECTOR, NO_VECTOR)
    velocity, angular, acceleration, angular_acceleration = rng.uniform(-2, 2, (4, 3)).round(2)
    return Base(
        gravity,
        numbers.vector("xyz", velocity),
        numbers.vector("xyz", angular),
        numbers.vector("xyz", acceleration),
        numbers.vector("xyz", angular_acceleration),
    )


def led_by_the_first(machine: Machine, factor: float = 0.3) -> Machine:
    """The machine whose last variable of the first one's kind has a multiple of the first one added in its cell."""
    with_variable = [row for row in machine.joints if row.variable]
    first = with_variable[0]
    last = next((row for row in reversed(with_variable[1:]) if row.sigma == first.sigma), None)
    if last is None:
        return machine
    cell = "r" if last.sigma else "theta"
    led = replace(last, **{cell: Formula.parse(f"{getattr(last, cell)} + {factor}*{first.variable}")})
    return replace(machine, joints=tuple(led if row is last else row for row in machine.joints))
