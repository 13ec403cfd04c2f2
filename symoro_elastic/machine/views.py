"""Tables of a machine: geometric parameters, bodies, named frames, limits, drives."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from symoro_elastic.foundation.results import Part, Table, parts_of
from symoro_elastic.machine.columns import cells, declared_columns
from symoro_elastic.machine.described import DescribedMachine, drives_of, limits_of
from symoro_elastic.machine.drives import ONE, Drive, LowPass, Notch, Sought, gain_unit
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import Joint
from symoro_elastic.machine.limits import LIMITED, Range, unit_of
from symoro_elastic.machine.machine import Machine, known_values
from symoro_elastic.quantities.frames import BASE

CASCADE = "cascade"
IDLE = re.compile(r"(?<!\w)\(([\w.]+(?:(?<=e)-\d+)?)\)")
"""A name or a number in brackets, which are not those of a function."""
BODY_COLUMNS = ("M", "MX", "MY", "MZ", "XX", "XY", "XZ", "YY", "YZ", "ZZ")


@parts_of.register
def _(machine: Machine) -> list[Part]:
    """Return the table of geometric parameters, and the values of named parameters."""
    return [machine.headline, machine_table(machine, machine.name), *other_tables(machine), *parameter_lines(machine)]


def other_tables(machine: Machine) -> list[Table]:
    """Return the tables of named frames, limits and drives that have rows."""
    by_title = {
        **{"beams": beams_table, "springs from catalogues": catalogue_table},
        **{"frames": frames_table, "limits": limits_table, "drives": drives_table},
    }
    tables = [table(machine, title) for title, table in by_title.items()]
    return [table for table in tables if table.rows]


def machine_table(machine: Machine, title: str = "", with_units: bool = False) -> Table:
    """Return the table of geometric parameters, optionally with units in heads and laws of joints."""
    geometry = {column.key: column.dimension.units[0] for column in declared_columns(Joint, "joints")}
    unused = [name for name in ("gamma", "b") if all(getattr(joint, name).is_zero for joint in machine.joints)]
    geometric_columns = [name for name in geometry if name not in unused]
    heads = [f"{name}, {geometry[name]}" if with_units else name for name in geometric_columns]
    body = "body, kg" if with_units else "body"
    table = Table(("j", "name", "a(j)", "kind", "sigma", *heads, body, "joint"), title=title, keys=2)
    for j, joint in enumerate(machine.joints, start=1):
        geometric = [_cell(joint, name) for name in geometric_columns]
        kind = (str(joint.antecedent), joint.kind.value, str(joint.sigma))
        table.add_row(str(j), joint.name, *kind, *geometric, _body(joint), _law(joint, with_units))
    return table


def bodies_table(machine: Machine, title: str = "") -> Table:
    """Return masses, kg, first moments, kg m, and inertias, kg m2, about the origin of each body's frame."""
    massive = [joint for joint in machine.joints if joint.body.has_inertia]
    rows = [(joint.name, *(_written(formula) for _, formula in cells(joint.body))) for joint in massive]
    units = {1: "kg", 2: "kg m", 3: "kg m2"}
    heads = [f"{name}, {units[1 if name == 'M' else 2 if name[0] == 'M' else 3]}" for name in BODY_COLUMNS]
    return Table(("body", *heads), rows, title)


def frames_table(machine: Machine, title: str = "") -> Table:
    """Return the named frames with their placements in the frames of the rows whose bodies carry them."""
    table = Table(("frame", "on", "x, m", "y, m", "z, m", "roll, rad", "pitch, rad", "yaw, rad"), title=title)
    for frame in machine.frames:
        table.add_row(frame.name, frame.on or BASE, *(_written(cell) for _, cell in cells(frame)))
    return table


def frames_json(machine: Machine) -> dict[str, Any]:
    """Return the named frames: the joint whose body carries each, origin, m, roll, pitch and yaw, rad, as formulas."""
    return {
        frame.name: {"on": frame.on or BASE, "at": [*map(_written, frame.at)], "rpy": [*map(_written, frame.rpy)]}
        for frame in machine.frames
    }


