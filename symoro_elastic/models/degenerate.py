"""Machines that no dynamic model can move: pivots H_j that are zero for every value of the variables.

The recursion is run modulo a large prime on random values, so zero means identically zero. The
motion that meets no inertia names the joints which share the blame. Where joints depend on others the inertia matrix
at assembled positions tells (`models/degenerate_coupled.py`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.series_springs import springs_in_series
from symoro_elastic.mechanics.dynamics import AccelerationKnown, Rule, SingularPivot, TorqueKnown, dynamics
from symoro_elastic.mechanics.floating_base import WrenchKnown
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import AT_REST, NO_WRENCH
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.degenerate_coupled import motions_without_inertia
from symoro_elastic.models.modular import modulo_prime

__all__ = ["Degeneracy", "SingularPivot", "degeneracies"]


@dataclass(frozen=True)
class Degeneracy:
    """A joint whose pivot is zero, and all joints of the motion that meets no inertia."""

    joint: int
    moving_together: tuple[int, ...]

    def message(self, machine: Machine) -> str:
        """The fault and its remedies, naming the joints."""
        if not self.joint:
            return "with all that it carries it has a motion that meets no inertia: give it a body"
        names = [_name(machine, j) for j in self.moving_together]
        joints = [machine.joint(j) for j in self.moving_together]
        if len(joints) == 1:
            return (
                f"H{self.joint} is zero at every position: {names[0]} moves no inertia; "
                f"{_massless_cure(joints[0])}, lock it in a scene, or remove the row"
            )
        if not {*self.moving_together} <= {*machine.moving}:
            return (
                f"H{self.joint} is zero at every position: {_listed(names)} move together without moving any mass; "
                "give one of their bodies inertia, or the motor that drives them a rotor inertia"
            )
        return (
            f"H{self.joint} is zero at every position: {_listed(names)} can move against each other without moving "
            f"any mass, {_reason(joints)}; give a body between them inertia, {_merge(joints)}{self._offer(machine)}, "
            "or check alpha and theta of these rows"
        )

    def _offer(self, machine: Machine) -> str:
        """How to condense the springs where that is exact, else why it is not."""
        pairs = [one for one in springs_in_series(machine) if {one.first, one.last} == {*self.moving_together}]
        if not pairs:
            return ""
        return (
            f" (not by condense: {pairs[0].obstacle})" if pairs[0].obstacle else " (condense = true in a scene does it)"
        )


def _name(machine: Machine, j: int) -> str:
    return f"joint {j} ({machine.joint(j).name})"


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:-1]) + f" and {names[-1]}"


def _massless_cure(joint: Joint) -> str:
    return "give a body beyond it mass" if joint.sigma == 1 else "give a body beyond it inertia about this axis"


def _reason(joints: Sequence[Joint]) -> str:
    if len(joints) == 2 and joints[0].sigma == joints[1].sigma:
        return "for their axes are parallel and what lies between is massless"
    return "for what lies between is massless"


def _merge(joints: Sequence[Joint]) -> str:
    if all(joint.kind is Kind.ELASTIC for joint in joints) and len(joints) == 2:
        return "replace the two springs by one of stiffness k1 k2/(k1 + k2)"
    return "merge them"


def degeneracies(machine: Machine, known_motors: bool, folded: Sequence[str] = ()) -> list[Degeneracy]:
    """Joints whose pivot vanishes in the direct model or, with `known_motors`, in the inverse model."""
    if machine.is_coupled:
        together = motions_without_inertia(machine, known_motors, folded)
        return [Degeneracy(min((j for j in joints if j), default=0), joints) for joints in together]
    bound = Bound(machine, folded)
    mechanism = _modulo_prime(bound)
    base = WrenchKnown(NO_WRENCH) if bound.base_rule else None
    rules: list[Rule | None] = [None] * (len(machine.joints) + 1)
    for j in machine.moving:
        known = known_motors and j in bound.motors
        rules[j] = AccelerationKnown(0) if known else TorqueKnown(0)
    return list(_singular_joints(mechanism, rules, base))


def _singular_joints(mechanism: Mechanism, rules: list[Rule | None], base: WrenchKnown | None) -> Iterator[Degeneracy]:
    at_rest = [0] * len(rules)
    while True:
        try:
            dynamics(mechanism, at_rest, rules, base)
        except SingularPivot as pivot:
            if not pivot.joint:
                yield Degeneracy(0, (0,))
                return
            rules[pivot.joint] = AccelerationKnown(1)
            together = _moving(mechanism, rules)
            rules[pivot.joint] = AccelerationKnown(0)
            yield Degeneracy(pivot.joint, together)
        else:
            return


def _moving(mechanism: Mechanism, rules: list[Rule | None]) -> tuple[int, ...]:
    """Joints that move when one is driven; joints nearer the base are held, where they may be singular too."""
    driven = max(j for j, rule in enumerate(rules) if rule == AccelerationKnown(1))
    held: list[Rule | None] = [AccelerationKnown(0) if rule and j < driven else rule for j, rule in enumerate(rules)]
    found = dynamics(mechanism, [0] * len(rules), held)
    return tuple(j for j, qdd in found.qdd.items() if _nonzero(qdd))


def _nonzero(residue: Any) -> bool:
    return bool(residue)


def _modulo_prime(bound: Bound) -> Mechanism:
    """The mechanism at rest, without gravity, at random values modulo a prime."""
    return modulo_prime(replace(bound.mechanism, velocity=AT_REST, acceleration=AT_REST))
