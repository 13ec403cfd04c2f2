"""Restriction of a machine to a scene: locked joints become fixed frames, gravity may be removed."""

from __future__ import annotations

from dataclasses import replace

from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import NO_VECTOR, Friction, Joint, Kind, Machine, Spring
from symoro_elastic.machine.scene import ALL, Scene


def restricted(machine: Machine, scene: Scene) -> Machine:
    """The machine with the joints of the scene locked, without gravity if the scene says so."""
    joints = tuple(
        _locked(joint, scene.locked[joint.name]) if joint.name in scene.locked else joint for joint in machine.joints
    )
    base = machine.base if scene.gravity else replace(machine.base, gravity=NO_VECTOR)
    return replace(machine, joints=joints, base=base)


def folded(machine: Machine, scene: Scene) -> tuple[str, ...]:
    """Names of the parameters that become constants: those asked for, or all that have a value."""
    if scene.fold == ALL:
        return tuple(p.name for p in machine.parameters if p.value is not None)
    return tuple(scene.fold)


def _locked(joint: Joint, value: Formula) -> Joint:
    """The joint held at a value of its variable: a fixed frame."""
    still = replace(joint, kind=Kind.FIXED, sigma=2, variable=None, spring=Spring(), friction=Friction())
    still = replace(still, rotor_inertia=Formula.parse(0))
    if joint.sigma == 1:
        return replace(still, r=_sum(joint.r, value))
    return replace(still, theta=_sum(joint.theta, value))


def _sum(offset: Formula, value: Formula) -> Formula:
    return value if offset.is_zero else Formula.parse(f"({offset}) + ({value})")
