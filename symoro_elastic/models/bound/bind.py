"""A machine bound to the equations: the cells of its table as expressions of a single graph, its loops closed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.frames import FrameNames, Points, row_under
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.bias_acceleration import with_tips_in_frames_before
from symoro_elastic.mechanics.coordinates import joint_accelerations, joint_rates, product, projection
from symoro_elastic.mechanics.kinematics import path
from symoro_elastic.mechanics.lagrange import InertiaMatrix, inertia_matrix, of_coordinates
from symoro_elastic.mechanics.loops.planar import Closed
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.spatial import Twist, Vector, Wrench, cross, dot
from symoro_elastic.models.loops.closed_forms import in_space, own_variable, parallelogram_angles, planar
from symoro_elastic.models.loops.coordinates import Coordinates, name_positions, name_turns, reserve_sections
from symoro_elastic.models.loops.plan import Form, LoopPlan, assembled_joints, loops_of, plan_of
from symoro_elastic.models.parameters.base_parameters import Grouping
from symoro_elastic.models.tree.joint_laws import JointFriction, JointSpring, MotorCogging
from symoro_elastic.models.tree.once import once_for_each_machine
from symoro_elastic.models.tree.parallel_links import with_parallel_links
from symoro_elastic.models.tree.tree import NO_LINKS, Coupling, Tree
from symoro_elastic.symbolic.expression import operand

EXTERNAL_WRENCHES = "f_ext"
"""The argument of models that holds wrenches of the surroundings on frames, in axes of frame 0."""


@once_for_each_machine
def closed_forms(machine: Machine) -> dict[int, Scalar]:
    """Joint coordinates of a machine as expressions, by joint: symbols, and closed forms of its loops."""
    return dict(Bound(machine).variables)


class Bound(Tree):
    """A machine whose cells are expressions of a single graph, with closed forms of its loops.

    Each of the `points`, frames without a row, is one more fixed frame of its mechanism. `by` names the columns of
    derivatives, all where it is empty. A machine bound `sharing` with another has its graph and its plan of loops;
    `mounted` are links that replace the table's, by joint. `grouping` is that of its inertial parameters, for
    models that need it.
    """

    def __init__(
        self,
        machine: Machine,
        folded: Sequence[str] = (),
        points: Points = (),
        by: Sequence[str] = (),
        *,
        sharing: Bound | None = None,
        mounted: Mapping[int, Link] = NO_LINKS,
        grouping: Grouping | None = None,
    ) -> None:
        super().__init__(machine, folded, points, sharing=sharing, mounted=mounted)
        self.by = by
        self.grouping = grouping
        self.loops: tuple[LoopPlan, ...] = sharing.loops if sharing else loops_of(machine)
        self.torques: dict[int, Scalar] = {**self.tau}
        """Torques of motors: arguments, or the outputs of their drives."""
        self.assembled: tuple[int, ...] = sharing.assembled if sharing else assembled_joints(machine)
        """Joints whose variables have no closed form: arguments of the models."""
        self._close_loops()

    def _close_loops(self) -> None:
        """Replace variables by closed forms of loops, and complete the mechanism: parallel links, external wrenches."""
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
        """Replace the dependent variables of a loop by their closed forms."""
        if loop.is_assembled:
            return
        if loop.form is Form.MAP:
            angles = parallelogram_angles(self, loop.loop, loop.dependent) or {}
            self.variables |= {j: x - self.offset(j) for j, x in angles.items()}
        else:
            closed_form = self._closed_form(loop)
            name_positions(self.names, loop, closed_form)
            for j in loop.dependent:
                turn = closed_form.turns.get(j)
                self.variables[j] = (
                    own_variable(self, j, turn, loop.half_turns[j]) if turn else closed_form.slides[j] - self.offset(j)
                )
                self.placed |= {j: (operand(turn.x), operand(turn.y))} if turn else {}
        self.mechanism = self.mechanism_at_variables()

    def _closed_form(self, loop: LoopPlan) -> Closed:
        if not loop.is_in_space:
            return planar(self, loop.loop, loop.dependent, loop.signs)
        plan = plan_of(self.machine)
        closed_form = in_space(self, loop.loop, loop.dependent, plan.assembly, plan.positions)
        if closed_form is None:
            what = "its closed form is lost where parameters are numbers: fold fewer of its lengths and angles"
            raise self.machine.error(f"loop {loop.loop.name}", what)
        return closed_form

    def rate(self, j: int) -> Scalar:
        """Rate of the coordinate of joint j; of a coupled joint, the rate of the joint itself."""
        own = self.coordinates.rates_x
        return own[j] if j in own else product(self.coordinates.S[j], self.qd)

    def friction_of(self, j: int) -> JointFriction:
        """The law of friction of joint j at its rate."""
        law = self.machine.joint(j).friction
        cells = (law.viscous, law.coulomb, law.creep, law.static, law.stribeck, law.load)
        bristle = (law.bristle, law.bristle_damping, law.breakaway)
        coefficients = (self.cell(cell) for cell in (*cells, *bristle))
        return JointFriction(self.graph, self.rate(j), self.z.get(j, 0), self.load.get(j, 0), *coefficients)

    def friction(self, j: int) -> Scalar:
        """Friction of joint j, opposing motion, including that of its ball joint."""
        return self.friction_of(j).force() + self.friction_of_balls.get(j, 0)

    @cached_property
    def damping_of_balls(self) -> dict[int, Scalar]:
        """Sum of the dampings of the ball joints that joints are part of, by joint."""
        damping: dict[int, Scalar] = {}
        for j, joint in enumerate(self.machine.joints, start=1):
            for k in self.machine.ball(j) if not joint.friction.ball.is_zero else ():
                damping[k] = damping.get(k, 0) + self.cell(joint.friction.ball)
        return damping

    @cached_property
    def friction_of_balls(self) -> dict[int, Scalar]:
        """Damping torques of ball joints by joint: c z . w, w being the angular velocity between the end bodies."""
        friction: dict[int, Scalar] = {}
        for j, joint in enumerate(self.machine.joints, start=1):
            if joint.friction.ball.is_zero:
                continue
            axes: dict[int, Vector] = {}
            for k in self.machine.ball(j):
                axes = {i: self.mechanism.link(k).transform.to_child(z) for i, z in axes.items()}
                axes[k] = Vector(0, 0, 1)
            w = sum((self.rate(k) * z for k, z in axes.items()), Vector(0, 0, 0))
            for k, z in axes.items():
                friction[k] = friction.get(k, 0) + self.cell(joint.friction.ball) * dot(z, w)
        return friction

    def friction_slope(self, j: int) -> Scalar:
        """Derivative of friction by the rate of joint j; a sign counts as constant."""
        return self.friction_of(j).slope()

    def passive_torque(self, j: int) -> Scalar:
        """Torque of spring and damper on joint j [9]; zero for joints without."""
        return self.spring_of(j).torque(self.rate(j))

    def spring_of(self, j: int) -> JointSpring | MotorCogging:
        """The law of spring and damper of joint j at its deflection, and of the cogging of a motor."""
        (stiffness, deflection), law = self.spring(j), self.machine.joint(j).spring
        spring = JointSpring(
            self.graph, stiffness, deflection, *map(self.cell, (law.damping, law.backlash, law.rounding))
        )
        if self.machine.joint(j).cogging.amplitude.is_zero:
            return spring
        cogging = self.machine.joint(j).reflected_cogging
        amplitude, order, phase = map(self.cell, (cogging.amplitude, cogging.order, cogging.phase))
        return MotorCogging(self.graph, amplitude, order, phase, self.variables[j], spring)

    def spring(self, j: int) -> tuple[Scalar, Scalar]:
        """Stiffness of joint j and deflection of its spring; zero for joints without."""
        joint = self.machine.joint(j)
        if not joint.has_spring:
            return 0, 0
        return Coupling(self, joint.spring.stiffness).value, self.variables[j] - self.cell(joint.spring.neutral)

    def exerted_torque(self, j: int) -> Scalar:
        """Sum of the torques on the coordinate of joint j: motor, spring and damper, less friction."""
        return self.torques.get(j, 0) + self.passive_torque(j) - self.friction(j)

    def own_forces(self) -> dict[int, Scalar]:
        """Forces exerted on the joint coordinates, including those of stiffnesses that change with them."""
        return self._with_stiffness_changes({j: self.exerted_torque(j) for j in self.machine.with_variable})

    def exerted_forces(self) -> dict[int, Scalar]:
        """Forces exerted on the independent variables (L3)."""
        return self._on_independent(self.own_forces())

    def passive_forces(self) -> dict[int, Scalar]:
        """Forces of springs, dampers and friction on the independent variables, without the motors."""
        forces = {j: self.passive_torque(j) - self.friction(j) for j in self.machine.with_variable}
        return self._on_independent(self._with_stiffness_changes(forces))

    def friction_forces(self) -> dict[int, Scalar]:
        """Friction on the independent variables, opposing motion."""
        own = {j: self.friction(j) for j in self.machine.with_variable}
        return self._projection(own, {j: self.friction(j) for j in self._coupled_joints})

    def _with_stiffness_changes(self, own: dict[int, Scalar]) -> dict[int, Scalar]:
        """Forces with -k' deflection^2 / 2 of springs whose stiffness k changes with joint coordinates."""
        for j in self.machine.elastic:
            _, deflection = self.spring(j)
            for v, change in Coupling(self, self.machine.joint(j).spring.stiffness).partials.items():
                own[v] = own[v] - change * deflection * deflection / 2
        return own

    def _on_independent(self, own: Mapping[int, Scalar]) -> dict[int, Scalar]:
        return self._projection(own, {j: -self.friction(j) for j in self._coupled_joints})

    def _projection(self, own: Mapping[int, Scalar], of_joints: Mapping[int, Scalar]) -> dict[int, Scalar]:
        forces = dict.fromkeys(self.machine.independent, 0) | projection(self.coordinates.S_x, own)
        for k, x in projection(self.coordinates.S, of_joints).items():
            forces[k] = forces[k] + x
        return forces

    @property
    def _coupled_joints(self) -> tuple[int, ...]:
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
        """Accelerations of the joints where the independent variables do not accelerate: gam (L2)."""
        return self._by_link(self.coordinates.gam)

    def _by_link(self, by_joint: Mapping[int, Scalar]) -> list[Scalar]:
        return [by_joint.get(j, 0) for j in range(len(self.mechanism.links) + 1)]

    @cached_property
    def without_tip_angles(self) -> Mechanism:
        """The mechanism, with tips of coupled machines in the frames before their joints' rotations.

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
    """The mechanism under the external wrenches of its machine, about the origins and in the axes of their frames."""
    links, names = list(mechanism.links), iter(tree.arguments()[EXTERNAL_WRENCHES])
    numbers = FrameNames(tree.machine).own
    for frame in tree.machine.forces:
        number = numbers[frame.name]
        j = row_under(tree.machine, number)
        force, moment = (Vector(*(tree.graph.symbol(next(names)) for _ in range(3))) for _ in range(2))
        for i in path(mechanism, j):
            turned = mechanism.link(i).transform
            force, moment = turned.to_child(force), turned.to_child(moment)
        if frame.at or number != j:
            moment = moment + cross(tree.fixed_link(number, frame.at).transform.origin, force)
        links[j - 1] = replace(links[j - 1], wrench=links[j - 1].wrench - Wrench(force, moment))
    return replace(mechanism, links=tuple(links))


def coordinate_inertia(bound: Bound) -> InertiaMatrix:
    """Inertia matrix over the independent variables, S^T A S with A of the open tree (L21)."""
    A = inertia_matrix(bound.without_tip_angles)
    return of_coordinates(A, bound.coordinates.S, bound.machine.independent) if bound.machine.is_coupled else A
