"""Machines that can be modelled but are hardly intended: redundant motors, masses that nothing holds.

Decided modulo a large prime at a random position of motors and passive joints, springs at their neutral positions: what
is said holds at every position and for all values of the parameters. Machines whose joints depend on each other are
not judged: there the axis of a motor does not tell what it moves, and a loop may hold what its slide does not.
"""

from __future__ import annotations

from collections.abc import Iterator

from symoro_elastic.machine.checks import place_of
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.mechanics.kinematics import frames, path
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import Axis, Vector, cross
from symoro_elastic.models.modular import modulo_prime
from symoro_elastic.models.tree import Tree


def implausible_motions(machine: Machine) -> list[str]:
    """Return warnings, one line each, about motors with the same effect and bodies that nothing holds."""
    if machine.is_coupled:
        return []
    mechanism = modulo_prime(Tree(_with_still_springs(machine)).mechanism)
    warned = [*_motors_alike(machine, mechanism), *_unsupported(machine, mechanism)]
    return [f"{place_of(j, machine.joint(j))}: {what}" for j, what in sorted(warned)]


def _with_still_springs(machine: Machine) -> Machine:
    neutral = {joint.name: joint.spring.neutral for joint in machine.joints if joint.kind is Kind.ELASTIC}
    return restrict(machine, Scene(locked=neutral))


def _motors_alike(machine: Machine, mechanism: Mechanism) -> Iterator[tuple[int, str]]:
    """Motors that move all that is beyond them as a motor before them does."""
    placed = frames(mechanism)
    lines = {j: (placed[j].origin, placed[j].z) for j in machine.motors}
    for j in machine.motors:
        before = (k for k in path(mechanism, j)[:-1] if k in lines and _alike(mechanism, lines, k, j))
        for k in before:
            slides = mechanism.link(j).axis is Axis.PRISMATIC
            how = "slides parallel to" if slides else "turns about the axis of"
            what = (
                f"{how} {place_of(k, machine.joint(k))} at every position, so both move the tool in the same direction"
            )
            yield j, f"{what}: check the angles{'' if slides else ' and lengths'} of the rows after {k} up to {j}"
            break


def _alike(mechanism: Mechanism, lines: dict[int, tuple[Vector, Vector]], k: int, j: int) -> bool:
    """Whether two motors slide in one direction, or turn about one line."""
    axes = {mechanism.link(k).axis, mechanism.link(j).axis}
    (origin_k, z_k), (origin_j, z_j) = lines[k], lines[j]
    parallel = not any(cross(z_k, z_j))
    if axes == {Axis.PRISMATIC}:
        return parallel
    return axes == {Axis.REVOLUTE} and parallel and not any(cross(z_k, origin_j - origin_k))


def _unsupported(machine: Machine, mechanism: Mechanism) -> Iterator[tuple[int, str]]:
    """Passive joints that slide along gravity at every position, with a mass and nothing that holds it.

    Tables without any motor or spring describe geometry.
    """
    gravity = -mechanism.acceleration.linear
    if machine.degrees_of_base or not any(gravity) or not (machine.motors or machine.elastic):
        return
    placed = frames(mechanism)
    for j in machine.independent:
        along = not any(cross(placed[j].z, gravity))
        if along and _slides_freely(machine.joint(j)) and _is_heavy(mechanism, _beyond(mechanism, j)):
            yield j, "nothing holds what it carries: it slides along gravity without motor, spring or friction"


def _slides_freely(joint: Joint) -> bool:
    friction = joint.friction
    bare = friction.viscous.is_zero and friction.coulomb.is_zero
    return joint.kind is Kind.PASSIVE and joint.sigma == 1 and bare


def _is_heavy(mechanism: Mechanism, bodies: list[int]) -> bool:
    """Whether bodies have a mass, and no wrench that may hold it."""
    links = [mechanism.link(k) for k in bodies]
    return any(link.body.mass for link in links) and not any(x for link in links for x in link.wrench.entries)


def _beyond(mechanism: Mechanism, j: int) -> list[int]:
    """Numbers of the bodies that joint j carries."""
    carried = {j}
    for k, link in mechanism.from_base():
        if link.antecedent in carried:
            carried.add(k)
    return sorted(carried)
