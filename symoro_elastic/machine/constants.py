"""Parameters replaced by their values in every cell."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

from symoro_elastic.machine.described import AnyMachine, DescribedMachine, with_changed_scene
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.scene import ALL, AT, RequestedPart, Scene

WITH_CELLS = ("joints", "base", "floating", "loops", "static", "forces")
"""Fields of a machine in which names of parameters stand."""
_NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*", re.ASCII)


def with_constants(machine: AnyMachine, names: Collection[str]) -> AnyMachine:
    """The machine with the values of these parameters in place of their names, wherever they occur.

    Raises `InputError` where an expression grows beyond what is read.
    """
    values = {p.name: p.value for p in machine.parameters if p.name in names and p.value is not None}
    kept = tuple(parameter for parameter in machine.parameters if parameter.name not in values)
    try:
        own = (*WITH_CELLS, *(("drives",) if isinstance(machine, DescribedMachine) else ()))
        cells = {name: _replaced(getattr(machine, name), values) for name in own}
        return with_changed_scene(replace(machine, parameters=kept, **cells), lambda scene: _scene(scene, values))
    except FormulaError as error:
        raise machine.error("parameters", f"{', '.join(values)}: {error}") from None


def _scene(scene: Scene, values: Mapping[str, Formula]) -> Scene:
    """The scene with values in place of names, which are no longer among its constants."""
    found: Scene = _replaced(scene, values)
    return found if found.fold == ALL else replace(found, fold=tuple(name for name in found.fold if name not in values))


def _replaced(x: Any, values: Mapping[str, Formula]) -> Any:
    """Data with values in place of names in all its formulas, points in the outputs of a scene included."""
    if isinstance(x, Formula):
        return substitute(x, values)
    if isinstance(x, str) and AT in x:
        return str(_replaced(RequestedPart.parse(x), values))
    if isinstance(x, tuple):
        return tuple(_replaced(part, values) for part in x)
    if isinstance(x, dict):
        return {key: _replaced(part, values) for key, part in x.items()}
    if is_dataclass(x) and not isinstance(x, type):
        return replace(x, **{field.name: _replaced(getattr(x, field.name), values) for field in fields(x)})
    return x


def substitute(formula: Formula, values: Mapping[str, Formula]) -> Formula:
    """The expression with others in place of names; raises `FormulaError` where it grows beyond what is read."""
    if not formula.names & values.keys():
        return formula
    if formula.tree[0] == "name":
        return values[formula.tree[1]]
    text = _NAME.sub(lambda found: f"({values[found[0]]})" if found[0] in values else found[0], formula.text)
    return Formula.parse(text)
