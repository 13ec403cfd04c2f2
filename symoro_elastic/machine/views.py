"""The table of geometric parameters, as it is printed."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from symoro_elastic.machine.columns import cells, declared
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import Joint

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine


BODY_COLUMNS = ("M", "MX", "MY", "MZ", "XX", "XY", "XZ", "YY", "YZ", "ZZ")


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


def bodies_table(machine: Machine) -> Any:
    """Return masses, kg, first moments, kg m, and inertias, kg m2, about the origin of each body's frame."""
    from rich.table import Table

    table = Table("body", *BODY_COLUMNS)
    for joint in machine.joints:
        values = [formula for _, formula in cells(joint.body)]
        if not all(formula.is_zero for formula in values):
            table.add_row(joint.name, *map(_written, values))
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
