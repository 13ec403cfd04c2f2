"""The command ladder: what a motion requires of the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import click

from symoro_elastic.cli.options import JSON, MACHINE, InputFile, OutputFile, Plots, draws, writes
from symoro_elastic.cli.output import print_json, print_table, staged, write_text
from symoro_elastic.cli.parsing import WholeRange, among, parsed_by, ranges
from symoro_elastic.cli.reading import read, scene_of
from symoro_elastic.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.prescribed_motion import PrescribedMotion
    from symoro_elastic.machine.wanted import Wanted
    from symoro_elastic.model_ladder.rungs import Ladder
    from symoro_elastic.progress import Announce, Progress


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
    from symoro_elastic.model_ladder.plots import plot_ladder
    from symoro_elastic.model_ladder.tables import ladder_json

    with staged() as (announce, progress):
        whole = read(machine, announce=announce)
        found = _found(whole, scene, box, starts, announce, progress)
    if as_json:
        print_json(ladder_json(found))
    else:
        _print(found, scene)
    if out:
        _write_reduced(found, whole, scene, out)
    plots.write(partial(plot_ladder, found))


def _print(found: Ladder, scene: str) -> None:
    from symoro_elastic.machine.formats import read_wanted
    from symoro_elastic.model_ladder.tables import advice, arithmetic_line, ladder_table, period_of, springs_table

    for note in found.condensed:
        click.echo(f"note: {note}", err=True)
    print_table(ladder_table(found), f"{found.machine.name}: what {scene} requires")
    if found.springs:
        print_table(springs_table(found), "each spring by itself, which does not tell what it costs with others")
    wanted = read_wanted(scene)
    lines = [advice(found), period_of(found, wanted) if wanted else "", arithmetic_line(found)]
    click.echo("\n".join(line for line in lines if line))


def _found(
    whole: Machine,
    scene: str,
    box: Mapping[str, tuple[float, float]],
    starts: int,
    announce: Announce,
    progress: Progress,
) -> Ladder:
    from symoro_elastic.machine.restrict import restricted
    from symoro_elastic.model_ladder.rungs import ladder as ladder_of
    from symoro_elastic.simulation.tolerances import tolerances

    machine = replace(restricted(whole, scene_of(whole, scene)), forces=())
    motions, wanted = _tables(scene, machine)
    placed = _from_box(motions, box, starts, machine)
    return ladder_of(machine, placed, tolerances(wanted, machine), wanted.period, announce, progress)


def quoted_ladder(whole: Machine, scene: str) -> str:
    """Return a line on what the motion of a scene requires, by prediction; empty where it has no motion or tolerance.

    Raises `InputError` for machines and motions that the ladder cannot treat.
    """
    from symoro_elastic.machine.formats import read_motions, read_wanted
    from symoro_elastic.machine.restrict import restricted
    from symoro_elastic.model_ladder.rungs import predicted_ladder
    from symoro_elastic.model_ladder.tables import predicted_line
    from symoro_elastic.simulation.tolerances import tolerances

    machine = replace(restricted(whole, scene_of(whole, scene)), forces=())
    motions, wanted = read_motions(scene, machine), read_wanted(scene)
    if not motions or wanted is None or wanted.tolerance is None:
        return ""
    return predicted_line(predicted_ladder(machine, motions, tolerances(wanted, machine), wanted.period))


def _from_box(
    motions: Sequence[PrescribedMotion], box: Mapping[str, tuple[float, float]], count: int, machine: Machine
) -> list[PrescribedMotion]:
    """Return each motion from every position of a sample of the box; the same motions where there is none."""
    from symoro_elastic.model_ladder.starts import starts

    among(tuple(box), tuple(joint.name for joint in machine.moving_joints), "--from")
    places = starts(box, count) if box else [{}]
    return [replace(motion, start={**motion.start, **place}) for motion in motions for place in places]


def _tables(scene: str, machine: Machine) -> tuple[tuple[PrescribedMotion, ...], Wanted]:
    from symoro_elastic.machine.formats import read_motions, read_wanted

    motions, wanted = read_motions(scene, machine), read_wanted(scene)
    if not motions:
        raise InputError(scene, "motion", "there is no table [motion]: say how the motors move")
    if wanted is None or wanted.tolerance is None:
        raise InputError(scene, "wanted, tolerance", 'no error is allowed yet: write tolerance = { "tool.x" = 1e-6 }')
    return motions, wanted


def _write_reduced(found: Ladder, whole: Machine, scene: str, out: str) -> None:
    from symoro_elastic.machine.formats import read_wanted
    from symoro_elastic.machine.formats.toml_writing import write_scene
    from symoro_elastic.model_ladder.tables import advice, reduced_scene

    motions = [reference.prescribed for reference in found.references]
    reduced = reduced_scene(found, whole, scene_of(whole, scene))
    write_text(write_scene(reduced, motions, read_wanted(scene), [advice(found)]), out)
    click.echo(f"wrote {out}", err=True)
