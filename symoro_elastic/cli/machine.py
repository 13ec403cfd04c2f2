"""Commands about a machine and the models there are: show, convert, models."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from symoro_elastic.cli.options import BASE, JSON, MACHINE, SCENE
from symoro_elastic.cli.output import print_json, print_table
from symoro_elastic.cli.reading import read, scene_of
from symoro_elastic.errors import InputError

if TYPE_CHECKING:
    pass


@click.command()
@MACHINE
@SCENE
@JSON
def show(machine: str, scene: str | None, as_json: bool) -> None:
    """Print the table of MACHINE, its parameters, and what is degenerate."""
    from symoro_elastic.grouping import base_parameters
    from symoro_elastic.machine.machine import Kind
    from symoro_elastic.machine.restrict import restricted
    from symoro_elastic.pipeline import found_degeneracies
    from symoro_elastic.report.tables import machine_table

    found = read(machine)
    asked = scene_of(found, scene)
    kept = restricted(found, asked)
    degenerate = [f"{joints}: {message}" for message, joints in found_degeneracies(found, asked)]
    base = base_parameters(kept)
    if as_json:
        by_kind = {k: [joint.name for joint in kept.joints if joint.kind is k] for k in Kind}
        print_json(
            {
                "name": kept.name,
                "joints": [kept.joints[j - 1].name for j in kept.moving],
                "motors": by_kind[Kind.MOTOR],
                "elastic": by_kind[Kind.ELASTIC],
                "parameters": [p.name for p in kept.parameters],
                "base_parameters": base.formulas,
                "base_parameters_parts": base.parts,
                "base_parameters_check": base.check,
                "base_parameters_condition": base.condition,
                "degenerate": degenerate,
            }
        )
        return
    print_table(machine_table(kept), kept.name)
    for parameter in kept.parameters:
        click.echo(f"{parameter.name} = {parameter.value or 'no value'} {parameter.unit}".rstrip())
    if kept.floating:
        turned, known = kept.floating.orientation, kept.floating.known
        click.echo(f"floating base: {turned} and {known} given, M = {kept.floating.body.mass}")
    click.echo(f"\nbase inertial parameters: {base.check}")
    for name, formula in {**base.parts, **base.formulas}.items():
        click.echo(f"  {name} = {formula}")
    click.echo(base.conditioning)
    click.echo("\n".join(f"degenerate: {message}" for message in degenerate) or "no degenerate joints")


@click.command()
@MACHINE
@click.argument("file", metavar="FILE", type=click.Path())
@BASE
def convert(machine: str, file: str, base: bool) -> None:
    """Write MACHINE to FILE, a .toml or a .par, with its base inertial parameters only if asked."""
    from symoro_elastic.machine.formats import write_machine

    if Path(file).exists():
        raise InputError(file, "FILE", "exists already: choose another name, or remove it")
    write_machine(read(machine, base), file)
    click.echo(f"wrote {file}")


@click.command()
@JSON
def models(as_json: bool) -> None:
    """List the models with their arguments, results, shapes, units and equations."""
    from symoro_elastic.report.tables import NOTES, catalogue_json, catalogue_table

    if as_json:
        print_json(catalogue_json())
    else:
        print_table(catalogue_table())
        click.echo("\n".join(NOTES))
