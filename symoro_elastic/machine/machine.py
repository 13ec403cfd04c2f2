"""The machine as data: the table of geometric parameters, the bodies, the springs, the motors.

Units are SI, angles in radians. Every cell is a `Formula`: a number or an expression over
parameter names, declared with what it is; `columns` walks over all of them. Nothing here computes a model.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import StrEnum

from symoro_elastic.errors import InputError
from symoro_elastic.machine.columns import AXES, TENSOR, Column, Dimension, column
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.scene import Scene
from symoro_elastic.quantities.units import FORCE, POSITION

Vector3 = tuple[Formula, Formula, Formula]
Inertia6 = tuple[Formula, Formula, Formula, Formula, Formula, Formula]

BASE_PARAMETERS = "base_parameters"
"""Key of the extras of a machine whose inertial parameters have been grouped."""
TENSOR_IS = "XX YY ZZ, or all of XX XY XZ YY YZ ZZ, where XY is minus the integral of x y over the mass"
NO_VECTOR: Vector3 = (ZERO, ZERO, ZERO)
NO_INERTIA: Inertia6 = (ZERO,) * 6


class Kind(StrEnum):
    """Kind of a joint by the force on its variable."""

    MOTOR = "motor"
    ELASTIC = "elastic"
    PASSIVE = "passive"
    FIXED = "fixed"


@dataclass(frozen=True)
class Body:
    """Inertial parameters of one body, in its own frame.

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


@dataclass(frozen=True)
class Spring:
    """Elastic law of a joint [9]: Gamma = -stiffness (q - neutral) - damping qd."""

    stiffness: Formula = column(
        *(Dimension.STIFFNESS, "springs", "k"),
        symbol="k",
        tunable=True,
        meaning="stiffness k of an elastic joint, whose spring exerts -k (q - neutral) - damping qd",
        example="4.0e5",
    )
    damping: Formula = column(
        *(Dimension.DAMPING, "springs", "damping"),
        symbol="d",
        tunable=True,
        meaning="damping of the spring",
        example="120",
    )
    neutral: Formula = column(
        *(Dimension.POSITION, "springs", "neutral"),
        symbol="q0",
        tunable=True,
        meaning="position of the joint at which the spring exerts no force",
        example="0.001",
    )


