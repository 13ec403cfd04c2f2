"""The open tree of a machine: its variables, transforms and mechanism as expressions of one graph."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from types import MappingProxyType

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.arguments import arguments
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.loops import Closing
from symoro_elastic.machine.machine import Joint, Kind, Machine, Orientation
from symoro_elastic.mechanics.base_body import rotation_of
from symoro_elastic.mechanics.coordinates import Row, combination
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.spatial import (
    AT_REST,
    AxialTransform,
    Axis,
    Matrix,
    Transform,
    Twist,
    Vector,
    Wrench,
    X,
    Z,
    dot,
    translation,
)
from symoro_elastic.models.cells import Cells, Points
from symoro_elastic.quantities import ON_BASE
from symoro_elastic.symbolic.differentiation import Differentiation, substitute
from symoro_elastic.symbolic.expression import Expression
from symoro_elastic.symbolic.functions import Circle, cosine_sine

NO_LINKS: Mapping[int, Link] = MappingProxyType({})


class Tree(Cells):
    """A machine whose cells are expressions of one graph, its loops open: every joint coordinate is a symbol.

    Each of the `points`, (number of the frame, coordinates in it), is one more fixed frame of its mechanism.
    `mounted` are links in place of those of the table, by joint.
    """

    def __init__(
        self,
        machine: Machine,
        folded: Sequence[str] = (),
        points: Points = (),
        *,
        beside: Cells | None = None,
        mounted: Mapping[int, Link] = NO_LINKS,
    ) -> None:
        super().__init__(machine, folded, points, beside=beside)
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
        """The mechanism with its joints where the variables are."""
        base, floating = self.machine.base, self.machine.floating
        links = [self._mounted.get(j) or self._link(j, joint) for j, joint in enumerate(self.machine.joints, start=1)]
        links += [Link(self.met_frame(j), Axis.NONE, translation(self.vector(at))) for j, at in self.points]
        linear, angular = self.base_acceleration
        return Mechanism(
            tuple(links),
            self.twist_on_base("V0") if floating else self.twist(base.velocity, base.angular_velocity),
            Twist(linear - self.gravity, angular),
            self.body(floating.body) if floating else None,
        )

    def offset(self, j: int) -> Scalar:
        """What the cell of a joint adds to its coordinate."""
        joint = self.machine.joint(j)
        names = joint.selected.names & self.machine.variables.keys()
        values = {name: self.variables[self.machine.variables[name]] for name in names}
        return self.cell(joint.selected, self.values_by_name(values))

    def angle(self, j: int) -> Scalar:
        """The angle, or the shift, of a joint: its coordinate and what its cell adds."""
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
        return Link(
            joint.antecedent,
            Axis.NONE if joint.kind is Kind.CUT else Axis(joint.sigma),
            Transform(steps),
            self.body(joint.body),
            self.cell(joint.reflected_inertia),
            wrench,
        )

    def arguments(self) -> dict[str, tuple[str, ...]]:
        """Names of the entries of each argument of the generated functions."""
        return self._arguments

    @cached_property
    def _arguments(self) -> dict[str, tuple[str, ...]]:
        return arguments(self.machine)

    @property
    def gravity(self) -> Vector:
        """Acceleration of gravity in frame 0; that of a floating base is turned."""
        found = self.vector(self.machine.base.gravity)
        return self.base_rotation.T * found if self.machine.floating else found

    @property
    def base_rotation(self) -> Matrix:
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

    def met_frame(self, j: int) -> int:
        """Number of the frame that a cut joint meets, with which its own coincides; that of any other frame itself."""
        return self._met.get(j, j)

    @cached_property
    def _met(self) -> dict[int, int]:
        return {loop.cut: loop.meets for loop in self.machine.loops if loop.closes is Closing.FRAME}

    @property
    def base_acceleration(self) -> Twist:
        """V'_0 without gravity."""
        base = self.machine.base
        if self.machine.floating:
            return self.twist_on_base("V0d")
        return self.twist(base.acceleration, base.angular_acceleration)

    @property
    def held_base_acceleration(self) -> Twist:
        """V'_0 without gravity where no coordinate accelerates: that of the file, zero for a floating base."""
        return AT_REST if self.machine.floating else self.base_acceleration


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
        found = Differentiation(self._formal_partials.values())
        for w, symbol in self.by.items():
            tangents = found.by(symbol)
            for v, x in self._formal_partials.items():
                total = total + self._at(tangents.of(x)) * (rates[v] * rates[w])
        return total

    @cached_property
    def _formal_partials(self) -> dict[int, Scalar]:
        found = Differentiation([self._formal])
        return {v: found.by(symbol).of(self._formal) for v, symbol in self.by.items()}

    def _at(self, x: Scalar) -> Scalar:
        """An expression over the variables' own symbols at their values."""
        values = {self.by[v].operands[0]: self._tree.variables[v] for v in self.by}
        changed = {name: value for name, value in values.items() if value is not self._tree.graph.symbol(name)}
        return substitute(self._tree.graph, [x], changed)[0] if changed and isinstance(x, Expression) else x
