"""Swept quantities of a machine: parameters, numbers of its table and its drives, positions of its joints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from symoro_elastic.analysis.sweeps.ranges import LIMITS, OPTION, TOLERANCE, Axis, OfMachine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.columns import Cell, Dimension, cells
from symoro_elastic.machine.described import drives_of, limits_of
from symoro_elastic.machine.frames import COORDINATES
from symoro_elastic.machine.limits import Limits
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.named_cells import WINDING, numbers_of_drives, why_no_number, with_named_cells
from symoro_elastic.machine.names import did_you_mean, quote

POSITION = "q."
"""What the name of a position begins with: q.motor_x. It may be left out where no parameter is called so."""
STRUCTURE = (
    "zeros and angles of the table, and lengths in loops, are part of the structure of a machine: name a parameter"
)


@dataclass(frozen=True)
class Quantity:
    """The quantity of an axis: `key` is the name of a parameter, or of a joint for its position.

    `of_drive` says that drives alone depend on it.
    """

    name: str
    key: str
    is_position: bool
    unit: str = ""
    cells: tuple[Cell, ...] = ()
    of_drive: bool = False

    def fault(self, x: float) -> str:
        """Return why the machine's cells cannot have the value x of this quantity; empty for a valid one."""
        return next((what for cell in self.cells if (what := _fault(cell, x))), "")


def quantities(machine: Machine, names: Iterable[str]) -> tuple[Quantity, ...]:
    """Return the quantities by their names; raises `InputError` for unknown and for repeated ones."""
    by_name = _quantities_by_name(machine)
    selected = tuple(_quantity_of(machine, name, by_name) for name in names)
    for k, quantity in enumerate(selected):
        for other in selected[:k]:
            if (quantity.key, quantity.is_position) == (other.key, other.is_position):
                what = f"{other.name} and {quantity.name} are the same quantity: give it one axis"
                raise InputError(machine.label, OPTION, what)
    return selected


def with_ranges(machine: Machine, swept: Sequence[Quantity], axes: Mapping[str, Axis]) -> dict[str, Axis]:
    """Return the axes with ranges of the machine; raises `InputError` for missing ranges."""
    limits = limits_of(machine)
    return {quantity.name: _with_range(machine, limits, quantity, axes[quantity.name]) for quantity in swept}


def _with_range(machine: Machine, limits: Limits, quantity: Quantity, over: Axis) -> Axis:
    if not isinstance(over, OfMachine):
        return over
    if over.word == LIMITS:
        bounds = limits.of(quantity.key).position if quantity.is_position else None
        key = quantity.key
        what = f"[limits] of the machine give no position of {key}: write {key} = {{ position = [LOW, HIGH] }}"
        other = f"{quantity.name} is a parameter: write {quantity.name}={TOLERANCE}"
    else:
        bounds = None if quantity.is_position else limits.parameters.get(quantity.key)
        written = quantity.key if "." not in quantity.key else "P"
        what = "[parameters] of the machine give no tolerance of it: write"
        what += f' {written} = {{ value = X, tolerance = "5 %" }}'
        what += f", and P in place of {quantity.key}" if written == "P" else ""
        other = f"{quantity.name} is a position: write {quantity.name}={LIMITS}"
    if bounds is None:
        is_other = quantity.is_position is not (over.word == LIMITS)
        raise InputError(machine.label, OPTION, f"{quantity.name}={over.word}: {other if is_other else what}")
    if not bounds.low < bounds.high:
        raise InputError(machine.label, OPTION, f"{quantity.name}={over.word}: there is one value only, {bounds.low:g}")
    return over.between(bounds)


def split(swept: Sequence[Quantity], row: Sequence[float]) -> tuple[dict[str, float], dict[str, float]]:
    """Return the values of parameters and the positions of joints at a point of the design."""
    pairs = list(zip(swept, row, strict=True))
    return {x.key: v for x, v in pairs if not x.is_position}, {x.key: v for x, v in pairs if x.is_position}


def impossible(swept: Sequence[Quantity], row: Sequence[float]) -> str:
    """Return why a machine cannot have the values of a point; empty for valid ones."""
    return ", ".join(f"{x.name} {what}" for x, v in zip(swept, row, strict=True) if (what := x.fault(v)))


def _quantities_by_name(machine: Machine) -> dict[str, Quantity]:
    """Return all quantities by name: parameters first, then cells as in TOML and in .par, then positions."""
    positions = [Quantity(x.name, x.name, True, x.unit) for x in machine.independent_joints]
    positions += [Quantity(x, x, True, "rad" if ".r" in x else "m") for x in COORDINATES[: machine.degrees_of_base]]
    named = {parameter.name for parameter in with_named_cells(machine).parameters}
    filled = [pair for owner in (*machine.joints, *machine.free_bodies) for pair in cells(owner)]
    alone = {p.name: tuple(cell for cell, formula in filled if str(formula) == p.name) for p in machine.parameters}
    driving = _of_drives_alone(machine)
    parameters = [(p.name, p.unit) for p in machine.parameters]
    by_name = {x: Quantity(x, x, False, unit, alone[x], x in driving) for x, unit in parameters}
    for joint in machine.joints:
        for cell in (cell for cell, _ in cells(joint)):
            key = f"{joint.name}.{cell.name}"
            for name in (key, f"{joint.name}.{cell.par}") if key in named else ():
                by_name.setdefault(name, Quantity(name, key, False, joint.unit_of(cell), (cell,)))
    for name, number in numbers_of_drives(machine).items():
        by_name.setdefault(name, Quantity(name, name, False, number.unit, of_drive=True))
    for position in positions:
        by_name[POSITION + position.name] = Quantity(POSITION + position.name, position.key, True, position.unit)
        by_name.setdefault(position.name, position)
    for joint in machine.independent_joints:
        variable = str(joint.variable)
        by_name.setdefault(variable, Quantity(variable, joint.name, True, joint.unit))
    return by_name


def _of_drives_alone(machine: Machine) -> set[str]:
    """Return the parameters that occur only in drives and their windings."""
    drives = drives_of(machine).by_motor.values()
    driving = {name for drive in drives for _, formula in drive.formulas for name in formula.names}
    elsewhere = set[str]()
    for owner in (*machine.joints, machine.base, *machine.free_bodies):
        for cell, formula in cells(owner):
            (driving if cell.name in WINDING else elsewhere).update(formula.names)
    return driving - elsewhere


def _fault(cell: Cell, x: float) -> str:
    if x < 0 and cell.column.dimension is Dimension.INERTIA and cell.name in ("XX", "YY", "ZZ"):
        return f"is negative: {x:g}"
    return cell.column.dimension.fault(x)


def _quantity_of(machine: Machine, name: str, by_name: dict[str, Quantity]) -> Quantity:
    if name in by_name:
        return by_name[name]
    if reason := why_no_number(machine, name):
        raise InputError(machine.label, OPTION, f"{quote(name)} cannot be swept: {reason}")
    joint, _, key = name.partition(".")
    own = next((x for x in machine.joints if x.name == joint), None)
    if own and key in {label for cell, _ in cells(own) for label in (cell.name, cell.par)}:
        if own.name in (body.joint for body in machine.flexible):
            what = "its body bends by modes, whose integrals do not follow: give a beam joints in place of modes"
            raise InputError(machine.label, OPTION, f"{quote(name)} cannot be swept: {what}")
        raise InputError(machine.label, OPTION, f"{quote(name)} cannot be swept: {STRUCTURE} in its place")
    what = f"no parameter, number of the table or position {quote(name)}{did_you_mean(name, by_name)}"
    raise InputError(machine.label, OPTION, what)