@dataclass(frozen=True)
class Friction:
    """Friction of a joint, opposing motion: coulomb sign(qd) + viscous qd."""

    viscous: Formula = column(
        *(Dimension.VISCOUS_FRICTION, "friction", "FV"),
        title="viscous friction",
        symbol="Fv",
        tunable=True,
        meaning="friction in proportion to the velocity of the joint",
        example="0.8",
    )
    coulomb: Formula = column(
        *(Dimension.COULOMB_FRICTION, "friction", "FS"),
        title="coulomb friction",
        symbol="Fs",
        meaning="dry friction, against the sense of motion; none at rest",
        example="1.5",
    )


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
class Joint:
    """One row of the table: iTj = Rot(z,gamma) Trans(z,b) Rot(x,alpha) Trans(x,d) Rot(z,theta) Trans(z,r) [1].

    `antecedent` is 0 for the base, else the number (from 1) of an earlier joint. `sigma` is 0
    (revolute), 1 (prismatic) or 2 (fixed frame). `theta` (or `r`, when prismatic) is the offset
    to which the joint variable, named `variable`, is added.
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
        *(Dimension.LENGTH, "joints", "b"),
        tunable=True,
        meaning="translation along z of the antecedent, before alpha: for branches of trees",
        example="0.1",
    )
    alpha: Formula = column(
        *(Dimension.ANGLE, "joints", "alpha"),
        meaning="angle between z of the antecedent and z of the joint, about x",
        example='"pi/2"',
    )
    d: Formula = column(
        *(Dimension.LENGTH, "joints", "d"),
        tunable=True,
        meaning="distance between z of the antecedent and z of the joint, along x",
        example='"L2"',
    )
    theta: Formula = column(
        *(Dimension.ANGLE, "joints", "theta"),
        meaning="angle about z of the joint; the joint variable where sigma = 0, alone or plus a constant",
        example='"q1 + pi/2"',
    )
    r: Formula = column(
        *(Dimension.LENGTH, "joints", "r"),
        tunable=True,
        meaning="translation along z of the joint; the joint variable where sigma = 1, alone or plus a constant",
        example='"q2"',
    )
    body: Body = Body()
    spring: Spring = Spring()
    rotor_inertia: Formula = column(
        *(Dimension.ROTOR_INERTIA, "motors", "IA"),
        symbol="Ia",
        tunable=True,
        meaning="inertia of the rotor as the joint feels it: its own times the square of the gear ratio",
        example="1.2",
    )
    friction: Friction = Friction()
    wrench: Wrench = Wrench()

    @property
    def unit(self) -> str:
        """Unit of the joint variable: m where the joint is prismatic, else rad."""
        return POSITION.of(int(self.sigma == 1))

    @property
    def force_unit(self) -> str:
        """Unit of the generalized force: N where the joint is prismatic, else N m."""
        return FORCE.of(int(self.sigma == 1))


@dataclass(frozen=True)
class Parameter:
    """A named number of the machine; `value` is None when the machine gives none."""

    name: str
    value: Formula | None = None
    unit: str = ""


@dataclass(frozen=True)
class Base:
    """Motion of frame 0, in frame 0, and gravity (m/s2), in frame 0."""

    gravity: Vector3 = column(
        *(Dimension.GRAVITY, "", "G", AXES),
        meaning="acceleration of gravity, in frame 0; in axes of the world where the base floats",
        example="[0, 0, -9.81]",
    )
    velocity: Vector3 = column(
        *(Dimension.VELOCITY, "base", "V0", AXES),
        meaning="velocity of the origin of frame 0, in frame 0",
        example="[0.5, 0, 0]",
    )
    angular_velocity: Vector3 = column(
        *(Dimension.ANGULAR_VELOCITY, "base", "W0", AXES),
        meaning="angular velocity of frame 0, in frame 0",
        example="[0, 0, 0.1]",
    )
    acceleration: Vector3 = column(
        *(Dimension.ACCELERATION, "base", "VP0", AXES),
        meaning="acceleration of the origin of frame 0, in frame 0",
        example="[0, 0.2, 0]",
    )
    angular_acceleration: Vector3 = column(
        *(Dimension.ANGULAR_ACCELERATION, "base", "WP0", AXES),
        meaning="angular acceleration of frame 0, in frame 0",
        example="[0, 0, 0.05]",
    )


class Orientation(StrEnum):
    """Representation of the orientation of a floating base: a rotation matrix 0R, or a unit quaternion."""

    ROTATION = "rotation"
    QUATERNION = "quaternion"


class Given(StrEnum):
    """Known quantity of a floating base: the wrench on it, or its acceleration."""

    WRENCH = "wrench"
    ACCELERATION = "acceleration"


@dataclass(frozen=True)
class Floating:
    """A base that is a body with six degrees of freedom; frame 0 is its frame.

    Its orientation, its velocity and what is `known` of its motion are arguments of the models;
    gravity is then given in the axes of the world.
    """

    orientation: Orientation = Orientation.ROTATION
    known: Given = Given.WRENCH
    body: Body = Body()


@dataclass(frozen=True)
class Machine:
    """A tree of bodies joined by motors, springs, passive joints and fixed frames.

    `joint(j)` is row j of the table. `notes` are remarks carried along; `extras` are
    entries of a file format that no model uses, kept so that reading then writing loses nothing.
    `source` is the file it was read from, `name_origin` says where its name comes from unless it is given there.
    """

    name: str
    joints: tuple[Joint, ...]
    parameters: tuple[Parameter, ...] = ()
    base: Base = Base()
    floating: Floating | None = None
    scene: Scene | None = None
    notes: tuple[str, ...] = ()
    extras: dict[str, str] = field(default_factory=dict)
    source: str = ""
    name_origin: str = field(default="", compare=False)

    @property
    def is_grouped(self) -> bool:
        """Whether its inertial parameters are base parameters, which are not those of physical bodies."""
        return self.extras.get(BASE_PARAMETERS) == "true"

    def joint(self, j: int) -> Joint:
        """Joint number `j`, counted from 1 as in the table."""
        return self.joints[j - 1]

    @property
    def moving(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints that have a variable, in table order: the entries of q."""
        return tuple(j for j, joint in enumerate(self.joints, start=1) if joint.sigma != 2)

    @property
    def motors(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints driven by motors, in table order: the entries of tau."""
        return self._numbers_of(Kind.MOTOR)

    @property
    def elastic(self) -> tuple[int, ...]:
        """Numbers (from 1) of the elastic joints, in table order."""
        return self._numbers_of(Kind.ELASTIC)

    @property
    def moving_joints(self) -> tuple[Joint, ...]:
        """The joints that have a variable, in the order of the entries of q."""
        return tuple(map(self.joint, self.moving))

    @property
    def motor_joints(self) -> tuple[Joint, ...]:
        """The joints driven by motors, in the order of the entries of tau."""
        return tuple(map(self.joint, self.motors))

    @property
    def motor_entries(self) -> tuple[int, ...]:
        """Indices into q (from 0) of the joints driven by motors."""
        return self.entries(self.motors)

    @property
    def elastic_entries(self) -> tuple[int, ...]:
        """Indices into q (from 0) of the elastic joints."""
        return self.entries(self.elastic)

    def entries(self, joints: Iterable[int]) -> tuple[int, ...]:
        """Indices into q (from 0) of moving joints given by their numbers (from 1)."""
        entry = {j: k for k, j in enumerate(self.moving)}
        return tuple(entry[j] for j in joints)

    def error(self, place: str, what: str) -> InputError:
        """The error to raise about one place of the machine, named by its `label`."""
        return InputError(self.label, place, what)

    @property
    def label(self) -> str:
        """Its name in messages: the file it was read from, else its own name."""
        return self.source or self.name

    def _numbers_of(self, kind: Kind) -> tuple[int, ...]:
        return tuple(j for j in self.moving if self.joint(j).kind is kind)
