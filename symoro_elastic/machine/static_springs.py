"""Static springs: their joints are locked in the motion, and their deflections follow from the reactions.

Where a spring is much stiffer than the motion is fast, its joint stands still but for q_E = q0_E - Gamma_E / k_E:
Gamma_E = a . f of [35], [58] is the reaction at the joint, held at a position near its equilibrium. Joints that follow
its variable add their reactions times the derivatives of their formulas, and a mode the force of its body.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.scene import Scene

Positions = Mapping[str, Formula | None]
"""Where joints are held, by name, rad or m; None for the neutral position of the spring."""


def held_positions(machine: Machine, static: Positions) -> dict[str, Formula]:
    """The positions of the static joints, rad or m: requested ones, else the neutral positions of their springs."""
    rows = {joint.name: joint for joint in with_free_springs(machine).joints}
    return {name: rows[name].spring.neutral if x is None else x for name, x in static.items()}


def static_rows(machine: Machine, static: Positions) -> dict[int, Joint]:
    """The rows of static joints, and of those that follow them, before these are locked, by number."""
    own = {str(joint.variable) for joint in machine.joints if joint.name in static}
    rows = enumerate(machine.joints, start=1)
    return {j: joint for j, joint in rows if joint.name in static or own & joint.selected.names}


def with_free_springs(machine: Machine) -> Machine:
    """The machine in which its static springs can deflect."""
    rows = enumerate(machine.joints, start=1)
    return replace(machine, joints=tuple(machine.static.get(j, joint) for j, joint in rows))


def refuse_static(machine: Machine, scene: Scene) -> None:
    """Raise `InputError` for a joint whose spring a scene cannot leave out of the motion of a machine."""
    source = scene.source or machine.label
    for name in scene.static:
        reason = _not_static(machine, machine.rows[name]) if name in machine.rows else "the machine has no such joint"
        if reason:
            raise InputError(source, f"scene, static, {name}", reason)


def without_spring(machine: Machine, joint: Joint) -> str:
    """Why a joint has no spring that could be static; empty where it has one."""
    if joint.kind is Kind.ELASTIC:
        return ""
    elastic = ", ".join(machine.joint(j).name for j in machine.elastic) or "none here"
    return f"the joint is {joint.kind}: only elastic joints have a spring that can be static, {elastic}"


def _not_static(machine: Machine, j: int) -> str:
    """Why the spring of joint j cannot be static; empty where it can."""
    joint = machine.joint(j)
    if joint.spring.stiffness.is_zero and joint.kind is Kind.ELASTIC:
        return f"its spring has no stiffness: give [springs] {joint.name} one, or leave it out of static"
    if not joint.spring.backlash.is_zero:
        return "its spring has backlash: keep it in the motion, or leave backlash out"
    return without_spring(machine, joint) or _coupling(machine, j)


def _coupling(machine: Machine, j: int) -> str:
    """Return why the force of a spring is not its joint's reaction alone; empty if it is."""
    joint = machine.joint(j)
    changed_by = joint.spring.stiffness.names & machine.variables.keys()
    if changed_by:
        return f"its stiffness changes with {', '.join(sorted(changed_by))}: only constant springs can be static"
    for loop in machine.loops:
        if j in machine.around(loop) or j in machine.with_variable_in(loop):
            return f"it is part of loop {loop.name}, whose forces are not part of the reaction: keep it in the motion"
    neighbours = [x for x in machine.joints if x is not joint]
    in_place = (x for x in neighbours if x.kind is not Kind.COUPLED and joint.variable in x.selected.names)
    in_spring = (x for x in neighbours if joint.variable in x.spring.stiffness.names)
    followers = ", ".join(x.name for x in (*in_place, *in_spring))
    return f"{followers} follows its variable: keep it in the motion" if followers else ""
