"""The equations of the loops of a machine in numbers, and positions that fulfil them."""

from __future__ import annotations

import copy
import random
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.loops import Closing, Loop, branches
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.coordinates import Row, combination
from symoro_elastic.mechanics.loops.closing import Branches, CutJoint, branches_of, closing_columns, closing_error
from symoro_elastic.mechanics.spatial import Axis
from symoro_elastic.models.loops.continuation import CLOSED, LONGEST, continued_positions
from symoro_elastic.models.tree import Tree
from symoro_elastic.symbolic.arithmetic import FLOATS, Arithmetic, library
from symoro_elastic.symbolic.operations import ATAN2, COSPI, PI
from symoro_elastic.symbolic.tape import Tape

SEED = 20263
STEPS = 50
ARRAYS: Arithmetic[Any] = Arithmetic(
    float, library(np, {ATAN2: np.arctan2, PI: lambda: np.pi, COSPI: lambda x: np.cos(np.pi * x)})
)
"""Many positions at once."""
Position = dict[int, float]
"""Values of the joint coordinates by number of their joint, rad or m."""
Values = Mapping[str, float]


def cut_joint(machine: Machine, loop: Loop) -> CutJoint:
    """The cut joint of a loop."""
    return CutJoint(loop.cut, loop.meets, Axis(machine.joint(loop.cut).sigma), loop.closes is Closing.POINT)


def loop_branches(tree: Tree, loop: Loop, view: int | None = None, pivot: int | None = None) -> Branches:
    """The branches of a loop of a bound machine, seen from the frame met or from another link."""
    rows = [j for branch in branches(tree.machine.antecedents, loop) for j in branch]
    return branches_of(tree.mechanism, rows, cut_joint(tree.machine, loop), view, pivot)


@dataclass(frozen=True)
class Equation:
    """A row of W over the joint coordinates, by number of their joint, and its closing error."""

    loop: str
    row: int
    columns: Mapping[int, Scalar]
    error: Scalar


def equations_of(tree: Tree, loop: Loop) -> list[Equation]:
    """All rows of a loop, at any position, of a machine whose joint coordinates are all independent."""
    branches = loop_branches(tree, loop)
    own: dict[int, Row] = {j: {j: 1} for j in tree.machine.with_variable}
    columns, error = closing_columns(branches), closing_error(branches)
    by_own: dict[int, dict[int, Scalar]] = {
        row: combination((column.entries[row], tree.row(j, own)) for j, column in columns.items()) for row in range(6)
    }
    return [Equation(loop.name, row, by_own[row], error.entries[row]) for row in branches.cut.rows]


