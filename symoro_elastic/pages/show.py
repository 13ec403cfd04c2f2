"""Tables for the terminal, and the same values as plain data for `--json`."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import Any

from symoro_elastic.codegen.package_context import SINGULAR
from symoro_elastic.foundation.results import Table, plain
from symoro_elastic.models.catalogue import MODELS, Model
from symoro_elastic.models.joint_axes import PlacedMachine
from symoro_elastic.quantities import MOTION

MOVES = ("turns about", "slides along", "is fixed, z:")
DIRECTIONS: dict[tuple[float, ...], str] = {
    **{(1, 0, 0): "x", (0, 1, 0): "y", (0, 0, 1): "z"},
    **{(-1, 0, 0): "-x", (0, -1, 0): "-y", (0, 0, -1): "-z"},
}
ROUNDING = 1e-12


def axes_table(placed: PlacedMachine, title: str = "") -> Table:
    """Return origin and axis of each joint in frame 0; `-` where they depend on parameters without value."""
    table = Table(("j", "name", "q", "origin x, m", "y, m", "z, m", "it", "this axis"), title=title, keys=2)
    size = max((abs(x) for one in placed.joints for x in one.origin if not math.isnan(x)), default=0.0)
    for j, one in enumerate(placed.joints, start=1):
        q = _number(placed.q[one.joint.name]) if one.joint.name in placed.q else ""
        origin = (_number(_cleared(x, size)) for x in one.origin)
        table.add_row(str(j), one.joint.name, q, *origin, MOVES[one.joint.sigma], _direction(one.axis))
    return table


def position_json(placed: PlacedMachine) -> dict[str, float | None]:
    """Return the position by joint, rad or m."""
    return dict(plain(placed.q))


def axes_json(placed: PlacedMachine) -> dict[str, Any]:
    """Return origin, m, and axis of each joint in frame 0, null where they depend on parameters without value."""
    return {one.joint.name: {"origin": plain(one.origin), "axis": plain(one.axis)} for one in placed.joints}


def _direction(axis: Sequence[float]) -> str:
    x, y, z = (_cleared(x, 1.0) for x in axis)
    return DIRECTIONS.get((x, y, z)) or f"{_number(x)}, {_number(y)}, {_number(z)}"


def _cleared(x: float, size: float) -> float:
    """A number; the nearest whole one where only rounding of numbers of this size lies between."""
    whole = 0.0 if math.isnan(x) else float(round(x))
    return whole if abs(x - whole) <= ROUNDING * size else x


def _number(x: float) -> str:
    return "-" if math.isnan(x) else f"{x + 0.0:.6g}"


def catalogue_json() -> dict[str, Any]:
    """Return every model: its family, arguments and results with shape and meaning, equations."""
    return {
        "models": {
            model.name: {
                "title": model.title,
                "family": model.family,
                "equations": model.equations,
                "arguments": {name: _described(model, name) for name in model.arguments},
                "results": {name: _described(model, name) for name in model.results},
            }
            for model in MODELS.values()
        },
        "notes": list(NOTES),
    }


def _described(model: Model, name: str) -> list[str]:
    """Shape and meaning of an argument or result."""
    row = model.quantity(name)
    return [row.shape, row.sentence]


def catalogue_lines(width: int) -> list[str]:
    """Return every model with its arguments and equations, then a line or two for each of its results."""
    rows = [(name, *_described(model, name)) for model in MODELS.values() for name in model.results]
    names, shapes = (max(len(row[k]) for row in rows) for k in (0, 1))
    lines = []
    for model in MODELS.values():
        lines.append(f"{model.name} of {_shown_arguments(model)} {model.equations}".rstrip())
        for name in model.results:
            shape, meaning = _described(model, name)
            head = f"  {name:{names}}  {shape:{shapes}}  "
            lines += textwrap.wrap(head + meaning, width, subsequent_indent=" " * len(head), break_on_hyphens=False)
    return lines


NOTES = (
    "n joints that move, m motors, so n - m elastic and passive joints; s static joints; frames: all rows of the "
    "table, or those a scene asks for ('tool at (0.1, 0, L2)' is a point in axes of tool, m)",
    "'tool in ram': geometric_model gives the placement of tool relative to ram; velocities, accelerations, jacobian "
    "and jacobian_dot_qd give its motion relative to frame 0, with components along the axes of ram",
    "inverse models: a target that is out of reach by more than rounding (1e-12) has no solution, so that fewer joints "
    "than it has degrees of freedom (6, or 3 for a position) need a target of 12 digits",
    "y ...: y and as many derivatives by time as the chain needs: yd, ydd, yddd ...",
    f"where a model solves for accelerations: {SINGULAR}, and so are their derivatives",
)


def _shown_arguments(model: Model) -> str:
    wanted = {row.name for row in MOTION}
    names = [name for name in model.arguments if name not in wanted]
    return ", ".join([*names, *(["y ..."] if len(names) < len(model.arguments) else [])]) or "p"
