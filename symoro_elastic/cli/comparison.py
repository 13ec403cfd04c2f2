"""The command compare: the full model against the reduced model and the rigid limit."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import click

from symoro_elastic.cli.options import AT, JSON, MACHINE, VALUE, InputFile, Plots, draws, gather, writes
from symoro_elastic.cli.output import counted, print_result
from symoro_elastic.cli.parsing import Number, numbers, parsed_by
from symoro_elastic.cli.reading import read_restricted


@dataclass(frozen=True)
class ComparedMotion:
    """The motion that models are compared on: a file, or a move of a stroke and a duration."""

    motion: str | None
    stroke: float
    duration: float | None


@click.command()
@MACHINE
@gather("compared", ComparedMotion)
@AT
@VALUE
@click.option(
    "--ratio",
    "ratios",
    metavar="MOTOR=N",
    multiple=True,
    callback=parsed_by(numbers),
    help="Gear ratio: turns of the rotor per turn of its joint; couples them in the full model.",
)
@click.option(
    "--motion",
    metavar="FILE",
    type=InputFile(),
    help="Motion of all joints with torques, or of the motors alone (springs follow), .csv or .npz (default: a move).",
)
@click.option(
    "--stroke",
    default=0.1,
    show_default=True,
    type=Number(),
    metavar="X",
    help="Stroke of the move, of every motor, rad or m.",
)
@click.option(
    "--duration",
    type=Number(),
    metavar="S",
    help="Duration of the move (default: five periods of the first natural frequency).",
)
@click.option("--free", is_flag=True, help="Natural frequencies with free motors instead of held ones.")
@draws
@writes
@JSON
def compare(
    machine: str,
    compared: ComparedMotion,
    positions: dict[str, float],
    values: dict[str, float],
    ratios: dict[str, float],
    free: bool,
    plots: Plots,
    as_json: bool,
) -> None:
    """Compare the full model with reduced and rigid models.

    Errors in frequencies, torques and elastic accelerations of Spong's reduced model and of the rigid limit,
    on a motion.
    """
    from symoro_elastic.api import vibrations
    from symoro_elastic.machine.scene import Scene
    from symoro_elastic.vibration.plots import plot_comparison

    kept = read_restricted(machine)
    with counted("springs follow") as progress:
        found = vibrations.compare(
            kept, compared.motion, at=positions, values=values, ratios=ratios, stroke=compared.stroke,
            duration=compared.duration, free=free, scene=Scene(), progress=progress,
        )  # fmt: skip
    print_result(found, as_json)
    plots.write(partial(plot_comparison, found))
