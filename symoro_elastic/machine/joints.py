"""The rows of the table of geometric parameters: joints, and the bodies, springs, motors and friction of each.

Units are SI, angles in radians. Every cell is a `Formula`: a number or an expression over
parameter names, declared with what it is; `columns` walks over all of them. Nothing here computes a model.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum

from symoro_elastic.machine.columns import AXES, OF_ROTORS, TENSOR, Cell, Column, Dimension, column
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.quantities.units import FORCE, POSITION

Vector3 = tuple[Formula, Formula, Formula]
Inertia6 = tuple[Formula, Formula, Formula, Formula, Formula, Formula]

TENSOR_IS = "XX YY ZZ, or all of XX XY XZ YY YZ ZZ, where XY is minus the integral of x y over the mass"
TURNS = ("roll", "pitch", "yaw")
USUAL_ROUNDING = 50
"""Part of a backlash that rounds its edges, unless a rounding is given."""
NO_VECTOR: Vector3 = (ZERO, ZERO, ZERO)
NO_INERTIA: Inertia6 = (ZERO,) * 6
INERTIAL = (*TENSOR, "MX", "MY", "MZ", "M")
"""Inertial parameters of a body, about the origin of its frame."""
SELECTED = {0: "theta", 1: "r"}
"""Cell that sigma selects: the one that holds the joint variable."""


class Kind(StrEnum):
    """Kind of a joint by the force on its variable."""

    MOTOR = "motor"
    ELASTIC = "elastic"
    PASSIVE = "passive"
    FIXED = "fixed"
    COUPLED = "coupled"
    CUT = "cut"


@dataclass(frozen=True)
class Body:
    """Inertial parameters of a body, in its own frame.

    `inertia` holds XX XY XZ YY YZ ZZ (tensor entries, kg m2). With `central` False, as in the
    paper, they are about the origin of the frame and `moments` are the first moments MX MY MZ
    (kg m). With `central` True they are about the centre of mass, whose coordinates (m) are
    `moments`.
    """

    mass: Formula = column(Dimension.MASS, "bodies", "M", tunable=True, meaning="mass of the body", example="2.5")
    moments: Vector3 = column(
        *(Dimension.FIRST_MOMENT, "bodies", "MX MY MZ", AXES),
        key="first_moments",
        tunable=True,
        meaning="mass times the coordinates x y z of the centre of mass, in the frame of the body",
        example="[0.25, 0, 0]",
        central=Column(
            *("center_of_mass", "bodies", Dimension.LENGTH, (), AXES),
            tunable=True,
            meaning="coordinates x y z of the centre of mass, in the frame of the body",
            example="[0.1, 0, 0]",
        ),
    )
    inertia: Inertia6 = column(
        *(Dimension.INERTIA, "bodies", " ".join(TENSOR), TENSOR),
        key="inertia_at_origin",
        title="inertia",
        tunable=True,
        meaning=f"inertia tensor about the origin of the frame: {TENSOR_IS}",
        example="[0.01, 0.05, 0.05]",
        central=Column(
            *("inertia", "bodies", Dimension.INERTIA, TENSOR, TENSOR),
            tunable=True,
            meaning=f"inertia tensor about the centre of mass, in axes of the frame: {TENSOR_IS}",
            example="[0.01, 0, 0.002, 0.03, 0, 0.03]",
        ),
    )
    central: bool = False

    @classmethod
    def of(cls, parameters: Mapping[str, Formula]) -> Body:
        """Return the body with these values of XX .. M."""
        xx, xy, xz, yy, yz, zz, mx, my, mz, mass = (parameters[name] for name in INERTIAL)
        return cls(mass, (mx, my, mz), (xx, xy, xz, yy, yz, zz))

    @property
    def parameters(self) -> dict[str, Formula]:
        """Inertial parameters XX .. M by name, about the origin or, with `central`, about the centre of mass."""
        return dict(zip(INERTIAL, (*self.inertia, *self.moments, self.mass), strict=True))

    @property
    def has_inertia(self) -> bool:
        """Whether the table gives mass, moments or inertia."""
        return not all(formula.is_zero for formula in self.parameters.values())

    @property
    def is_balanced(self) -> bool:
        """Whether mass and inertia of the body are symmetric about its axis z."""
        xx, xy, xz, yy, yz, _ = self.inertia
        return xx.tree == yy.tree and all(x.is_zero for x in (*self.moments[:2], xy, xz, yz))


@dataclass(frozen=True)
class Spring:
    """Elastic law of a joint [9]: Gamma = -stiffness (q - neutral) - damping qd; a motor may have a spring in parallel.

    With a `backlash` it exerts nothing while |q - neutral| is below backlash/2, over edges that `rounding` smooths.
    """

    stiffness: Formula = column(
        Dimension.STIFFNESS, "springs", "k", symbol="k", tunable=True,
        meaning="stiffness k of an elastic joint, whose spring exerts -k (q - neutral) - damping qd; it may hold joint "
        "variables x, on which the spring then exerts -(dk/dx) (q - neutral)^2/2 as well; on a motor, a constant: that "
        "of a spring in parallel with it", example="4.0e5"
    )  # fmt: skip
    damping: Formula = column(
        Dimension.DAMPING, "springs", "damping", symbol="d", tunable=True, meaning="damping of the spring",
        example="120"
    )  # fmt: skip
    neutral: Formula = column(
        Dimension.POSITION, "springs", "neutral", symbol="q0", tunable=True,
        meaning="position of the joint at which the spring exerts no force", example="0.001"
    )  # fmt: skip
    backlash: Formula = column(
        Dimension.BACKLASH, "springs", "backlash", symbol="bl", tunable=True,
        meaning="play b in which spring and damper exert nothing, b/2 to either side of neutral; the stiffness is then "
        "a constant", example="1e-3"
    )  # fmt: skip
    rounding: Formula = column(
        Dimension.BACKLASH, "springs", "rounding", symbol="e", tunable=True,
        meaning="deflection e that rounds the two edges of a backlash; left out: backlash/50", example="2e-5"
    )  # fmt: skip


@dataclass(frozen=True)
class Friction:
    """Friction of a joint, opposing motion: coulomb sign(qd) + viscous qd.

    With a velocity `creep` dry friction has no jump: qd / sqrt(qd^2 + creep^2) stands for sign(qd). With `static`
    coulomb becomes coulomb + (static - coulomb)/(1 + (qd/stribeck)^2), and a `load` adds a share of the torque that
    passes. With a `bristle` friction has a state, its deflection.
    """

    viscous: Formula = column(
        Dimension.VISCOUS_FRICTION, "friction", "FV", title="viscous friction", symbol="Fv", tunable=True,
        meaning="friction in proportion to the velocity of the joint", example="0.8"
    )  # fmt: skip
    coulomb: Formula = column(
        Dimension.COULOMB_FRICTION, "friction", "FS", title="coulomb friction", symbol="Fs",
        meaning="dry friction, against the sense of motion; none at rest", example="1.5"
    )  # fmt: skip
    creep: Formula = column(
        Dimension.CREEP, "friction", "creep", title="creep velocity", symbol="vs",
        meaning="velocity vs that makes dry friction smooth, Fs qd / sqrt(qd^2 + vs^2); under a torque tau below Fs "
        "the joint then creeps by vs tau / sqrt(Fs^2 - tau^2); left out: Fs sign(qd)", example="1e-4"
    )  # fmt: skip
    static: Formula = column(
        Dimension.COULOMB_FRICTION, "friction", "static", title="static friction", symbol="Fb",
        meaning="dry friction at rest, coulomb + (static - coulomb)/(1 + (qd/stribeck)^2) at a velocity; left out: as "
        "coulomb", example="2"
    )  # fmt: skip
    stribeck: Formula = column(
        Dimension.CREEP, "friction", "stribeck", title="Stribeck velocity", symbol="vb",
        meaning="velocity at which half of static - coulomb is left: 0.83 of "
        "the vs of a law exp(-(v/vs)^2), 0.69 of that of exp(-v/vs)", example="0.01"
    )  # fmt: skip
    load: Formula = column(
        Dimension.SHARE, "friction", "load", title="load friction", symbol="mu",
        meaning="share of the torque through the transmission, as an amount, by which dry friction rises; below 0.9",
        example="0.05"
    )  # fmt: skip
    bristle: Formula = column(
        Dimension.STIFFNESS, "friction", "bristle", title="bristle stiffness", symbol="s0",
        meaning="stiffness of dry friction before it slips, which makes its deflection z a state: "
        "friction is bristle z + bristle_damping zd + viscous qd; in place of creep", example="1e5"
    )  # fmt: skip
    bristle_damping: Formula = column(
        Dimension.DAMPING, "friction", "bristle_damping", symbol="s1", title="bristle damping",
        meaning="damping of the bristle; sqrt(bristle times the inertia of the joint) is usual", example="300"
    )  # fmt: skip
    breakaway: Formula = column(
        Dimension.SHARE, "friction", "breakaway", symbol="zb", title="breakaway",
        meaning="part of its largest deflection up to which the bristle is elastic, so that loads do not make the "
        "joint drift; 0: it always slips, as of LuGre", example="0.7", default="0.7"
    )  # fmt: skip
    ball: Formula = column(
        Dimension.ANGULAR_DAMPING, "friction", "ball", title="ball damping", symbol="Fw", tunable=True,
        meaning="damping c of the ball joint of this row and the two before it, revolute ones: moments -c w against "
        "the angular velocity w between the body before the three and this one", example="0.05"
    )  # fmt: skip


@dataclass(frozen=True)
class Wrench:
    """Force (N) and moment (N m) a body exerts on its surroundings, in its own frame."""

    force: Vector3 = column(
        *(Dimension.FORCE, "wrenches", "FX FY FZ", AXES),
        meaning="force that the body exerts on its surroundings at the origin of its frame, in its frame",
        example="[0, 0, 50]",
    )
    moment: Vector3 = column(
        *(Dimension.MOMENT, "wrenches", "CX CY CZ", AXES),
        meaning="moment that the body exerts on its surroundings about the origin of its frame, in its frame",
        example="[0, 0, 0.2]",
    )


@dataclass(frozen=True)
class Electrics:
    """The winding of a motor: L di/dt = u - R i - Ke w, torque Kt i, w being the velocity of its rotor."""

    resistance: Formula = column(
        Dimension.RESISTANCE, "motors", "resistance", symbol="R",
        meaning="resistance of the winding, for drives whose current loop has kp and ti", example="0.5"
    )  # fmt: skip
    inductance: Formula = column(
        *(Dimension.INDUCTANCE, "motors", "inductance"), symbol="L", meaning="inductance of the winding", example="1e-3"
    )
    torque_constant: Formula = column(
        Dimension.TORQUE_CONSTANT, "motors", "torque_constant", title="torque constant", symbol="Kt",
        meaning="torque by current, about the rotor's own axis where a ratio is given", example="0.1"
    )  # fmt: skip
    back_emf: Formula = column(
        Dimension.BACK_EMF, "motors", "back_emf", title="back EMF", symbol="Ke",
        meaning="voltage by velocity, of the rotor's own axis where a ratio is given; 0: that of torque_constant",
        example="0.1"
    )  # fmt: skip


@dataclass(frozen=True)
class Cogging:
    """Torque of a motor by the position of its rotor alone: amplitude sin(order n q + phase) on its own axis."""

    amplitude: Formula = column(
        Dimension.COGGING, "motors", "cogging", key="cogging", symbol="A",
        meaning="amplitude of the cogging torque, n A sin(N n q + phase) on a joint behind a ratio n; about the axis "
        "of the rotor", example="0.02"
    )  # fmt: skip
    order: Formula = column(
        Dimension.PER_TURN, "motors", "cogging_order", key="cogging_order", title="cogging order", symbol="N",
        meaning="periods of cogging in a turn of the rotor; where it slides without a ratio, 2 pi over their length",
        example="24"
    )  # fmt: skip
    phase: Formula = column(
        Dimension.PHASE, "motors", "cogging_phase", key="cogging_phase", title="cogging phase", symbol="phi",
        meaning="phase of cogging where the joint is at zero", example="0.4"
    )  # fmt: skip


@dataclass(frozen=True)
class Joint:
    """One row of the table: iTj = Rot(z,gamma) Trans(z,b) Rot(x,alpha) Trans(x,d) Rot(z,theta) Trans(z,r) [1].

    `antecedent` is 0 for the base, else the number (from 1) of an earlier joint. `sigma` is 0
    (revolute), 1 (prismatic) or 2 (fixed frame). `theta` (or `r`, when prismatic) is the offset
    to which the joint's own variable, named `variable`, is added: a constant, or a formula of the variables of
    other joints. A coupled joint has that formula only; a cut joint closes a loop.
    """

    name: str
    antecedent: int
    kind: Kind
    sigma: int
    variable: str | None = None
    gamma: Formula = column(
        *(Dimension.ANGLE, "joints", "gamma"),
        meaning="rotation about z of the antecedent, before alpha: for branches of trees",
        example='"pi/6"',
    )
    b: Formula = column(
        Dimension.LENGTH, "joints", "b", tunable=True,
        meaning="translation along z of the antecedent, before alpha: for branches of trees", example="0.1"
    )  # fmt: skip
    alpha: Formula = column(
        *(Dimension.ANGLE, "joints", "alpha"),
        meaning="angle between z of the antecedent and z of the joint, about x",
        example='"pi/2"',
    )
    d: Formula = column(
        Dimension.LENGTH, "joints", "d", tunable=True,
        meaning="distance between z of the antecedent and z of the joint, along x", example='"L2"'
    )  # fmt: skip
    theta: Formula = column(
        *(Dimension.ANGLE, "joints", "theta"),
        meaning="angle about z of the joint; where sigma = 0 the joint variable, alone or plus a constant or a formula "
        "of the variables of other joints",
        example='"q1 + pi/2"',
    )
    r: Formula = column(
        Dimension.LENGTH, "joints", "r", tunable=True,
        meaning="translation along z of the joint; where sigma = 1 the joint variable, alone or plus a constant or a "
        "formula of the variables of other joints", example='"q2"'
    )  # fmt: skip
    body: Body = Body()
    spring: Spring = Spring()
    rotor_inertia: Formula = column(
        Dimension.ROTOR_INERTIA, "motors", "IA", symbol="Ia", tunable=True,
        meaning="inertia of the rotor reflected to the joint: its own times the square of the gear ratio; on a coupled "
        "joint it turns with that joint, and is added to the body of the row", example="1.2"
    )  # fmt: skip
    ratio: Formula = column(
        *(Dimension.RATIO, "motors", "ratio"),
        meaning="rotor turns per joint turn, rad/m where it slides: rotor_inertia is then that of the "
        "rotor about its own axis, kg m2",
        example="100",
    )
    sharing: Formula = column(
        *(Dimension.NUMBER, "motors", "sharing"),
        meaning="load-sharing weight of motors on the same degree of freedom, where only their sum is determined",
        example="1",
    )
    friction: Friction = Friction()
    wrench: Wrench = Wrench()
    electrics: Electrics = Electrics()
    cogging: Cogging = Cogging()

    @property
    def selected(self) -> Formula:
        """The formula in the cell that sigma selects: r of a prismatic joint, else theta."""
        return self.r if self.sigma == 1 else self.theta

    def with_selected(self, formula: Formula) -> Joint:
        """The joint with another formula in the cell that sigma selects."""
        return replace(self, r=formula) if self.sigma == 1 else replace(self, theta=formula)

    @property
    def reflected_inertia(self) -> Formula:
        """Inertia of the rotor reflected to the joint: times the square of its ratio."""
        if self.ratio.is_zero or self.rotor_inertia.is_zero:
            return self.rotor_inertia
        text = f"({self.ratio})^2*({self.rotor_inertia})"
        return Formula(text, ("*", ("power", self.ratio.tree, 2), self.rotor_inertia.tree))

    @property
    def reflected(self) -> Joint:
        """The joint with its motor reflected: numbers of the rotor's axis times the ratio or its square."""
        electrics, cogging = self.reflected_electrics, self.reflected_cogging
        return replace(self, rotor_inertia=self.reflected_inertia, electrics=electrics, cogging=cogging)

    @property
    def reflected_electrics(self) -> Electrics:
        """The winding reflected to the joint: its constants times the ratio."""
        return replace(self.electrics, **self._times_ratio(self.electrics, ("torque_constant", "back_emf")))

    @property
    def has_spring(self) -> bool:
        """Whether a spring acts on its variable: on an elastic joint, or in parallel with a motor."""
        return self.kind is Kind.ELASTIC or (self.kind is Kind.MOTOR and not self.spring.stiffness.is_zero)

    @property
    def reflected_cogging(self) -> Cogging:
        """Cogging by the joint's position: amplitude and order times the ratio."""
        return replace(self.cogging, **self._times_ratio(self.cogging, ("amplitude", "order")))

    def _times_ratio(self, owner: object, keys: tuple[str, ...]) -> dict[str, Formula]:
        cells = {key: getattr(owner, key) for key in keys if not self.ratio.is_zero}
        return {
            key: Formula(f"({self.ratio})*({x})", ("*", self.ratio.tree, x.tree))
            for key, x in cells.items()
            if not x.is_zero
        }

    @property
    def unit(self) -> str:
        """Unit of the joint variable: m where the joint is prismatic, else rad."""
        return POSITION.of(int(self.sigma == 1))

    def unit_of(self, cell: Cell) -> str:
        """Unit of one of its cells; empty for a number without unit."""
        of_rotor = cell.column.dimension in OF_ROTORS and not self.ratio.is_zero
        return cell.column.dimension.units[int(self.sigma == 1 and not of_rotor)]

    @property
    def force_unit(self) -> str:
        """Unit of the generalized force: N where the joint is prismatic, else N m."""
        return FORCE.of(int(self.sigma == 1))


@dataclass(frozen=True)
class NamedFrame:
    """A frame fixed to the body of a row, or to frame 0 where `on` is empty: a link of a robot, a site, a tool.

    Its placement in the row's frame is Trans(at) Rot(z, yaw) Rot(y, pitch) Rot(x, roll), m and rad.
    """

    name: str
    on: str = ""
    at: Vector3 = column(
        *(Dimension.LENGTH, "frames", "", AXES), meaning="its origin, in axes of the row's frame", example="[0, 0, 0.1]"
    )
    rpy: Vector3 = column(
        *(Dimension.ANGLE, "frames", "", TURNS),
        meaning="its axes: those of the row turned about x, then about y, then about z, all axes of the row's frame",
        example='[0, "pi/2", 0]',
    )
