"""Machines that are hardly intended: redundant motors, masses that nothing holds, loops with too few variables.

Decided modulo a large prime at a random position of motors and passive joints, springs at their neutral positions: the
warnings are valid at every position and for all values of the parameters. Machines whose joints depend on each other
are not checked: there the axis of a motor does not determine what it moves, and a loop may support a slide.
"""

from __future__ import annotations

from collections.abc import Iterator

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import place_of
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.mechanics.kinematics import frames, path
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import Axis, Vector, cross
from symoro_elastic.models.loops.plan import loops_of
from symoro_elastic.models.tree.modular import modulo_prime
from symoro_elastic.models.tree.tree import Tree


def implausible_motions(machine: Machine) -> list[str]:
    """Return warnings, one line each, about motors with the same effect, bodies that nothing holds, loops."""
    if machine.is_coupled:
        try:
            loops_of(machine)
        except InputError as error:  # raised by every model of a machine with open loops
            return [f"{error.place}: {error.what}"]
        return []
    neutral = {joint.name: joint.spring.neutral for joint in machine.joints if joint.kind is Kind.ELASTIC}
    mechanism = modulo_prime(Tree(restrict(machine, Scene(locked=neutral))).mechanism)
    warnings = [*_redundant_motors(machine, mechanism), *_unsupported_joints(machine, mechanism)]
    return [f"{place_of(j, machine.joint(j))}: {what}" for j, what in sorted(warnings)]


def _redundant_motors(machine: Machine, mechanism: Mechanism) -> Iterator[tuple[int, str]]:
    """Motors that have the same effect on all bodies beyond them as an earlier motor."""
    poses = frames(mechanism)
    lines = {j: (poses[j].origin, poses[j].z) for j in machine.motors}
    for j in machine.motors:
        before = (k for k in path(mechanism, j)[:-1] if k in lines and _have_same_effect(mechanism, lines, k, j))
        for k in before:
            slides = mechanism.link(j).axis is Axis.PRISMATIC
            how = "slides parallel to" if slides else "turns about the axis of"
            what = (
                f"{how} {place_of(k, machine.joint(k))} at every position, so both move the tool in the same direction"
            )
            yield j, f"{what}: check the angles{'' if slides else ' and lengths'} of the rows after {k} up to {j}"
            break


def _have_same_effect(mechanism: Mechanism, lines: dict[int, tuple[Vector, Vector]], k: int, j: int) -> bool:
    """Whether two motors slide in one direction, or turn about one line."""
    axes = {mechanism.link(k).axis, mechanism.link(j).axis}
    (origin_k, z_k), (origin_j, z_j) = lines[k], lines[j]
    parallel = not any(cross(z_k, z_j))
    if axes == {Axis.PRISMATIC}:
        return parallel
    return axes == {Axis.REVOLUTE} and parallel and not any(cross(z_k, origin_j - origin_k))


def _unsupported_joints(machine: Machine, mechanism: Mechanism) -> Iterator[tuple[int, str]]:
    """Passive joints that slide along gravity at every position, with a mass that nothing supports.

    Tables without any motor or spring describe geometry.
    """
    gravity = -mechanism.acceleration.linear
    if machine.degrees_of_base or not any(gravity) or not (machine.motors or machine.elastic):
        return
    poses = frames(mechanism)
    for j in machine.independent:
        along = not any(cross(poses[j].z, gravity))
        if along and _slides_freely(machine.joint(j)) and _is_heavy(mechanism, _beyond(mechanism, j)):
            yield j, "nothing holds what it carries: it slides along gravity without motor, spring or friction"


def _slides_freely(joint: Joint) -> bool:
    friction = joint.friction
    bare = friction.viscous.is_zero and friction.coulomb.is_zero
    return joint.kind is Kind.PASSIVE and joint.sigma == 1 and bare


def _is_heavy(mechanism: Mechanism, bodies: list[int]) -> bool:
    """Whether bodies have a mass, and no external wrench that may support it."""
    links = [mechanism.link(k) for k in bodies]
    return any(link.body.mass for link in links) and not any(x for link in links for x in link.wrench.entries)


def _beyond(mechanism: Mechanism, j: int) -> list[int]:
    """Numbers of the bodies that joint j carries."""
    carried = {j}
    for k, link in mechanism.from_base():
        if link.antecedent in carried:
            carried.add(k)
    return sorted(carried)
