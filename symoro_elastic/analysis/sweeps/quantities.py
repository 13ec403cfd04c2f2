"""Quantities of a machine that are swept: parameters, numbers of its table and its drives, positions of its joints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from symoro_elastic.analysis.sweeps.ranges import LIMITS, OPTION, TOLERANCE, Axis, OfMachine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.columns import Cell, Dimension, cells
from symoro_elastic.machine.described import drives_of, limits_of
from symoro_elastic.machine.drive_numbers import WINDING, numbers_of_drives, why_no_number
from symoro_elastic.machine.free_base import COORDINATES
from symoro_elastic.machine.limits import Limits
from symoro_elastic.machine.machine import Joint, Machine
from symoro_elastic.machine.named_cells import with_named_cells
from symoro_elastic.machine.names import did_you_mean, quote

POSITION = "q."
"""What the name of a position begins with: q.motor_x. It may be left out where no parameter is called so."""
STRUCTURE = (
    "zeros and angles of the table, and lengths in loops, are part of the structure of a machine: name a parameter"
)


@dataclass(frozen=True)
class Quantity:
    """What an axis changes: `key` is the name of a parameter, or of a joint whose position it is.

    `of_drive` says that drives alone depend on it.
    """

    name: str
    key: str
    is_position: bool
    unit: str = ""
    cells: tuple[Cell, ...] = ()
    of_drive: bool = False

    def fault(self, x: float) -> str:
        """Return why the cells that hold it cannot be x; empty where they can."""
        return next((what for cell in self.cells if (what := _fault(cell, x))), "")


def quantities(machine: Machine, names: Iterable[str]) -> tuple[Quantity, ...]:
    """Return the quantities of these names; raises `InputError` for unknown ones and for one that is named twice."""
    known = _known(machine)
    found = tuple(_found(machine, name, known) for name in names)
    for k, one in enumerate(found):
        for other in found[:k]:
            if (one.key, one.is_position) == (other.key, other.is_position):
                what = f"{other.name} and {one.name} are the same quantity: give it one axis"
                raise InputError(machine.label, OPTION, what)
    return found


def with_ranges(machine: Machine, found: Sequence[Quantity], axes: Mapping[str, Axis]) -> dict[str, Axis]:
    """Return the axes with the ranges that a machine gives; raises `InputError` where it gives none."""
    limits = limits_of(machine)
    return {one.name: _ranged(machine, limits, one, axes[one.name]) for one in found}


def _ranged(machine: Machine, limits: Limits, one: Quantity, over: Axis) -> Axis:
    if not isinstance(over, OfMachine):
        return over
    if over.word == LIMITS:
        given = limits.of(one.key).position if one.is_position else None
        what = f"[limits] of the machine give no position of {one.key}: write {one.key} = {{ position = [LOW, HIGH] }}"
        other = f"{one.name} is a parameter: write {one.name}={TOLERANCE}"
    else:
        given = None if one.is_position else limits.parameters.get(one.key)
        written = one.key if "." not in one.key else "P"
        what = (
            f'[parameters] of the machine give no tolerance of it: write {written} = {{ value = X, tolerance = "5 %" }}'
        )
        what += f", and P in place of {one.key}" if written == "P" else ""
        other = f"{one.name} is a position: write {one.name}={LIMITS}"
    if given is None:
        is_other = one.is_position is not (over.word == LIMITS)
        raise InputError(machine.label, OPTION, f"{one.name}={over.word}: {other if is_other else what}")
    if not given.low < given.high:
        raise InputError(machine.label, OPTION, f"{one.name}={over.word}: there is one value only, {given.low:g}")
    return over.between(given)


def split(found: Sequence[Quantity], row: Sequence[float]) -> tuple[dict[str, float], dict[str, float]]:
    """Return values of parameters and positions of joints at a point."""
    pairs = list(zip(found, row, strict=True))
    return {x.key: v for x, v in pairs if not x.is_position}, {x.key: v for x, v in pairs if x.is_position}


def impossible(found: Sequence[Quantity], row: Sequence[float]) -> str:
    """Return why a machine cannot have these values; empty where it can."""
    return ", ".join(f"{x.name} {what}" for x, v in zip(found, row, strict=True) if (what := x.fault(v)))


def _known(machine: Machine) -> dict[str, Quantity]:
    """Return all quantities by name: parameters first, then cells as in TOML and in .par, then positions."""
    positions = [Quantity(x.name, x.name, True, x.unit) for x in machine.independent_joints]
    positions += [Quantity(x, x, True, "rad" if ".r" in x else "m") for x in COORDINATES[: machine.degrees_of_base]]
    named = {parameter.name for parameter in with_named_cells(machine).parameters}
    filled = [pair for owner in (*machine.joints, *machine.free_bodies) for pair in cells(owner)]
    alone = {p.name: tuple(cell for cell, formula in filled if str(formula) == p.name) for p in machine.parameters}
    driving = _of_drives_alone(machine)
    found = {
        p.name: Quantity(p.name, p.name, False, p.unit, alone[p.name], p.name in driving) for p in machine.parameters
    }
    for joint in machine.joints:
        for cell in (cell for cell, _ in cells(joint)):
            key = f"{joint.name}.{cell.name}"
            for name in (key, f"{joint.name}.{cell.par}") if key in named else ():
                found.setdefault(name, _of_cell(joint, cell, name, key))
    for name, number in numbers_of_drives(machine).items():
        found.setdefault(name, Quantity(name, name, False, number.unit, of_drive=True))
    for one in positions:
        found[POSITION + one.name] = Quantity(POSITION + one.name, one.key, True, one.unit)
        found.setdefault(one.name, one)
    for joint in machine.independent_joints:
        variable = str(joint.variable)
        found.setdefault(variable, Quantity(variable, joint.name, True, joint.unit))
    return found


def _of_drives_alone(machine: Machine) -> set[str]:
    """Return the parameters that stand in drives and their windings, and nowhere else."""
    drives = drives_of(machine).by_motor.values()
    driving = {name for one in drives for _, formula in one.formulas for name in formula.names}
    others = set[str]()
    for owner in (*machine.joints, machine.base, *machine.free_bodies):
        for cell, formula in cells(owner):
            (driving if cell.name in WINDING else others).update(formula.names)
    return driving - others


def _of_cell(joint: Joint, cell: Cell, name: str, key: str) -> Quantity:
    return Quantity(name, key, False, joint.unit_of(cell), (cell,))


def _fault(cell: Cell, x: float) -> str:
    if x < 0 and cell.column.dimension is Dimension.INERTIA and cell.name in ("XX", "YY", "ZZ"):
        return f"is negative: {x:g}"
    return cell.column.dimension.fault(x)


def _found(machine: Machine, name: str, known: dict[str, Quantity]) -> Quantity:
    if name in known:
        return known[name]
    if reason := why_no_number(machine, name):
        raise InputError(machine.label, OPTION, f"{quote(name)} cannot be swept: {reason}")
    joint, _, key = name.partition(".")
    own = next((x for x in machine.joints if x.name == joint), None)
    if own and key in {label for cell, _ in cells(own) for label in (cell.name, cell.par)}:
        raise InputError(machine.label, OPTION, f"{quote(name)} cannot be swept: {STRUCTURE} in its place")
    what = f"no parameter, number of the table or position {quote(name)}{did_you_mean(name, known)}"
    raise InputError(machine.label, OPTION, what)
