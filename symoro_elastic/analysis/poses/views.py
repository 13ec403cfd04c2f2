"""Results at one position as tables, as data for JSON, and as sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from typing import Any

import numpy as np

from symoro_elastic.analysis.poses.evaluation import EvaluatedResult, Evaluation
from symoro_elastic.analysis.poses.frame_stiffness import COMPONENTS, FORCES, FrameStiffness, StiffnessMap
from symoro_elastic.analysis.poses.inverse_geometry import InverseGeometry
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.results import Field, Part, Table, columns_of, declare, json_of, parts_of
from symoro_elastic.quantities.units import MICRO

MOST_SHARES = 3
MIXED = 1e-9
"""Of the largest entry of a stiffness matrix: smaller mixed terms are rounding."""
LONGEST = 60
"""Characters of a title."""
MATRIX = 2
"""Axes of an entry that has a table of its own."""


@parts_of.register
def _(evaluation: Evaluation) -> list[Part]:
    """Return a table for each result, and for each frame of results that are matrices."""
    tables = [table for name, results in evaluation.models.items() for x in results for table in _tables(name, x)]
    return [evaluation.headline, *tables]


def _tables(model: str, result: EvaluatedResult) -> Iterator[Table]:
    title, rows = f"{model}: {result.name}", {name: np.asarray(x, dtype=float) for name, x in result.entries.items()}
    if any(x.ndim == MATRIX for x in rows.values()):
        for name, matrix in rows.items():
            lines = COMPONENTS if len(matrix) == len(COMPONENTS) else tuple(map(str, range(1, len(matrix) + 1)))
            yield _table(f"{title} of {name}", result, dict(zip(lines, matrix, strict=True)))
        return
    yield _table(title, result, rows)


def _table(title: str, result: EvaluatedResult, rows: Mapping[str, Array]) -> Table:
    size = max((x.size for x in rows.values()), default=0)
    short = result.meaning if len(result.meaning) <= LONGEST else result.meaning.partition(",")[0]
    heads = (result.meaning,) if size == 1 else result.columns or tuple(str(k + 1) for k in range(size))
    table = Table(("", *heads), title=title if size == 1 else f"{title}, {short}")
    for name, x in rows.items():
        table.add_row(name, *(f"{y:.6g}" for y in x.ravel() + 0.0))
    return table


@json_of.register
def _(evaluation: Evaluation) -> dict[str, Any]:
    """Return entries by model, result and row; those of matrices by column where columns have names."""
    return {
        model: {x.name: {row: _entry(x, y) for row, y in x.entries.items()} for x in results}
        for model, results in evaluation.models.items()
    }


def _entry(result: EvaluatedResult, x: Any) -> Any:
    return dict(zip(result.columns, x, strict=True)) if result.columns and np.ndim(x) == 1 else x


@columns_of.register
def _(evaluation: Evaluation) -> dict[str, list[Any]]:
    """Return a row for each entry: model, result, row, column, value."""
    rows = []
    for model, x in ((model, x) for model, results in evaluation.models.items() for x in results):
        for row, entry in x.entries.items():
            numbers = np.ravel(np.asarray(entry, dtype=float))
            pairs = zip(x.columns or range(len(numbers)), numbers, strict=True)
            rows += [(model, x.name, row, *pair) for pair in pairs]
    return dict(zip(("model", "result", "row", "column", "value"), map(list, zip(*rows, strict=True)), strict=True))


declare(
    InverseGeometry,
    Field("solutions", lambda result: [dict(x.joints) for x in result.solutions]),
    Field("at_limits", lambda result: [list(x.at_limits) for x in result.solutions]),
    Field("singular", lambda result: [x.is_singular for x in result.solutions]),
    *map(Field, ("redundant", "miss", "turned", "nearest")),
)


@parts_of.register
def _(result: InverseGeometry) -> list[Part]:
    """Return the solutions, the nearest first; without any the residual of the nearest position."""
    if not result.solutions:
        turned = f" and {result.turned:.3g} rad" if result.pose.orientation is not None else ""
        at = ", ".join(f"{name} = {x:.6g}" for name, x in result.nearest.items())
        missed = f"the nearest of {result.starts} starts misses it by {result.miss:.3g} m{turned}, at {at}"
        return [f"{result.frame_name} does not reach this pose within the limits: {missed}"]
    heads = [f"{name}, {unit}" for name, unit in result.units.items()]
    count = "1 solution" if len(result.solutions) == 1 else f"{len(result.solutions)} solutions"
    title = f"{result.frame_name}: {count} from {result.starts} starts, the nearest first"
    table = Table(("", *heads, ""), title=title)
    for k, solution in enumerate(result.solutions, 1):
        notes = ["singular"] if solution.is_singular else []
        notes += [f"at a limit: {', '.join(solution.at_limits)}"] if solution.at_limits else []
        table.add_row(str(k), *(f"{solution.joints[name]:.6g}" for name in result.units), "; ".join(notes))
    if result.redundant:
        motions = "1 motion" if result.redundant == 1 else f"{result.redundant} motions"
        return [table, f"redundant: {motions} of the joints leave this pose, this is the nearest one of a family"]
    return [table]


RIGID = "some motions of this frame bend no spring: no stiffness matrix is finite, use the compliance (--json)"
declare(
    FrameStiffness,
    Field("at"),
    Field("stiffness", array=True),
    Field("compliance", array=True),
    Field("worst_direction", "worst", array=True),
    *map(Field, ("worst_compliance", "shares", "shares_by_axis", "advice")),
)


@parts_of.register
def _(result: FrameStiffness) -> list[Part]:
    """Return stiffness by axis with the springs that limit it, the worst direction, advice, and mixed terms."""
    table = Table(("along", "stiffness", "", "compliance", "", "springs that yield"), title=_place(result))
    units = [("N/um", "um/N")] * 3 + [("N m/urad", "urad/(N m)")] * 3
    yielding = [k for k, c in enumerate(np.diagonal(result.compliance)) if c > 0]
    for k in yielding:
        name, c = COMPONENTS[k], result.compliance[k, k]
        shares = _spring_shares(result.shares_by_axis[name])
        table.add_row(name, f"{1 / c / MICRO:.4g}", units[k][0], f"{c * MICRO:.4g}", units[k][1], shares)
    rigid = [name for k, name in enumerate(COMPONENTS) if k not in yielding]
    worst, direction = result.worst_compliance * MICRO, ", ".join(f"{x:.3g}" for x in result.worst + 0.0)
    lines = [f"rigid: {', '.join(rigid)}"] if rigid else []
    lines += [f"worst direction ({direction}): {worst:.4g} um/N, {_spring_shares(result.shares)}", result.advice]
    return [table, *lines, *_mixed(result, yielding)]


def _place(result: FrameStiffness) -> str:
    at = ", ".join(f"{name} = {x:g}" for name, x in result.at.items())
    return f"stiffness of {result.frame_name} in axes of frame 0, motors held{f', at {at}' if at else ''}"


def _spring_shares(shares: Mapping[str, float]) -> str:
    return ", ".join(f"{share:.0%} {name}" for name, share in islice(shares.items(), MOST_SHARES)) or "none"


def _mixed(result: FrameStiffness, rows: Sequence[int]) -> list[Part]:
    """Return the stiffness matrix of the axes that yield, where it has mixed terms."""
    S = result.stiffness[np.ix_(rows, rows)] / MICRO
    if not np.isfinite(S).all():
        return [RIGID]
    if np.abs(S - np.diag(np.diagonal(S))).max(initial=0.0) <= MIXED * np.abs(S).max(initial=0.0):
        return []
    names = [COMPONENTS[k] for k in rows]
    table = Table(("stiffness", *names), title="MN/m, MN m/rad, MN/rad and MN m/m of displacements and turns")
    for k, row in zip(rows, S, strict=True):
        table.add_row(FORCES[k], *(f"{x:.4g}" for x in row))
    return [table]


declare(StiffnessMap, Field("points"))


@parts_of.register
def _(result: StiffnessMap) -> list[Part]:
    """Return a row per position: stiffness along the axes, in the worst direction, and its first spring."""
    first = result.points[0]
    heads = (*first.at, "x, N/um", "y, N/um", "z, N/um", "worst, N/um", "springs that yield")
    table = Table(heads, title=f"stiffness of {first.frame_name}, motors held", keys=len(first.at))
    for point in result.points:
        along = [1 / c / MICRO if c > 0 else np.inf for c in np.diagonal(point.compliance)[:3]]
        cells = [f"{x:.4g}" for x in (*along, point.least_stiffness / MICRO)]
        table.add_row(*(f"{x:g}" for x in point.at.values()), *cells, _spring_shares(point.shares))
    return [table, result.headline]
