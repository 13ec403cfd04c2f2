"""Restriction of a machine to a scene: locked joints keep their place, gravity may be removed."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

from symoro_elastic.foundation.errors import InputError, refusing
from symoro_elastic.machine.constants import substitute
from symoro_elastic.machine.described import AnyMachine
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.joints import SELECTED, Cogging, Electrics
from symoro_elastic.machine.machine import NO_VECTOR, Friction, Joint, Kind, Machine, Spring
from symoro_elastic.machine.scene import ALL, RequestedPart, Scene
from symoro_elastic.machine.series_springs import condense
from symoro_elastic.machine.static_springs import held_positions, refuse_static, static_rows
from symoro_elastic.machine.zeroed import with_zeros


def restrict(machine: AnyMachine, scene: Scene) -> AnyMachine:
    """The machine restricted to a scene: joints locked, springs condensed, gravity and numbers set to zero.

    The variable of a locked joint is a constant in the cells of other joints too; the joint is a fixed frame, or
    coupled if its cell holds other joints' variables. Static joints are held likewise; `static` of the machine
    has their rows, `forces` those of the frames of the scene. Raises `InputError` for joints that cannot be locked or
    static.
    """
    base = machine.base if scene.gravity else replace(machine.base, gravity=NO_VECTOR)
    machine = replace(machine, base=base)
    machine = with_zeros(machine, scene.zero)
    if scene.condense:
        machine = condense(machine).machine
    machine = with_held_joints(machine, scene.locked, "locked")
    if scene.forces:
        machine = under_forces(machine, scene.forces)
    if not scene.static:
        return machine
    refuse_static(machine, scene)
    rows = static_rows(machine, scene.static)
    return replace(with_held_joints(machine, held_positions(machine, scene.static), "static"), static=rows)


def rigid(machine: AnyMachine) -> AnyMachine:
    """The rigid limit: every spring infinitely stiff, its joint fixed at the neutral position."""
    locked = {joint.name: joint.spring.neutral for joint in machine.joints if joint.kind is Kind.ELASTIC}
    return restrict(machine, Scene(locked=locked))


def under_forces(machine: AnyMachine, frames: Iterable[str]) -> AnyMachine:
    """The machine whose models have wrenches on some frames, as `RequestedPart` writes them, as arguments."""
    return replace(machine, forces=tuple(map(RequestedPart.parse, dict.fromkeys(frames))))


def with_held_joints(machine: AnyMachine, positions: Mapping[str, Formula], key: str) -> AnyMachine:
    """The machine with joints, by name, held at these positions, rad or m; `key` of a scene is named in messages."""
    if positions.keys().isdisjoint(joint.name for joint in machine.joints):
        return machine
    refuse_locking(machine, positions, machine.label, key)
    locked = {str(j.variable): positions[j.name] for j in machine.joints if j.name in positions}
    with refusing(machine.label, f"scene, {key}", f"{', '.join(locked)}: "):
        joints = tuple(_with_locked(joint, locked) for joint in machine.joints)
    joints = tuple(_still_if_coupled(joint, machine.variables) for joint in joints)
    starts = [{name: x for name, x in loop.start.items() if name not in locked} for loop in machine.loops]
    loops = tuple(replace(loop, start=start) for loop, start in zip(machine.loops, starts, strict=True))
    return replace(machine, joints=joints, loops=loops)


def names_to_fold(machine: Machine, scene: Scene) -> tuple[str, ...]:
    """Names of the parameters that become constants: those requested, or all that have a value."""
    if scene.fold == ALL:
        return tuple(p.name for p in machine.parameters if p.value is not None)
    return tuple(scene.fold)


def refuse_locking(machine: Machine, names: Iterable[str], source: str, key: str = "locked") -> None:
    """Raise `InputError` for a joint, by name, whose variable is not independent; `key` is that of the scene."""
    for name in names:
        reason = _not_lockable(machine, machine.rows[name]) if name in machine.rows else ""
        if reason:
            raise InputError(source, f"scene, {key}, {name}", reason)


def _not_lockable(machine: Machine, j: int) -> str:
    """Why joint j cannot be locked; empty where it can."""
    kind = machine.joint(j).kind
    if machine.joint(j).sigma == 2:
        return "a fixed frame has no variable to lock"
    if kind == Kind.COUPLED:
        followed = [name for name in machine.variables if name in machine.joint(j).selected.names]
        return f"a coupled joint follows {', '.join(followed)}: lock {'that' if len(followed) == 1 else 'those'}"
    loops = [loop for loop in machine.loops if j in machine.dependent_in(loop) or j == loop.cut]
    if not loops:
        return ""
    free = [str(machine.joint(k).variable) for k in machine.with_variable_in(loops[0]) if k in machine.independent]
    what = f"its variable follows from loop {loops[0].name}"
    return f"{what}: lock an independent joint of the loop: {', '.join(free)}" if free else what


def _with_locked(joint: Joint, locked: Mapping[str, Formula]) -> Joint:
    """The joint with constants for locked variables: a locked joint follows the other names in its cell."""
    value = locked.get(str(joint.variable))
    if joint.sigma in SELECTED:
        cell = substitute(joint.selected, locked)
        joint = joint.with_selected(cell if value is None else _sum(cell, value))
    stiffness = substitute(joint.spring.stiffness, locked)
    joint = replace(joint, spring=replace(joint.spring, stiffness=stiffness))
    if value is None:
        return joint
    return replace(
        joint, kind=Kind.COUPLED, variable=None, spring=Spring(), friction=Friction(), sharing=ZERO, cogging=Cogging()
    )


def _still_if_coupled(joint: Joint, variables: Collection[str]) -> Joint:
    """A fixed frame in place of a coupled joint whose formula has no variable left."""
    if joint.kind != Kind.COUPLED or not joint.selected.names.isdisjoint(variables):
        return joint
    bare = replace(joint, friction=Friction(), rotor_inertia=ZERO, ratio=ZERO)
    return replace(bare, kind=Kind.FIXED, sigma=2, electrics=Electrics(), cogging=Cogging())


def _sum(offset: Formula, value: Formula) -> Formula:
    if offset.is_zero:
        return value
    return Formula(f"({offset}) + ({value})", ("+", offset.tree, value.tree))
