"""Reading and writing of machine files in the format of their suffix."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from symoro_elastic.formats.files import load_text, text_of
from symoro_elastic.formats.format import Conversion, Format
from symoro_elastic.formats.kinds_of_files import FileKind, read_as
from symoro_elastic.formats.par import reading as par
from symoro_elastic.formats.robots.converting import DISTAL, MJCF, URDF
from symoro_elastic.formats.robots.robot import EXPAND
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import write_text
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.format_names import in_words, suffixes
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import NONE, Reasons
from symoro_elastic.machine.resolve import Models
from symoro_elastic.machine.rounded_angles import DECIMALS, with_exact_angles
from symoro_elastic.machine.valid_names import with_valid_names

FORMATS: tuple[Format, ...] = (toml.FORMAT, par.FORMAT, URDF, MJCF, DISTAL)
"""Every format, as `FORMAT_NAMES` has them; a new one is a module, a line there and its line here."""
ADVICE = {".xacro": EXPAND}
"""What to do with files of other suffixes."""


def read_machine(
    path: str | Path, reserved: Reasons = NONE, models: Models | None = None
) -> tuple[DescribedMachine, list[str]]:
    """Read and check a machine file; return the machine and warnings, a line each; raises `InputError`."""
    machine = read(path, reserved)
    return machine, check(machine, reserved, models)


def read(path: str | Path, reserved: Reasons = NONE, conversion: Conversion | None = None) -> DescribedMachine:
    """Read a machine file without the consistency checks of `check`; raises `InputError`.

    Names of robots that generated code cannot take, or that are `reserved`, are changed. Robots as links and joints may
    be converted; other machines are refused then.
    """
    with read_as(FileKind.MACHINE, path):
        form = format_of(path, FORMATS)
        return _machine_in(load_text(path, form.encodings), form, path, reserved, conversion)


def read_content(content: bytes, path: str | Path, reserved: Reasons = NONE) -> DescribedMachine:
    """Return the machine of a file from its content, without access to the file; raises `InputError`."""
    form = format_of(path, FORMATS)
    return _machine_in(text_of(content, str(path), form.encodings), form, path, reserved)


def _machine_in(
    text: str, form: Format, path: str | Path, reserved: Reasons, conversion: Conversion | None = None
) -> DescribedMachine:
    if form.describe is None:
        if conversion and conversion.springs:
            what = f"--elastic is for robots as links and joints, not for {form.title} files"
            raise InputError(str(path), "file", what)
        return with_exact_angles(form.read(text, str(path)), (conversion and conversion.snap) or DECIMALS)
    if conversion is None:
        return with_valid_names(form.read(text, str(path)), reserved)
    from symoro_elastic.formats.robots.converting import machine_with_changes

    return with_valid_names(machine_with_changes(form.describe(text, str(path)), str(path), conversion), reserved)


def write_machine(machine: Machine, path: str | Path, like: str | Path | None = None) -> str:
    """Write the machine in the format of the suffix; raises `InputError`.

    If that and the file `like` are TOML, only what differs is written into the text of `like`. What is returned says
    why its comments are not kept, nothing where they are.
    """
    form = refuse_unwritable(path)
    assert form.write
    if form is not toml.FORMAT:
        machine.refuse_flexible(f"the format {form.title}")
    text, lost = form.write(machine), ""
    if form is toml.FORMAT and like is not None:
        from symoro_elastic.formats.toml.kept_text import in_text_of

        text, lost = in_text_of(like, text, lambda other: toml.write(toml.read(other, str(path))))
    write_text(text, path)
    return lost


def refuse_unwritable(path: str | Path, place: str = "file") -> Format:
    """Return the format of a file that machines can be written to; raises `InputError` for others."""
    form = format_of(path, FORMATS, place)
    if form.write is None:
        writable = in_words(suffixes(written=True))
        raise InputError(str(path), place, f"{form.title} files can be read, but not written: use {writable}")
    return form


def format_of(path: str | Path, formats: Iterable[Format], place: str = "file") -> Format:
    """The format with the suffix of a file; raises `InputError` for an unknown suffix."""
    suffix = Path(path).suffix.lower()
    for form in formats:
        if suffix in form.suffixes:
            return form
    accepted = in_words(suffixes([form.named for form in formats]))
    what = ADVICE.get(suffix) or f"the suffix {suffix!r} is not a machine format: use {accepted}"
    raise InputError(str(path), place, what)
