"""Positions of loads that the drives of an FMU control in place of their motors', about where the FMU starts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.described import DescribedMachine, drives_of
from symoro_elastic.machine.drives import MOTOR, LoadPosition
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.drives.drive_states import position_of_load
from symoro_elastic.numerics.arrays import values_along
from symoro_elastic.numerics.motion.signals import FrameSignal, positions
from symoro_elastic.symbolic.differentiation import Differentiation
from symoro_elastic.symbolic.expression import operand

STILL = 1e-9
"""What a load moves with its motor, by what it does with any joint, where it does not."""


def measures_loads(machine: Machine) -> bool:
    """Return whether drives of a machine measure other positions than those of their motors."""
    return any(one.measured != MOTOR for one in drives_of(machine).by_motor.values())


def with_loads(machine: Machine, kept: Machine, q: Mapping[int, float]) -> Machine:
    """Return a machine with the positions that its drives measure at loads, about q, by joint, of the restricted one.

    Raises `InputError` for signals that are no such positions.
    """
    numbers = {kept.joint(j).name: j for j in kept.motors}
    measured = {name: one.measured for name, one in drives_of(kept).by_motor.items() if one.measured != MOTOR}
    found = {name: _load(kept, numbers[name], signal, q) for name, signal in measured.items()}
    return replace(DescribedMachine.of(machine), drives=replace(drives_of(machine), loads=found))


def _load(machine: Machine, j: int, measured: str, q: Mapping[int, float]) -> LoadPosition:
    place = f"drives, {machine.joint(j).name}, measured"
    (signal,) = positions(machine, [measured], place)
    if machine.is_coupled:
        raise machine.error(place, "positions of the load are not simulated where joints are coupled")
    if isinstance(signal, FrameSignal) and (signal.component > 2 or machine.static):
        of = "frames on static springs" if machine.static else "rotations of frames"
        raise machine.error(place, f"an FMU does not measure {of}: name a joint or a point, or give --by-torque")
    axis, at = (signal.component, signal.at) if isinstance(signal, FrameSignal) else (None, None)
    load = LoadPosition(signal.number, axis, at, 0.0, 1.0, q[j])
    start, *slopes = _values(machine, load, q)
    ratio = slopes[machine.independent.index(j)]
    if abs(ratio) <= STILL * max(map(abs, slopes)):
        what = f"{measured} does not move with {machine.joint(j).name} here: name a position behind it"
        raise machine.error(place, what)
    return replace(load, start=start, ratio=ratio)


def _values(machine: Machine, load: LoadPosition, q: Mapping[int, float]) -> list[float]:
    """Return the position of a load, and its derivatives by the variables of the joints."""
    bound = Bound(machine)
    position = position_of_load(bound, load)
    by = Differentiation([position])
    roots = [position, *(by.by(bound.q[j]).of(position) for j in machine.independent)]
    symbols: dict[str, float] = {p.name: p.value.value() for p in machine.parameters if p.value is not None}
    symbols |= {str(bound.q[j].operands[0]): q[j] for j in machine.independent}
    found: Array = values_along(list(map(operand, roots)), symbols, 1)[:, 0]
    return [float(x) for x in found]
