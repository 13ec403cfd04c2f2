"""Tables for the terminal, and the same values as plain data for `--json`."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import Any

from symoro_elastic.codegen.package_context import SINGULAR
from symoro_elastic.foundation.results import Table, plain
from symoro_elastic.models.bound.joint_axes import PlacedMachine
from symoro_elastic.models.programs.catalogue import MODELS, Model
from symoro_elastic.quantities import MOTION

MOVES = ("turns about", "slides along", "is fixed, z:")
DIRECTIONS: dict[tuple[float, ...], str] = {
    **{(1, 0, 0): "x", (0, 1, 0): "y", (0, 0, 1): "z"},
    **{(-1, 0, 0): "-x", (0, -1, 0): "-y", (0, 0, -1): "-z"},
}
ROUNDING = 1e-12


def axes_table(placement: PlacedMachine, title: str = "") -> Table:
    """Return origin and axis of the joints in frame 0; `-` if they depend on parameters without value."""
    table = Table(("j", "name", "q", "origin x, m", "y, m", "z, m", "it", "this axis"), title=title, keys=2)
    size = max((abs(x) for joint in placement.joints for x in joint.origin if not math.isnan(x)), default=0.0)
    for j, joint in enumerate(placement.joints, start=1):
        q = _number(placement.q[joint.joint.name]) if joint.joint.name in placement.q else ""
        origin = (_number(_without_rounding(x, size)) for x in joint.origin)
        table.add_row(str(j), joint.joint.name, q, *origin, MOVES[joint.joint.sigma], _direction(joint.axis))
    return table


def position_json(placement: PlacedMachine) -> dict[str, float | None]:
    """Return the position by joint, rad or m."""
    return dict(plain(placement.q))


def axes_json(placement: PlacedMachine) -> dict[str, Any]:
    """Return origin, m, and axis of the joints in frame 0, null if they depend on parameters without value."""
    return {joint.joint.name: {"origin": plain(joint.origin), "axis": plain(joint.axis)} for joint in placement.joints}


def _direction(axis: Sequence[float]) -> str:
    x, y, z = (_without_rounding(x, 1.0) for x in axis)
    return DIRECTIONS.get((x, y, z)) or f"{_number(x)}, {_number(y)}, {_number(z)}"


def _without_rounding(x: float, size: float) -> float:
    """Return the nearest integer if a number differs from it by rounding alone, else the number."""
    rounded = 0.0 if math.isnan(x) else float(round(x))
    return rounded if abs(x - rounded) <= ROUNDING * size else x


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
                "arguments": {name: _description(model, name) for name in model.arguments},
                "results": {name: _description(model, name) for name in model.results},
            }
            for model in MODELS.values()
        },
        "notes": list(NOTES),
    }


def _description(model: Model, name: str) -> list[str]:
    """Shape and meaning of an argument or result."""
    row = model.quantity(name)
    return [row.shape, row.sentence]


def catalogue_lines(width: int) -> list[str]:
    """Return every model with its arguments and equations, then a line or two for each of its results."""
    rows = [(name, *_description(model, name)) for model in MODELS.values() for name in model.results]
    names, shapes = (max(len(row[k]) for row in rows) for k in (0, 1))
    lines = []
    for model in MODELS.values():
        lines.append(f"{model.name} of {_shown_arguments(model)} {model.equations}".rstrip())
        for name in model.results:
            shape, meaning = _description(model, name)
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
