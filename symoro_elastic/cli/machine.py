"""Commands about machines and models: show, convert, models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import click

from symoro_elastic.api import kinds
from symoro_elastic.api.declaration import Options, in_si_units, option
from symoro_elastic.api.options import Drawing, Reading
from symoro_elastic.api.rows import WRITABLE, left_out_names
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import JSON, MACHINE, OutputFile, OutputMachine, takes, writes
from symoro_elastic.cli.output import echo, line_width, print_json, print_parts, say
from symoro_elastic.cli.reading import note, read, scene_of
from symoro_elastic.foundation.errors import among
from symoro_elastic.foundation.file_forms import PICTURES

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine


@command("show")
@MACHINE
@takes(Drawing)
@click.option(
    "--picture",
    metavar="FILE",
    type=OutputFile(PICTURES),
    help="Draw the machine at that position: .svg, .png or .pdf.",
)
@writes
@JSON
def show(machine: str, options: Drawing, picture: str | None, as_json: bool) -> None:
    """Print where each joint is and how it moves, seen from frame 0; how each loop closes, and where it is singular.

    Names the joints, if any, whose inertia is singular at every position.
    """
    from symoro_elastic.machine.named_cells import with_values
    from symoro_elastic.machine.restrict import restrict
    from symoro_elastic.pages.show import description

    full_machine = read(machine)
    options = in_si_units(full_machine, options)
    if options.values:
        full_machine = with_values(full_machine, dict(options.values))
    scene = scene_of(full_machine, options.scene)
    if picture:
        _draw(restrict(full_machine, scene), options.at, picture, as_json)
    described = description(full_machine, scene, options.at)
    for warning in described.chain.warnings:
        say(f"warning: {warning}")
    if as_json:
        print_json(described.as_json())
    else:
        print_parts(described.parts(line_width()))


def _draw(machine: Machine, positions: Mapping[str, float], path: str, as_json: bool) -> None:
    """Write the picture of a machine at a position, and name it; on stderr with JSON."""
    from symoro_elastic.pages.drawing.picture_files import write_picture
    from symoro_elastic.pages.drawing.svg import machine_picture

    picture = machine_picture(machine, positions)
    for remark in picture.figure.remarks:
        note(remark)
    write_picture(picture, path, "--picture")
    echo(f"wrote {path}", err=as_json)


class Dropping(Options):
    """What is left out of the machine that is written."""

    drop: Sequence[str] = option(
        (), "PARTS", "Leave out parts that URDF or MJCF has not: {names}; without springs elastic joints are fixed "
        "where these are neutral, without loops joints without motors are driven.", kinds.WORDS, names=left_out_names,
    )  # fmt: skip


CONVERT = f"""FILE ends in {" or ".join(WRITABLE)}.

Robots in URDF get a table of geometric parameters. It is exact but for rounding; --snap makes it simpler, and prints
how far frames move.
"""


@command("convert", CONVERT)
@MACHINE
@click.argument("file", metavar="FILE", type=OutputMachine())
@takes(Reading, "reading", "base", "snap", "elastic")
@takes(Dropping, "dropping")
@writes
def convert(machine: str, file: str, reading: Reading, dropping: Dropping) -> None:
    """Convert a machine file to another format."""
    from symoro_elastic.formats import write_machine
    from symoro_elastic.machine.left_out_parts import PARTS, without

    dropped = among(dropping.drop, PARTS, "--drop")
    reduced, remarks = without(read(machine, reading), dropped)
    write_machine(reduced.with_notes(*reduced.origin.remarks, *remarks), file)
    for remark in remarks:
        note(remark)
    echo(f"wrote {file}")


@command("models")
@JSON
def models(as_json: bool) -> None:
    """Print them with the numbers of their equations."""
    from symoro_elastic.pages.models_page import NOTES, catalogue_json, catalogue_lines

    if as_json:
        print_json(catalogue_json())
    else:
        echo("\n".join(["", *catalogue_lines(line_width()), "", *NOTES]))
