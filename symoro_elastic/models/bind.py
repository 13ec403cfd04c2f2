"""A machine bound to the equations: every cell of its table an expression of one graph."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from symoro_elastic.equations.dynamics import AccelerationKnown, Rule, TorqueKnown
from symoro_elastic.equations.floating_base import WrenchKnown, rotation_of
from symoro_elastic.equations.joint_laws import elastic_torque, friction
from symoro_elastic.equations.mechanism import Link, Mechanism
from symoro_elastic.equations.spatial import (
    AT_REST,
    AxialTransform,
    Axis,
    Matrix,
    RigidInertia,
    Symmetric,
    Transform,
    Twist,
    Vector,
    Wrench,
    X,
    Z,
    dot,
    translation,
)
from symoro_elastic.machine.arguments import arguments
from symoro_elastic.machine.checks import formulas
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Body, Given, Joint, Kind, Machine, Orientation
from symoro_elastic.machine.scene import Point
from symoro_elastic.quantities import ON_BASE, Quantity
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.expression import Expression, Graph, Level, operand
from symoro_elastic.symbolic.functions import arc_tangent, cosine_sine, sign, square_root
from symoro_elastic.symbolic.program import Names

Points = tuple[tuple[int, Point], ...]


def _exact(x: Scalar) -> Scalar:
    """Constants as fractions, so that their quotients are exact."""
    found = operand(x)
    return found if isinstance(found, Expression) else Fraction(found)


class Bound:
    """A machine whose cells are expressions of one graph.

    Each of the `points`, (number of the frame, coordinates in it), is one more fixed frame of its mechanism.
    `by` names the columns of derivatives, all where it is empty.
    """

    def __init__(
        self, machine: Machine, folded: Sequence[str] = (), points: Points = (), by: Sequence[str] = ()
    ) -> None:
        self.machine, self.points, self.by = machine, points, by
        self.graph = Graph()
        self.names = Names()
        self.motors = machine.motors
        self._functions: dict[str, Callable[..., Any]] = {
            "sin": lambda x: _exact(cosine_sine(self.graph, x)[1]),
            "cos": lambda x: _exact(cosine_sine(self.graph, x)[0]),
            "tan": self._tangent,
            "sqrt": lambda x: square_root(self.graph, x),
            "atan2": lambda y, x: arc_tangent(self.graph, y, x),
        }
        self._cells = self._parameter_cells(folded)
        self.q = self._per_joint("q", machine.moving)
        self.qd = self._per_joint("qd", machine.moving)
        self.qdd = self._per_joint("qdd", machine.moving)
        self.tau = self._per_joint("tau", self.motors)
        self.qdd_motor = self._per_joint("qdd_motor", self.motors)
        self.on_base = {row.name: tuple(map(self.graph.symbol, row.entries)) for row in self._rows_on_base()}
        self.mechanism = self._mechanism()

    def _rows_on_base(self) -> Iterable[Quantity]:
        return ON_BASE if self.machine.floating else ()

    def _per_joint(self, argument: str, joints: Sequence[int]) -> dict[int, Expression]:
        return dict(zip(joints, map(self.graph.symbol, arguments(self.machine)[argument]), strict=True))

    def _parameter_cells(self, folded: Sequence[str]) -> dict[str, Scalar]:
        cells: dict[str, Scalar] = {"pi": self.graph.pi}
        for parameter in self.machine.parameters:
            if parameter.name in folded and parameter.value is not None:
                cells[parameter.name] = self.cell(parameter.value, {"pi": self.graph.pi})
            else:
                cells[parameter.name] = self.graph.symbol(parameter.name, Level.PARAMETER)
        return cells

    def _tangent(self, x: Scalar) -> Scalar:
        cosine, sine = cosine_sine(self.graph, x)
        return _exact(sine) / cosine

    def cell(self, formula: Formula, names: dict[str, Scalar] | None = None) -> Scalar:
        """The expression of a cell; exact zero is the integer 0 of structure. Raises `InputError`."""
        try:
            value = formula.evaluate(names or self._cells, self._functions, Fraction)
        except (ArithmeticError, ValueError) as error:
            reason = "it divides by zero" if isinstance(error, ZeroDivisionError) else str(error)
            raise self.machine.error(self._place(formula), f"{formula.text!r} has no value: {reason}") from None
        return 0 if not isinstance(value, Expression) and value == 0 else value

    def cells(self, written: Sequence[Formula]) -> Any:
        """The expressions of several cells."""
        return tuple(map(self.cell, written))

    def vector(self, written: Sequence[Formula]) -> Vector:
        """The expressions of three cells."""
        return Vector(*self.cells(written))

    def _place(self, formula: Formula) -> str:
        of_point = any(formula in at for _, at in self.points)
        elsewhere = "scene, outputs" if of_point else "parameters"
        return next((place for place, written in formulas(self.machine) if written == formula), elsewhere)

    def _mechanism(self) -> Mechanism:
        base, floating = self.machine.base, self.machine.floating
        links = [self._link(j, joint) for j, joint in enumerate(self.machine.joints, start=1)]
        links += [Link(j, Axis.NONE, translation(self.vector(at))) for j, at in self.points]
        linear, angular = self.base_acceleration
        return Mechanism(
            tuple(links),
            self._twist_on_base("V0") if floating else self._twist(base.velocity, base.angular_velocity),
            Twist(linear - self.gravity, angular),
            self._body(floating.body) if floating else None,
        )

    def _twist(self, linear: Sequence[Formula], angular: Sequence[Formula]) -> Twist:
        return Twist(self.vector(linear), self.vector(angular))

    def _twist_on_base(self, argument: str) -> Twist:
        entries = self.on_base[argument]
        return Twist(Vector(*entries[:3]), Vector(*entries[3:]))

    def _link(self, j: int, joint: Joint) -> Link:
        q = self.q.get(j, 0)
        theta = self.cell(joint.theta) + (q if joint.sigma == 0 else 0)
        r = self.cell(joint.r) + (q if joint.sigma == 1 else 0)
        steps = (  # (1)
            AxialTransform(Z, *cosine_sine(self.graph, self.cell(joint.gamma)), self.cell(joint.b)),
            AxialTransform(X, *cosine_sine(self.graph, self.cell(joint.alpha)), self.cell(joint.d)),
            AxialTransform(Z, *cosine_sine(self.graph, theta), r),
        )
        wrench = Wrench(self.vector(joint.wrench.force), self.vector(joint.wrench.moment))
        return Link(
            joint.antecedent,
            Axis(joint.sigma),
            Transform(steps),
            self._body(joint.body),
            self.cell(joint.reflected_inertia),
            wrench,
        )

    def _body(self, body: Body) -> RigidInertia:
        mass, moments, inertia = self.cell(body.mass), self.vector(body.moments), Symmetric(*self.cells(body.inertia))
        if not body.central:
            return RigidInertia(mass, moments, inertia)
        return RigidInertia.about_center(mass, moments, inertia)

    def arguments(self) -> dict[str, tuple[str, ...]]:
        """Names of the entries of each argument of the generated functions."""
        return arguments(self.machine)

    def sign_of_velocity(self, j: int) -> Scalar:
        """sign(qd_j)."""
        return sign(self.graph, self.qd[j])

    def friction(self, j: int) -> Scalar:
        """Friction of joint j, opposing motion."""
        law = self.machine.joint(j).friction
        viscous, coulomb = self.cell(law.viscous), self.cell(law.coulomb)
        return friction(viscous, coulomb, self.qd[j], self.sign_of_velocity(j))

    def passive_torque(self, j: int) -> Scalar:
        """Torque of spring and damper on joint j [9]; zero for joints without."""
        stiffness, deflection = self.spring(j)
        damping = self.cell(self.machine.joint(j).spring.damping)
        return elastic_torque(stiffness, deflection, damping, self.qd[j])

    def spring(self, j: int) -> tuple[Scalar, Scalar]:
        """Stiffness of joint j and deflection of its spring; zero for joints without."""
        joint = self.machine.joint(j)
        if joint.kind is not Kind.ELASTIC:
            return 0, 0
        return self.cell(joint.spring.stiffness), self.q[j] - self.cell(joint.spring.neutral)

    @property
    def gravity(self) -> Vector:
        """Acceleration of gravity in frame 0; that of a floating base is turned."""
        found = self.vector(self.machine.base.gravity)
        return self._rotation().T * found if self.machine.floating else found

    def _rotation(self) -> Matrix:
        """From the axes of a floating base to those of the world."""
        if self.machine.floating and self.machine.floating.orientation is Orientation.QUATERNION:
            return rotation_of(self.on_base["Q0"])
        a, b, c, d, e, f, g, h, i = self.on_base["R0"]
        return Matrix(Vector(a, b, c), Vector(d, e, f), Vector(g, h, i))

    @property
    def depth(self) -> Scalar:
        """g . P of the origin of frame 0 in the world; zero where frame 0 is the world."""
        if self.machine.floating is None:
            return 0
        x, y, z = self.on_base["P0"]
        return dot(self.vector(self.machine.base.gravity), Vector(x, y, z))

    def rates(self) -> list[Scalar]:
        """qd by link number, zero for fixed frames and the base."""
        return [self.qd.get(j, 0) for j in range(len(self.mechanism.links) + 1)]

    def given_accelerations(self) -> list[Scalar]:
        """qdd by link number, zero for fixed frames and the base."""
        return [self.qdd.get(j, 0) for j in range(len(self.mechanism.links) + 1)]

    @property
    def base_acceleration(self) -> Twist:
        """V'_0 without gravity."""
        base = self.machine.base
        if self.machine.floating:
            return self._twist_on_base("V0d")
        return self._twist(base.acceleration, base.angular_acceleration)

    @property
    def held_base_acceleration(self) -> Twist:
        """V'_0 without gravity where no coordinate accelerates: that of the file, zero for a floating base."""
        return AT_REST if self.machine.floating else self.base_acceleration

    @property
    def held(self) -> Mechanism:
        """The mechanism on a base that no coordinate accelerates, under gravity."""
        linear, angular = self.held_base_acceleration
        return replace(self.mechanism, acceleration=Twist(linear - self.gravity, angular))

    @property
    def base_rule(self) -> WrenchKnown | None:
        """The wrench on a base that is free to move."""
        floating = self.machine.floating
        if floating is None or floating.known is Given.ACCELERATION:
            return None
        return WrenchKnown(Wrench(*self._twist_on_base("f0")))

    def given_rules(self) -> list[Rule | None]:
        """Every acceleration known."""
        rules: list[Rule | None] = [None] * (len(self.machine.joints) + 1)
        for j in self.machine.moving:
            rules[j] = AccelerationKnown(self.qdd[j])
        return rules

    def exerted(self, j: int) -> Scalar:
        """Sum of the torques on joint j: motor, spring and damper, less friction."""
        return self.tau.get(j, 0) + self.passive_torque(j) - self.friction(j)

    def direct_rules(self) -> list[Rule | None]:
        """Every torque known."""
        rules: list[Rule | None] = [None] * (len(self.machine.joints) + 1)
        for j in self.machine.moving:
            rules[j] = TorqueKnown(self.exerted(j))
        return rules

    def inverse_rules(self) -> list[Rule | None]:
        """Motor accelerations known, elastic and passive torques known [50]-[54]."""
        rules = self.direct_rules()
        for j in self.motors:
            rules[j] = AccelerationKnown(self.qdd_motor[j])
        return rules

    def held_rules(self) -> list[Rule | None]:
        """Every acceleration known, and zero: gives H(q, qd)."""
        rules: list[Rule | None] = [None] * (len(self.machine.joints) + 1)
        for j in self.machine.moving:
            rules[j] = AccelerationKnown(0)
        return rules
