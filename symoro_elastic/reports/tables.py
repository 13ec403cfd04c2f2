"""Tables for the terminal, and the same figures as plain data for `--json`."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from symoro_elastic.codegen.described import SINGULAR
from symoro_elastic.machine.columns import cells, declared
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Machine
from symoro_elastic.models.catalogue import MODELS, Model, TracedModel
from symoro_elastic.models.joint_axes import PlacedMachine
from symoro_elastic.quantities import MOTION
from symoro_elastic.symbolic.program import OperationCount, saved

if TYPE_CHECKING:
    from symoro_elastic.numerics.verify import Verification


def count_json(count: OperationCount) -> dict[str, int]:
    """Operations by kind."""
    return {"mul": count.mul, "add": count.add, "div": count.div, "sincos": count.sincos}


def models_json(models: Sequence[TracedModel], whole: Sequence[TracedModel]) -> dict[str, Any]:
    """Operation counts of each model, and of the whole machine where less was asked for."""
    found: dict[str, Any] = {}
    for model, full in zip(models, whole, strict=True):
        found[model.model.name] = count_json(model.program.count) | {"once": count_json(model.program.count_once)}
        if full is not model:
            found[model.model.name]["whole"] = count_json(full.program.count)
            found[model.model.name]["saved"] = dict(saved(full.program.count, model.program.count))
    return found


def models_table(models: Sequence[TracedModel], whole: Sequence[TracedModel]) -> Any:
    """Operation counts of each model, beside those of the whole machine where less was asked for."""
    from rich.table import Table

    partial = any(full is not model for model, full in zip(models, whole, strict=True))
    table = Table(
        "model", *(("whole machine", "asked", "saved") if partial else ("a call",)), "once for each parameter set"
    )
    for model, full in zip(models, whole, strict=True):
        once = operations(model.program.count_once)
        asked = operations(model.program.count)
        if not partial:
            table.add_row(model.model.name, asked, once)
        else:
            table.add_row(model.model.name, operations(full.program.count), asked, _share(full, model), once)
    return table


def operations(count: OperationCount) -> str:
    """`292x 277+ 10 sin/cos`; x counts products and divisions, + sums and differences."""
    if count == OperationCount():
        return "-"
    return f"{count.products}x {count.add}+" + (f" {count.sincos} sin/cos" if count.sincos else "")


def _share(full: TracedModel, asked: TracedModel) -> str:
    before, after = (m.program.count.products + m.program.count.add for m in (full, asked))
    return f"{before - after} ({(before - after) / before:.0%})" if before else "-"


def machine_table(machine: Machine) -> Any:
    """The table of geometric parameters."""
    from rich.table import Table

    geometry = [column.key for column in declared(Joint, "joints")]
    shown = [name for name in geometry if name not in ("gamma", "b") or _any(machine, name)]
    table = Table("j", "name", "a(j)", "kind", "sigma", *shown, "body", "joint")
    for j, joint in enumerate(machine.joints, start=1):
        geometric = [_cell(joint, name) for name in shown]
        kind = (str(joint.antecedent), joint.kind.value, str(joint.sigma))
        table.add_row(str(j), joint.name, *kind, *geometric, _body(joint), _law(joint))
    return table


def _any(machine: Machine, name: str) -> bool:
    return any(not getattr(joint, name).is_zero for joint in machine.joints)


def _cell(joint: Joint, name: str) -> str:
    offset: Formula = getattr(joint, name)
    if joint.variable is None or (name, joint.sigma) not in (("theta", 0), ("r", 1)):
        return _written(offset)
    return joint.variable if offset.is_zero else _added(joint.variable, _written(offset))


def _written(formula: Formula) -> str:
    """A formula as it stands in the file, pi always by the same name."""
    return re.sub(r"\bPi\b", "pi", str(formula))


def _added(variable: str, offset: str) -> str:
    return f"{variable} - {offset[1:].lstrip()}" if offset.startswith("-") else f"{variable} + {offset}"


def _body(joint: Joint) -> str:
    massless = all(formula.is_zero for _, formula in cells(joint.body))
    return "massless" if massless else f"M = {joint.body.mass}"


def _law(joint: Joint) -> str:
    shown = ((cell.column.symbol, formula) for cell, formula in cells(joint) if cell.column.symbol)
    return ", ".join(f"{symbol} = {_written(formula)}" for symbol, formula in shown if not formula.is_zero)


MOVES = ("turns about", "slides along", "is fixed, z:")
DIRECTIONS: dict[tuple[float, ...], str] = {
    **{(1, 0, 0): "x", (0, 1, 0): "y", (0, 0, 1): "z"},
    **{(-1, 0, 0): "-x", (0, -1, 0): "-y", (0, 0, -1): "-z"},
}
ROUNDING = 1e-12


def axes_table(placed: PlacedMachine) -> Any:
    """Origin and axis of each joint in frame 0; `-` where they depend on parameters without value."""
    from rich.table import Table

    table = Table("j", "name", "q", "origin x, m", "y, m", "z, m", "it", "this axis")
    size = max((abs(x) for one in placed.joints for x in one.origin if not math.isnan(x)), default=0.0)
    for j, one in enumerate(placed.joints, start=1):
        q = _number(placed.q[one.joint.name]) if one.joint.name in placed.q else ""
        origin = (_number(_cleared(x, size)) for x in one.origin)
        table.add_row(str(j), one.joint.name, q, *origin, MOVES[one.joint.sigma], _direction(one.axis))
    return table


def position_json(placed: PlacedMachine) -> dict[str, float | None]:
    """The position by joint, rad or m."""
    return {name: _finite(x) for name, x in placed.q.items()}


def axes_json(placed: PlacedMachine) -> dict[str, Any]:
    """Origin, m, and axis of each joint in frame 0, null where they depend on parameters without value."""
    return {
        one.joint.name: {"origin": list(map(_finite, one.origin)), "axis": list(map(_finite, one.axis))}
        for one in placed.joints
    }


def _direction(axis: Sequence[float]) -> str:
    x, y, z = (_cleared(x, 1.0) for x in axis)
    return DIRECTIONS.get((x, y, z)) or f"{_number(x)}, {_number(y)}, {_number(z)}"


def _cleared(x: float, size: float) -> float:
    """A number; the nearest whole one where only rounding of numbers of this size lies between."""
    whole = 0.0 if math.isnan(x) else float(round(x))
    return whole if abs(x - whole) <= ROUNDING * size else x


def _number(x: float) -> str:
    return "-" if math.isnan(x) else f"{x + 0.0:.6g}"


def _finite(x: float) -> float | None:
    return None if math.isnan(x) else x


def verification_table(result: Verification) -> Any:
    """Worst errors of each model: at moderate states / at extreme states."""
    from rich.table import Table

    table = Table("model", "C", "numpy", "floats", "bound", "")
    for model in result.models:
        errors = [
            f"{worst.moderate:.1e} / {worst.extreme:.1e}" if worst else "-"
            for worst in (model.c, model.numpy, model.equations)
        ]
        table.add_row(model.name, *errors, f"{model.bound:.1e}", "ok" if model.ok else "out of bounds")
    return table


def verification_json(result: Verification) -> dict[str, Any]:
    """Worst errors of each model as plain data; `c` is null without a compiler."""
    models = {
        model.name: {
            "numpy": model.numpy.error,
            "c": model.c.error if model.c else None,
            "equations": model.equations.error,
            "moderate": {"numpy": model.numpy.moderate, "c": model.c.moderate if model.c else None},
            "bound": model.bound,
            "ok": model.ok,
        }
        for model in result.models
    }
    found: dict[str, Any] = {"ok": result.ok and not result.missing, "states": result.states, "models": models}
    return found | ({"missing": result.missing} if result.missing else {})


def catalogue_json() -> dict[str, Any]:
    """Every model: its family, arguments and results with shape and meaning, equations."""
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
    """Every model with its arguments and equations, then a line or two for each of its results."""
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
