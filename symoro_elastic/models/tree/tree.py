"""The open tree of a machine: its variables, transforms and mechanism as expressions of a graph."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from types import MappingProxyType
from typing import Any

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.arguments import arguments
from symoro_elastic.machine.checks import formulas
from symoro_elastic.machine.flexible import FlexibleBody
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.frames import Points, row_under
from symoro_elastic.machine.loops import Closing
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine, NamedFrame, Orientation
from symoro_elastic.machine.scene import Point
from symoro_elastic.mechanics.base_body import rotation_of
from symoro_elastic.mechanics.coordinates import Row, combination
from symoro_elastic.mechanics.flexible_inertia import Modes
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.spatial import (
    AT_REST,
    NO_WRENCH,
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
    roll_pitch_yaw,
    translation,
)
from symoro_elastic.quantities import ON_BASE
from symoro_elastic.symbolic.differentiation import Differentiation, substitute
from symoro_elastic.symbolic.expression import Expression, Graph, Level, operand
from symoro_elastic.symbolic.functions import Circle, arc_tangent, cosine_sine, square_root
from symoro_elastic.symbolic.program import Names

NO_LINKS: Mapping[int, Link] = MappingProxyType({})


def _exact(x: Scalar) -> Scalar:
    """Constants as fractions, so that their quotients are exact."""
    value = operand(x)
    return value if isinstance(value, Expression) else Fraction(value)


class Cells:
    """The cells of a machine as expressions; `folded` names parameters that become constants.

    With `sharing` they are expressions of that graph, with its names and constants.
    """

    def __init__(
        self, machine: Machine, folded: Sequence[str] = (), points: Points = (), *, sharing: Cells | None = None
    ) -> None:
        self.machine, self.points = machine, points
        self.graph: Graph = sharing.graph if sharing else Graph()
        self.names: Names = sharing.names if sharing else Names()
        self._functions: dict[str, Callable[..., Any]] = {
            "sin": lambda x: _exact(cosine_sine(self.graph, x)[1]),
            "cos": lambda x: _exact(cosine_sine(self.graph, x)[0]),
            "tan": self._tangent,
            "sqrt": lambda x: square_root(self.graph, x),
            "atan2": lambda y, x: arc_tangent(self.graph, y, x),
        }
        self._cells: dict[str, Scalar] = sharing._cells if sharing else self._parameter_cells(folded)

    def values_by_name(self, variables: Mapping[str, Scalar]) -> dict[str, Scalar]:
        """Values of the names in cells: parameters, and these variables."""
        return {**self._cells, **variables}

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
        of_point = any(formula in at for _, at in self.points if at)
        elsewhere = "scene, outputs" if of_point else "parameters"
        return next((place for place, written in formulas(self.machine) if written == formula), elsewhere)

    def twist(self, linear: Sequence[Formula], angular: Sequence[Formula]) -> Twist:
        """The expressions of a twist."""
        return Twist(self.vector(linear), self.vector(angular))

    def body(self, body: Body) -> RigidInertia:
        """The expressions of a body, about the origin of its frame."""
        mass, moments, inertia = self.cell(body.mass), self.vector(body.moments), Symmetric(*self.cells(body.inertia))
        if not body.central:
            return RigidInertia(mass, moments, inertia)
        return RigidInertia.about_center(mass, moments, inertia)


class Tree(Cells):
    """A machine whose cells are expressions of a graph, its loops open: every joint coordinate is a symbol.

    The `points`, frames without a row, are further fixed frames of its mechanism. `mounted` are links that replace
    those of the table, by joint.
    """

    def __init__(
        self,
        machine: Machine,
        folded: Sequence[str] = (),
        points: Points = (),
        *,
        sharing: Cells | None = None,
        mounted: Mapping[int, Link] = NO_LINKS,
    ) -> None:
        super().__init__(machine, folded, points, sharing=sharing)
        self.motors, self._mounted = machine.motors, mounted
        entries = self.arguments()
        self.q = self._per_joint(entries["q"], machine.independent)
        self.qd = self._per_joint(entries["qd"], machine.independent)
        self.qdd = self._per_joint(entries["qdd"], machine.independent)
        self.tau = self._per_joint(entries["tau"], self.motors)
        self.qdd_motor = self._per_joint(entries["qdd_motor"], self.motors)
        self.z = self._per_joint(entries["z"], machine.bristles)
        self.load = self._per_joint(entries["load"], machine.loaded)
        self.on_base = {
            row.name: tuple(map(self.graph.symbol, row.entries)) for row in (ON_BASE if machine.floating else ())
        }
        self.variables: dict[int, Scalar] = {
            j: self.graph.symbol(str(machine.joint(j).variable)) for j in machine.with_variable
        }
        self.placed: dict[int, Circle] = {}
        """Cosine and sine of the joints whose closed forms give these."""
        self.mechanism = self.mechanism_at_variables()

    @cached_property
    def couplings(self) -> dict[int, Coupling]:
        """The formulas of joint coordinates that cells of joints hold, by joint."""
        rows = ((j, self.machine.joint(j).selected) for j in self.machine.articulated)
        return {j: self.coupling(cell) for j, cell in rows if not cell.names.isdisjoint(self.machine.variables)}

    def coupling(self, formula: Formula) -> Coupling:
        """A formula of joint coordinates, and its derivatives."""
        return Coupling(self, formula)

    def row(self, j: int, S_x: Mapping[int, Row]) -> Row:
        """Rates of joint j where joint coordinates have the rates S_x: dq_j/dx S_x (L1)."""
        own = [(1, S_x[j])] if j in S_x else []
        if j not in self.couplings:
            return own[0][1] if own else {}
        followed = ((x, S_x[v]) for v, x in self.couplings[j].partials.items() if v in S_x)
        return combination([*own, *followed])

    def _per_joint(self, entries: Sequence[str], joints: Sequence[int]) -> dict[int, Expression]:
        return dict(zip(joints, map(self.graph.symbol, entries), strict=True))

    def mechanism_at_variables(self) -> Mechanism:
        """The mechanism with each joint at the value of its variable, loops open."""
        base, floating = self.machine.base, self.machine.floating
        links = [self._mounted.get(j) or self._link(j, joint) for j, joint in enumerate(self.machine.joints, start=1)]
        links += [self.fixed_link(number, at) for number, at in self.points]
        linear, angular = self.base_acceleration
        velocity = self.twist_on_base("V0") if floating else self.twist(base.velocity, base.angular_velocity)
        return Mechanism(
            tuple(links),
            velocity,
            Twist(linear - self.gravity, angular),
            self.body(floating.body) if floating else None,
            self.damping_of_base(velocity),
        )

    def damping_of_base(self, velocity: Twist) -> Wrench:
        """The wrench of the dampers of a floating base at its velocity."""
        entries = [self.cell(c) * v for c, v in zip(self.machine.damping_of_base, velocity.entries, strict=False)]
        return Wrench(Vector(*entries[:3]), Vector(*entries[3:])) if entries else NO_WRENCH

    def offset(self, j: int) -> Scalar:
        """Value of a joint's cell without its own variable, to which the joint coordinate is added."""
        joint = self.machine.joint(j)
        names = joint.selected.names & self.machine.variables.keys()
        values = {name: self.variables[self.machine.variables[name]] for name in names}
        return self.cell(joint.selected, self.values_by_name(values))

    def angle(self, j: int) -> Scalar:
        """The angle, or the shift, of a joint: its coordinate plus its offset."""
        return self.offset(j) + self.variables.get(j, 0)

    def twist_on_base(self, argument: str) -> Twist:
        """An argument of a floating base that is a twist: its linear, then its angular part."""
        entries = self.on_base[argument]
        return Twist(Vector(*entries[:3]), Vector(*entries[3:]))

    def _link(self, j: int, joint: Joint) -> Link:
        theta = self.angle(j) if joint.sigma == 0 else self.cell(joint.theta)
        r = self.angle(j) if joint.sigma == 1 else self.cell(joint.r)
        steps = (  # (1)
            AxialTransform(Z, *cosine_sine(self.graph, self.cell(joint.gamma)), self.cell(joint.b)),
            AxialTransform(X, *cosine_sine(self.graph, self.cell(joint.alpha)), self.cell(joint.d)),
            AxialTransform(Z, *(self.placed.get(j) or cosine_sine(self.graph, theta)), r),
        )
        wrench = Wrench(self.vector(joint.wrench.force), self.vector(joint.wrench.moment))
        modes = self._modes(*self.machine.flexible_bodies[j]) if j in self.machine.flexible_bodies else None
        return Link(
            joint.antecedent,
            Axis.NONE if joint.kind is Kind.CUT else Axis(joint.sigma),
            Transform(steps),
            modes.deformed(self.body(joint.body)) if modes else self.body(joint.body),
            self.cell(joint.reflected_inertia),
            wrench,
            modes=modes,
        )

    def _modes(self, body: FlexibleBody, numbers: Sequence[int]) -> Modes:
        """The modes of a flexible body; those of rows that do not move have constant deflections."""
        rows = {j: self.machine.joint(j) for j in numbers}
        e = tuple(self.variables.get(j, self.cell(row.r) + self.cell(row.theta)) for j, row in rows.items())
        Ct1, T1 = (
            tuple(tuple(map(_vector, row)) for row in body.Ct1),
            tuple(tuple(map(_matrix, row)) for row in body.T1),
        )
        Mee = tuple(tuple(map(_number, row)) for row in body.Mee)
        return Modes(tuple(numbers), e, tuple(map(_vector, body.Ct0)), Ct1, tuple(map(_matrix, body.T0)), T1, Mee)

    def fixed_link(self, number: int, at: Point | None = None) -> Link:
        """A frame that has no row: a named one, or one whose origin is another point of a body."""
        steps = translation(self.vector(at)) if at else Transform(())
        carrier = row_under(self.machine, number)
        if number > len(self.machine.joints):
            steps = steps.after(self._placement(self.machine.frames[number - len(self.machine.joints) - 1]))
        return Link(self.met_frame(carrier), Axis.NONE, steps)

    def _placement(self, frame: NamedFrame) -> Transform:
        """Trans(at) Rot(z, yaw) Rot(y, pitch) Rot(x, roll)."""
        roll, pitch, yaw = (cosine_sine(self.graph, self.cell(angle)) for angle in frame.rpy)
        return roll_pitch_yaw(roll, pitch, yaw).after(translation(self.vector(frame.at)))

    def link_of(self, number: int, at: Point | None = None) -> int:
        """Number in the mechanism of a frame, or of a point of it; those without a row come after the table."""
        if at is None and number <= len(self.machine.joints):
            return self.met_frame(number)
        return len(self.machine.joints) + 1 + self.points.index((number, at))

    def arguments(self) -> dict[str, tuple[str, ...]]:
        """Names of the entries of the arguments of generated functions."""
        return self._arguments

    @cached_property
    def _arguments(self) -> dict[str, tuple[str, ...]]:
        return arguments(self.machine)

    @property
    def gravity(self) -> Vector:
        """Acceleration of gravity in frame 0, rotated for a floating base."""
        gravity = self.vector(self.machine.base.gravity)
        return self.base_rotation.T * gravity if self.machine.floating else gravity

    @property
    def base_rotation(self) -> Matrix:
        """Rotation from the axes of a floating base to the axes of the world."""
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

    def met_frame(self, j: int) -> int:
        """Number of the frame that coincides with frame j at a cut joint; j itself for other frames."""
        return self._met.get(j, j)

    @cached_property
    def _met(self) -> dict[int, int]:
        return {loop.cut: loop.meets for loop in self.machine.loops if loop.closes is Closing.FRAME}

    @property
    def base_acceleration(self) -> Twist:
        """Acceleration V'_0 of the base without gravity."""
        base = self.machine.base
        if self.machine.floating:
            return self.twist_on_base("V0d")
        return self.twist(base.acceleration, base.angular_acceleration)

    @property
    def held_base_acceleration(self) -> Twist:
        """Acceleration V'_0 of the base without gravity at zero accelerations of all coordinates."""
        return AT_REST if self.machine.floating else self.base_acceleration


