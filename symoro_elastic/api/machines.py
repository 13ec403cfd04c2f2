"""Machines: read, write, new."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from pathlib import Path
from typing import Any, TypeAlias

from symoro_elastic import pipeline
from symoro_elastic.errors import InputError, among
from symoro_elastic.machine.formats import write_machine
from symoro_elastic.machine.formats.format import Conversion
from symoro_elastic.machine.formats.starting import STARTS, starting_text
from symoro_elastic.machine.formats.tables import table_of
from symoro_elastic.machine.formats.toml import machine_of
from symoro_elastic.machine.freed import SECTIONS
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.output_files import permission, write_text

MachineLike: TypeAlias = Machine | str | Path | Mapping[str, Any]
"""A machine, its file, or the tables of such a file as dictionaries and lists."""
Values: TypeAlias = Mapping[str, float]
"""Numbers by the name of a joint or a parameter."""
NO_VALUES: Values = {}


class MachineWarning(UserWarning):
    """Something in a machine that is allowed, and rarely meant."""


def warn(line: str) -> None:
    """Issue a `MachineWarning` that points to the line of the user's program."""
    frame, level = inspect.currentframe(), 1
    while frame and str(frame.f_globals.get("__name__", "")).partition(".")[0] == "symoro_elastic":
        frame, level = frame.f_back, level + 1
    warnings.warn(line, MachineWarning, stacklevel=level)


def read(
    machine: str | Path | Mapping[str, Any] | Any,
    *,
    base: bool = False,
    free: Sequence[str] = (),
    snap: float | None = None,
    elastic: Mapping[str, float | Sequence[float]] | None = None,
    warn: Callable[[str], None] = warn,
) -> Machine:
    """Return the machine in a file, checked, with its inertial parameters grouped if `base`.

    Parameters
    ----------
    machine
        A .toml, .par, .urdf or .xml (MJCF) file, or the tables of a .toml file as dictionaries and lists (`name` must
        be among them), or a robot of the Robotics Toolbox: an object with `links`.
    base
        Group the inertial parameters: fewer operations, the same motion.
    free
        Tables whose numbers stay parameters of generated code: "bodies", "springs", "motors", "friction", "wrenches".
    snap
        Tolerance, rad and m, within which angles of a robot in URDF become multiples of pi/12 and lengths 0.
    elastic
        Springs behind the motors of joints of a robot in URDF, by joint: stiffness, N m/rad or N/m, and inertia of the
        rotor as the joint feels it, kg m2 or kg.
    warn
        Called with each line about what is allowed, and rarely meant; by default a `MachineWarning`.

    Raises
    ------
    InputError
        For a file that is no machine: names the file, the joint, the key and the way out.
    """
    among(free, SECTIONS, "--free")
    if isinstance(machine, Mapping):
        return pipeline.prepared(machine_of(table_of(machine, "machine")), warn, base=base, free=free)
    if hasattr(machine, "links"):
        return pipeline.prepared(pipeline.read_robot(machine), warn, base=base, free=free)
    if not isinstance(machine, str | Path):
        what = f"{type(machine).__name__} is no machine: give a file, its tables as dictionaries, or a robot with links"
        raise InputError("symoro-elastic", "machine", what)
    _refuse_springs(elastic)
    conversion = Conversion.of(snap, elastic or {})
    return pipeline.prepare(machine, warn, base=base, free=free, conversion=conversion)


def _refuse_springs(elastic: Any) -> None:
    """Raise `InputError` for springs that are no numbers by joint."""
    if elastic is None:
        return
    if not isinstance(elastic, Mapping):
        raise InputError("symoro-elastic", "--elastic", f'{elastic!r} gives no stiffness: write {{"elbow": 1e4}}')
    for name, given in elastic.items():
        numbers = [given] if isinstance(given, Real) else given
        if isinstance(numbers, str) or not all(isinstance(x, Real) for x in numbers):
            what = f"{name}: {given!r} is no stiffness, nor a stiffness and an inertia of the rotor"
            raise InputError("symoro-elastic", "--elastic", what)


def the_machine(machine: MachineLike, values: Values = NO_VALUES) -> Machine:
    """Return a machine that is given in any form, with these values of parameters."""
    found = machine if isinstance(machine, Machine) else read(machine)
    return with_values(found, dict(values)) if values else found


def write(machine: MachineLike, path: str | Path, *, force: bool = False) -> Path:
    """Write a machine in the format of the suffix, and return the path; an existing file is replaced if `force`."""
    with permission(force=force):
        write_machine(the_machine(machine), path)
    return Path(path)


def new(path: str | Path, kind: str = "arm", *, force: bool = False) -> Machine:
    """Write a commented .toml file to start a machine from, and return the machine in it.

    `kind` is "arm", "cartesian", "elastic" (a drive with a spring), "floating" (a flying base) or "linkage" (a gear
    and a closed loop). The machine has the name of the file.
    """
    among((kind,), [*STARTS], "--kind")
    file = Path(path).with_suffix(".toml")
    pipeline.refuse_name(file.stem, "NAME")
    with permission(force=force):
        write_text(starting_text(file.stem, kind), file)
    return read(file)
