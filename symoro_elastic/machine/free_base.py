"""A floating base as six joints without springs: three prismatic along axes of the world, then three revolute.

Small motions are about a base whose axes are those of the world. One whose acceleration is known is held.
"""

from __future__ import annotations

from dataclasses import replace

from symoro_elastic.machine.described import AnyMachine, with_changed_scene
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Joint, Kind, KnownOfBase, Machine
from symoro_elastic.machine.names import distinct
from symoro_elastic.machine.scene import COMPONENTS
from symoro_elastic.quantities.frames import BASE

COORDINATES = tuple(f"{BASE}.{axis}" for axis in COMPONENTS)
"""Names of the six joints; the frame they carry is the base."""
QUARTER = Formula.parse("pi/2")


def with_base_coordinates(machine: AnyMachine) -> AnyMachine:
    """Return the machine on a base at rest, its six degrees of freedom being the first joints.

    Each axis is the next of x, y, z: Rot(z, pi/2) Rot(x, pi/2) permutes them. The row of its body is called `base`, but
    `base_body` where a joint has that name.
    """
    if machine.floating is None:
        return machine
    if machine.floating.known is KnownOfBase.ACCELERATION:
        return replace(machine, floating=None)
    names = {joint.name for joint in machine.joints}
    name = distinct(f"{BASE}_body", names) if BASE in names else BASE
    coordinates = [_coordinate(k, name) for k, name in enumerate(COORDINATES)]
    base = Joint(name, len(coordinates), Kind.FIXED, 2, body=machine.floating.body)
    before = len(coordinates) + 1
    carried = [replace(joint, antecedent=joint.antecedent + before) for joint in machine.joints]
    loops = tuple(replace(loop, cut=loop.cut + before, meets=loop.meets + before) for loop in machine.loops)
    static = {j + before: replace(row, antecedent=row.antecedent + before) for j, row in machine.static.items()}
    joints = (*coordinates, base, *carried)
    free = replace(machine, joints=joints, loops=loops, static=static, floating=None)
    return with_changed_scene(free, lambda _: None)


def row_of_base(machine: Machine) -> int | None:
    """Return the number of the row that carries the body of a base with coordinates; None where it has none."""
    has_coordinates = machine.joints[:1] and machine.joint(1).name == COORDINATES[0]
    return len(COORDINATES) + 1 if has_coordinates else None


def with_given_acceleration(machine: AnyMachine) -> AnyMachine:
    """Return the machine with a given acceleration of its base, where that moves freely."""
    floating = machine.floating and replace(machine.floating, known=KnownOfBase.ACCELERATION)
    return replace(machine, floating=floating)


def _coordinate(k: int, name: str) -> Joint:
    """Return joint k + 1: prismatic for k up to 2, then revolute, its axis the next of x, y, z."""
    turns = k > 2
    return Joint(name, k, Kind.PASSIVE, 0 if turns else 1, name, gamma=QUARTER, alpha=QUARTER, theta=ZERO, r=ZERO)
