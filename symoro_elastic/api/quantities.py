"""Numbers with units as options: `--at elbow="30 deg"`, converted to the unit of an option, a joint or a parameter."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from symoro_elastic.foundation.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine

UnitOf = Callable[["Machine", str], "str | tuple[str, str] | None"]
"""Unit of a value by its name, units of its two numbers, or None for names without one; "" names all motors."""
COMMAND = "symoro-elastic"
_PART = re.compile(r"[^:,]+")
"""One of the numbers of a text such as `8 N/um:9 N/um:5`."""


def has_unit(x: Any) -> bool:
    """Whether a value is a text with a unit, or holds one."""
    if isinstance(x, str):
        from symoro_elastic.quantities.unit_reader import in_two

        return any(in_two(part) for part in _PART.findall(x))
    if isinstance(x, Mapping):
        return any(map(has_unit, x.values()))
    return isinstance(x, list | tuple) and any(map(has_unit, x))


def convert(x: Any, unit: str | None, place: str) -> Any:
    """Return a value whose texts with units are numbers in SI units; raises `InputError` with the place."""
    if not has_unit(x):
        return x
    from symoro_elastic.machine.formula import number
    from symoro_elastic.quantities.unit_reader import UnitError, in_si

    if unit is None:
        raise InputError(COMMAND, place, f"{x!r}: give the number alone, in SI units")
    if isinstance(x, list | tuple):
        return type(x)(convert(part, unit, place) for part in x)
    if isinstance(x, Mapping):
        return {name: convert(part, unit, f"{place}, {name}") for name, part in x.items()}
    try:
        text = _PART.sub(lambda part: in_si(part[0], unit), x)
    except UnitError as error:
        raise InputError(COMMAND, place, str(error)) from None
    return text if re.search("[:,]", text) else number(text)


def converted_by_name(x: Any, unit_of: UnitOf, machine: Machine, place: str) -> Any:
    """Return a value, or values by name, in the SI units that the machine gives to the names; raises `InputError`."""
    if isinstance(x, Mapping):
        return {name: _one(part, unit_of(machine, name), f"{place}, {name}") for name, part in x.items()}
    return _one(x, unit_of(machine, ""), place)


def _one(x: Any, unit: str | tuple[str, str] | None, place: str) -> Any:
    if isinstance(unit, tuple):
        return tuple(convert(part, part_unit, place) for part, part_unit in zip(x, unit, strict=False))
    return convert(x, unit, place)


# Units of values by name


def of_joints(quantity: str) -> Callable[[Machine, str], str | None]:
    """Return the unit of a position, velocity, acceleration or torque by the name of a joint."""

    def unit(machine: Machine, name: str) -> str | None:
        from symoro_elastic.machine.limits import unit_of
        from symoro_elastic.machine.resolve import joints_by_any_name

        joints = {joint.name: joint for joint in machine.joints}
        named = [joints.get(joints_by_any_name(machine).get(name, name))] if name else [*machine.motor_joints]
        units = {unit_of(quantity, joint) if joint else None for joint in named}
        return units.pop() if len(units) == 1 else None

    return unit


def of_states(machine: Machine, name: str) -> str | None:
    """Return the unit of a position, of a velocity (`joint.qd`), acceleration (`.qdd`) or torque (`.tau`)."""
    joint, _, order = name.rpartition(".")
    quantities = {"q": "position", "qd": "velocity", "qdd": "acceleration", "tau": "torque"}
    if joint and order in quantities:
        return of_joints(quantities[order])(machine, joint)
    return of_joints("position")(machine, name)


def of_gains(machine: Machine, name: str) -> tuple[str, str] | None:
    """Return the units of both gains of a position controller."""
    gains = {"rad": ("N m/rad", "N m s/rad"), "m": ("N/m", "N s/m")}
    return gains.get(of_joints("position")(machine, name) or "")


def of_parameters(machine: Machine, name: str) -> str | None:
    """Return the unit of a parameter, of a number of the table (`ram.stiffness`) or of a position (`q.motor_x`)."""
    from symoro_elastic.analysis.sweeps.quantities import quantities

    try:
        return quantities(machine, [name])[0].unit or None
    except InputError:
        return None


def of_signals(machine: Machine, name: str) -> str | None:
    """Return the unit of a signal: of an output, or of the force or moment on a frame."""
    from symoro_elastic.numerics.motion.signals import input_unit, output_unit

    for unit in (output_unit, input_unit):
        try:
            return unit(machine, name)
        except InputError:
            continue
    return None
