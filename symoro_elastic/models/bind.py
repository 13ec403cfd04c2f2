"""A machine bound to the equations: every cell of its table an expression of one graph, its loops closed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.mechanics.bias_acceleration import with_tips_in_frames_before
from symoro_elastic.mechanics.coordinates import joint_accelerations, joint_rates, product, projection
from symoro_elastic.mechanics.kinematics import path
from symoro_elastic.mechanics.loops.planar import Closed
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.spatial import Twist, Vector, Wrench, cross
from symoro_elastic.models.base_parameters import Grouping
from symoro_elastic.models.cells import Points
from symoro_elastic.models.coordinates import Coordinates
from symoro_elastic.models.joint_friction import JointFriction
from symoro_elastic.models.joint_spring import JointSpring
from symoro_elastic.models.loops.closed_forms import in_space, own_variable, parallelogram_angles, planar
from symoro_elastic.models.loops.naming import name_positions, name_turns, reserve_sections
from symoro_elastic.models.loops.plan import Form, LoopPlan, assembled_joints, loops_of, plan_of
from symoro_elastic.models.motor_cogging import MotorCogging
from symoro_elastic.models.once import once_for_each_machine
from symoro_elastic.models.parallel_links import with_parallel_links
from symoro_elastic.models.tree import NO_LINKS, Coupling, Tree
from symoro_elastic.symbolic.expression import operand

EXTERNAL_WRENCHES = "f_ext"
"""The argument of models that holds wrenches of the surroundings on frames, in axes of frame 0."""


@once_for_each_machine
def closed_forms(machine: Machine) -> dict[int, Scalar]:
    """Joint coordinates of a machine, by joint: symbols, and closed forms that loops give."""
    return dict(Bound(machine).variables)


class Bound(Tree):
    """A machine whose cells are expressions of one graph, with closed forms of its loops.

    Each of the `points`, (number of the frame, coordinates in it), is one more fixed frame of its mechanism.
    `by` names the columns of derivatives, all where it is empty. A machine bound `beside` another shares its graph, and
    its loops close alike; `mounted` are links in place of those of the table, by joint. `grouping` is that of its
    inertial parameters, for models that need it.
    """

    def __init__(
        self,
        machine: Machine,
        folded: Sequence[str] = (),
        points: Points = (),
        by: Sequence[str] = (),
        *,
        beside: Bound | None = None,
        mounted: Mapping[int, Link] = NO_LINKS,
        grouping: Grouping | None = None,
    ) -> None:
        super().__init__(machine, folded, points, beside=beside, mounted=mounted)
        self.by = by
        self.grouping = grouping
        self.loops: tuple[LoopPlan, ...] = beside.loops if beside else loops_of(machine)
        self.torques: dict[int, Scalar] = {**self.tau}
        """Torques of motors: arguments, or what drives make of these."""
        self.assembled: tuple[int, ...] = beside.assembled if beside else assembled_joints(machine)
        """Joints whose variables have no closed form: arguments of the models."""
        self._close_loops()

    def _close_loops(self) -> None:
        """Put closed forms of loops in place of variables; the mechanism with all that its links know of others."""
        reserve_sections(self.names, [loop for loop in self.loops if loop.form is not Form.MAP])
        for loop in self.loops:
            self._close(loop)
        if self.machine.is_coupled:
            self.mechanism = with_parallel_links(self, self.mechanism)
        for loop in self.loops:
            name_turns(self.names, loop, {j: self.mechanism.link(j).transform.steps[2] for j in loop.dependent})
        if self.machine.forces:
            self.mechanism = with_external_wrenches(self, self.mechanism)
        self.coordinates = Coordinates(self, self.loops)

    def _close(self, loop: LoopPlan) -> None:
        """Put closed forms in place of the dependent variables of a loop."""
        if loop.is_assembled:
            return
        if loop.form is Form.MAP:
            angles = parallelogram_angles(self, loop.loop, loop.dependent) or {}
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
        self.mechanism = self.mechanism_at_variables()

    def _closed(self, loop: LoopPlan) -> Closed:
        if not loop.is_in_space:
            return planar(self, loop.loop, loop.dependent, loop.signs)
        plan = plan_of(self.machine)
        found = in_space(self, loop.loop, loop.dependent, plan.assembly, plan.positions)
        if found is None:
            what = "its closed form is lost where parameters are numbers: fold fewer of its lengths and angles"
            raise self.machine.error(f"loop {loop.loop.name}", what)
        return found

    def rate(self, j: int) -> Scalar:
        """Rate of the joint coordinate; of a coupled joint, that of the joint."""
        own = self.coordinates.rates_x
        return own[j] if j in own else product(self.coordinates.S[j], self.qd)

    def sign_of_velocity(self, j: int) -> Scalar:
        """Sign of the rate of joint j, as its friction has it: smooth where it creeps."""
        return self.friction_of(j).sense()

    def friction_of(self, j: int) -> JointFriction:
        """The law of friction of joint j at its rate."""
        law = self.machine.joint(j).friction
        cells = (law.viscous, law.coulomb, law.creep, law.static, law.stribeck, law.load)
        bristle = (law.bristle, law.bristle_damping, law.breakaway)
        found = (self.cell(one) for one in (*cells, *bristle))
        return JointFriction(self.graph, self.rate(j), self.z.get(j, 0), self.load.get(j, 0), *found)

    def friction(self, j: int) -> Scalar:
        """Friction of joint j, opposing motion."""
        return self.friction_of(j).force()

    def friction_slope(self, j: int) -> Scalar:
        """Derivative of friction by the rate of joint j; a sign counts as constant."""
        return self.friction_of(j).slope()

    def passive_torque(self, j: int) -> Scalar:
        """Torque of spring and damper on joint j [9]; zero for joints without."""
        return self.spring_of(j).torque(self.rate(j))

    def spring_of(self, j: int) -> JointSpring | MotorCogging:
        """The law of spring and damper of joint j at its deflection; of a motor with cogging that of its position."""
        if not self.machine.joint(j).cogging.amplitude.is_zero:
            cogging = self.machine.joint(j).reflected_cogging
            amplitude, order, phase = map(self.cell, (cogging.amplitude, cogging.order, cogging.phase))
            return MotorCogging(self.graph, amplitude, order, phase, self.variables[j])
        (stiffness, deflection), law = self.spring(j), self.machine.joint(j).spring
        return JointSpring(
            self.graph, stiffness, deflection, *map(self.cell, (law.damping, law.backlash, law.rounding))
        )

    def spring(self, j: int) -> tuple[Scalar, Scalar]:
        """Stiffness of joint j and deflection of its spring; zero for joints without."""
        joint = self.machine.joint(j)
        if joint.kind is not Kind.ELASTIC:
            return 0, 0
        return Coupling(self, joint.spring.stiffness).value, self.variables[j] - self.cell(joint.spring.neutral)

    def exerted_torque(self, j: int) -> Scalar:
        """Sum of the torques on the coordinate of joint j: motor, spring and damper, less friction."""
        return self.torques.get(j, 0) + self.passive_torque(j) - self.friction(j)

    def own_forces(self) -> dict[int, Scalar]:
        """Sum of what is exerted on each joint coordinate, and what a stiffness that it changes does on it."""
        return self._with_stiffness_changes({j: self.exerted_torque(j) for j in self.machine.with_variable})

    def exerted_forces(self) -> dict[int, Scalar]:
        """What is exerted on the independent variables (L3)."""
        return self._on_independent(self.own_forces())

    def passive_forces(self) -> dict[int, Scalar]:
        """The same without the motors."""
        found = {j: self.passive_torque(j) - self.friction(j) for j in self.machine.with_variable}
        return self._on_independent(self._with_stiffness_changes(found))

    def rates_of_bristles(self) -> dict[int, Scalar]:
        """Rates of the states of friction, by joint (D1), (D2)."""
        return {j: self.friction_of(j).rate_of_bristle() for j in self.machine.bristles}

    def friction_forces(self) -> dict[int, Scalar]:
        """Friction on the independent variables, opposing motion."""
        own = {j: self.friction(j) for j in self.machine.with_variable}
        return self._projected(own, {j: self.friction(j) for j in self._coupled})

    def _with_stiffness_changes(self, own: dict[int, Scalar]) -> dict[int, Scalar]:
        """Forces with -k' deflection^2 / 2 of springs whose stiffness k changes with joint coordinates."""
        for j in self.machine.elastic:
            _, deflection = self.spring(j)
            for v, change in Coupling(self, self.machine.joint(j).spring.stiffness).partials.items():
                own[v] = own[v] - change * deflection * deflection / 2
        return own

    def _on_independent(self, own: Mapping[int, Scalar]) -> dict[int, Scalar]:
        return self._projected(own, {j: -self.friction(j) for j in self._coupled})

    def _projected(self, own: Mapping[int, Scalar], of_joints: Mapping[int, Scalar]) -> dict[int, Scalar]:
        found = dict.fromkeys(self.machine.independent, 0) | projection(self.coordinates.S_x, own)
        for k, x in projection(self.coordinates.S, of_joints).items():
            found[k] = found[k] + x
        return found

    @property
    def _coupled(self) -> tuple[int, ...]:
        """Joints without a variable of their own, on which friction acts by their rate."""
        return tuple(j for j in self.machine.articulated if j not in self.machine.with_variable)

    def on_independent(self, Gamma: Mapping[int, Scalar]) -> dict[int, Scalar]:
        """Forces of the joints on the independent variables: S^T Gamma (L3)."""
        return dict.fromkeys(self.machine.independent, 0) | projection(self.coordinates.S, Gamma)

    def rates(self) -> list[Scalar]:
        """Rates of the joints by link number, zero for fixed frames and the base."""
        return self._by_link(joint_rates(self.coordinates.S, self.qd))

    def given_accelerations(self) -> list[Scalar]:
        """Accelerations of the joints by link number, zero for fixed frames and the base."""
        return self._by_link(joint_accelerations(self.coordinates.S, self.qdd, self.coordinates.gam))

    def bias_accelerations(self) -> list[Scalar]:
        """The same where the independent variables do not accelerate: gam (L2)."""
        return self._by_link(self.coordinates.gam)

    def _by_link(self, by_joint: Mapping[int, Scalar]) -> list[Scalar]:
        return [by_joint.get(j, 0) for j in range(len(self.mechanism.links) + 1)]

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
    def unaccelerated_mechanism(self) -> Mechanism:
        """The mechanism on a base that no coordinate accelerates, under gravity."""
        linear, angular = self.held_base_acceleration
        return replace(self.without_tip_angles, acceleration=Twist(linear - self.gravity, angular))


def with_external_wrenches(tree: Tree, mechanism: Mechanism) -> Mechanism:
    """The mechanism under the wrenches `forces` of its machine, each about the origin of its frame, in axes of it."""
    links, names = list(mechanism.links), iter(tree.arguments()[EXTERNAL_WRENCHES])
    rows = FrameNames(tree.machine).own
    for asked in tree.machine.forces:
        j = rows[asked.name]
        force, moment = (Vector(*(tree.graph.symbol(next(names)) for _ in range(3))) for _ in range(2))
        for i in path(mechanism, j):
            turned = mechanism.link(i).transform
            force, moment = turned.to_child(force), turned.to_child(moment)
        if asked.at:
            moment = moment + cross(tree.vector(asked.at), force)
        links[j - 1] = replace(links[j - 1], wrench=links[j - 1].wrench - Wrench(force, moment))
    return replace(mechanism, links=tuple(links))