def beams_table(machine: Machine, title: str = "") -> Table:
    """Return the beams of a machine's file: first frequencies, Hz, are those with the root clamped and the tip free."""
    heads = ("beam", "along", "length, m", "mass, kg", "rule", "joints or modes", "first frequencies if clamped, Hz")
    beams = machine.origin.beams if isinstance(machine, DescribedMachine) else ()
    is_chosen = any(beam.choice for beam in beams)
    table = Table((*heads, *(["predicted errors"] if is_chosen else [])), title=title)
    values = known_values(machine.parameters)
    for beam in beams:
        numbers = (Formula.parse(text).known_value(values) for text in (beam.length, beam.piece(0.0, 1.0)[0]))
        length, mass = ("-" if x is None else f"{x:.6g}" for x in numbers)
        first = ", ".join(f"{kind} {'-' if f is None else f'{f:.5g}'}" for kind, f in beam.first_frequencies(values))
        counts = [beam.modes_of(kind) if beam.modes else len(beam.places(kind)[0]) for kind in beam.bends]
        rule = "modes" if beam.modes else beam.rule
        choice = [beam.choice] if is_chosen else []
        table.add_row(beam.name, beam.along, length, mass, rule, "+".join(map(str, counts)), first, *choice)
    return table


def by_first_cell(table: Table) -> dict[str, dict[str, str]]:
    """Return the rows of a table by their first cells: texts by head."""
    return {row[0]: dict(zip(table.heads[1:], row[1:], strict=True)) for row in table.rows}


def catalogue_table(machine: Machine, title: str = "") -> Table:
    """Return the springs whose stiffness comes from a catalogue, with values where parameters have some."""
    table = Table(("spring", "stiffness", "formula", "source", "tolerance"), title=title)
    values = known_values(machine.parameters)
    units = {joint.name: f"{joint.force_unit}/{joint.unit}" for joint in machine.joints}
    for spring in machine.origin.catalogue_springs if isinstance(machine, DescribedMachine) else ():
        value = spring.stiffness.known_value(values)
        varying = ", ".join(sorted(spring.stiffness.names - values.keys()))
        shown = f"by {varying}" if value is None else f"{value:.6g} {units.get(spring.joint, '')}"
        table.add_row(spring.joint, shown, _written(spring.stiffness), spring.source, spring.tolerance)
    return table


def limits_table(machine: Machine, title: str = "") -> Table:
    """Return the limits of the joints of a machine, with units; without rows where it has none."""
    table = Table(("joint", *LIMITED), title=title)
    limits = limits_of(machine)
    for joint in machine.joints:
        if limit := limits.joints.get(joint.name):
            table.add_row(joint.name, *(_range(getattr(limit, name), unit_of(name, joint)) for name in LIMITED))
    return table


def drives_table(machine: Machine, title: str = "") -> Table:
    """Return the drives of a machine, with units; without rows where it has none."""
    rows = []
    for name, drive in drives_of(machine).by_motor.items():
        joint = next(row for row in machine.joints if row.name == name)
        gains = (_gain(getattr(drive, key), gain_unit(key, joint)) for key in ("Kp", "Tn", "Kv"))
        rows.append([name, CASCADE, *gains, drive.measured, ", ".join(_lateness(drive)) or "at once"])
        rows[-1] += [", ".join(_of_set_point(drive)), ", ".join(_limits_of_drive(drive, joint))]
    heads = ("axis", "kind", "Kp", "Tn", "Kv", "measured", "torque comes", "set point", "limits")
    filled = [k for k in range(len(heads)) if k < 7 or any(row[k] for row in rows)]
    return Table(tuple(heads[k] for k in filled), [tuple(row[k] for k in filled) for row in rows], title)


def _gain(gain: Formula | Sought | None, unit: str) -> str:
    if gain is None:
        return "-"
    return f"{_written(gain)} {unit}" if isinstance(gain, Formula) else str(gain)


