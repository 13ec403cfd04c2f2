"""A machine bound to the equations: every cell of its table an expression of one graph."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from symoro_elastic.machine.arguments import arguments
from symoro_elastic.machine.loops import Closing
from symoro_elastic.machine.machine import Given, Joint, Kind, Machine, Orientation
from symoro_elastic.mechanics.bias_acceleration import with_tips_in_frames_before
from symoro_elastic.mechanics.clusters import Cluster
from symoro_elastic.mechanics.coordinates import image, product, projection
from symoro_elastic.mechanics.dynamics import AccelerationKnown, Rule, Rules
from symoro_elastic.mechanics.floating_base import WrenchKnown, rotation_of
from symoro_elastic.mechanics.joint_laws import elastic_torque, friction, friction_slope, smooth_sign
from symoro_elastic.mechanics.loops.planar import Closed
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
from symoro_elastic.models.coordinates import Coordinates, Coupling
from symoro_elastic.models.loops.closed_forms import in_space, mapped, own_variable, planar
from symoro_elastic.models.loops.naming import name_positions, name_turns, reserve_sections
from symoro_elastic.models.loops.plan import Form, LoopPlan, plan_of
from symoro_elastic.models.parallel_links import with_parallel_links
from symoro_elastic.models.rules import Motion
from symoro_elastic.quantities import ON_BASE, Quantity
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.expression import Expression, operand
from symoro_elastic.symbolic.functions import Circle, cosine_sine, sign, square_root


class Bound(Cells):
    """A machine whose cells are expressions of one graph.

    Each of the `points`, (number of the frame, coordinates in it), is one more fixed frame of its mechanism.
    `by` names the columns of derivatives, all where it is empty.
    """

    def __init__(
        self, machine: Machine, folded: Sequence[str] = (), points: Points = (), by: Sequence[str] = ()
    ) -> None:
        super().__init__(machine, folded, points)
        self.by = by
        self.motors = machine.motors
        self.q = self._per_joint("q", machine.moving)
        self.qd = self._per_joint("qd", machine.moving)
        self.qdd = self._per_joint("qdd", machine.moving)
        self.tau = self._per_joint("tau", self.motors)
        self.qdd_motor = self._per_joint("qdd_motor", self.motors)
        self.on_base = {row.name: tuple(map(self.graph.symbol, row.entries)) for row in self._rows_on_base()}
        self.loops = plan_of(machine, Bound).loops if machine.loops else ()
        self.assembled = tuple(sorted({j for loop in self.loops if loop.is_assembled for j in loop.dependent}))
        """Joints whose variables have no closed form: arguments of the models."""
        self.takes_dependent = bool(self.assembled)
        self.close_loops()

    def close_loops(self) -> None:
        """Bind own variables, the mechanism, and closed forms of its loops."""
        self.variables: dict[int, Scalar] = {
            j: self.graph.symbol(str(self.machine.joint(j).variable)) for j in self.machine.owners
        }
        self.placed: dict[int, Circle] = {}
        self.mechanism = self._mechanism()
        reserve_sections(self.names, [loop for loop in self.loops if loop.form is not Form.MAP])
        for loop in self.loops:
            self._close(loop)
        if self.machine.is_coupled:
            self.mechanism = with_parallel_links(self, self.mechanism)
        for loop in self.loops:
            name_turns(self.names, loop, {j: self.mechanism.link(j).transform.steps[2] for j in loop.dependent})
        self.coordinates = Coordinates(self, self.loops)

    def _rows_on_base(self) -> Iterable[Quantity]:
        return ON_BASE if self.machine.floating else ()

    def _per_joint(self, argument: str, joints: Sequence[int]) -> dict[int, Expression]:
        return dict(zip(joints, map(self.graph.symbol, arguments(self.machine)[argument]), strict=True))

    def _mechanism(self) -> Mechanism:
        base, floating = self.machine.base, self.machine.floating
        links = [self._link(j, joint) for j, joint in enumerate(self.machine.joints, start=1)]
        links += [Link(self.met(j), Axis.NONE, translation(self.vector(at))) for j, at in self.points]
        linear, angular = self.base_acceleration
        return Mechanism(
            tuple(links),
            self._twist_on_base("V0") if floating else self.twist(base.velocity, base.angular_velocity),
            Twist(linear - self.gravity, angular),
            self.body(floating.body) if floating else None,
        )

    def _close(self, loop: LoopPlan) -> None:
        """Put closed forms in place of the dependent variables of a loop."""
        if loop.is_assembled:
            return
        if loop.form is Form.MAP:
            angles = mapped(self, loop.loop, loop.dependent) or {}
            self.variables |= {j: x - self.offset(j) for j, x in angles.items()}
        else:
            found = self._closed(loop)
            name_positions(self.names, loop, found)
            for j in loop.dependent:
                turn = found.turns.get(j)
                self.variables[j] = (
                    own_variable(self, j, turn, loop.half_turns[j]) if turn else found.slides[j] - self.offset(j)
                )
                self.placed |= {j: (operand(turn.x), operand(turn.y))} if turn else {}
        self.mechanism = self._mechanism()

    def _closed(self, loop: LoopPlan) -> Closed:
        if not loop.is_in_space:
            return planar(self, loop.loop, loop.dependent, loop.signs)
        plan = plan_of(self.machine, Bound)
        found = in_space(self, loop.loop, loop.dependent, plan.assembly, plan.positions)
        if found is None:
            what = "its closed form is lost where parameters are numbers: fold fewer of its lengths and angles"
            raise self.machine.error(f"loop {loop.loop.name}", what)
        return found

    def offset(self, j: int) -> Scalar:
        """What the cell of a joint adds to its own variable."""
        joint = self.machine.joint(j)
        names = joint.selected.names & self.machine.variables.keys()
        values = {name: self.variables[self.machine.variables[name]] for name in names}
        return self.cell(joint.selected, self.named(values))

    def angle(self, j: int) -> Scalar:
        """The angle, or the shift, of a joint: its own variable and what its cell adds."""
        return self.offset(j) + self.variables.get(j, 0)

    def _twist_on_base(self, argument: str) -> Twist:
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
        return arguments(self.machine)

    def rate(self, j: int) -> Scalar:
        """Rate of the joint's own variable; of a coupled joint, that of the joint."""
        own = self.coordinates.rates_x
        return own[j] if j in own else product(self.coordinates.S[j], self.qd)

    def sign_of_velocity(self, j: int) -> Scalar:
        """Sign of the rate of joint j, as its friction has it: smooth where it creeps."""
        speed = self._speed(j)
        return sign(self.graph, self.rate(j)) if speed is None else smooth_sign(self.rate(j), speed)

    def _speed(self, j: int) -> Scalar | None:
        """sqrt(qd^2 + creep^2) of a joint that creeps; None for others."""
        creep = self.cell(self.machine.joint(j).friction.creep)
        if self.machine.joint(j).friction.creep.is_zero:
            return None
        rate = self.rate(j)
        return square_root(self.graph, rate * rate + creep * creep)

    def friction(self, j: int) -> Scalar:
        """Friction of joint j, opposing motion."""
        law = self.machine.joint(j).friction
        viscous, coulomb = self.cell(law.viscous), self.cell(law.coulomb)
        return friction(viscous, coulomb, self.rate(j), self.sign_of_velocity(j))

    def friction_slope(self, j: int) -> Scalar:
        """Derivative of friction by the rate of joint j; a sign counts as constant."""
        law = self.machine.joint(j).friction
        viscous, coulomb, speed = self.cell(law.viscous), self.cell(law.coulomb), self._speed(j)
        return viscous if speed is None else friction_slope(viscous, coulomb, self.cell(law.creep), speed)

    def passive_torque(self, j: int) -> Scalar:
        """Torque of spring and damper on joint j [9]; zero for joints without."""
        stiffness, deflection = self.spring(j)
        damping = self.cell(self.machine.joint(j).spring.damping)
        return elastic_torque(stiffness, deflection, damping, self.rate(j))

    def spring(self, j: int) -> tuple[Scalar, Scalar]:
        """Stiffness of joint j and deflection of its spring; zero for joints without."""
        joint = self.machine.joint(j)
        if joint.kind is not Kind.ELASTIC:
            return 0, 0
        return Coupling(self, joint.spring.stiffness).value, self.variables[j] - self.cell(joint.spring.neutral)

    def exerted(self, j: int) -> Scalar:
        """Sum of the torques on the own variable of joint j: motor, spring and damper, less friction."""
        return self.tau.get(j, 0) + self.passive_torque(j) - self.friction(j)

    def own_forces(self) -> dict[int, Scalar]:
        """Sum of what is exerted on each own variable, and what a stiffness that it changes does on it."""
        return self._with_stiffness_changes({j: self.exerted(j) for j in self.machine.owners})

    def exerted_forces(self) -> dict[int, Scalar]:
        """What is exerted on the independent variables (L3)."""
        return self._on_independent(self.own_forces())

    def passive_forces(self) -> dict[int, Scalar]:
        """The same without the motors."""
        found = {j: self.passive_torque(j) - self.friction(j) for j in self.machine.owners}
        return self._on_independent(self._with_stiffness_changes(found))

    def friction_forces(self) -> dict[int, Scalar]:
        """Friction on the independent variables, opposing motion."""
        own = {j: self.friction(j) for j in self.machine.owners}
        return self._projected(own, {j: self.friction(j) for j in self._coupled})

    def _with_stiffness_changes(self, own: dict[int, Scalar]) -> dict[int, Scalar]:
        """Forces with -k' deflection^2 / 2 of springs whose stiffness k changes with own variables."""
        for j in self.machine.elastic:
            _, deflection = self.spring(j)
            for v, change in Coupling(self, self.machine.joint(j).spring.stiffness).partials.items():
                own[v] = own[v] - change * deflection * deflection / 2
        return own

    def _on_independent(self, own: Mapping[int, Scalar]) -> dict[int, Scalar]:
        return self._projected(own, {j: -self.friction(j) for j in self._coupled})

    def _projected(self, own: Mapping[int, Scalar], of_joints: Mapping[int, Scalar]) -> dict[int, Scalar]:
        found = dict.fromkeys(self.machine.moving, 0) | projection(self.coordinates.S_x, own)
        for k, x in projection(self.coordinates.S, of_joints).items():
            found[k] = found[k] + x
        return found

    @property
    def _coupled(self) -> tuple[int, ...]:
        """Joints without a variable of their own, on which friction acts by their rate."""
        return tuple(j for j in self.machine.articulated if j not in self.machine.owners)

    def on_independent(self, Gamma: Mapping[int, Scalar]) -> dict[int, Scalar]:
        """Forces of the joints on the independent variables: S^T Gamma (L3)."""
        return dict.fromkeys(self.machine.moving, 0) | projection(self.coordinates.S, Gamma)

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

    def rates(self) -> list[Scalar]:
        """Rates of the joints by link number, zero for fixed frames and the base."""
        return self._by_link(image(self.coordinates.S, self.qd))

    def given_accelerations(self) -> list[Scalar]:
        """Accelerations of the joints by link number, zero for fixed frames and the base."""
        return self._by_link(image(self.coordinates.S, self.qdd, self.coordinates.gam))

    def bias_accelerations(self) -> list[Scalar]:
        """The same where the independent variables do not accelerate: gam (L2)."""
        return self._by_link(self.coordinates.gam)

    def met(self, j: int) -> int:
        """Number of the frame that a cut joint meets, with which its own coincides; that of any other frame itself."""
        return self._met.get(j, j)

    @cached_property
    def _met(self) -> dict[int, int]:
        return {loop.cut: loop.meets for loop in self.machine.loops if loop.closes is Closing.FRAME}

    def _by_link(self, by_joint: Mapping[int, Scalar]) -> list[Scalar]:
        return [by_joint.get(j, 0) for j in range(len(self.mechanism.links) + 1)]

    @property
    def base_acceleration(self) -> Twist:
        """V'_0 without gravity."""
        base = self.machine.base
        if self.machine.floating:
            return self._twist_on_base("V0d")
        return self.twist(base.acceleration, base.angular_acceleration)

    @property
    def held_base_acceleration(self) -> Twist:
        """V'_0 without gravity where no coordinate accelerates: that of the file, zero for a floating base."""
        return AT_REST if self.machine.floating else self.base_acceleration

    @cached_property
    def without_tip_angles(self) -> Mechanism:
        """The mechanism; where joints are coupled, tips in the frames before their joints' rotations.

        The angle of a balanced rotor then is in no equation (L7).
        """
        if not self.machine.is_coupled:
            return self.mechanism
        single = [j for j in self.machine.articulated if self.mechanism.link(j).parallel is None]
        return with_tips_in_frames_before(self.mechanism, single)

    @property
    def held(self) -> Mechanism:
        """The mechanism on a base that no coordinate accelerates, under gravity."""
        linear, angular = self.held_base_acceleration
        return replace(self.without_tip_angles, acceleration=Twist(linear - self.gravity, angular))

    @property
    def base_rule(self) -> WrenchKnown | None:
        """The wrench on a base that is free to move."""
        floating = self.machine.floating
        if floating is None or floating.known is Given.ACCELERATION:
            return None
        return WrenchKnown(Wrench(*self._twist_on_base("f0")))

    def given_rules(self) -> Rules:
        """Every acceleration known."""
        return Motion(self, self.qdd, {}).rules

    def held_rules(self) -> Rules:
        """Every acceleration known, zero for the independent variables: gives H(q, qd)."""
        return Motion(self, dict.fromkeys(self.machine.moving, 0), {}).rules

    def still_rules(self) -> Rules:
        """Every acceleration known, and zero, at rest."""
        rules: list[Rule | Cluster | None] = [None] * (len(self.machine.joints) + 1)
        for j in self.machine.articulated:
            rules[j] = AccelerationKnown(0)
        return rules

    def direct_motion(self) -> Motion:
        """Every torque known."""
        return Motion(self, {}, self.exerted_forces())

    def inverse_motion(self) -> Motion:
        """Motor accelerations known, elastic and passive torques known [50]-[54]."""
        known = {j: x for j, x in self.qdd_motor.items() if j in self.machine.moving}
        return Motion(self, known, self.passive_forces())
