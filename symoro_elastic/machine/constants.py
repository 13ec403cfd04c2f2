"""Parameters replaced by their values in every cell."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

from symoro_elastic.foundation.errors import refusing
from symoro_elastic.machine.columns import Cell, with_cells
from symoro_elastic.machine.described import AnyMachine, DescribedMachine, with_changed_scene
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Parameter
from symoro_elastic.machine.names import IN_USE, NONE, Reasons, why_reserved
from symoro_elastic.machine.scene import ALL, AT, RequestedPart, Scene

WITH_CELLS = ("joints", "base", "floating", "loops", "static", "forces", "frames")
"""Fields of a machine in which names of parameters stand."""
_NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*", re.ASCII)
SECTIONS = ("bodies", "springs", "motors", "friction", "wrenches")
"""Tables whose numbers may become parameters; lengths and angles are the structure of a machine."""
STEMS = {"center_of_mass": "c", "damping": "d", "neutral": "n"}
"""Of the names of columns that have no symbol of their own in .par files."""


def with_constants(machine: AnyMachine, names: Collection[str]) -> AnyMachine:
    """The machine with values of some parameters in place of their names, wherever they occur.

    Raises `InputError` where an expression grows beyond what is read.
    """
    values = {p.name: p.value for p in machine.parameters if p.name in names and p.value is not None}
    remaining = tuple(parameter for parameter in machine.parameters if parameter.name not in values)
    with refusing(machine.label, "parameters", f"{', '.join(values)}: "):
        own = (*WITH_CELLS, *(("drives",) if isinstance(machine, DescribedMachine) else ()))
        cells = {name: _with_values_in(getattr(machine, name), values) for name in own}
        return with_changed_scene(replace(machine, parameters=remaining, **cells), lambda scene: _scene(scene, values))


def _scene(scene: Scene, values: Mapping[str, Formula]) -> Scene:
    """The scene with values in place of names, which are no longer among its constants."""
    replaced: Scene = _with_values_in(scene, values)
    fold = ALL if replaced.fold == ALL else tuple(name for name in replaced.fold if name not in values)
    return replace(replaced, fold=fold)


def _with_values_in(x: Any, values: Mapping[str, Formula]) -> Any:
    """Return data with values in place of names in all its formulas, points in the outputs of a scene included."""
    if isinstance(x, Formula):
        return substitute(x, values)
    if isinstance(x, str) and AT in x:
        return str(_with_values_in(RequestedPart.parse(x), values))
    if isinstance(x, tuple):
        return tuple(_with_values_in(part, values) for part in x)
    if isinstance(x, dict):
        return {key: _with_values_in(part, values) for key, part in x.items()}
    if is_dataclass(x) and not isinstance(x, type):
        return replace(x, **{field.name: _with_values_in(getattr(x, field.name), values) for field in fields(x)})
    return x


def substitute(formula: Formula, values: Mapping[str, Formula]) -> Formula:
    """The expression with others in place of names; raises `FormulaError` where it grows beyond what is read."""
    if not formula.names & values.keys():
        return formula
    if formula.tree[0] == "name":
        return values[formula.tree[1]]
    text = _NAME.sub(lambda match: f"({values[match[0]]})" if match[0] in values else match[0], formula.text)
    return Formula.parse(text)


def with_free_numbers(machine: AnyMachine, sections: Collection[str], reserved: Reasons = NONE) -> AnyMachine:
    """Return the machine with the numbers of some tables as parameters: M3, XX3, k13, IA1 ... with their values.

    The number is that of the joint. Zeros stay: they are structure. Where a name is used already, or `reserved`, or one
    of generated code, it is free_M3 instead.
    """
    own = machine.parameter_names.union(joint.variable or "" for joint in machine.joints)
    used = {**reserved, **dict.fromkeys({machine.name, *own, *(joint.name for joint in machine.joints)}, IN_USE)}
    named: list[Parameter] = []
    joints = tuple(_with_free(joint, j, sections, used, named) for j, joint in enumerate(machine.joints, start=1))
    return replace(machine, joints=joints, parameters=(*machine.parameters, *named))


def _with_free(joint: Joint, j: int, sections: Collection[str], used: dict[str, str], named: list[Parameter]) -> Joint:
    def free(cell: Cell, formula: Formula) -> Formula:
        left_out = formula.is_zero or formula == cell.column.default
        if formula.names or left_out or cell.column.section not in sections:
            return formula
        name = unused_name(f"{_stem(cell)}{j}", used)
        used[name] = IN_USE
        named.append(Parameter(name, formula, joint.unit_of(cell)))
        return Formula.parse(name)

    return with_cells(joint, free)


def _stem(cell: Cell) -> str:
    """Return the name of a column in a parameter: that of .par files, such as XX, or a letter and an axis."""
    stem = STEMS.get(cell.column.key)
    if stem is None:
        return cell.par
    return stem + (cell.column.parts[cell.index] if cell.column.parts else "")


def unused_name(name: str, used: Reasons) -> str:
    """The name of a parameter, with a prefix `free_` where it is in use or invalid."""
    candidates: Sequence[str] = (name, f"free_{name}", *(f"free_{name}_{k}" for k in range(1, len(used) + 1)))
    return next(candidate for candidate in candidates if why_reserved(candidate, used) is None)