def _lateness(drive: Drive) -> Iterator[str]:
    """Yield descriptions of the delays, filters and current loop between the velocity controller and the torque."""
    for name in ("lag", "dead_time", "period"):
        x = getattr(drive, name)
        if x is not None and not x.is_zero:
            yield f"{name.replace('_', ' ')} {_written(x)} s"
    if (loop := drive.current) is not None:
        yield f"current loop {_written(loop.kp)} V/A, {_written(loop.ti)} s"
        if not loop.compensation.is_zero:
            yield f"back-EMF compensated times {_written(loop.compensation)}"
    for stage in drive.filters:
        yield f"{'notch' if isinstance(stage, Notch) else 'low-pass'} {_written(stage.frequency)} Hz"


def _of_set_point(drive: Drive) -> Iterator[str]:
    """Yield the filter of the set point, and the rates that are fed forward."""
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
    """Yield the limits of a drive, and the time constant of its anti-windup."""
    units = {"torque_limit": joint.force_unit, "current_limit": "A", "voltage_limit": "V", "windup": "s"}
    for name, unit in units.items():
        if (x := getattr(drive, name)) is not None:
            yield f"{name.removesuffix('_limit')} {_written(x)} {unit}"


def drives_lines(machine: Machine) -> list[str]:
    """Return a sentence for each drive."""
    table = drives_table(machine)
    heads = ["", "", *table.heads[2:5], "measured:", "torque:", *(f"{name}:" for name in table.heads[7:])]
    sentences = ([f"{head} {x}".strip() for head, x in zip(heads[1:], row[1:], strict=True) if x] for row in table.rows)
    return [f"drive of {row[0]}: {', '.join(parts)}" for row, parts in zip(table.rows, sentences, strict=True)]


def limits_json(machine: Machine) -> dict[str, Any]:
    """Return low and high end of the limits of a machine, in SI units: of joints by quantity, and of parameters."""
    limits = limits_of(machine)
    joints = {
        name: {key: [x.low, x.high] for key in LIMITED if (x := getattr(ranges, key)) is not None}
        for name, ranges in limits.joints.items()
    }
    parameters = {name: [interval.low, interval.high] for name, interval in limits.parameters.items()}
    return {"joints": joints, "parameters": parameters}


def _range(interval: Range | None, unit: str) -> str:
    return "" if interval is None else f"{interval.low:.6g} to {interval.high:.6g} {unit}".rstrip()


def parameter_lines(machine: Machine) -> list[str]:
    """Return a line with the value of each named parameter, and one with the names of parameters without value."""
    tolerated = limits_of(machine).parameters
    ranges = {name: f" ({_range(one, '')})" for name, one in tolerated.items()}
    stated = (p for p in machine.parameters if p.value is not None)
    valued = [f"{p.name} = {p.value} {p.unit}".rstrip() + ranges.get(p.name, "") for p in stated]
    unknown = [p.name for p in machine.parameters if p.value is None]
    if not unknown:
        return valued
    count = "a parameter" if len(unknown) == 1 else f"{len(unknown)} parameters"
    return [*valued, f"{count} without value: {', '.join(unknown)}"]


def _cell(joint: Joint, name: str) -> str:
    offset: Formula = getattr(joint, name)
    if joint.variable is None or (name, joint.sigma) not in (("theta", 0), ("r", 1)):
        return _written(offset)
    return joint.variable if offset.is_zero else _sum_text(joint.variable, _written(offset))


def _written(formula: Formula) -> str:
    """A formula as in the file, pi always by the same name."""
    return re.sub(r"\bPi\b", "pi", str(formula))


def _sum_text(variable: str, offset: str) -> str:
    return f"{variable} - {offset[1:].lstrip()}" if offset.startswith("-") else f"{variable} + {offset}"


def _body(joint: Joint) -> str:
    return f"M = {joint.body.mass}" if joint.body.has_inertia else "massless"


def _law(joint: Joint, with_units: bool = False) -> str:
    """Return the laws of a joint, such as k = 2e7, d = 0.1; those of motors reflected to the joint."""
    columns = ((cell.column, formula) for cell, formula in cells(joint.reflected) if cell.column.symbol)
    given_laws = ((column, formula) for column, formula in columns if formula != column.default)
    laws = ((column, IDLE.sub(r"\1", f"{column.symbol} = {_written(formula)}")) for column, formula in given_laws)
    unit = int(joint.sigma == 1)
    return ", ".join(f"{law} {column.dimension.units[unit]}".rstrip() if with_units else law for column, law in laws)
