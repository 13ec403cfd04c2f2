"""The machine as data: the table of geometric parameters, its parameters, its base and its loops.

Units are SI, angles in radians. Nothing here computes a model.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from typing import TypeVar

from symoro_elastic.foundation.errors import InputError, without_value
from symoro_elastic.foundation.results import Shown
from symoro_elastic.machine.columns import AXES, Cell, Dimension, cells, column
from symoro_elastic.machine.flexible import FlexibleBody
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import (
    NO_INERTIA,
    NO_VECTOR,
    Body,
    Friction,
    Inertia6,
    Joint,
    Kind,
    NamedFrame,
    Spring,
    Vector3,
    Wrench,
)
from symoro_elastic.machine.loops import Closing, Loop, branches
from symoro_elastic.machine.scene import RequestedPart

__all__ = [
    "NO_INERTIA",
    "NO_VECTOR",
    "Base",
    "Body",
    "Closing",
    "Floating",
    "Friction",
    "Inertia6",
    "Joint",
    "Kind",
    "KnownOfBase",
    "Loop",
    "Machine",
    "NamedFrame",
    "Orientation",
    "Parameter",
    "Spring",
    "Vector3",
    "Wrench",
]

T = TypeVar("T")
NO_MOTOR = 'no joint has a motor: give one kind = "motor" (.par: mu = 1)'


@dataclass(frozen=True)
class Parameter:
    """A named number of the machine; `value` is None when the machine gives none."""

    name: str
    value: Formula | None = None
    unit: str = ""


def known_values(parameters: Iterable[Parameter]) -> dict[str, float]:
    """The values of the parameters that have one which is a number, by name."""
    cells = {parameter.name: parameter.value for parameter in parameters if parameter.value is not None}
    return {name: value for name, cell in cells.items() if (value := cell.known_value({})) is not None}


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


class KnownOfBase(StrEnum):
    """Known quantity of a floating base: the wrench on it, or its acceleration."""

    WRENCH = "wrench"
    ACCELERATION = "acceleration"


@dataclass(frozen=True)
class Floating:
    """A base that is a body with six degrees of freedom; frame 0 is its frame.

    Its orientation, its velocity and what is `known` of its motion are arguments of the models;
    gravity is then given in the axes of the world. What is around it opposes its velocity by
    -linear_damping v and -angular_damping w.
    """

    orientation: Orientation = Orientation.ROTATION
    known: KnownOfBase = KnownOfBase.WRENCH
    body: Body = Body()
    linear_damping: Formula = column(
        *(Dimension.LINEAR_DAMPING, "base", ""),
        meaning="force against the velocity of the origin of a floating base, in proportion",
        example="0.1",
    )
    angular_damping: Formula = column(
        *(Dimension.ANGULAR_DAMPING, "base", ""),
        meaning="moment against the angular velocity of a floating base, in proportion",
        example="0.02",
    )


@dataclass(frozen=True, repr=False)
class Machine(Shown):
    """A tree of bodies joined by motors, springs, passive and coupled joints and fixed frames, closed by `loops`.

    It is mechanics only: what a file asks of it, and where it came from, are in a `DescribedMachine`.
    `joint(j)` is row j of the table. Where it `is_grouped`, its inertial parameters are base parameters, which are
    not those of physical bodies. `static` are the rows, by number, of springs that are left out of the motion, and of
    joints that follow these, as they are when they deflect; `forces` the frames, and points of them, with wrenches that
    its models have as arguments; `frames` those that have a name and no row, `flexible` the bodies that bend. `source`
    is the file that messages name.
    """

    name: str
    joints: tuple[Joint, ...]
    parameters: tuple[Parameter, ...] = ()
    base: Base = Base()
    floating: Floating | None = None
    source: str = ""
    loops: tuple[Loop, ...] = ()
    is_grouped: bool = False
    static: dict[int, Joint] = field(default_factory=dict)
    forces: tuple[RequestedPart, ...] = ()
    frames: tuple[NamedFrame, ...] = ()
    flexible: tuple[FlexibleBody, ...] = ()

    @property
    def headline(self) -> str:
        """Its name, and how many joints and motors it has."""
        counts = {"coordinate": len(self.independent), "motor": len(self.motors), "spring": len(self.sprung)}
        counts |= {"row": len(self.joints), **({"loop": len(self.loops)} if self.loops else {})}
        numbered = (f"{count} {what}{'' if count == 1 else 's'}" for what, count in counts.items())
        return f"Machine {self.name}: {', '.join(numbered)}"

    def joint(self, j: int) -> Joint:
        """Joint number `j`, counted from 1 as in the table."""
        return self.joints[j - 1]

    @cached_property
    def rows(self) -> Mapping[str, int]:
        """Numbers (from 1) of the joints by name."""
        return {joint.name: j for j, joint in enumerate(self.joints, start=1)}

    @cached_property
    def parameter_names(self) -> frozenset[str]:
        """Names of the parameters."""
        return frozenset(parameter.name for parameter in self.parameters)

    @property
    def given_values(self) -> dict[str, float]:
        """Values of the parameters that have one."""
        return {p.name: p.value.value() for p in self.parameters if p.value is not None}

    @cached_property
    def independent(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints that own an independent variable, in table order: the entries of q."""
        return tuple(j for j in self.with_variable if j not in self.dependent)

    @cached_property
    def with_variable(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints of the tree that have a variable of their own, in table order."""
        return tuple(j for j in self.articulated if self.joint(j).kind is not Kind.COUPLED)

    @cached_property
    def articulated(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints of the tree that move, coupled ones too, in table order."""
        numbered = enumerate(self.joints, start=1)
        return tuple(j for j, joint in numbered if joint.sigma != 2 and joint.kind is not Kind.CUT)

    @property
    def free_bodies(self) -> tuple[Body, ...]:
        """The body of a base that moves freely; none where the base is fixed."""
        return (self.floating.body,) if self.floating else ()

    @cached_property
    def has_inertia(self) -> bool:
        """Whether any body or rotor has mass or inertia; without them only geometry and kinematics matter."""
        bodies = (*(joint.body for joint in self.joints), *self.free_bodies)
        weights = (cell for body in bodies for cell in (body.mass, *body.moments, *body.inertia))
        rotors = (joint.rotor_inertia for joint in self.joints)
        return not all(cell.is_zero for cell in (*weights, *rotors))

    @property
    def gravity_in_words(self) -> str:
        """The acceleration of gravity, m/s2, and the axes that it is given in."""
        gravity = self.base.gravity
        if all(x.is_zero for x in gravity):
            return "no gravity"
        where = "axes of the world" if self.floating else "frame 0"
        return f"gravity: {', '.join(map(str, gravity))} m/s2 in {where}"

    @property
    def damping_of_base(self) -> tuple[Formula, ...]:
        """Damping of the six velocities of a base that moves freely, linear ones first; none where it is fixed."""
        floating = self.floating
        return (*(floating.linear_damping,) * 3, *(floating.angular_damping,) * 3) if floating else ()

    @property
    def degrees_of_base(self) -> int:
        """Degrees of freedom of the base: 6 or 0."""
        return 6 * len(self.free_bodies)

    @cached_property
    def cells_with_names(self) -> tuple[tuple[str, Joint | Body, tuple[tuple[Cell, Formula], ...]], ...]:
        """Joints and free bodies that have cells with names: their name in messages, joint or body, and these cells."""
        owners: list[tuple[str, Joint | Body]] = [(joint.name, joint) for joint in self.joints]
        owners += [("base", body) for body in self.free_bodies]
        named = ((name, owner, tuple(pair for pair in cells(owner) if pair[1].names)) for name, owner in owners)
        return tuple(entry for entry in named if entry[2])

    @cached_property
    def dependent(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints whose variables loops give, in table order."""
        return tuple(sorted({j for loop in self.loops for j in self.dependent_in(loop)}))

    def dependent_in(self, loop: Loop) -> tuple[int, ...]:
        """Numbers of the dependent joints of a loop: those it names, else its passive joints."""
        if loop.dependent:
            return tuple(j for j in self.with_variable if self.joint(j).name in loop.dependent)
        return tuple(j for j in self.around(loop) if self.joint(j).kind is Kind.PASSIVE)

    def around(self, loop: Loop) -> tuple[int, ...]:
        """Numbers of the joints of the tree that move on both branches of a loop."""
        rows = {j for branch in branches(self.antecedents, loop) for j in branch}
        return tuple(j for j in self.articulated if j in rows)

    def with_variable_in(self, loop: Loop) -> tuple[int, ...]:
        """Numbers of the joints whose variables occur in the cells of the joints around a loop."""
        joints = [self.joint(j) for j in self.around(loop)]
        names = {name for joint in joints for name in (str(joint.variable), *joint.selected.names)}
        return tuple(j for j in self.with_variable if self.joint(j).variable in names)

    @cached_property
    def not_started(self) -> tuple[int, ...]:
        """Numbers of the joints of loops with a start that omits their position, which is solved for."""
        started = {name for loop in self.loops for name in loop.start}
        in_started_loops = {j for loop in self.loops if loop.start for j in self.with_variable_in(loop)}
        return tuple(j for j in sorted(in_started_loops) if self.joint(j).variable not in started)

    @cached_property
    def in_loops(self) -> frozenset[int]:
        """Numbers of the joints on whose variables those of some loop depend."""
        return frozenset(j for loop in self.loops for j in self.with_variable_in(loop))

    @cached_property
    def antecedents(self) -> tuple[int, ...]:
        """Numbers of the antecedents of all rows, in table order."""
        return tuple(joint.antecedent for joint in self.joints)

    @cached_property
    def variables(self) -> dict[str, int]:
        """Number of the joint that owns a variable, by the name of the variable."""
        return {str(self.joint(j).variable): j for j in self.with_variable}

    def by_variable(self, by_joint: Mapping[int, T]) -> dict[str, T]:
        """Return values of joint coordinates by joint name instead of joint number."""
        return {str(self.joint(j).variable): x for j, x in by_joint.items()}

    @cached_property
    def is_coupled(self) -> bool:
        """Whether joints depend on other joints' variables: by their cells, through loops, or by flexible bodies."""
        if self.loops or self.flexible or any(joint.kind is Kind.COUPLED for joint in self.joints):
            return True
        return any(not self.variables.keys().isdisjoint(joint.selected.names) for joint in self.joints)

    @cached_property
    def flexible_bodies(self) -> dict[int, tuple[FlexibleBody, tuple[int, ...]]]:
        """Flexible bodies with the numbers (from 1) of their modes, by the number of the row that they belong to."""
        return {self.rows[x.joint]: (x, tuple(self.rows[name] for name in x.modes)) for x in self.flexible}

    @cached_property
    def modal_rows(self) -> frozenset[int]:
        """Numbers (from 1) of the rows that are modes of flexible bodies."""
        return frozenset(j for _, modes in self.flexible_bodies.values() for j in modes)

    def no_frame_of_mode(self, number: int) -> str:
        """Why a row has no frame: it is a mode of a flexible body; empty for other numbers of frames."""
        body = next((x.joint for x, modes in self.flexible_bodies.values() if number in modes), "")
        return f"it is a mode of {body}, which has no frame: name an interface of the body" if body else ""

    @cached_property
    def modal_followers(self) -> tuple[int, ...]:
        """Rows from bodies that bend by modes to their interfaces, whose places are those of the modes."""
        rows: list[int] = []
        for j, joint in enumerate(self.joints, start=1):
            begins = joint.antecedent in self.flexible_bodies and joint.kind in (Kind.COUPLED, Kind.FIXED)
            if begins or (joint.antecedent in rows and joint.kind is Kind.COUPLED):
                rows.append(j)
        return tuple(rows)

    @cached_property
    def motors(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints driven by motors, in table order: the entries of tau."""
        return self._numbers_of(Kind.MOTOR)

    @cached_property
    def elastic(self) -> tuple[int, ...]:
        """Numbers (from 1) of the elastic joints, in table order."""
        return self._numbers_of(Kind.ELASTIC)

    @property
    def static_springs(self) -> dict[int, Joint]:
        """The static elastic joints, by number, as rows in which their springs can deflect."""
        return {j: joint for j, joint in self.static.items() if joint.kind is Kind.ELASTIC}

    @cached_property
    def sprung(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints that have springs, in table order: elastic ones, and motors with one."""
        return tuple(j for j in self.with_variable if self.joint(j).has_spring)

    def ball(self, j: int) -> tuple[int, ...]:
        """Numbers (from 1) of three successive revolute joints that end with joint j; empty for others."""
        rows = [j]
        while len(rows) < 3 and rows[0]:
            rows.insert(0, self.joint(rows[0]).antecedent)
        return tuple(rows) if rows[0] and all(k in self.articulated and not self.joint(k).sigma for k in rows) else ()

    @cached_property
    def bristles(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints whose friction has a state, in table order: the entries of z."""
        return tuple(j for j in self.articulated if not self.joint(j).friction.bristle.is_zero)

    @property
    def largest_deflections(self) -> tuple[float, ...]:
        """Deflections, rad or m, at which bristles slip at rest, where all parameters have values."""
        values = self.given_values
        laws = (self.joint(j).friction for j in self.bristles)
        return tuple(max(x.coulomb.value(values), x.static.value(values)) / x.bristle.value(values) for x in laws)

    @cached_property
    def loaded(self) -> tuple[int, ...]:
        """Numbers (from 1) of the joints whose friction rises with the load, in table order: the entries of load."""
        return tuple(j for j in self.articulated if not self.joint(j).friction.load.is_zero)

    def refuse_states_of_friction(self, task: str) -> None:
        """Raise `InputError` where friction has a state or rises with the load, which a task does not know."""
        states = "does not know its state: give creep in place of bristle"
        loads = "does not know the torque that passes through the joint: leave load out"
        for numbers, why in ((self.bristles, states), (self.loaded, loads)):
            for j in numbers:
                raise self.error(f"friction, {self.joint(j).name}", f"{task} {why}")

    def refuse_flexible(self, task: str) -> None:
        """Raise `InputError` where a body bends by modes, whose integrals over the mass a task does not know."""
        for body in self.flexible:
            what = f"{task} does not know the integrals of its modes: give a beam joints in place of modes, or a body"
            what += " without [flexible]"
            raise self.error(f"flexible body {body.joint}", what)

    @cached_property
    def with_backlash(self) -> tuple[int, ...]:
        """Numbers (from 1) of the elastic joints whose springs have backlash, in table order."""
        return tuple(j for j in self.elastic if not self.joint(j).spring.backlash.is_zero)

    @cached_property
    def independent_joints(self) -> tuple[Joint, ...]:
        """The joints that own an independent variable, in the order of the entries of q."""
        return tuple(map(self.joint, self.independent))

    @cached_property
    def motor_joints(self) -> tuple[Joint, ...]:
        """The joints driven by motors, in the order of the entries of tau."""
        return tuple(map(self.joint, self.motors))

    def refuse_missing_values(self, place: str, option: str = "", given: Collection[str] = ()) -> None:
        """Raise `InputError` for a parameter without value whose name is not in `given`; `option` gives values."""
        missing = [p.name for p in self.parameters if p.value is None and p.name not in given]
        if missing:
            raise self.error(place, without_value(missing, option))

    def refuse_without_motors(self, place: str) -> None:
        """Raise `InputError` for a machine without motors."""
        if not self.motors:
            raise self.error(place, NO_MOTOR)

    def why_no_motor(self, name: str) -> str:
        """Return the message about the joint `name`, which has no motor, with the motors that there are."""
        motors = ", ".join(joint.name for joint in self.motor_joints)
        return f"{name} has no motor: motors are {motors}" if motors else NO_MOTOR

    def why_dependent(self, name: str) -> str:
        """Return the message about the joint `name`, which is not independent, with the independent ones."""
        names = ", ".join(joint.name for joint in self.independent_joints)
        return f"{name} does not move by itself: independent joints are {names}"

    @cached_property
    def motors_by_name(self) -> Mapping[str, str]:
        """Names of the joints that motors drive, by their variables and by these names, which win."""
        by_variable = {str(joint.variable): joint.name for joint in self.motor_joints}
        return by_variable | {joint.name: joint.name for joint in self.motor_joints}

    @cached_property
    def motor_entries(self) -> tuple[int, ...]:
        """Indices into q (from 0) of the joints driven by motors whose variables are independent."""
        return self.entries(j for j in self.motors if j in self.independent)

    @property
    def moves_by_motors(self) -> bool:
        """Whether q are the variables of the motors, in their order: torques and velocities give the power."""
        return len(self.motors) == len(self.independent) and self.motor_entries == tuple(range(len(self.motors)))

    @cached_property
    def elastic_entries(self) -> tuple[int, ...]:
        """Indices into q (from 0) of the elastic joints whose variables are independent."""
        return self.entries(j for j in self.elastic if j in self.independent)

    def entries(self, joints: Iterable[int]) -> tuple[int, ...]:
        """Indices into q (from 0) of independent joints given by their numbers (from 1)."""
        entry = {j: k for k, j in enumerate(self.independent)}
        return tuple(entry[j] for j in joints)

    def error(self, place: str, what: str) -> InputError:
        """The error to raise about one place of the machine, named by its `label`."""
        return InputError(self.label, place, what)

    @property
    def label(self) -> str:
        """Its name in messages: the file it was read from, else its own name."""
        return self.source or self.name

    def _numbers_of(self, kind: Kind) -> tuple[int, ...]:
        return tuple(j for j in self.with_variable if self.joint(j).kind is kind)
