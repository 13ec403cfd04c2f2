"""A machine in print: the table of geometric parameters, that of bodies, and that of limits."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from symoro_elastic.foundation.results import Part, Table, parts_of
from symoro_elastic.machine.columns import cells, declared_columns
from symoro_elastic.machine.described import drives_of, limits_of
from symoro_elastic.machine.drives import ONE, Drive, LowPass, Notch, Sought, gain_unit
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import Joint
from symoro_elastic.machine.limits import LIMITED, JointLimits, Range, unit_of
from symoro_elastic.machine.machine import Machine

CASCADE = "cascade"
IDLE = re.compile(r"(?<!\w)\(([\w.]+(?:(?<=e)-\d+)?)\)")
"""A name or a number in brackets, which are not those of a function."""
BODY_COLUMNS = ("M", "MX", "MY", "MZ", "XX", "XY", "XZ", "YY", "YZ", "ZZ")


@parts_of.register
def _(machine: Machine) -> list[Part]:
    """Return the table of geometric parameters, and the values of named parameters."""
    limited = limits_table(machine, "limits")
    driven = drives_table(machine, "drives")
    tables = [machine_table(machine, machine.name), *(one for one in (limited, driven) if one.rows)]
    return [machine.headline, *tables, *parameter_lines(machine)]


def machine_table(machine: Machine, title: str = "", with_units: bool = False) -> Table:
    """Return the table of geometric parameters, with units in heads and laws of joints if they are asked for."""
    geometry = {column.key: column.dimension.units[0] for column in declared_columns(Joint, "joints")}
    shown = [name for name in geometry if name not in ("gamma", "b") or _any(machine, name)]
    heads = [f"{name}, {geometry[name]}" if with_units else name for name in shown]
    body = "body, kg" if with_units else "body"
    table = Table(("j", "name", "a(j)", "kind", "sigma", *heads, body, "joint"), title=title, keys=2)
    for j, joint in enumerate(machine.joints, start=1):
        geometric = [_cell(joint, name) for name in shown]
        kind = (str(joint.antecedent), joint.kind.value, str(joint.sigma))
        table.add_row(str(j), joint.name, *kind, *geometric, _body(joint), _law(joint, with_units))
    return table


def bodies_table(machine: Machine, title: str = "") -> Table:
    """Return masses, kg, first moments, kg m, and inertias, kg m2, about the origin of each body's frame."""
    rows = [(joint.name, [formula for _, formula in cells(joint.body)]) for joint in machine.joints]
    massive = [(name, *map(_written, x)) for name, x in rows if not all(formula.is_zero for formula in x)]
    units = {1: "kg", 2: "kg m", 3: "kg m2"}
    heads = [f"{name}, {units[1 if name == 'M' else 2 if name[0] == 'M' else 3]}" for name in BODY_COLUMNS]
    return Table(("body", *heads), massive, title)


def limits_table(machine: Machine, title: str = "") -> Table:
    """Return the limits of the joints of a machine, with units; without rows where it has none."""
    table = Table(("joint", *LIMITED), title=title)
    limits = limits_of(machine)
    for joint in machine.joints:
        if one := limits.joints.get(joint.name):
            table.add_row(joint.name, *(_range(getattr(one, name), unit_of(name, joint)) for name in LIMITED))
    return table


def drives_table(machine: Machine, title: str = "") -> Table:
    """Return the drives of a machine, with units; without rows where it has none."""
    rows = []
    for name, drive in drives_of(machine).by_motor.items():
        joint = next(one for one in machine.joints if one.name == name)
        gains = (_gain(getattr(drive, key), gain_unit(key, joint)) for key in ("Kp", "Tn", "Kv"))
        rows.append([name, CASCADE, *gains, drive.measured, ", ".join(_lateness(drive)) or "at once"])
        rows[-1] += [", ".join(_of_set_point(drive)), ", ".join(_limits_of_drive(drive, joint))]
    heads = ("axis", "kind", "Kp", "Tn", "Kv", "measured", "torque comes", "set point", "limits")
    kept = [k for k in range(len(heads)) if k < 7 or any(row[k] for row in rows)]
    return Table(tuple(heads[k] for k in kept), [tuple(row[k] for k in kept) for row in rows], title)


def _gain(gain: Formula | Sought | None, unit: str) -> str:
    if gain is None:
        return "-"
    return f"{_written(gain)} {unit}" if isinstance(gain, Formula) else str(gain)


