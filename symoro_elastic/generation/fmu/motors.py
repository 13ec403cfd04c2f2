"""How the motors of an FMU are given: by their torques, by set points of their drives, or of sampled drives.

Drives are those of the model `closed_dynamics`: whatever it has states for, an FMU has. Between its samples a sampled
drive is nothing but its current loop, under a torque that is held.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, dataclass, fields, replace
from enum import Enum
from functools import partial

from symoro_elastic.machine.described import DescribedMachine, drives_of
from symoro_elastic.machine.drive_numbers import DriveNumber, with_changed
from symoro_elastic.machine.drives import ONE, TUNED, Drive, Drives
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.freed import unused_name
from symoro_elastic.machine.joints import Joint
from symoro_elastic.machine.machine import Machine, Parameter
from symoro_elastic.machine.names import IN_USE, Reasons
from symoro_elastic.models.drives.control import sampled_drives
from symoro_elastic.models.drives.drive_states import driven_motors

WAY_OUT = "leave it out, or give --by-torque"
KEYS = {"torque_limit": "limits, torque", "current": "current, kp"}
"""Keys of a file whose names are others than those of a `Drive`."""
OF_SAMPLES = ("period", "dead_time", "time")
"""Numbers that decide when a controller is called, and what it keeps: constants of an FMU."""
SAME = 1e-9
"""Of a period: a dead time that is this near to it is a period."""


class Given(Enum):
    """What is given of the motors."""

    TORQUES = "torques"
    SET_POINTS = "set points of drives"
    SAMPLES = "set points of sampled drives"


def given_of(machine: Machine) -> tuple[Given, tuple[str, ...]]:
    """Return what is given of the motors of a machine, and a note where drives are left out.

    Raises `InputError` for drives that no FMU has, by motor and key.
    """
    drives = drives_of(machine).by_motor
    if not drives:
        return Given.TORQUES, ()
    if sought := [name for name, one in drives.items() if TUNED in (one.Kv, one.Kp, one.Tn)]:
        what = f'torques of motors are inputs: gains of [drives] ({", ".join(sought)}) are "{TUNED}": control --save '
        return Given.TORQUES, (f"{what}writes them",)
    if any(one.period is not None for one in drives.values()):
        sampled_drives(machine)
        return Given.SAMPLES, ()
    if not driven_motors(machine):
        name, key = next(_without_states(machine), (next(iter(drives)), ""))
        place = ", ".join(filter(None, ("drives", name, key)))
        raise machine.error(place, f"no generated model has its states, so no FMU has: {WAY_OUT}")
    return Given.SET_POINTS, ()


def _without_states(machine: Machine) -> Iterator[tuple[str, str]]:
    """Yield motors and keys of drives that alone keep a machine from a model with drives."""
    described = DescribedMachine.of(machine)
    for name, one in drives_of(machine).by_motor.items():
        for field in fields(Drive):
            value = getattr(one, field.name)
            if field.default is MISSING or value == field.default:
                continue
            alone = Drive(ONE, ONE, **{field.name: value})
            if not driven_motors(replace(described, drives=Drives({name: alone}))):
                yield name, KEYS.get(field.name, field.name)


@dataclass(frozen=True)
class Sampling:
    """When sampled drives act: the period, s, times after a sample at which torques change, s, the first 0.

    `applied` tells for each motor at which of these times its torque comes, their number for that of the next sample.
    """

    period: float
    offsets: tuple[float, ...]
    applied: tuple[int, ...]


def sampling_of(machine: Machine) -> Sampling:
    """Return when the sampled drives of a machine act; raises `InputError` for dead times longer than the period."""
    drives = sampled_drives(machine)
    values = {p.name: p.value.value() for p in machine.parameters if p.value is not None}
    period = min(float(one.period.value(values)) for one in drives.values() if one.period)
    late = []
    for j, one in drives.items():
        dead = period if one.dead_time is None else float(one.dead_time.value(values))
        if dead > period * (1 + SAME):
            what = f"{dead:g} s is longer than the period, {period:g} s: give at most one period"
            raise machine.error(f"drives, {machine.joint(j).name}, dead_time", what)
        late.append(period if dead > period * (1 - SAME) else dead)
    offsets = (0.0, *sorted({x for x in late if 0 < x < period}))
    return Sampling(period, offsets, tuple((*offsets, period).index(x) for x in late))


def with_free_drives(machine: Machine, taken: Reasons) -> tuple[Machine, dict[str, DriveNumber]]:
    """Return the machine with the numbers of its drives as parameters, and these by the names of the parameters.

    Zeros stay: they are structure; so do the times of samples, as numbers. `taken` are names that are none of
    parameters.
    """
    drives, loads, found = drives_of(machine).by_motor, drives_of(machine).loads, dict[str, DriveNumber]()
    if not drives:
        return machine, {}
    joints = {joint.name: joint for joint in machine.joints}
    values = {p.name: p.value.value() for p in machine.parameters if p.value is not None}
    own = (machine.name, *joints, *(p.name for p in machine.parameters), *(x.variable or "" for x in machine.joints))
    used, named = {**taken, **dict.fromkeys(own, IN_USE)}, list[Parameter]()

    def free(joint: Joint, place: str, x: Formula) -> Formula:
        if place.rpartition(".")[2] in OF_SAMPLES and drives[joint.name].period is not None:
            return Formula.parse(float(x.value(values)))
        if x.names or x.is_zero:
            return x
        number = DriveNumber(joint, place)
        name = unused_name(f"{place.replace('.', '_')}{machine.joints.index(joint) + 1}", used)
        used[name], found[name] = IN_USE, number
        named.append(Parameter(name, x, number.unit))
        return Formula.parse(name)

    made = {name: with_changed(one, partial(free, joints[name])) for name, one in drives.items()}
    freed = replace(machine, drives=Drives(made, loads), parameters=(*machine.parameters, *named))  # type: ignore[call-arg]
    return freed, found
