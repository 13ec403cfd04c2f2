"""Rules of the joints for a motion in which some accelerations are known, and what the recursion then finds.

A joint that shares no variable has a rule of its own. Joints that do form a cluster. Where all of its joints own
variables, as in an elastic transmission, nothing is constrained: with joint forces lam (L5) each has its own rule
again. Where all its accelerations are known, so are those of its joints.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import KnownOfBase, Machine
from symoro_elastic.mechanics.base_body import WrenchKnown
from symoro_elastic.mechanics.clusters import Cluster, Members, clusters
from symoro_elastic.mechanics.coordinates import (
    Rows,
    combination,
    joint_accelerations,
    product,
    projection,
    transmission_forces,
)
from symoro_elastic.mechanics.dynamics import AccelerationKnown, Dynamics, Rules, TorqueKnown, dynamics
from symoro_elastic.mechanics.elastic_cells import ElasticCell, elastic_cells
from symoro_elastic.mechanics.elimination import Rule
from symoro_elastic.mechanics.kinematics import frames
from symoro_elastic.mechanics.loops.closing import closing_columns
from symoro_elastic.mechanics.loops.linear import solve
from symoro_elastic.mechanics.loops.motors import Driven, driven_motion, shared_torques
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import Axis, Vector, Wrench, cross
from symoro_elastic.models.bound.bind import Bound, coordinate_inertia
from symoro_elastic.models.loops.assembly import cut_joint, independent, loop_branches
from symoro_elastic.models.loops.plan import LoopPlan, plan_of
from symoro_elastic.models.tree.tree import Tree
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate

Forces = Mapping[int, Scalar]
"""Generalized forces, or accelerations, by the joint that owns the variable."""


class Motion:
    """A motion of a machine: accelerations `known` of some independent variables, forces `Gamma_u` on the others."""

    def __init__(self, bound: Bound, known: Forces, Gamma_u: Forces) -> None:
        self.bound, self.known, self.Gamma_u = bound, known, Gamma_u
        coordinates = bound.coordinates
        self.S, self.gam = coordinates.S, coordinates.gam
        self.members = clusters(bound.mechanism, self.S) if bound.machine.is_coupled else []

    @cached_property
    def rules(self) -> Rules:
        """Rules of the dynamics recursion, by number of the joint: known torque, known acceleration, or a cluster."""
        rules: list[Rule | Cluster | None] = [None] * (len(self.bound.machine.joints) + 1)
        for members in self.members:
            for j, rule in self._of_cluster(members).items():
                rules[j] = rule
        for j in self._lone_joints:
            rules[j] = AccelerationKnown(self.known[j]) if j in self.known else TorqueKnown(self.Gamma_u[j])
        for j in self._led_joints:
            rules[j] = AccelerationKnown(self._given_accelerations[j])
        return rules

    def dynamics_of(self, mechanism: Mechanism) -> Dynamics:
        """The dynamics of a mechanism in this motion."""
        return dynamics(mechanism, self.bound.rates(), self.rules, base_rule(self.bound))

    def dynamics_by_cells(self, mechanism: Mechanism) -> Dynamics:
        """The dynamics of a mechanism in this motion, with elastic cells eliminated at once, which costs less."""
        groups = elastic_cells(mechanism, {*self._lone_joints} & {*self.bound.machine.elastic})
        cells = {j: ElasticCell(links, {i: self.Gamma_u[i] for i in links}) for links in groups for j in links}
        rules = [cells.get(j, rule) for j, rule in enumerate(self.rules)]
        return dynamics(mechanism, self.bound.rates(), rules, base_rule(self.bound))

    def accelerations(self, recursion: Dynamics) -> dict[int, Scalar]:
        """Accelerations of the independent variables."""
        udd = {**self.known, **{j: recursion.qdd[j] for j in self._lone_joints}}
        for cluster in recursion.moved.values():
            udd |= cluster.udd
        for members in self._transmissions:
            for j in reversed(self._followers_first(members)):
                udd[j] = recursion.qdd[j] - self.gam[j] - product(self._C[j], udd)  # (L6)
        return udd

    def forces(self, recursion: Dynamics) -> dict[int, Scalar]:
        """Forces that the motion requires on the independent variables with known accelerations."""
        Gamma: dict[int, Scalar] = {j: recursion.Gamma[j] for j in self._lone_joints}
        for cluster in recursion.moved.values():
            Gamma |= cluster.Gamma_u
        for members in self._transmissions:
            for j in members.links:
                if j in self.known:
                    followers = {i: self._C[i].get(j, 0) for i in members.links if i in self._C}
                    Gamma[j] = recursion.Gamma[j] + product(followers, recursion.Gamma)
        led = projection(self.S, {j: recursion.Gamma[j] for j in self._led_joints})
        return dict.fromkeys(self.bound.machine.independent, 0) | combination(((1, Gamma), (1, led)))

    def _of_cluster(self, members: Members) -> dict[int, Rule | Cluster]:
        joints = [j for j in members.links if j in self.S]
        free = tuple(sorted({k for j in joints for k in self.S[j] if k not in self.known}))
        if not free:
            return {}
        if members in self._transmissions:
            followers_first = self._followers_first(members)
            lam = transmission_forces(self._C, followers_first, self.Gamma_u)
            return {
                j: AccelerationKnown(self.known[j]) if j in self.known else TorqueKnown(lam[j]) for j in followers_first
            }
        Gamma = {k: self.Gamma_u[k] for k in free}
        cluster = Cluster(members, {j: self.S[j] for j in joints}, self._given_accelerations, free, Gamma)
        return dict.fromkeys(members.links, cluster)

    @cached_property
    def _given_accelerations(self) -> dict[int, Scalar]:
        """Accelerations of all joints with unknown accelerations of independent variables set to zero."""
        return joint_accelerations(self.S, self.known, self.gam)

    @cached_property
    def _lone_joints(self) -> tuple[int, ...]:
        """Independent joints outside of clusters."""
        together = {j for members in self.members for j in members.links}
        return tuple(j for j in self.bound.machine.independent if j not in together)

    @cached_property
    def _led_joints(self) -> tuple[int, ...]:
        """Dependent joints whose accelerations follow from known ones."""
        return tuple(
            j for j in self.S if j not in self._lone_joints and not {*self.S[j]} - {*self.known} and not self._free(j)
        )

    def _free(self, j: int) -> bool:
        """Whether a joint belongs to a cluster with unknown accelerations."""
        mine = next((members for members in self.members if j in members.links), None)
        return mine is not None and any(k not in self.known for i in mine.links for k in self.S.get(i, ()))

    @cached_property
    def _transmissions(self) -> tuple[Members, ...]:
        """Clusters of independent joints in which joints of known acceleration follow no other joint."""
        independent = {*self.bound.machine.independent}
        modal = self.bound.machine.modal_rows
        return tuple(
            members
            for members in self.members
            if all(j in independent for j in members.links if j in self.S)
            and modal.isdisjoint(members.links)
            and not any(self._C[j] for j in members.links if j in self.known)
            and any(j not in self.known for j in members.links if j in self.S)
        )

    @cached_property
    def _C(self) -> Rows:
        """Partial derivatives of the cells of joints by coordinates of other joints."""
        couplings = self.bound.coordinates.couplings
        return {j: couplings[j].partials if j in couplings else {} for j in self.S}

    def _followers_first(self, members: Members) -> list[int]:
        """Joints of a transmission, ordered so that each precedes the joints whose variables its cell contains."""
        leaders: list[int] = []

        def visit(j: int) -> None:
            for v in self._C[j]:
                visit(v)
            if j not in leaders:
                leaders.append(j)

        for j in members.links:
            if j in self.S:
                visit(j)
        return leaders[::-1]


def base_rule(tree: Tree) -> WrenchKnown | None:
    """The rule of a floating base with a known wrench; None for other bases."""
    floating = tree.machine.floating
    if floating is None or floating.known is KnownOfBase.ACCELERATION:
        return None
    return WrenchKnown(Wrench(*tree.twist_on_base("f0")))


def given_rules(bound: Bound) -> Rules:
    """Rules of the recursion for known accelerations of all joints."""
    return Motion(bound, bound.qdd, {}).rules


def held_rules(bound: Bound) -> Rules:
    """Rules of the recursion for zero accelerations of the independent variables, which give H(q, qd)."""
    return Motion(bound, dict.fromkeys(bound.machine.independent, 0), {}).rules


def still_rules(machine: Machine) -> Rules:
    """Rules of the recursion for a machine at rest, all accelerations zero."""
    rules: list[Rule | Cluster | None] = [None] * (len(machine.joints) + 1)
    for j in machine.articulated:
        rules[j] = AccelerationKnown(0)
    return rules


def direct_motion(bound: Bound) -> Motion:
    """The motion under known torques."""
    return Motion(bound, {}, bound.exerted_forces())


def inverse_motion(bound: Bound) -> Motion:
    """The motion with known accelerations of motors, under elastic and passive torques [50]-[54]."""
    motor_accelerations = {j: x for j, x in bound.qdd_motor.items() if j in bound.machine.independent}
    return Motion(bound, motor_accelerations, bound.passive_forces())


def with_loop_forces(bound: Bound) -> Mechanism:
    """The mechanism with the forces of its loops as external wrenches on the bodies that meet (L33)."""
    if not bound.machine.loops:
        return bound.mechanism
    recursion = dynamics(bound.mechanism, bound.rates(), given_rules(bound))
    wrenches, links = loop_forces(bound, recursion), list(bound.mechanism.links)
    for loop in bound.machine.loops:
        cut, wrench = cut_joint(bound.machine, loop), wrenches[loop.name]
        e = frames(bound.mechanism, cut.m)[cut.e]
        moment = wrench.moment if cut.axis is not Axis.PRISMATIC else wrench.moment - cross(e.origin, wrench.force)
        on_e = Wrench(e.rotation.T * wrench.force, e.rotation.T * moment)
        links[cut.e - 1] = replace(links[cut.e - 1], wrench=links[cut.e - 1].wrench - on_e)
        links[cut.m - 1] = replace(links[cut.m - 1], wrench=links[cut.m - 1].wrench + wrench)
    return replace(bound.mechanism, links=tuple(links))


def needed_forces(bound: Bound, recursion: Dynamics) -> dict[int, Scalar]:
    """Forces that the motion requires on the joints of the open tree, including friction of coupled joints."""
    forces = {j: recursion.Gamma[j] for j in bound.machine.articulated}
    for j in forces.keys() - {*bound.machine.with_variable}:
        forces[j] = forces[j] + bound.friction(j)
    return forces


def coupling_forces(bound: Bound, recursion: Dynamics, wrenches: Mapping[str, Wrench]) -> dict[int, Scalar]:
    """Forces that couplings exert on the joints without own variables; forces of loops are excluded."""
    needed = needed_forces(bound, recursion)
    forces = {j: needed[j] for j in bound.machine.articulated if j not in bound.machine.with_variable}
    for loop in bound.machine.loops:
        for j, column in closing_columns(loop_branches(bound, loop)).items():
            if j in forces:
                forces[j] = forces[j] - wrenches[loop.name].dot(column)
    return forces


def loop_forces(bound: Bound, recursion: Dynamics) -> dict[str, Wrench]:
    """Wrenches on the bodies of cut joints from the bodies that they meet, by the name of the loop (L33)."""
    coordinates = bound.coordinates
    needed = needed_forces(bound, recursion)
    exerted = bound.own_forces()
    rho = {j: needed.get(j, 0) - exerted[j] for j in bound.machine.dependent}
    for j in bound.machine.dependent:
        for i, coupling in coordinates.couplings.items():
            rho[j] = rho[j] + coupling.partials.get(j, 0) * needed[i]
    wrenches: dict[str, Wrench] = {}
    for block in coordinates.blocks_with_maps[::-1]:
        unknown = coordinates.unknown(block)
        columns = coordinates.columns_of(block)
        transposed = [[column[i] for column in columns] for i in range(len(unknown))]
        (mu,) = solve(transposed, [[rho[j] for j in unknown]])
        rows = iter(mu)
        for loop in block:
            entries: list[Scalar] = [0] * 6
            for i in loop.kept:
                entries[i] = next(rows)
            wrenches[loop.loop.name] = Wrench(Vector(*entries[:3]), Vector(*entries[3:]))
        rho = _remaining_forces(bound, block, wrenches, rho)
    return wrenches


def _remaining_forces(
    bound: Bound, block: Sequence[LoopPlan], wrenches: dict[str, Wrench], rho: dict[int, Scalar]
) -> dict[int, Scalar]:
    """Forces rho of joints that remain for other loops, after subtracting those of a block of loops."""
    shares: dict[int, Scalar] = dict.fromkeys(rho, 0)
    for loop in block:
        for i, column in closing_columns(loop_branches(bound, loop.loop)).items():
            force = wrenches[loop.loop.name].dot(column)
            shares = {j: share + bound.coordinates.partial(i, j) * force for j, share in shares.items()}
    return {j: x - shares[j] for j, x in rho.items()}


def inverse_by_motors(bound: Bound) -> Driven:
    """Torques of all motors and accelerations of independent variables for the accelerations of all motors.

    Raises `InputError` where only sums of torques are determined and no motor has a share.
    """
    machine, coordinates = bound.machine, bound.coordinates
    rows = {m: coordinates.S_x[m] for m in bound.motors}
    motors = independent_motors(bound, rows)
    shares = {m: bound.cell(machine.joint(m).sharing) for m in bound.motors}
    if len(motors) < len(rows) and not any(not machine.joint(m).sharing.is_zero for m in rows):
        what = "combination of torques is" if len(motors) == 1 else "combinations of torques are"
        what = f"only {len(motors)} {what} determined; give sharing, or make the beam elastic"
        raise machine.error("inverse_dynamics", f"{drive(len(rows), len(motors))}: {what}")
    accelerations = {m: bound.qdd_motor[m] - coordinates.gam_x[m] for m in motors}
    driven = driven_motion(_inertia(bound), _load_forces(bound), {m: rows[m] for m in motors}, accelerations)
    if len(motors) == len(rows):
        return driven
    weights = {m: 1 if machine.joint(m).sharing.is_zero else shares[m] for m in rows}
    return Driven(driven.udd, shared_torques(rows, motors, driven.tau, weights))


def independent_motors(bound: Bound, rows: Mapping[int, Mapping[int, Scalar]]) -> list[int]:
    """Motors with linearly independent rows of S, in order, at an assembled position of the machine."""
    machine = bound.machine
    if not machine.loops:
        return list(rows)
    plan = plan_of(machine)
    entries = [row.get(k, 0) for row in rows.values() for k in machine.independent]
    matrices = []
    for position in plan.positions:
        value = evaluate(entries, plan.assembly.symbols(position), FLOATS)
        matrices.append(np.array([float(value(x)) for x in entries]).reshape(len(rows), len(machine.independent)))
    return [list(rows)[k] for k in independent(matrices)]


def drive(motors: int, freedoms: int) -> str:
    """The text `2 motors drive 1 freedom`."""
    return f"{motors} motors drive {freedoms} {'freedom' if freedoms == 1 else 'freedoms'}"


def _inertia(bound: Bound) -> dict[int, dict[int, Scalar]]:
    A, independent = coordinate_inertia(bound).A, bound.machine.independent
    return {i: {j: A[i][j] for j in independent} for i in independent}


def _load_forces(bound: Bound) -> dict[int, Scalar]:
    """H less the forces of springs, dampers and friction, on the independent variables."""
    recursion = dynamics(bound.unaccelerated_mechanism, bound.rates(), held_rules(bound))
    bias, passive = bound.on_independent(recursion.Gamma), bound.passive_forces()
    return {k: bias[k] - passive[k] for k in bound.machine.independent}
