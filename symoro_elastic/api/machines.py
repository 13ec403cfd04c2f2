"""Machines: read, write, new."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from pathlib import Path
from typing import Any

from symoro_elastic.api.declaration import argument, operation, outside
from symoro_elastic.api.options import Reading
from symoro_elastic.api.rows import READABLE, MachineLike, Values
from symoro_elastic.formats import write_machine
from symoro_elastic.formats.files import load_text
from symoro_elastic.formats.format import Conversion
from symoro_elastic.formats.toml.starting import STARTS, start_of_axes, starting_text
from symoro_elastic.foundation.errors import InputError, among, printable
from symoro_elastic.foundation.input_files import examples
from symoro_elastic.foundation.output_files import permission, write_text
from symoro_elastic.foundation.progress import Announce, announce_nothing
from symoro_elastic.generation import pipeline
from symoro_elastic.machine.constants import SECTIONS
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.left_out_parts import PARTS, without
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.named_cells import with_values

NO_VALUES: Values = {}


class MachineWarning(UserWarning):
    """A warning about a machine that is valid but probably not intended."""


def warn(line: str) -> None:
    """Issue a `MachineWarning` that points to the line of the user's program."""
    warnings.warn(printable(line), MachineWarning, stacklevel=outside())


class ReadingWithWarnings(Reading):
    """Options of `read`."""

    warn: Callable[[str], None] = argument(
        warn, "Called with each warning about what is allowed but rarely intended; by default a `MachineWarning`."
    )


@operation(
    ReadingWithWarnings,
    f"A file ({', '.join(READABLE)}), or the tables of a .toml file as dictionaries and lists (`name` must be "
    "among them), or a robot of the Robotics Toolbox: an object with `links` of Denavit-Hartenberg parameters, or with "
    "a `urdf_string`; its `base`, `tool` and `gravity` are taken.",
)
def read(machine: str | Path | Mapping[str, Any] | Any, options: ReadingWithWarnings) -> DescribedMachine:
    """Return the machine in a file, checked, with its inertial parameters grouped if `base`.

    Raises
    ------
    InputError
        If the file is not a valid machine; the message names the file, the joint, the key and the remedy.
    """
    _refuse_springs(options.elastic)
    return prepared(machine, options, options.warn)


def prepared(
    machine: Any, options: Reading, warn: Callable[[str], None], announce: Announce = announce_nothing
) -> DescribedMachine:
    """Return a machine, read and checked, with the changes of options; `warn` is called with each warning."""
    free = among(options.free, SECTIONS, "--free")
    conversion = Conversion.of(options.snap, options.elastic or {})
    return pipeline.prepare(machine, warn, base=options.base, free=free, conversion=conversion, announce=announce)


def _refuse_springs(elastic: Any) -> None:
    """Raise `InputError` for springs that are not numbers by joint."""
    if elastic is None:
        return
    if not isinstance(elastic, Mapping):
        raise InputError("symoro-elastic", "--elastic", f'{elastic!r} gives no stiffness: write {{"elbow": 1e4}}')
    for name, spring in elastic.items():
        numbers = [spring] if isinstance(spring, Real) else spring
        if isinstance(numbers, str) or not all(isinstance(x, Real) for x in numbers):
            what = f"{name}: {spring!r} is neither a stiffness nor a stiffness and an inertia of the rotor"
            raise InputError("symoro-elastic", "--elastic", what)


def the_machine(machine: MachineLike, values: Values = NO_VALUES) -> DescribedMachine:
    """Return a machine passed in any form, with these values of parameters."""
    described = DescribedMachine.of(machine) if isinstance(machine, Machine) else read(machine)
    return with_values(described, dict(values)) if values else described


def write(
    machine: MachineLike, path: str | Path, *, drop: Sequence[str] = (), like: str | Path | None = None,
    force: bool = False,
) -> Path:  # fmt: skip
    """Write a machine in the format of the suffix, and return the path; an existing file is replaced if `force`.

    With `like`, a .toml file that the machine was made from, comments and order of that file are kept: what differs is
    written into its text. A `MachineWarning` says where that is not possible.

    `drop` are parts that are left out, for URDF and MJCF: "rotors", "springs" (elastic joints are fixed where these are
    neutral), "loops" (their joints without motors are driven), "wrenches", "backlash", "creep", "sharing"; a
    `MachineWarning` names the joints, and notes of the file do.
    """
    reduced, remarks = without(the_machine(machine), among(drop, PARTS, "--drop"))
    with permission(force=force):
        lost = write_machine(reduced.with_notes(*reduced.origin.remarks, *remarks), path, like)
    for remark in (*remarks, *filter(None, [lost])):
        warn(remark)
    return Path(path)


def new(
    path: str | Path,
    kind: str = "arm",
    *,
    full: bool = False,
    example: str = "",
    axes: str = "",
    screws: str = "",
    force: bool = False,
) -> DescribedMachine:
    """Write a .toml file to start a machine from, and return the machine in it.

    `kind` is "arm", "cartesian", "delta" (three limbs, closed loops), "elastic" (a drive with a spring), "floating" (a
    flying base), "gantry", "linkage" (a gear and a closed loop), "lathe", "mill" (slides on ball screws) or "scara";
    `axes`, as "X Y Z", are slides instead, from the frame to the tool, and `screws`, as "20mm", the pitch of elastic
    ball screws that drive them. Most have limits, and drives whose gains `tune` finds. The machine has the name of the
    file. `full` adds all other tables and keys as comments.
    `example` is the name of a machine that comes with the package, of which a copy is written: "two_axis", ...
    """
    file = Path(path).with_suffix(".toml")
    with permission(force=force):
        if example:
            machines = examples(scenes=False)
            source = machines[among((example,), machines, "--example")[0]]
            file = file.with_suffix(source.suffix)
            write_text(load_text(source), file)
        else:
            write_start(file, kind, full, axes or None, screws)
    return read(file)


def write_start(file: Path, kind: str, full: bool, axes: str | None, screws: str) -> None:
    """Write a file to start a machine of a kind, or of slides along axes, from; raises `InputError`."""
    among((kind,), [*STARTS], "--kind")
    pipeline.refuse_name(file.stem, "NAME")
    start = kind if axes is None else start_of_axes(axes, screws)
    write_text(starting_text(file.stem, start, full), file)
