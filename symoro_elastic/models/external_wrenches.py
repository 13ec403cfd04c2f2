"""Wrenches of the surroundings on frames, given in axes of frame 0 as arguments of the models."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from symoro_elastic.mechanics.kinematics import path
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import Vector, Wrench, cross
from symoro_elastic.symbolic.expression import reachable
from symoro_elastic.symbolic.operations import SYMBOL

if TYPE_CHECKING:
    from symoro_elastic.models.bind import Bound
    from symoro_elastic.models.model import Model, Results

ARGUMENT = "f_ext"


def with_external_wrenches(bound: Bound, mechanism: Mechanism) -> Mechanism:
    """The mechanism under the wrenches `forces` of its machine, each about the origin of its frame, in axes of it."""
    links, names = list(mechanism.links), iter(bound.arguments()[ARGUMENT])
    rows = {joint.name: j for j, joint in enumerate(bound.machine.joints, start=1)}
    for asked in bound.machine.forces:
        j = rows[asked.name]
        force, moment = (Vector(*(bound.graph.symbol(next(names)) for _ in range(3))) for _ in range(2))
        for i in path(mechanism, j):
            turned = mechanism.link(i).transform
            force, moment = turned.to_child(force), turned.to_child(moment)
        if asked.at:
            moment = moment + cross(bound.vector(asked.at), force)
        links[j - 1] = replace(links[j - 1], wrench=links[j - 1].wrench - Wrench(force, moment))
    return replace(mechanism, links=tuple(links))


def under_wrenches(model: Model, bound: Bound, results: Results) -> Model:
    """The model with these wrenches as its last argument, where its results depend on them."""
    names = {*bound.arguments()[ARGUMENT]}
    used = reachable(x for result in results.values() for x in result.entries)
    if not any(node.operation == SYMBOL and node.operands[0] in names for node in used):
        return model
    return replace(model, arguments=(*model.arguments, ARGUMENT))
