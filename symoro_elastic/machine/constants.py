"""Parameters replaced by their values in every cell."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, AT, Asked

_NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*", re.ASCII)


def with_constants(machine: Machine, names: Collection[str]) -> Machine:
    """The machine with the values of these parameters in place of their names, wherever they occur.

    Raises `InputError` where an expression grows beyond what is read.
    """
    values = {p.name: p.value for p in machine.parameters if p.name in names and p.value is not None}
    try:
        inside: Machine = _replaced(replace(machine, parameters=(), scene=None, motions=()), values)
        scene = _replaced(machine.scene, values)
    except FormulaError as error:
        raise machine.error("parameters", f"{', '.join(values)}: {error}") from None
    if scene is not None and scene.fold != ALL:
        scene = replace(scene, fold=tuple(name for name in scene.fold if name not in values))
    kept = tuple(parameter for parameter in machine.parameters if parameter.name not in values)
    return replace(inside, parameters=kept, scene=scene, motions=machine.motions)


def _replaced(x: Any, values: Mapping[str, Formula]) -> Any:
    """Data with values in place of names in all its formulas, points in the outputs of a scene included."""
    if isinstance(x, Formula):
        return substituted(x, values)
    if isinstance(x, str) and AT in x:
        return str(_replaced(Asked.parse(x), values))
    if isinstance(x, tuple):
        return tuple(_replaced(part, values) for part in x)
    if isinstance(x, dict):
        return {key: _replaced(part, values) for key, part in x.items()}
    if is_dataclass(x) and not isinstance(x, type):
        return replace(x, **{field.name: _replaced(getattr(x, field.name), values) for field in fields(x)})
    return x


def substituted(formula: Formula, values: Mapping[str, Formula]) -> Formula:
    """The expression with others in place of names; raises `FormulaError` where it grows beyond what is read."""
    if not formula.names & values.keys():
        return formula
    if formula.tree[0] == "name":
        return values[formula.tree[1]]
    text = _NAME.sub(lambda found: f"({values[found[0]]})" if found[0] in values else found[0], formula.text)
    return Formula.parse(text)
