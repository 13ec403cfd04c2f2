"""Forces of the constraints of loops and couplings (L32), (L33)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.dynamics import Dynamics, dynamics
from symoro_elastic.mechanics.kinematics import frames
from symoro_elastic.mechanics.loops.closing import closing_columns
from symoro_elastic.mechanics.loops.linear import solve
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import Axis, Vector, Wrench, cross
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.loops.assembly import cut_joint, loop_branches
from symoro_elastic.models.loops.plan import LoopPlan
from symoro_elastic.models.rules import given_rules


def with_loop_forces(bound: Bound) -> Mechanism:
    """The mechanism with the forces of its loops as external wrenches on the bodies that meet (L33)."""
    if not bound.machine.loops:
        return bound.mechanism
    found = dynamics(bound.mechanism, bound.rates(), given_rules(bound))
    wrenches, links = loop_forces(bound, found), list(bound.mechanism.links)
    for loop in bound.machine.loops:
        cut, wrench = cut_joint(bound.machine, loop), wrenches[loop.name]
        e = frames(bound.mechanism, cut.m)[cut.e]
        moment = wrench.moment if cut.axis is not Axis.PRISMATIC else wrench.moment - cross(e.origin, wrench.force)
        on_e = Wrench(e.rotation.T * wrench.force, e.rotation.T * moment)
        links[cut.e - 1] = replace(links[cut.e - 1], wrench=links[cut.e - 1].wrench - on_e)
        links[cut.m - 1] = replace(links[cut.m - 1], wrench=links[cut.m - 1].wrench + wrench)
    return replace(bound.mechanism, links=tuple(links))


def needed_forces(bound: Bound, found: Dynamics) -> dict[int, Scalar]:
    """Force that each joint needs beyond its friction where it has no variable of its own; loops count as cut."""
    forces = {j: found.Gamma[j] for j in bound.machine.articulated}
    for j in forces.keys() - {*bound.machine.with_variable}:
        forces[j] = forces[j] + bound.friction(j)
    return forces


def coupling_forces(bound: Bound, found: Dynamics, wrenches: Mapping[str, Wrench]) -> dict[int, Scalar]:
    """Force on each joint without a variable of its own, by its coupling; what loops do on it is not part of it."""
    needed = needed_forces(bound, found)
    forces = {j: needed[j] for j in bound.machine.articulated if j not in bound.machine.with_variable}
    for loop in bound.machine.loops:
        for j, column in closing_columns(loop_branches(bound, loop)).items():
            if j in forces:
                forces[j] = forces[j] - wrenches[loop.name].dot(column)
    return forces


def loop_forces(bound: Bound, found: Dynamics) -> dict[str, Wrench]:
    """Wrench of the body of the frame met on the body of each cut joint, by the name of the loop (L33)."""
    coordinates = bound.coordinates
    needed = needed_forces(bound, found)
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
        rho = _without(bound, block, wrenches, rho)
    return wrenches


def _without(
    bound: Bound, block: Sequence[LoopPlan], wrenches: dict[str, Wrench], rho: dict[int, Scalar]
) -> dict[int, Scalar]:
    """What is left for the other loops: a loop that runs through joints of others loads them."""
    shares: dict[int, Scalar] = dict.fromkeys(rho, 0)
    for loop in block:
        for i, column in closing_columns(loop_branches(bound, loop.loop)).items():
            force = wrenches[loop.loop.name].dot(column)
            shares = {j: share + bound.coordinates.partial(i, j) * force for j, share in shares.items()}
    return {j: x - shares[j] for j, x in rho.items()}
