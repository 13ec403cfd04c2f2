"""The command feed-forward: motor torques for a wanted motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from symoro_elastic.cli.options import JSON, MACHINE, SCENE
from symoro_elastic.cli.output import print_json, print_table, steps
from symoro_elastic.cli.reading import numbers, read, scene_of

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.vibration.reference_trajectory import ReferenceTrajectory


@click.command("feed-forward")
@MACHINE
@click.option(
    "--motion",
    metavar="FILE",
    type=click.Path(),
    help="Reference trajectory, .csv or .npz with t, y_<motor>, yd_<motor> ..., or positions; a move unless said.",
)
@click.option(
    "--stroke", metavar="[MOTOR=]X", multiple=True, help="Of the move, rad or m; 0.1 of every motor unless said."
)
@click.option(
    "--duration", type=float, metavar="S", help="Of the move; five periods of the first vibration unless said."
)
@click.option("--at", metavar="MOTOR=X", multiple=True, help="Where the move begins, rad or m, 0 unless said.")
@click.option(
    "--degree", type=int, metavar="N",
    help="Of the splines of a move, or through the positions of a file; one more than is needed unless said.",
)  # fmt: skip
@click.option("--rate", type=float, metavar="HZ", help="Of the samples of splines; 1000 unless said.")
@click.option("--value", "values", metavar="NAME=X", multiple=True, help="Value of a parameter; may be repeated.")
@SCENE
@click.option("--out", metavar="FILE", type=click.Path(), help="Torques and motion of all joints: .csv or .npz.")
@click.option("--plots", metavar="FOLDER", type=click.Path(), help="Draw a picture there.")
@JSON
def feed_forward(
    machine: str,
    motion: str | None,
    values: tuple[str, ...],
    scene: str | None,
    out: str | None,
    plots: str | None,
    as_json: bool,
    **asked: Any,
) -> None:
    """Motor torques with which what the motors of MACHINE drive, beyond the springs, follows a wanted motion.

    Exact for the full elastic model. Its torques need derivatives of the motion: two, and two more for each
    spring in a row. Joints that are no spring behind a motor are to be locked in a scene.
    """
    from symoro_elastic.machine.named_cells import with_values
    from symoro_elastic.machine.restrict import restricted
    from symoro_elastic.vibration import export
    from symoro_elastic.vibration import feed_forward as vibration
    from symoro_elastic.vibration.plots import plot_feed_forward
    from symoro_elastic.vibration.tables import feed_forward_table

    if out:
        export.refuse_file(out, (export.CSV, export.NPZ))
    whole = read(machine)
    kept = with_values(restricted(whole, scene_of(whole, scene)), numbers(values, "--value"))
    with steps() as step:
        step("feed-forward")
        found = vibration.feed_forward(kept, _wanted(kept, motion, **asked))
    figures = vibration.figures(found)
    if as_json:
        print_json({**figures, **({"written": out} if out else {})})
    else:
        print_table(feed_forward_table(found), f"{kept.name}: {figures['motion']}")
        click.echo("\n".join([f"{figures['duration']:.6g} s, {figures['samples']} samples", *figures["notes"]]))
    if out:
        vibration.save_feed_forward(found, out)
        click.echo(f"wrote {out}", err=as_json)
    if plots:
        (picture,) = plot_feed_forward(found, plots)
        click.echo(f"wrote {picture}", err=True)


def _wanted(
    machine: Machine,
    motion: str | None,
    stroke: Sequence[str],
    duration: float | None,
    at: Sequence[str],
    degree: int | None,
    rate: float | None,
) -> ReferenceTrajectory:
    """The motion that the options ask for."""
    from symoro_elastic.vibration import reference_trajectory
    from symoro_elastic.vibration.comparison import usual_duration
    from symoro_elastic.vibration.feed_forward import orders

    start = numbers(at, "--at")
    smooth = max(orders(machine).values(), default=0) + 1
    if motion:
        return reference_trajectory.read_reference(motion, machine, degree, smooth, rate)
    strokes = numbers([x if "=" in x else f"={x}" for x in stroke], "--stroke") or {"": reference_trajectory.STROKE}
    seconds = usual_duration(machine, start) if duration is None else duration
    return reference_trajectory.move(machine, start, strokes, seconds, smooth if degree is None else degree, rate)
