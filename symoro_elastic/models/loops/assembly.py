"""The closing equations of the loops of a machine in numbers, and assembled positions."""

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
from symoro_elastic.models.tree.tree import Tree
from symoro_elastic.symbolic.arithmetic import FLOATS, Arithmetic, library
from symoro_elastic.symbolic.operations import ATAN2, COSPI, PI
from symoro_elastic.symbolic.tape import Tape

SEED = 20263
STEPS = 50
ARRAYS: Arithmetic[Any] = Arithmetic(
    float, library(np, {ATAN2: np.arctan2, PI: lambda: np.pi, COSPI: lambda x: np.cos(np.pi * x)})
)
"""Arithmetic over arrays of positions."""
Position = dict[int, float]
"""Values of the joint coordinates by number of their joint, rad or m."""
Values = Mapping[str, float]
INDEPENDENT = 1e-8
"""Relative size of a row of W, after elimination, above which it is linearly independent."""


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

    Parameters without value have random values.
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
        assembly = copy.copy(self)
        assembly.values = dict(values)
        return assembly

    def of_loops(self, loops: Sequence[Loop]) -> Assembly:
        """The equations of some of the loops alone."""
        assembly, names = copy.copy(self), {loop.name for loop in loops}
        assembly.equations = [equation for equation in self.equations if equation.loop in names]
        for name in ("_tapes", "_entries", "blocks"):
            assembly.__dict__.pop(name, None)
        return assembly

    @cached_property
    def free(self) -> list[int]:
        """Columns of the independent variables of loops among `machine.with_variable`."""
        return self.columns(self.machine.in_loops.difference(self.machine.dependent))

    @cached_property
    def unknown(self) -> list[int]:
        """Columns of the dependent variables."""
        return self.columns(self.machine.dependent)

    @cached_property
    def blocks(self) -> list[tuple[list[int], list[int]]]:
        """Rows and columns of W_d: of all loops together, and loop by loop."""
        rows = [equation.loop for equation in self.equations]
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
        """Programs of the closing errors and then entries of W, in the order of `_entries`, in floats and in arrays."""
        entries = [x for equation in self.equations for x in equation.columns.values()]
        roots = [*(equation.error for equation in self.equations), *entries]
        return Tape(roots, FLOATS), Tape(roots, ARRAYS)

    @cached_property
    def _entries(self) -> list[tuple[int, int]]:
        order = {j: k for k, j in enumerate(self.machine.with_variable)}
        return [(i, order[j]) for i, equation in enumerate(self.equations) for j in equation.columns]

    def symbols(self, position: Position) -> dict[str, float]:
        """Values of parameters and joint coordinates at a position, by name."""
        return self.values | self.machine.by_variable(position)

    def numbers(self, position: Position) -> tuple[Array, Array]:
        """Closing errors, and W over all joint coordinates, in the order of `machine.with_variable`."""
        errors, W = self.at(np.array([[position[j] for j in self.machine.with_variable]]))
        return errors[0], W[0]

    def at(self, positions: Array) -> tuple[Array, Array]:
        """Closing errors (samples, rows), and W (samples, rows, variables), at positions (samples, variables)."""
        is_single = len(positions) == 1
        columns: list[Any] = positions[0].tolist() if is_single else [*positions.T]
        variables = self.machine.by_variable(dict(zip(self.machine.with_variable, columns, strict=True)))
        with np.errstate(all="ignore"):
            numbers = self._tapes[0 if is_single else 1].values(self.values | variables)
        errors = np.zeros((len(positions), len(self.equations)))
        W = np.zeros((*errors.shape, len(self.machine.with_variable)))
        for i, x in enumerate(numbers[: len(self.equations)]):
            errors[:, i] = x
        for (i, k), x in zip(self._entries, numbers[len(self.equations) :], strict=True):
            W[:, i, k] = x
        return errors, W

    def start(self) -> Position:
        """The position that the loops give as start, zero elsewhere."""
        start_formulas = {name: formula for loop in self.machine.loops for name, formula in loop.start.items()}
        names = self.machine.variables
        position = dict.fromkeys(self.machine.with_variable, 0.0)
        return position | {names[name]: x.value(self.values) for name, x in start_formulas.items() if name in names}

    def assembled_position(self, position: Position, dependent: Sequence[int]) -> tuple[Position, float]:
        """The position with dependent variables solved by Newton's method, and the largest remaining error."""
        columns = [k for k, j in enumerate(self.machine.with_variable) if j in dependent]
        assembled = dict(position)
        for _ in range(STEPS):
            errors, W = self.numbers(assembled)
            if not np.all(np.isfinite(errors)) or np.max(np.abs(errors), initial=0) < CLOSED / 100:
                break
            step = -np.linalg.lstsq(W[:, columns], errors, rcond=1e-9)[0]
            step *= min(1.0, LONGEST / max(np.max(np.abs(step), initial=0), 1e-300))
            for k, change in zip(columns, step, strict=True):
                assembled[self.machine.with_variable[k]] += float(change)
        return assembled, float(np.max(np.abs(self.numbers(assembled)[0]), initial=0))

    def position_at(self, position: Position, target: Mapping[int, float]) -> Position | None:
        """An assembled position at other independent variables, on the branch of this one; None where that ends."""
        (reached,) = self.positions_at(
            position, np.array([[{**position, **target}[j] for j in self.machine.independent]])
        )
        return None if np.isnan(reached).any() else dict(zip(self.machine.with_variable, reached.tolist(), strict=True))

    def positions_at(self, position: Position, q: Array) -> Array:
        """Joint coordinates (samples, variables) at q (samples, n), on the branch of a position; NaN where it ends."""
        targets = np.tile([position[j] for j in self.machine.with_variable], (len(q), 1))
        targets[:, self.columns(self.machine.independent)] = q
        start = targets.copy()
        start[:, self.free] = [position[self.machine.with_variable[k]] for k in self.free]
        return continued_positions(self, start, targets[:, self.free])


