"""Commands about machines and models: show, convert, models."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from symoro_elastic.api import kinds
from symoro_elastic.api.declaration import Options, in_si_units, option
from symoro_elastic.api.options import Drawing, Reading
from symoro_elastic.api.rows import WRITABLE
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import JSON, MACHINE, OutputFile, OutputMachine, takes, writes
from symoro_elastic.cli.output import echo, line_width, print_json, print_table, say
from symoro_elastic.cli.reading import note, read, scene_of
from symoro_elastic.foundation.errors import among
from symoro_elastic.foundation.file_forms import PICTURES

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.models.bound.joint_axes import PlacedMachine
    from symoro_elastic.numerics.linear.grouping import BaseParameters
    from symoro_elastic.pages.closed_chains import ClosedChain


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
    from symoro_elastic.generation.pipeline import zero_pivots
    from symoro_elastic.machine.named_cells import with_values
    from symoro_elastic.machine.restrict import restrict
    from symoro_elastic.models.bound.joint_axes import placed_machine
    from symoro_elastic.numerics.linear.grouping import base_parameters
    from symoro_elastic.pages.closed_chains import closed_chain

    full_machine = read(machine)
    options = in_si_units(full_machine, options)
    if options.values:
        full_machine = with_values(full_machine, dict(options.values))
    scene = scene_of(full_machine, options.scene)
    scene_machine = restrict(full_machine, scene)
    if picture:
        _draw(scene_machine, options.at, picture, as_json)
    placement = placed_machine(scene_machine, options.at)
    chain = closed_chain(scene_machine, placement)
    for warning in chain.warnings:
        say(f"warning: {warning}")
    degenerate = [f"{joints}: {message}" for message, joints in zero_pivots(full_machine, scene)]
    base = base_parameters(scene_machine)
    if as_json:
        print_json(_as_json(chain, placement, base, degenerate))
    else:
        _print(chain, placement, base, degenerate)


def _draw(machine: Machine, positions: Mapping[str, float], path: str, as_json: bool) -> None:
    """Write the picture of a machine at a position, and name it; on stderr with JSON."""
    from symoro_elastic.pages.drawing.picture_files import write_picture
    from symoro_elastic.pages.drawing.svg import machine_picture

    picture = machine_picture(machine, positions)
    for remark in picture.figure.remarks:
        note(remark)
    write_picture(picture, path, "--picture")
    echo(f"wrote {path}", err=as_json)


def _as_json(
    chain: ClosedChain, placement: PlacedMachine, base: BaseParameters, degenerate: Sequence[str]
) -> dict[str, Any]:
    from symoro_elastic.machine.machine import Kind
    from symoro_elastic.machine.views import beams_json, catalogue_json, drives_json, frames_json, limits_json
    from symoro_elastic.pages.closed_chains import closed_chain_json
    from symoro_elastic.pages.show import axes_json, position_json

    machine = chain.machine
    by_kind = {kind: [joint.name for joint in machine.joints if joint.kind is kind] for kind in Kind}
    return {
        "name": machine.name,
        "joints": [joint.name for joint in machine.independent_joints],
        "motors": by_kind[Kind.MOTOR],
        "elastic": by_kind[Kind.ELASTIC],
        **closed_chain_json(chain),
        "position": position_json(placement),
        "axes": axes_json(placement),
        "gravity": [str(x) for x in machine.base.gravity],
        "frames": frames_json(machine),
        "parameters": [p.name for p in machine.parameters],
        "beams": beams_json(machine),
        "catalogue_springs": catalogue_json(machine),
        "limits": limits_json(machine),
        "drives": drives_json(machine),
        "base_parameters": base.formulas,
        "base_parameters_parts": base.parts,
        "base_parameters_zero": base.zero,
        "base_parameters_check": base.check,
        "base_parameters_condition": base.condition,
        "degenerate": degenerate,
    }


def _print(chain: ClosedChain, placement: PlacedMachine, base: BaseParameters, degenerate: Sequence[str]) -> None:
    from symoro_elastic.machine.views import machine_table, other_tables, parameter_lines
    from symoro_elastic.pages.closed_chains import closed_chain_lines
    from symoro_elastic.pages.show import axes_table

    machine = chain.machine
    print_table(machine_table(machine, machine.name))
    print_table(axes_table(placement, "origins and axes in frame 0"))
    for table in other_tables(machine):
        print_table(table)
    echo(machine.gravity_in_words)
    for line in parameter_lines(machine):
        echo(textwrap.fill(line, line_width(), subsequent_indent="  "))
    if machine.floating:
        orientation, quantity = machine.floating.orientation, machine.floating.known
        echo(f"floating base: {orientation} and {quantity} given, M = {machine.floating.body.mass}")
    for line in closed_chain_lines(chain):
        echo(line)
    echo(f"\nbase inertial parameters: {base.check}")
    for name, formula in {**base.parts, **base.formulas}.items():
        echo(f"  {name} = {formula}")
    if base.zero:
        echo(f"  zero for these bodies: {', '.join(base.zero)}")
    echo(base.conditioning)
    echo("\n".join(f"degenerate: {message}" for message in degenerate) or "no degenerate joints")


def _parts() -> Iterable[str]:
    from symoro_elastic.machine.left_out_parts import PARTS

    return PARTS


class Dropping(Options):
    """What is left out of the machine that is written."""

    drop: Sequence[str] = option(
        (), "PARTS", "Leave out parts that URDF or MJCF has not: {names}; without springs elastic joints are fixed "
        "where these are neutral, without loops joints without motors are driven.", kinds.WORDS, names=_parts,
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
    from symoro_elastic.pages.show import NOTES, catalogue_json, catalogue_lines

    if as_json:
        print_json(catalogue_json())
    else:
        echo("\n".join(["", *catalogue_lines(line_width()), "", *NOTES]))
