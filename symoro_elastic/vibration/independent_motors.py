"""Another choice of the independent joints of loops: one in which every motor is independent.

Small motions do not depend on the choice, but in this one motors are held and driven by coordinates of their own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from symoro_elastic.errors import InputError
from symoro_elastic.machine.loops import Loop
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.bind import Bound


def with_independent_motors(machine: Machine) -> Machine:
    """Return the machine with other joints of a loop dependent in place of motors, as it is where that cannot be."""
    for number, loop in enumerate(machine.loops):
        for motor in (j for j in machine.dependent_in(loop) if machine.joint(j).kind is Kind.MOTOR):
            machine = next(_changed(machine, number, motor), machine)
    return machine


def _changed(machine: Machine, number: int, motor: int) -> Iterator[Machine]:
    """Machines with another dependent joint, of this loop alone, in which the loop closes in closed form."""
    loop = machine.loops[number]
    beyond = {j for other in machine.loops if other is not loop for j in machine.owners_in(other)}
    for j in machine.owners_in(loop):
        if j in machine.moving and j not in beyond and machine.joint(j).kind is not Kind.MOTOR:
            changed = _with(machine, number, _exchanged(machine, loop, motor, j))
            try:
                if not Bound(changed).takes_dependent:
                    yield changed
            except InputError:
                continue


def _exchanged(machine: Machine, loop: Loop, motor: int, other: int) -> Loop:
    dependent = sorted({*machine.dependent_in(loop)} - {motor} | {other})
    return replace(loop, dependent=tuple(machine.joint(j).name for j in dependent))


def _with(machine: Machine, number: int, loop: Loop) -> Machine:
    return replace(machine, loops=(*machine.loops[:number], loop, *machine.loops[number + 1 :]))


def refuse_dependent_motors(machine: Machine) -> None:
    """Raise `InputError` for motors on joints that follow from loops."""
    following = [machine.joint(j).name for j in machine.motors if j not in machine.moving]
    if following:
        what = "not offered where a motor is on a dependent joint: choose others (dependent = [...])"
        raise machine.error(f"joint {', '.join(following)}", what)