def _number(x: float) -> Scalar:
    return Fraction(x) if x else 0


def _vector(entries: Sequence[float]) -> Vector:
    return Vector(*map(_number, entries))


def _matrix(rows: Sequence[Sequence[float]]) -> Matrix:
    return Matrix(*map(_vector, rows))


class Coupling:
    """A formula of joint coordinates: its value, and its derivatives by them."""

    def __init__(self, tree: Tree, formula: Formula) -> None:
        self._tree = tree
        variables = tree.machine.variables
        self.by = {variables[name]: tree.graph.symbol(name) for name in sorted(formula.names & variables.keys())}
        self._formal = tree.cell(
            formula, tree.values_by_name({name: tree.graph.symbol(name) for name in formula.names & variables.keys()})
        )

    @property
    def value(self) -> Scalar:
        """The formula at the values of the variables."""
        return self._at(self._formal)

    @cached_property
    def partials(self) -> dict[int, Scalar]:
        """Derivatives by joint coordinates, by number of the joint."""
        return {v: self._at(x) for v, x in self._formal_partials.items()}

    def second(self, rates: Mapping[int, Scalar]) -> Scalar:
        """Sum of second derivatives times rates: the second derivative by time at constant rates (L4)."""
        total: Scalar = 0
        derivatives = Differentiation(self._formal_partials.values())
        for w, symbol in self.by.items():
            tangents = derivatives.by(symbol)
            for v, x in self._formal_partials.items():
                total = total + self._at(tangents.of(x)) * (rates[v] * rates[w])
        return total

    @cached_property
    def _formal_partials(self) -> dict[int, Scalar]:
        derivatives = Differentiation([self._formal])
        return {v: derivatives.by(symbol).of(self._formal) for v, symbol in self.by.items()}

    def _at(self, x: Scalar) -> Scalar:
        """The value of an expression whose variables have their own symbols."""
        values = {self.by[v].operands[0]: self._tree.variables[v] for v in self.by}
        changed = {name: value for name, value in values.items() if value is not self._tree.graph.symbol(name)}
        return substitute(self._tree.graph, [x], changed)[0] if changed and isinstance(x, Expression) else x
