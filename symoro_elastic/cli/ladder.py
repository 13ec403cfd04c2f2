"""The command ladder: what a motion requires of the model."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import click

from symoro_elastic.cli.options import JSON, MACHINE, InputFile, OutputFile, Plots, draws, writes
from symoro_elastic.cli.output import print_json, print_table, staged, write_text
from symoro_elastic.cli.parsing import WholeRange, parsed_by, ranges
from symoro_elastic.cli.reading import read, scene_of

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.scene import Scene
    from symoro_elastic.model_ladder.rungs import Ladder


@click.command()
@MACHINE
@click.option(
    "--scene", required=True, metavar="FILE", type=InputFile(), help="TOML file with the tables [motion] and [wanted]."
)
@click.option(
    "--from",
    "box",
    metavar="JOINT=LOW:HIGH",
    multiple=True,
    callback=parsed_by(ranges),
    help="Range of positions at which the motion may start, rad or m; may be repeated.",
)
@click.option(
    "--starts",
    default=20,
    show_default=True,
    metavar="N",
    type=WholeRange(1, 1000),
    help="Positions in the ranges of --from that are tried, a Latin hypercube.",
)
@click.option("--out", metavar="FILE", type=OutputFile(), help="Write the scene of the chosen rung to this .toml file.")
@draws
@writes
@JSON
def ladder(
    machine: str,
    scene: str,
    box: dict[str, tuple[float, float]],
    starts: int,
    out: str | None,
    plots: Plots,
    as_json: bool,
) -> None:
    """Find springs, method and step that a motion requires.

    Errors of leaving springs out and of steps are predicted for every rung; the chosen one is simulated and measured.
    """
    from symoro_elastic.api import motions as api
    from symoro_elastic.model_ladder.plots import plot_ladder

    with staged() as (announce, progress):
        whole = read(machine, announce=announce)
        asked = scene_of(whole, scene)
        found = api.ladder(whole, scene, box=box, starts=starts, announce=announce, progress=progress)
    if as_json:
        print_json(found.as_json())
    else:
        _print(found, scene)
    if out:
        _write_reduced(found, whole, asked, scene, out)
    plots.write(partial(plot_ladder, found))


def _print(found: Ladder, scene: str) -> None:
    from symoro_elastic.machine.formats import read_wanted
    from symoro_elastic.model_ladder.tables import advice, arithmetic_line, ladder_table, period_of

    print_table(ladder_table(found), f"{found.machine.name}: what {scene} requires")
    wanted = read_wanted(scene)
    lines = [advice(found), period_of(found, wanted) if wanted else "", arithmetic_line(found)]
    click.echo("\n".join(line for line in lines if line))


def _write_reduced(found: Ladder, whole: Machine, asked: Scene, scene: str, out: str) -> None:
    from symoro_elastic.machine.formats import read_wanted
    from symoro_elastic.machine.formats.toml_writing import write_scene
    from symoro_elastic.model_ladder.tables import advice, reduced_scene

    motions = [reference.prescribed for reference in found.references]
    reduced = reduced_scene(found, whole, asked)
    write_text(write_scene(reduced, motions, read_wanted(scene), [advice(found)]), out)
    click.echo(f"wrote {out}", err=True)
