"""The command feed-forward: motor torques for a reference trajectory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import click

from symoro_elastic.cli.options import JSON, MACHINE, SCENE, VALUE, InputFile, OutputFile, Plots, draws, gather, writes
from symoro_elastic.cli.output import print_result, steps
from symoro_elastic.cli.parsing import Number, Whole, numbers, numbers_or_default, parsed_by
from symoro_elastic.cli.reading import read_restricted


@dataclass(frozen=True)
class Reference:
    """A reference trajectory: a file, or a move by strokes; degree and sample rate of its splines."""

    motion: str | None
    strokes: Mapping[str, float]
    duration: float | None
    positions: Mapping[str, float]
    degree: int | None
    rate: float | None


@click.command("feed-forward")
@MACHINE
@gather("reference", Reference)
@click.option(
    "--motion",
    metavar="FILE",
    type=InputFile(),
    help="Reference trajectory: .csv or .npz with t, y_<motor>, yd_<motor> ..., or positions only (default: a move).",
)
@click.option(
    "--stroke",
    "strokes",
    metavar="[MOTOR=]X",
    multiple=True,
    callback=parsed_by(numbers_or_default),
    help="Stroke of the move, rad or m (default: 0.1 for every motor).",
)
@click.option(
    "--duration",
    type=Number(),
    metavar="S",
    help="Duration of the move (default: five periods of the first natural frequency).",
)
@click.option(
    "--at",
    "positions",
    metavar="MOTOR=X",
    multiple=True,
    callback=parsed_by(numbers),
    help="Start of the move, rad or m (default: 0, or the start of a loop).",
)
@click.option(
    "--degree",
    type=Whole(),
    metavar="N",
    help="Degree of the splines of a move, or through the positions of a file (default: one more than necessary).",
)
@click.option("--rate", type=Number(), metavar="HZ", help="Sample rate of splines (default: 1000).")
@VALUE
@SCENE
@click.option("--out", metavar="FILE", type=OutputFile(), help="Save torques and motion of all joints: .csv or .npz.")
@draws
@writes
@JSON
def feed_forward(
    machine: str,
    reference: Reference,
    values: dict[str, float],
    scene: str | None,
    out: str | None,
    plots: Plots,
    as_json: bool,
) -> None:
    """Compute torques that make the load follow a trajectory.

    Motor torques of MACHINE, those of the full elastic model: the load, beyond the springs, follows the reference
    trajectory. They need its derivatives: two, and two more for each spring in a row. Springs may have damping.
    Behind a gear or a screw the trajectory of a motor is that of the last joint of its drive.
    Springs that are not behind a motor on its axis are left out; the command says what that costs.
    Where motors follow from loops, as in a delta, the trajectory is that of the independent joints (y_<joint>).
    """
    from symoro_elastic.api import vibrations
    from symoro_elastic.machine.scene import Scene
    from symoro_elastic.time_series.writing import CSV, NPZ
    from symoro_elastic.vibration import export
    from symoro_elastic.vibration.feed_forward import save_feed_forward
    from symoro_elastic.vibration.plots import plot_feed_forward

    if out:
        export.refuse_file(out, (CSV, NPZ))
    kept = read_restricted(machine, scene)
    with steps() as step:
        step("feed-forward")
        found = vibrations.feed_forward(
            kept, reference.motion, strokes=reference.strokes, duration=reference.duration, at=reference.positions,
            degree=reference.degree, rate=reference.rate, values=values, scene=Scene(),
        )  # fmt: skip
    print_result(found, as_json, **({"written": out} if out else {}))
    if out:
        save_feed_forward(found, out)
        click.echo(f"wrote {out}", err=as_json)
    plots.write(partial(plot_feed_forward, found))
