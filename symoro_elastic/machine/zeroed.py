"""Numbers of bodies and rotors, and parts of drives, that a scene sets to zero.

A number is named by its joint and its column, as in cart_y.mass, ram.XX, ram.center_of_mass.z, motor_y.rotor_inertia.
Without motor_y.rotor_coupling the rotor turns with its joint alone, not with its carrier too (`reduced_model`).
Parts of drives are lags, dead times and filters, motor_x.lag, motor_x.dead_time, motor_x.filter_1: what they let pass
follows at once. Whole numbers keep the structure of a machine: its inertia matrix is symmetric, and nothing is made
from nothing.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.columns import Cell, Dimension, cells, with_cells
from symoro_elastic.machine.described import AnyMachine, DescribedMachine, drives_of
from symoro_elastic.machine.drives import Drive, Drives
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Joint, Machine
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.machine.reduced import reduced_model, spins

BODIES = "bodies"
"""The table whose numbers may be left out, in addition to rotor inertias."""

COUPLING = "rotor_coupling"


def couplings_of(machine: Machine) -> dict[str, str]:
    """Names of joints whose rotors turn with their carrying bodies too, by coupling, as `motor_y.rotor_coupling`."""
    return {f"{name}.{COUPLING}": name for name in spins(machine)}


def numbers_of(machine: Machine) -> dict[str, Formula]:
    """The numbers of rigid bodies and rotors that are not zero, by name."""
    bending = {body.joint for body in machine.flexible}
    rigid = [joint for joint in machine.joints if joint.name not in bending]
    named = ((name_of(joint, cell), x) for joint in rigid for cell, x in cells(joint) if _is_inertia(cell))
    return {name: x for name, x in named if not x.is_zero}


def name_of(joint: Joint, cell: Cell) -> str:
    """The name of a cell's number: joint and quantity, such as `tool.XX`."""
    return f"{joint.name}.{cell.name}"


def with_zeros(machine: AnyMachine, names: Collection[str]) -> AnyMachine:
    """The machine in which these numbers are zero."""
    if not names:
        return machine
    if isinstance(machine, DescribedMachine):
        drives = {name: _without_parts(name, drive, names) for name, drive in machine.drives.by_motor.items()}
        machine = replace(machine, drives=Drives(drives))
    decoupled = {joint for name, joint in couplings_of(machine).items() if name in names}
    machine = reduced_model(machine, decoupled) if decoupled else machine
    joints = tuple(_without_numbers(joint, names) for joint in machine.joints)
    static = {j: _without_numbers(row, names) for j, row in machine.static.items()}
    return replace(machine, joints=joints, static=static)


def refuse_unknown(machine: Machine, names: Collection[str], source: str) -> None:
    """Raise `InputError` for a name that is not a number of a body, rotor or drive, or that is zero."""
    numbers = [*numbers_of(machine), *couplings_of(machine), *parts_of_drives(machine)]
    for name in names:
        if name not in numbers:
            what = f"no rigid body, rotor or drive has a number {quote(name)}{did_you_mean(name, numbers)}"
            raise InputError(source, "scene, zero", what)


def parts_of_drives(machine: Machine) -> tuple[str, ...]:
    """The parts of continuous drives that may be left out, by name; a sampled drive has none."""
    drives = drives_of(machine).by_motor
    return tuple(f"{name}.{part}" for name, drive in drives.items() if drive.period is None for part in _parts(drive))


def _parts(drive: Drive) -> Iterator[str]:
    if drive.dead_time is not None and not drive.dead_time.is_zero:
        yield "dead_time"
    if not drive.lag.is_zero:
        yield "lag"
    yield from (f"filter_{k}" for k in range(1, len(drive.filters) + 1))


def _without_parts(motor: str, drive: Drive, names: Collection[str]) -> Drive:
    left_out = {part for part in _parts(drive) if f"{motor}.{part}" in names and drive.period is None}
    filters = tuple(stage for k, stage in enumerate(drive.filters, start=1) if f"filter_{k}" not in left_out)
    without = replace(drive, filters=filters) if len(filters) < len(drive.filters) else drive
    without = replace(without, dead_time=None) if "dead_time" in left_out else without
    return replace(without, lag=ZERO) if "lag" in left_out else without


def _without_numbers(joint: Joint, names: Collection[str]) -> Joint:
    return with_cells(joint, lambda cell, x: ZERO if _is_inertia(cell) and name_of(joint, cell) in names else x)


def _is_inertia(cell: Cell) -> bool:
    return cell.column.section == BODIES or cell.column.dimension is Dimension.ROTOR_INERTIA
