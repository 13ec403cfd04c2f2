"""Rules of the joints for a motion in which some accelerations are known, and what the recursion then finds.

A joint that shares no variable has a rule of its own. Joints that do form a cluster. Where all of its joints own
variables, as in an elastic transmission, nothing is constrained: with joint forces lam (L5) each has its own rule
again. Where all its accelerations are known, so are those of its joints.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

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
from symoro_elastic.mechanics.elimination import Rule
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import Wrench
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.tree import Tree

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
        """The rule of each joint, by number."""
        found: list[Rule | Cluster | None] = [None] * (len(self.bound.machine.joints) + 1)
        for members in self.members:
            for j, rule in self._of_cluster(members).items():
                found[j] = rule
        for j in self._alone:
            found[j] = AccelerationKnown(self.known[j]) if j in self.known else TorqueKnown(self.Gamma_u[j])
        for j in self._led:
            found[j] = AccelerationKnown(self._given_accelerations[j])
        return found

    def dynamics_of(self, mechanism: Mechanism) -> Dynamics:
        """The dynamics of a mechanism in this motion."""
        return dynamics(mechanism, self.bound.rates(), self.rules, base_rule(self.bound))

    def accelerations(self, found: Dynamics) -> dict[int, Scalar]:
        """Accelerations of the independent variables."""
        udd = {**self.known, **{j: found.qdd[j] for j in self._alone}}
        for moved in found.moved.values():
            udd |= moved.udd
        for members in self._transmissions:
            for j in reversed(self._followers_first(members)):
                udd[j] = found.qdd[j] - self.gam[j] - product(self._C[j], udd)  # (L6)
        return udd

    def forces(self, found: Dynamics) -> dict[int, Scalar]:
        """Forces that the motion asks of the independent variables whose acceleration is known."""
        Gamma: dict[int, Scalar] = {j: found.Gamma[j] for j in self._alone}
        for moved in found.moved.values():
            Gamma |= moved.Gamma_u
        for members in self._transmissions:
            for j in members.links:
                if j in self.known:
                    followers = {i: self._C[i].get(j, 0) for i in members.links if i in self._C}
                    Gamma[j] = found.Gamma[j] + product(followers, found.Gamma)
        led = projection(self.S, {j: found.Gamma[j] for j in self._led})
        return dict.fromkeys(self.bound.machine.independent, 0) | combination(((1, Gamma), (1, led)))

    def _of_cluster(self, members: Members) -> dict[int, Rule | Cluster]:
        joints = [j for j in members.links if j in self.S]
        free = tuple(sorted({k for j in joints for k in self.S[j] if k not in self.known}))
        if not free:
            return {}
        if members in self._transmissions:
            return self._of_transmission(members)
        Gamma = {k: self.Gamma_u[k] for k in free}
        cluster = Cluster(members, {j: self.S[j] for j in joints}, self._given_accelerations, free, Gamma)
        return dict.fromkeys(members.links, cluster)

    def _of_transmission(self, members: Members) -> dict[int, Rule | Cluster]:
        followers_first = self._followers_first(members)
        lam = transmission_forces(self._C, followers_first, self.Gamma_u)
        return {
            j: AccelerationKnown(self.known[j]) if j in self.known else TorqueKnown(lam[j]) for j in followers_first
        }

    @cached_property
    def _given_accelerations(self) -> dict[int, Scalar]:
        """Accelerations of the joints where those that are not known are zero."""
        return joint_accelerations(self.S, self.known, self.gam)

    @cached_property
    def _alone(self) -> tuple[int, ...]:
        """Joints of independent variables that share none."""
        together = {j for members in self.members for j in members.links}
        return tuple(j for j in self.bound.machine.independent if j not in together)

    @cached_property
    def _led(self) -> tuple[int, ...]:
        """Other joints whose accelerations are known."""
        return tuple(
            j for j in self.S if j not in self._alone and not {*self.S[j]} - {*self.known} and not self._free(j)
        )

    def _free(self, j: int) -> bool:
        """Whether a joint is of a cluster with accelerations that are not known."""
        mine = next((members for members in self.members if j in members.links), None)
        return mine is not None and any(k not in self.known for i in mine.links for k in self.S.get(i, ()))

    @cached_property
    def _transmissions(self) -> tuple[Members, ...]:
        """Clusters whose joints all own independent variables, with known accelerations of joints that follow none."""
        independent = {*self.bound.machine.independent}
        return tuple(
            members
            for members in self.members
            if all(j in independent for j in members.links if j in self.S)
            and not any(self._C[j] for j in members.links if j in self.known)
            and any(j not in self.known for j in members.links if j in self.S)
        )

    @cached_property
    def _C(self) -> Rows:
        """Derivatives of the formula in the cell of each joint by joint coordinates of others."""
        couplings = self.bound.coordinates.couplings
        return {j: couplings[j].partials if j in couplings else {} for j in self.S}

    def _followers_first(self, members: Members) -> list[int]:
        """Joints of a transmission, each before those whose variables its cell holds."""
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
    """The wrench on a base that is free to move."""
    floating = tree.machine.floating
    if floating is None or floating.known is KnownOfBase.ACCELERATION:
        return None
    return WrenchKnown(Wrench(*tree.twist_on_base("f0")))


def given_rules(bound: Bound) -> Rules:
    """Every acceleration known."""
    return Motion(bound, bound.qdd, {}).rules


def held_rules(bound: Bound) -> Rules:
    """Every acceleration known, zero for the independent variables: gives H(q, qd)."""
    return Motion(bound, dict.fromkeys(bound.machine.independent, 0), {}).rules


def still_rules(machine: Machine) -> Rules:
    """Every acceleration known, and zero, at rest."""
    rules: list[Rule | Cluster | None] = [None] * (len(machine.joints) + 1)
    for j in machine.articulated:
        rules[j] = AccelerationKnown(0)
    return rules


def direct_motion(bound: Bound) -> Motion:
    """Every torque known."""
    return Motion(bound, {}, bound.exerted_forces())


def inverse_motion(bound: Bound) -> Motion:
    """Motor accelerations known, elastic and passive torques known [50]-[54]."""
    known = {j: x for j, x in bound.qdd_motor.items() if j in bound.machine.independent}
    return Motion(bound, known, bound.passive_forces())
