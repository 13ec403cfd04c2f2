"""What is known of the pivots of a model beside its intervals: lemmas 5 and 6, by node.

The recursion solves for one coordinate after another, and hands on the rest: a pivot H_j is the Schur complement of
entry j of the inertia matrix over the coordinates that it has solved for. On a tree these are the joints beyond j.

**Where joints are coupled or closed in loops**, they are solved for cluster by cluster. With the acceleration energy
G = (qdd' A qdd)/2 + ..., in which dependent accelerations are linear in the independent ones, each step takes the least
value of G over one coordinate, and H_j is the second derivative by coordinate j of what is left. So it is a Schur
complement here, too, over those that were solved for, whichever they are: the more, the smaller. Hence

    complement over all coordinates <= H_j <= A_jj
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from symoro_elastic.codegen.package import Function
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.models.catalogue import MODELS
from symoro_elastic.models.model import Pivots
from symoro_elastic.models.traced import Traced, trace_models
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.loewner import schur_complements
from symoro_elastic.numerics.guarantees.own_inertia import own_inertias
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, Known, running_errors
from symoro_elastic.symbolic.expression import Expression, reachable
from symoro_elastic.symbolic.operations import DIVIDE, NEGATE
from symoro_elastic.symbolic.program import Program


class PivotKnowledge:
    """Bounds of the pivots H_j in the program of a model, over any sub-boxes.

    Lemma 5 costs nothing; lemma 6 asks for the inertia matrix. Of coupled machines it is used for models that solve for
    all coordinates.
    """

    def __init__(self, asked: Traced, physical: Machine, parameters: Box, function: Function) -> None:
        """`physical` is the machine with inertial parameters of bodies, of which `parameters` are the values."""
        machine = asked.machine
        pivots = MODELS[function.name].pivots if function.name in MODELS else None
        solved = [j for j in machine.independent if pivots is Pivots.ALL or j not in machine.motors]
        nodes = {j: function.program.quantities.get(f"H{j}") for j in (solved if pivots else ())}
        self._nodes = {j: x for j, x in nodes.items() if isinstance(x, Expression)}
        self._coupled = machine.is_coupled
        rest = _from_rest(machine, self._nodes) if self._coupled else {*self._nodes}
        self._own = own_inertias(restrict(physical, asked.scene), parameters.whole, rest) if self._nodes else {}
        over = {j: solved if self._coupled else [k for k in solved if _carries(machine, j, k)] for j in self._nodes}
        self._beyond = {j: _indices(machine, joints) for j, joints in over.items()}
        self._entry = {j: machine.independent.index(j) for j in self._nodes}
        self._size = len(machine.independent)
        known = self._nodes and (pivots is Pivots.ALL or not self._coupled)
        self._inertia = _inertia_matrix(asked) if known else None

    def __call__(self, parts: Mapping[str, Interval]) -> Known:
        """What is known of pivots in sub-boxes: a function from the interval of a node to a smaller one."""
        matrix = self._matrix(parts)
        known = {}
        for j, x in self._nodes.items():
            found = Interval(self._own.get(j, np.array(0.0)), np.array(np.inf))
            if matrix is not None:
                found = found.meeting(self._complement(matrix, j))
            known[x.positive.id] = _meeting(-found if x.operation == NEGATE else found)
        return known

    def _complement(self, matrix: Interval, j: int) -> Interval:
        """The interval of the Schur complement that pivot j is."""
        k = self._entry[j]
        found = schur_complements(matrix, self._beyond[j], k)
        return Interval(found.low, matrix.high[k, k]) if self._coupled else found

    def _matrix(self, parts: Mapping[str, Interval]) -> Interval | None:
        """The intervals of the inertia matrix, (n, n, sub-boxes)."""
        if self._inertia is None:
            return None
        program = self._inertia
        count = max((len(np.atleast_1d(x.low)) for x in parts.values()), default=1)
        bounds = running_errors(program.nodes, parts, ROUNDINGS["double"])
        entries = [bounds.range_of(x) for x in program.outputs[0].entries]
        low, high = ([np.broadcast_to(end, count) for end in ends] for ends in zip(*entries, strict=True))
        shape = (self._size, self._size, count)
        return Interval(np.array(low).reshape(shape), np.array(high).reshape(shape))


def _inertia_matrix(asked: Traced) -> Program:
    """The program of the inertia matrix, parameters being symbols or numbers as in the models of the scene."""
    scene = replace(asked.scene, models=("inertia_matrix",), outputs={}, steps=())
    return trace_models(asked.whole, scene).models[0].program


def _from_rest(machine: Machine, pivots: Mapping[int, Expression]) -> set[int]:
    """The joints whose antecedents down to the base are independent and solved for later: pivots divide by theirs."""
    needs = {j: {x.id for x in _divisors(pivot)} for j, pivot in pivots.items()}
    found = set()
    for j, x in pivots.items():
        before = machine.joint(j).antecedent
        while before and x.positive.id in needs.get(before, ()):
            before = machine.joint(before).antecedent
        if not before:
            found.add(j)
    return found


def _divisors(x: Expression) -> Iterator[Expression]:
    """What an expression divides by."""
    divisors = (node.operands[1] for node in reachable([x]) if node.operation == DIVIDE)
    yield from (x.positive for x in divisors if isinstance(x, Expression))


def _carries(machine: Machine, j: int, k: int) -> bool:
    """Whether joint k is joint j, or stands on it."""
    while k and k != j:
        k = machine.joint(k).antecedent
    return k == j


def _indices(machine: Machine, joints: list[int]) -> list[int]:
    return [machine.independent.index(j) for j in joints]


def _meeting(known: Interval) -> Callable[[Interval], Interval]:
    """A function that leaves of an interval what is known to hold, too."""

    def smaller(found: Interval) -> Interval:
        return found.meeting(known)

    return smaller
