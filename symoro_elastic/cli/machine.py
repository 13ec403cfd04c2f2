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
    from symoro_elastic.machine.machine import Machine


@click.command()
@MACHINE
@SCENE
@JSON
def show(machine: str, scene: str | None, as_json: bool) -> None:
    """Print the table of MACHINE, its parameters, and what is degenerate."""
    from symoro_elastic.generate import found_degeneracies
    from symoro_elastic.machine.machine import Kind
    from symoro_elastic.machine.restrict import restricted
    from symoro_elastic.report.tables import machine_table

    found = read(machine)
    asked = scene_of(found, scene)
    kept = restricted(found, asked)
    degenerate = [f"{joints}: {message}" for message, joints in found_degeneracies(found, asked)]
    formulas, parts, message, condition, conditioning = _base_parameters(kept)
    if as_json:
        by_kind = {k: [joint.name for joint in kept.joints if joint.kind is k] for k in Kind}
        print_json(
            {
                "name": kept.name,
                "joints": [kept.joints[j - 1].name for j in kept.moving],
                "motors": by_kind[Kind.MOTOR],
                "elastic": by_kind[Kind.ELASTIC],
                "parameters": [p.name for p in kept.parameters],
                "base_parameters": {name: text for name, text in formulas.items() if name not in parts},
                "base_parameters_parts": parts,
                "base_parameters_check": message,
                "base_parameters_condition": condition,
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
    click.echo(f"\nbase inertial parameters: {message}")
    for name, formula in formulas.items():
        click.echo(f"  {name} = {formula}")
    click.echo(conditioning)
    click.echo("\n".join(f"degenerate: {message}" for message in degenerate) or "no degenerate joints")


def _base_parameters(machine: Machine) -> tuple[dict[str, str], dict[str, str], str, float | None, str]:
    """Formulas of the base inertial parameters and of the sums they share, how they were checked, and conditioning.

    The latter as a number and in words.
    """
    from symoro_elastic.grouping import base_formulas, checked_grouping, conditioning_text

    if machine.floating:
        return {}, {}, "not offered on a floating base", None, ""
    grouping, check = checked_grouping(machine)
    formulas = base_formulas(grouping, check)
    parts = grouping.parts if formulas else {}
    return formulas, parts, check.message, check.conditioning.condition, conditioning_text(check)


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