def independent_rows(assembly: Assembly, positions: Sequence[Position]) -> list[int]:
    """Equations that are linearly independent of earlier ones in at least one position."""
    return independent([assembly.numbers(position)[1] for position in positions])


def independent(matrices: Sequence[Array]) -> list[int]:
    """Rows that are linearly independent of earlier ones in at least one of the matrices."""
    selected: list[int] = []
    for row in range(len(matrices[0])):
        if any(_rank(W[[*selected, row]]) > _rank(W[selected]) for W in matrices):
            selected.append(row)
    return selected


def _rank(W: Array) -> int:
    if not W.size:
        return 0
    lengths = np.linalg.norm(W, axis=1, keepdims=True)
    return int(np.linalg.matrix_rank(W / np.where(lengths > INDEPENDENT, lengths, np.inf), tol=INDEPENDENT))


def refuse_wrong_number(machine: Machine, assembly: Assembly, selected: Sequence[int]) -> None:
    """Raise `InputError` where there are more, or fewer, equations than dependent variables."""
    if len(selected) == len(machine.dependent):
        return
    used: set[int] = set()
    for loop in machine.loops:
        own = [k for k, equation in enumerate(assembly.equations) if equation.loop == loop.name]
        dependent, rows = [j for j in machine.dependent_in(loop) if j not in used], [k for k in own if k in selected]
        if len(dependent) != len(rows):
            raise machine.error(f"loop {loop.name}", _wrong_number(machine, dependent, len(rows), len(own)))
        used.update(dependent)


def _wrong_number(machine: Machine, dependent: Sequence[int], rows: int, total: int) -> str:
    names = ", ".join(str(machine.joint(j).variable) for j in dependent)
    dropped = f" ({total - rows} of {total} are fulfilled by the plane)" if total > rows else ""
    count = f"{len(dependent)} dependent variable{'s' if len(dependent) != 1 else ''}"
    what = f"{rows} equation{'s' if rows != 1 else ''} for {count}{dropped}: "
    return what + (f"keep one of {names} independent" if len(dependent) > rows else "name more joints in dependent")


def refuse_singular(machine: Machine, assembly: Assembly, rows: Sequence[int], positions: Sequence[Position]) -> None:
    """Raise `InputError` for dependent variables that the equations determine in no position."""
    columns = [machine.with_variable.index(j) for j in machine.dependent]
    matrices = [assembly.numbers(position)[1][list(rows)] for position in positions]
    if not columns or any(_rank(W[:, columns].T) == len(columns) for W in matrices):
        return
    *_, V = np.linalg.svd(matrices[-1][:, columns])
    together = [machine.joint(j) for j, x in zip(machine.dependent, V[-1], strict=True) if abs(x) > 1e-6]
    names = " and ".join(str(joint.variable) for joint in together)
    parallel = "are parallel" if len(together) == 2 else "depend on each other"
    both = "both" if len(together) == 2 else "all"
    why = f"{both} depend: their columns {parallel} in every position"
    if len(together) == 1:
        why = "depend: the loop does not move it"
    what = f"{names} cannot {why}; try {_other(machine, matrices)}"
    loops = [loop.name for loop in machine.loops if {*machine.dependent_in(loop)} & {*machine.dependent}]
    raise machine.error(f"loop {loops[0]}", what)


def _other(machine: Machine, matrices: Sequence[Array]) -> str:
    """A valid choice of dependent joints, as a list of variables in the syntax of the file."""
    columns = independent([W.T for W in matrices])[: len(machine.dependent)]
    variables = [machine.joint(machine.with_variable[k]).variable for k in columns]
    return "[" + ", ".join(f'"{variable}"' for variable in variables) + "]"
