"""Commands about a machine and the models there are: show, convert, models."""

from __future__ import annotations

from pathlib import Path

import click

from symoro_elastic.cli.options import BASE, JSON, MACHINE, SCENE
from symoro_elastic.cli.output import print_json, print_table
from symoro_elastic.cli.reading import read, scene_of
from symoro_elastic.errors import InputError


@click.command()
@MACHINE
@SCENE
@JSON
def show(machine: str, scene: str | None, as_json: bool) -> None:
    """Print the table of MACHINE, its parameters, and what is degenerate."""
    from symoro_elastic.generate import found_degeneracies
    from symoro_elastic.grouping import base_formulas, checked_grouping, conditioning_text
    from symoro_elastic.machine.machine import Kind
    from symoro_elastic.machine.restrict import restricted
    from symoro_elastic.report.tables import machine_table

    found = read(machine)
    asked = scene_of(found, scene)
    kept = restricted(found, asked)
    degenerate = [f"{joints}: {message}" for message, joints in found_degeneracies(found, asked)]
    grouping, cross_check = checked_grouping(kept)
    if as_json:
        by_kind = {k: [joint.name for joint in kept.joints if joint.kind is k] for k in Kind}
        print_json(
            {
                "name": kept.name,
                "joints": [kept.joints[j - 1].name for j in kept.moving],
                "motors": by_kind[Kind.MOTOR],
                "elastic": by_kind[Kind.ELASTIC],
                "parameters": [p.name for p in kept.parameters],
                "base_parameters": base_formulas(grouping, cross_check),
                "base_parameters_check": cross_check.message,
                "base_parameters_condition": cross_check.conditioning.condition,
                "degenerate": degenerate,
            }
        )
        return
    print_table(machine_table(kept), kept.name)
    for parameter in kept.parameters:
        click.echo(f"{parameter.name} = {parameter.value or 'no value'} {parameter.unit}".rstrip())
    click.echo(f"\nbase inertial parameters: {cross_check.message}")
    for name, formula in base_formulas(grouping, cross_check).items():
        click.echo(f"  {name} = {formula}")
    click.echo(conditioning_text(cross_check))
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
    from symoro_elastic.report.tables import catalogue_json, catalogue_table

    if as_json:
        print_json(catalogue_json())
    else:
        print_table(catalogue_table())
        click.echo(
            "n joints that move, m motors; frames: all rows of the table, or those a scene asks for "
            "('tool in ram' is seen from ram, 'tool at (0.1, 0, L2) in base' is a point in axes of tool, m)"
        )