def _lateness(drive: Drive) -> Iterator[str]:
    """Yield what is between the velocity controller and the torque."""
    for name in ("lag", "dead_time", "period"):
        x = getattr(drive, name)
        if x is not None and not x.is_zero:
            yield f"{name.replace('_', ' ')} {_written(x)} s"
    if (loop := drive.current) is not None:
        yield f"current loop {_written(loop.kp)} V/A, {_written(loop.ti)} s"
        if not loop.compensation.is_zero:
            yield f"back-EMF compensated times {_written(loop.compensation)}"
    for one in drive.filters:
        yield f"{'notch' if isinstance(one, Notch) else 'low-pass'} {_written(one.frequency)} Hz"


def _of_set_point(drive: Drive) -> Iterator[str]:
    """Yield the filter of the set point, and what of its rates is fed forward."""
    if isinstance(drive.set_point, LowPass):
        yield f"low-pass {_written(drive.set_point.frequency)} Hz"
    elif drive.set_point is not None:
        yield f"mean of {_written(drive.set_point.time)} s"
    if drive.velocity_forward != ONE:
        yield f"velocity forward times {_written(drive.velocity_forward)}"
    if not drive.acceleration_forward.is_zero:
        yield f"acceleration forward times {_written(drive.acceleration_forward)}"
    if drive.torque_forward:
        yield "torque of the inverse model forward"


def _limits_of_drive(drive: Drive, joint: Joint) -> Iterator[str]:
    """Yield the limits of a drive, and the time in which the integral part gives way there."""
    units = {"torque_limit": joint.force_unit, "current_limit": "A", "voltage_limit": "V", "windup": "s"}
    for name, unit in units.items():
        if (x := getattr(drive, name)) is not None:
            yield f"{name.removesuffix('_limit')} {_written(x)} {unit}"


def drives_lines(machine: Machine) -> list[str]:
    """Return a sentence for each drive."""
    table = drives_table(machine)
    heads = ["", "", *table.heads[2:5], "measured:", "torque:", *(f"{name}:" for name in table.heads[7:])]
    shown = ([f"{head} {x}".strip() for head, x in zip(heads[1:], row[1:], strict=True) if x] for row in table.rows)
    return [f"drive of {row[0]}: {', '.join(said)}" for row, said in zip(table.rows, shown, strict=True)]


def drives_json(machine: Machine) -> dict[str, dict[str, str]]:
    """Return the drives of a machine by motor: what the table of them says."""
    table = drives_table(machine)
    return {row[0]: dict(zip(table.heads[1:], row[1:], strict=True)) for row in table.rows}


def limits_json(machine: Machine) -> dict[str, Any]:
    """Return low and high end of the limits of a machine, in SI units: of joints by quantity, and of parameters."""
    limits = limits_of(machine)
    joints = {name: _ranges_of(one) for name, one in limits.joints.items()}
    parameters = {name: [one.low, one.high] for name, one in limits.parameters.items()}
    return {"joints": joints, "parameters": parameters}


def _ranges_of(limits: JointLimits) -> dict[str, list[float]]:
    given = {name: getattr(limits, name) for name in LIMITED}
    return {name: [one.low, one.high] for name, one in given.items() if one is not None}


def _range(one: Range | None, unit: str) -> str:
    return "" if one is None else f"{one.low:.6g} to {one.high:.6g} {unit}".rstrip()


def parameter_lines(machine: Machine) -> list[str]:
    """Return a line with the value of each named parameter, and one with the names of those without."""
    tolerated = limits_of(machine).parameters
    ranges = {name: f" ({_range(one, '')})" for name, one in tolerated.items()}
    known = (p for p in machine.parameters if p.value is not None)
    valued = [f"{p.name} = {p.value} {p.unit}".rstrip() + ranges.get(p.name, "") for p in known]
    unknown = [p.name for p in machine.parameters if p.value is None]
    if not unknown:
        return valued
    count = "a parameter" if len(unknown) == 1 else f"{len(unknown)} parameters"
    return [*valued, f"{count} without value: {', '.join(unknown)}"]


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


def _law(joint: Joint, with_units: bool = False) -> str:
    """The laws of a joint, such as k = 2e7, d = 0.1; those of motors as the joint feels them."""
    found = ((cell.column, formula) for cell, formula in cells(joint.reflected) if cell.column.symbol)
    shown = ((column, formula) for column, formula in found if formula != column.default)
    laws = ((column, IDLE.sub(r"\1", f"{column.symbol} = {_written(formula)}")) for column, formula in shown)
    unit = int(joint.sigma == 1)
    return ", ".join(f"{law} {column.dimension.units[unit]}".rstrip() if with_units else law for column, law in laws)
