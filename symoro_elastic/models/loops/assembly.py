"""Assembled positions of a machine with loops, in numbers: Newton's method and continuation from a start."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.loops import Closing, Loop, branches
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.coordinates import combination
from symoro_elastic.mechanics.loops.closing import (
    Branches,
    CutJoint,
    branches_of,
    closing_columns,
    closing_error,
)
from symoro_elastic.mechanics.spatial import Axis
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate_nodes
from symoro_elastic.symbolic.expression import Expression, reachable

if TYPE_CHECKING:
    from symoro_elastic.models.bind import Bound

SEED = 20263
STEPS, CLOSED, LONGEST_STEP, FINEST = 50, 1e-11, 0.5, 64
Position = dict[int, float]
"""Values of the own variables by number of their joint, rad or m."""
Values = Mapping[str, float]


def cut_joint(machine: Machine, loop: Loop) -> CutJoint:
    """The cut joint of a loop."""
    return CutJoint(loop.cut, loop.meets, Axis(machine.joint(loop.cut).sigma), loop.closes is Closing.POINT)


def loop_branches(bound: Bound, loop: Loop, view: int | None = None, pivot: int | None = None) -> Branches:
    """The branches of a loop of a bound machine, seen from the frame met or from another link."""
    rows = [j for branch in branches(bound.machine.antecedents, loop) for j in branch]
    return branches_of(bound.mechanism, rows, cut_joint(bound.machine, loop), view, pivot)


@dataclass(frozen=True)
class Equation:
    """A row of W over the own variables, by number of their joint, and its closing error."""

    loop: str
    row: int
    columns: Mapping[int, Scalar]
    error: Scalar


def equations_of(bound: Bound, loop: Loop) -> list[Equation]:
    """All rows of a loop, at any position, of a machine bound with every own variable independent."""
    branches = loop_branches(bound, loop)
    columns, error = closing_columns(branches), closing_error(branches)
    by_own: dict[int, dict[int, Scalar]] = {
        row: combination((column.entries[row], bound.coordinates.S[j]) for j, column in columns.items())
        for row in range(6)
    }
    return [Equation(loop.name, row, by_own[row], error.entries[row]) for row in branches.cut.rows]


class Assembly:
    """A machine with its loops open, and the equations that close them, in numbers.

    `bind` binds a machine to the equations. Parameters without value are drawn.
    """

    def __init__(self, machine: Machine, bind: Callable[[Machine], Bound], values: Values | None = None) -> None:
        self.machine = machine
        self.bound = bind(replace(machine, loops=()))
        self.equations = [equation for loop in machine.loops for equation in equations_of(self.bound, loop)]
        self.values = self._values() if values is None else dict(values)

    def _values(self) -> dict[str, float]:
        source = random.Random(SEED)
        drawn = {parameter.name: source.uniform(0.5, 1.5) for parameter in self.machine.parameters}
        return drawn | parameter_values(self.machine)

    @cached_property
    def _nodes(self) -> list[Expression]:
        return reachable(x for one in self.equations for x in (one.error, *one.columns.values()))

    def symbols(self, position: Position) -> dict[str, float]:
        """Values of parameters and own variables at a position, by name."""
        return self.values | self.machine.by_variable(position)

    def numbers(self, position: Position) -> tuple[Array, Array]:
        """Closing errors, and W over all own variables, in the order of `machine.owners`."""
        value = evaluate_nodes(self._nodes, self.symbols(position), FLOATS)
        order = {j: k for k, j in enumerate(self.machine.owners)}
        errors = np.array([float(value(one.error)) for one in self.equations])
        W = np.zeros((len(self.equations), len(order)))
        for i, one in enumerate(self.equations):
            for j, x in one.columns.items():
                W[i, order[j]] = value(x)
        return errors, W

    def start(self) -> Position:
        """The position that the loops give as start, zero elsewhere."""
        given = {name: formula for loop in self.machine.loops for name, formula in loop.start.items()}
        names = self.machine.variables
        found = dict.fromkeys(self.machine.owners, 0.0)
        return found | {names[name]: x.value(self.values) for name, x in given.items() if name in names}

    def assembled(self, position: Position, dependent: Sequence[int]) -> tuple[Position, float]:
        """The position with its dependent variables changed until the loops close, and the largest error left."""
        columns = [k for k, j in enumerate(self.machine.owners) if j in dependent]
        found = dict(position)
        for _ in range(STEPS):
            errors, W = self.numbers(found)
            if not np.all(np.isfinite(errors)) or np.max(np.abs(errors), initial=0) < CLOSED / 100:
                break
            step = -np.linalg.lstsq(W[:, columns], errors, rcond=1e-9)[0]
            step *= min(1.0, LONGEST_STEP / max(np.max(np.abs(step), initial=0), 1e-300))
            for k, change in zip(columns, step, strict=True):
                found[self.machine.owners[k]] += float(change)
        return found, float(np.max(np.abs(self.numbers(found)[0]), initial=0))

    def moved(self, position: Position, target: Mapping[int, float], dependent: Sequence[int]) -> Position | None:
        """An assembled position at other independent variables, reached by continuation; None where it ends.

        Steps are halved where dependent variables go far in one, which is near a singular position, or a jump.
        """
        free = [j for j in target if j not in dependent]
        longest = max((abs(target[j] - position[j]) for j in free), default=0.0)
        step, done, found = 1 / max(1, int(np.ceil(longest / 0.1))), 0.0, position
        least = step / FINEST
        while done < 1:
            ahead = min(1.0, done + step)
            here = {j: position[j] + (target[j] - position[j]) * ahead for j in free}
            near, error = self.assembled({**found, **here}, dependent)
            if error < CLOSED and all(abs(near[j] - found[j]) < LONGEST_STEP for j in dependent):
                found, done = near, ahead
            elif step > least:
                step /= 2
            else:
                return None
        return found
