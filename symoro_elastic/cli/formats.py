"""Commands about file formats: new, formats, schema."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from symoro_elastic.api.rows import schema_names, start_names
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import Command, OutputFile, completed_from, writes
from symoro_elastic.cli.output import echo, write_text
from symoro_elastic.foundation.errors import InputError, among
from symoro_elastic.foundation.file_forms import MARKDOWN, SCHEMAS
from symoro_elastic.foundation.input_files import SCENES as SCENES_FOLDER
from symoro_elastic.foundation.input_files import SUFFIXES, examples


def _out(*forms: str) -> Callable[[Command], Command]:
    what = f"File to write: {', '.join(forms)} (default: standard output)."
    return click.option("--out", metavar="FILE", type=OutputFile(forms), help=what)


class NewFile(OutputFile):
    """A file to write: `mine` means mine.toml, or for mine with the suffix of the example."""

    def __init__(self) -> None:
        super().__init__(SUFFIXES)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the path with its suffix."""
        path, example = str(super().convert(value, param, ctx)), ctx.params.get("example") if ctx else None
        suffix = example.suffix if example else SUFFIXES[0]
        return path if path.endswith(suffix) else f"{path}{suffix}"


def _example(_context: click.Context, option: click.Parameter, name: str | None) -> Path | None:
    """The file of an example."""
    if name is None:
        return None
    names = examples()
    return names[among((name,), names, option.opts[0])[0]]


@command("new")
@click.argument("name", metavar="[NAME]", type=NewFile(), required=False)
@click.option(
    "--example",
    metavar="NAME",
    is_eager=True,
    callback=_example,
    shell_complete=completed_from(examples),
    help="Copy an example that comes with the package, a machine or a scene: two_axis, planar_2r_move ... The shell "
    "completes their names.",
)
@click.option("--full/--brief", help="With all other tables and keys as comments.")
@click.option(
    "--kind",
    metavar="NAME",
    shell_complete=completed_from(start_names),
    help="Machine to start from: arm (default), cartesian, delta (three limbs, closed loops), elastic (a drive with a "
    "spring), floating (a flying base), gantry, linkage (a gear and a closed loop), lathe, mill (slides on ball "
    "screws), scara.",
)
@click.option("--axes", metavar="LIST", help='Axes instead of a kind, from the frame to the tool: "X Y Z B C".')
@click.option("--screws", metavar="PITCH", help="An elastic ball screw behind each motor of --axes, as 20mm.")
@writes
def new(
    name: str | None, kind: str | None, full: bool, example: Path | None, axes: str | None, screws: str | None
) -> None:
    """Write a machine file to start from, or with --example a copy of an example."""
    from symoro_elastic.api.machines import write_start
    from symoro_elastic.formats.files import load_text

    if screws is not None and axes is None:
        raise InputError("symoro-elastic", "--screws", "says how the slides of --axes are driven: give --axes, too")
    if kind is not None and axes is not None:
        raise InputError("symoro-elastic", "--kind", "--axes makes a machine of its own: remove one of the two")
    if example:
        for option, value in (("--kind", kind), ("--full", full), ("--axes", axes is not None)):
            if value:
                raise InputError("symoro-elastic", option, "an example is copied as it is: leave it out, or --example")
        path = Path(name or example.name)
        write_text(load_text(example), str(path))
        is_scene = example.parent.name == SCENES_FOLDER
        echo(f"wrote {path}: symoro-elastic {f'simulate MACHINE --scene {path}' if is_scene else f'show {path}'}")
        return
    if name is None:
        raise InputError("symoro-elastic", "NAME", "name the file, or an example with --example")
    path = Path(name)
    write_start(path, kind or "arm", full, axes, screws or "")
    echo(f"wrote {path}: symoro-elastic generate {path}")


@command("formats")
@_out(*MARKDOWN)
@writes
def formats(out: str | None) -> None:
    """Print every table and key of machine files, scenes and lists of vibration tests, every column of motions and
    measurements, as Markdown.
    """
    from symoro_elastic.pages.formats import formats_page

    _print_or_write(formats_page(), out)


@command("schema")
@click.argument("file", metavar="[machine|scene|tests]", default="machine", shell_complete=completed_from(schema_names))
@_out(*SCHEMAS)
@writes
def schema(file: str, out: str | None) -> None:
    """Print what editors complete and check TOML files by (draft 2020-12)."""
    from symoro_elastic.pages.formats import schema as schema_of

    _print_or_write(schema_of(file), out)


def _print_or_write(text: str, out: str | None) -> None:
    if out is None:
        echo(text, nl=False)
        return
    write_text(text, out)
    echo(f"wrote {out}", err=True)
