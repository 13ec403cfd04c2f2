"""Equations of loops that are not a combination of others, and dependent variables that they determine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.loops.assembly import Assembly, Position

INDEPENDENT = 1e-8
"""Of a row of W, relative, beyond which it is not a combination of others."""


def independent_rows(assembly: Assembly, positions: Sequence[Position]) -> list[int]:
    """Equations that are not a combination of those before them, in one of the positions at least."""
    return independent([assembly.numbers(position)[1] for position in positions])


def independent(matrices: Sequence[Array]) -> list[int]:
    """Rows that are not a combination of those before them, in one of some matrices at least."""
    kept: list[int] = []
    for row in range(len(matrices[0])):
        if any(_rank(W[[*kept, row]]) > _rank(W[kept]) for W in matrices):
            kept.append(row)
    return kept


def _rank(W: Array) -> int:
    if not W.size:
        return 0
    lengths = np.linalg.norm(W, axis=1, keepdims=True)
    return int(np.linalg.matrix_rank(W / np.where(lengths > INDEPENDENT, lengths, np.inf), tol=INDEPENDENT))


def refuse_wrong_number(machine: Machine, assembly: Assembly, kept: Sequence[int]) -> None:
    """Raise `InputError` where there are more, or fewer, equations than dependent variables."""
    if len(kept) == len(machine.dependent):
        return
    taken: set[int] = set()
    for loop in machine.loops:
        own = [k for k, one in enumerate(assembly.equations) if one.loop == loop.name]
        dependent, rows = [j for j in machine.dependent_in(loop) if j not in taken], [k for k in own if k in kept]
        if len(dependent) != len(rows):
            raise machine.error(f"loop {loop.name}", _wrong_number(machine, dependent, len(rows), len(own)))
        taken.update(dependent)


def _wrong_number(machine: Machine, dependent: Sequence[int], rows: int, total: int) -> str:
    names = ", ".join(str(machine.joint(j).variable) for j in dependent)
    dropped = f" ({total - rows} of {total} are fulfilled by the plane)" if total > rows else ""
    count = f"{len(dependent)} dependent variable{'s' if len(dependent) != 1 else ''}"
    what = f"{rows} equation{'s' if rows != 1 else ''} for {count}{dropped}: "
    return what + (f"keep one of {names} independent" if len(dependent) > rows else "name more joints in dependent")


def refuse_singular(machine: Machine, assembly: Assembly, kept: Sequence[int], positions: Sequence[Position]) -> None:
    """Raise `InputError` for dependent variables that the equations determine in no position."""
    columns = [machine.with_variable.index(j) for j in machine.dependent]
    matrices = [assembly.numbers(position)[1][list(kept)] for position in positions]
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
    """Joints that can depend, as a list in a file."""
    found = independent([W.T for W in matrices])[: len(machine.dependent)]
    kept = [machine.joint(machine.with_variable[k]).variable for k in found]
    return "[" + ", ".join(f'"{variable}"' for variable in kept) + "]"
