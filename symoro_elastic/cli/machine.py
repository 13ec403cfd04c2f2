"""Commands about machines and models: show, convert, models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from symoro_elastic.cli.options import BASE, JSON, MACHINE, SCENE, VALUE, OutputFile, writes
from symoro_elastic.cli.output import line_width, print_json, print_table
from symoro_elastic.cli.parsing import Number, numbers, parsed_by, springs_on_joints
from symoro_elastic.cli.reading import read, scene_of

if TYPE_CHECKING:
    from symoro_elastic.grouping import BaseParameters
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.models.joint_axes import PlacedMachine
    from symoro_elastic.reports.closed_chains import ClosedChain

SNAP = "1e-9"
"""Tolerance of --snap, rad and m, where none is given."""


@click.command()
@MACHINE
@SCENE
@click.option(
    "--at",
    "positions",
    metavar="JOINT=X",
    multiple=True,
    callback=parsed_by(numbers),
    help="Position at which origins and axes are printed, rad or m (default 0, springs neutral); may be repeated.",
)
@VALUE
@click.option(
    "--picture", metavar="FILE", type=OutputFile(), help="Draw the machine at that position: .svg, .png or .pdf."
)
@writes
@JSON
def show(
    machine: str,
    scene: str | None,
    positions: dict[str, float],
    values: dict[str, float],
    picture: str | None,
    as_json: bool,
) -> None:
    """Print the parameters of MACHINE and its base parameters.

    Prints where each joint is and how it moves, seen from frame 0; how each loop closes, and where it is singular.
    Names the joints, if any, whose inertia is singular at every position.
    """
    from symoro_elastic.grouping import base_parameters
    from symoro_elastic.machine.named_cells import with_values
    from symoro_elastic.machine.restrict import restricted
    from symoro_elastic.models.joint_axes import placed_machine
    from symoro_elastic.pipeline import found_degeneracies
    from symoro_elastic.reports.closed_chains import closed_chain

    found = read(machine)
    if values:
        found = with_values(found, values)
    asked = scene_of(found, scene)
    kept = restricted(found, asked)
    if picture:
        _draw(kept, positions, picture, as_json)
    placed = placed_machine(kept, positions)
    chain = closed_chain(kept, placed)
    for warning in chain.warnings:
        click.echo(f"warning: {warning}", err=True)
    degenerate = [f"{joints}: {message}" for message, joints in found_degeneracies(found, asked)]
    base = base_parameters(kept)
    if as_json:
        print_json(_as_json(chain, placed, base, degenerate))
    else:
        _print(chain, placed, base, degenerate)


def _draw(machine: Machine, positions: Mapping[str, float], path: str, as_json: bool) -> None:
    """Write the picture of a machine at a position, and name it; on stderr beside JSON."""
    from symoro_elastic.drawing.files import refuse_picture, write_picture
    from symoro_elastic.drawing.svg import machine_picture

    refuse_picture(path, "--picture")
    picture = machine_picture(machine, positions)
    for remark in picture.figure.remarks:
        click.echo(f"note: {remark}", err=True)
    write_picture(picture, path, "--picture")
    click.echo(f"wrote {path}", err=as_json)


def _as_json(
    chain: ClosedChain, placed: PlacedMachine, base: BaseParameters, degenerate: Sequence[str]
) -> dict[str, Any]:
    from symoro_elastic.machine.machine import Kind
    from symoro_elastic.reports.closed_chains import closed_chain_json
    from symoro_elastic.reports.tables import axes_json, position_json

    machine = chain.machine
    by_kind = {kind: [joint.name for joint in machine.joints if joint.kind is kind] for kind in Kind}
    return {
        "name": machine.name,
        "joints": [joint.name for joint in machine.moving_joints],
        "motors": by_kind[Kind.MOTOR],
        "elastic": by_kind[Kind.ELASTIC],
        **closed_chain_json(chain),
        "position": position_json(placed),
        "axes": axes_json(placed),
        "parameters": [p.name for p in machine.parameters],
        "base_parameters": base.formulas,
        "base_parameters_parts": base.parts,
        "base_parameters_zero": base.zero,
        "base_parameters_check": base.check,
        "base_parameters_condition": base.condition,
        "degenerate": degenerate,
    }


def _print(chain: ClosedChain, placed: PlacedMachine, base: BaseParameters, degenerate: Sequence[str]) -> None:
    from symoro_elastic.machine.table import machine_table
    from symoro_elastic.reports.closed_chains import closed_chain_lines
    from symoro_elastic.reports.tables import axes_table

    machine = chain.machine
    print_table(machine_table(machine), machine.name, keys=2)
    print_table(axes_table(placed), "origins and axes in frame 0", keys=2)
    for parameter in machine.parameters:
        click.echo(f"{parameter.name} = {parameter.value or 'no value'} {parameter.unit}".rstrip())
    if machine.floating:
        orientation, known = machine.floating.orientation, machine.floating.known
        click.echo(f"floating base: {orientation} and {known} given, M = {machine.floating.body.mass}")
    for line in closed_chain_lines(chain):
        click.echo(line)
    click.echo(f"\nbase inertial parameters: {base.check}")
    for name, formula in {**base.parts, **base.formulas}.items():
        click.echo(f"  {name} = {formula}")
    if base.zero:
        click.echo(f"  zero for these bodies: {', '.join(base.zero)}")
    click.echo(base.conditioning)
    click.echo("\n".join(f"degenerate: {message}" for message in degenerate) or "no degenerate joints")


@click.command()
@MACHINE
@click.argument("file", metavar="FILE", type=OutputFile())
@click.option(
    "--snap",
    metavar="[TOL]",
    is_flag=False,
    flag_value=SNAP,
    type=Number(),
    help="Take angles of a robot within TOL, rad, of multiples of pi/12 for these, and lengths below TOL, m, for 0 "
    f"(default {SNAP}).",
)
@click.option(
    "--elastic",
    "springs",
    metavar="JOINT=K[:IA]",
    multiple=True,
    callback=parsed_by(springs_on_joints),
    help="Put a spring behind the motor of a joint of a robot: stiffness, and inertia of the rotor as the joint feels "
    "it; may be repeated.",
)
@BASE
@writes
def convert(machine: str, file: str, snap: float | None, springs: dict[str, tuple[float, ...]], base: bool) -> None:
    """Convert MACHINE to FILE, a .toml, a SYMORO .par or a .urdf.

    Robots in URDF get a table of geometric parameters. It is exact but for rounding; --snap makes it simpler, and
    prints how far frames move.
    """
    from symoro_elastic.machine.formats import write_machine
    from symoro_elastic.machine.formats.format import Conversion

    found = read(machine, base, conversion=Conversion.of(snap, springs))
    write_machine(replace(found, notes=tuple(dict.fromkeys((*found.notes, *found.remarks)))), file)
    click.echo(f"wrote {file}")


@click.command()
@JSON
def models(as_json: bool) -> None:
    """List the models: arguments, results, shapes, units.

    With the numbers of their equations.
    """
    from symoro_elastic.reports.tables import NOTES, catalogue_json, catalogue_lines

    if as_json:
        print_json(catalogue_json())
    else:
        click.echo("\n".join(["", *catalogue_lines(line_width()), "", *NOTES]))