class Assembly:
    """A machine with its loops open, and the equations that close them, in numbers.

    Parameters without value are drawn.
    """

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.tree = Tree(replace(machine, loops=()))
        self.equations = [equation for loop in machine.loops for equation in equations_of(self.tree, loop)]
        self.values = self._values()

    def _values(self) -> dict[str, float]:
        source = random.Random(SEED)
        drawn = {parameter.name: source.uniform(0.5, 1.5) for parameter in self.machine.parameters}
        return drawn | parameter_values(self.machine)

    def at_values(self, values: Values) -> Assembly:
        """The same equations at other values of the parameters."""
        found = copy.copy(self)
        found.values = dict(values)
        return found

    def of_loops(self, loops: Sequence[Loop]) -> Assembly:
        """The equations of some of the loops alone."""
        found, names = copy.copy(self), {loop.name for loop in loops}
        found.equations = [one for one in self.equations if one.loop in names]
        for name in ("_tapes", "_entries", "blocks"):
            found.__dict__.pop(name, None)
        return found

    @cached_property
    def free(self) -> list[int]:
        """Columns of the independent variables of loops among `machine.with_variable`."""
        return self.columns(self.machine.in_loops.difference(self.machine.dependent))

    @cached_property
    def unknown(self) -> list[int]:
        """Columns of the dependent ones."""
        return self.columns(self.machine.dependent)

    @cached_property
    def blocks(self) -> list[tuple[list[int], list[int]]]:
        """Rows and columns of W_d: all of them, and those of each loop."""
        rows = [one.loop for one in self.equations]
        own = [
            ([i for i, name in enumerate(rows) if name == loop.name], self.columns(self.machine.dependent_in(loop)))
            for loop in self.machine.loops
        ]
        return [([*range(len(rows))], self.unknown), *(own if len(own) > 1 else [])]

    def columns(self, joints: Collection[int]) -> list[int]:
        """Columns of W of some joints."""
        return [k for k, j in enumerate(self.machine.with_variable) if j in joints]

    @cached_property
    def _tapes(self) -> tuple[Tape[float], Tape[Any]]:
        """The errors, then the entries of W in the order of `_entries`, in floats and in arrays."""
        entries = [x for one in self.equations for x in one.columns.values()]
        roots = [*(one.error for one in self.equations), *entries]
        return Tape(roots, FLOATS), Tape(roots, ARRAYS)

    @cached_property
    def _entries(self) -> list[tuple[int, int]]:
        order = {j: k for k, j in enumerate(self.machine.with_variable)}
        return [(i, order[j]) for i, one in enumerate(self.equations) for j in one.columns]

    def symbols(self, position: Position) -> dict[str, float]:
        """Values of parameters and joint coordinates at a position, by name."""
        return self.values | self.machine.by_variable(position)

    def numbers(self, position: Position) -> tuple[Array, Array]:
        """Closing errors, and W over all joint coordinates, in the order of `machine.with_variable`."""
        errors, W = self.at(np.array([[position[j] for j in self.machine.with_variable]]))
        return errors[0], W[0]

    def at(self, positions: Array) -> tuple[Array, Array]:
        """Closing errors (samples, rows), and W (samples, rows, variables), at positions (samples, variables)."""
        one = len(positions) == 1
        columns: list[Any] = positions[0].tolist() if one else [*positions.T]
        variables = self.machine.by_variable(dict(zip(self.machine.with_variable, columns, strict=True)))
        with np.errstate(all="ignore"):
            found = self._tapes[0 if one else 1].values(self.values | variables)
        errors = np.zeros((len(positions), len(self.equations)))
        W = np.zeros((*errors.shape, len(self.machine.with_variable)))
        for i, x in enumerate(found[: len(self.equations)]):
            errors[:, i] = x
        for (i, k), x in zip(self._entries, found[len(self.equations) :], strict=True):
            W[:, i, k] = x
        return errors, W

    def start(self) -> Position:
        """The position that the loops give as start, zero elsewhere."""
        given = {name: formula for loop in self.machine.loops for name, formula in loop.start.items()}
        names = self.machine.variables
        found = dict.fromkeys(self.machine.with_variable, 0.0)
        return found | {names[name]: x.value(self.values) for name, x in given.items() if name in names}

    def assembled_position(self, position: Position, dependent: Sequence[int]) -> tuple[Position, float]:
        """The position with its dependent variables changed until the loops close, and the largest error left."""
        columns = [k for k, j in enumerate(self.machine.with_variable) if j in dependent]
        found = dict(position)
        for _ in range(STEPS):
            errors, W = self.numbers(found)
            if not np.all(np.isfinite(errors)) or np.max(np.abs(errors), initial=0) < CLOSED / 100:
                break
            step = -np.linalg.lstsq(W[:, columns], errors, rcond=1e-9)[0]
            step *= min(1.0, LONGEST / max(np.max(np.abs(step), initial=0), 1e-300))
            for k, change in zip(columns, step, strict=True):
                found[self.machine.with_variable[k]] += float(change)
        return found, float(np.max(np.abs(self.numbers(found)[0]), initial=0))

    def position_at(self, position: Position, target: Mapping[int, float]) -> Position | None:
        """An assembled position at other independent variables, on the branch of this one; None where that ends."""
        (found,) = self.positions_at(
            position, np.array([[{**position, **target}[j] for j in self.machine.independent]])
        )
        return None if np.isnan(found).any() else dict(zip(self.machine.with_variable, found.tolist(), strict=True))

    def positions_at(self, position: Position, q: Array) -> Array:
        """Joint coordinates (samples, variables) at q (samples, n), on the branch of a position; NaN where it ends."""
        wanted = np.tile([position[j] for j in self.machine.with_variable], (len(q), 1))
        wanted[:, self.columns(self.machine.independent)] = q
        start = wanted.copy()
        start[:, self.free] = [position[self.machine.with_variable[k]] for k in self.free]
        return continued_positions(self, start, wanted[:, self.free])
