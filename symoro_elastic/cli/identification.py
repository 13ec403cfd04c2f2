"""Commands for measured machines: excite, identify."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from symoro_elastic.cli.options import JSON, MACHINE, VALUE, InputFile, OutputFile, Plots, draws, gather, writes
from symoro_elastic.cli.output import counted, print_result, steps
from symoro_elastic.cli.parsing import Number, NumberRange, WholeRange, numbers, parsed_by, ranges
from symoro_elastic.cli.reading import read

if TYPE_CHECKING:
    from symoro_elastic.time_series.preparation import Preparation

Ranges = dict[str, tuple[float, float]]


@dataclass(frozen=True)
class MotorLimits:
    """Limits of the motors by name; the name "" stands for all."""

    position: Ranges
    velocity: Ranges
    acceleration: Ranges


@dataclass(frozen=True)
class FourierSeries:
    """The periodic motion that is optimized, and how it is sampled."""

    frequency: float
    harmonics: int
    periods: int
    rate: float
    evaluations: int
    seed: int


@dataclass(frozen=True)
class Given:
    """What is known before: values of named parameters, of columns that are not sought, the bandwidth of the motion."""

    values: dict[str, float]
    known: dict[str, float]
    bandwidth: float | None


@dataclass(frozen=True)
class Preparing:
    """How records are made ready."""

    gains: dict[str, float]
    resample: float | None
    first: float | None
    last: float | None

    @property
    def preparation(self) -> Preparation:
        """The preparation of records."""
        from symoro_elastic.time_series.preparation import Preparation

        return Preparation(self.first, self.last, self.resample, self.gains)


def limit(option: str, metavar: str, of: str) -> Callable[..., Any]:
    """Return an option for limits of all motors or of one."""
    text = f"{of} of all motors, or of one (NAME=...), SI units; may be repeated."
    return click.option(
        f"--{option}", metavar=metavar, multiple=True, required=True, callback=parsed_by(ranges), help=text
    )


@click.command()
@MACHINE
@gather("limits", MotorLimits)
@gather("series", FourierSeries)
@click.option("--out", required=True, metavar="FILE", type=OutputFile(), help="Save the trajectory: .csv or .npz.")
@limit("position", "[NAME=]LOW:HIGH", "Range of positions")
@limit("velocity", "[NAME=]MAX", "Largest velocity")
@limit("acceleration", "[NAME=]MAX", "Largest acceleration")
@click.option(
    "--frequency",
    default=0.1,
    show_default=True,
    metavar="HZ",
    type=NumberRange(0, min_open=True),
    help="Fundamental frequency of the motion.",
)
@click.option(
    "--harmonics", default=5, show_default=True, type=WholeRange(1, 50), help="Harmonics of the Fourier series."
)
@click.option(
    "--periods",
    default=3,
    show_default=True,
    type=WholeRange(1, 1000),
    help="Periods of the motion, without start and stop.",
)
@click.option(
    "--rate",
    default=1000.0,
    show_default=True,
    metavar="HZ",
    type=NumberRange(0, min_open=True),
    help="Sample rate.",
)
@click.option(
    "--evaluations",
    default=1500,
    show_default=True,
    type=WholeRange(1, 1_000_000),
    help="Motions that the search evaluates.",
)
@click.option("--seed", default=0, show_default=True, type=WholeRange(0), help="Seed of the first motions.")
@VALUE
@click.option("--known", metavar="LABEL", multiple=True, help="Parameter that is not to be identified.")
@draws
@writes
@JSON
def excite(
    machine: str,
    limits: MotorLimits,
    series: FourierSeries,
    out: str,
    values: dict[str, float],
    known: tuple[str, ...],
    plots: Plots,
    as_json: bool,
) -> None:
    """Design an exciting trajectory for identification.

    A Fourier series within limits whose regressor has a low condition number, started from rest and stopped,
    written as t, q_<motor>, qd_, qdd_. Elastic joints follow their springs; passive ones are assumed to stay at
    zero.
    """
    from symoro_elastic.api import measured
    from symoro_elastic.identification.plots import plot_excitation
    from symoro_elastic.identification.trajectory import write
    from symoro_elastic.time_series.writing import refuse_file

    refuse_file(out)
    of_file = read(machine)
    with counted("search") as progress:
        found = measured.excite(of_file, **vars(limits), **vars(series), values=values, known=known, progress=progress)
    write(found.sampled, found.machine, out)
    print_result(found, as_json, written=out)
    if not as_json:
        click.echo(f"wrote {out}")
    plots.write(partial(plot_excitation, found.best, found.sampled, found.limits, found.machine))


@click.command()
@MACHINE
@click.argument("data", metavar="DATA...", nargs=-1, required=True, type=InputFile())
@gather("given", Given)
@VALUE
@click.option(
    "--known",
    metavar="LABEL=X",
    multiple=True,
    callback=parsed_by(numbers),
    help="Value of a parameter that is not to be estimated.",
)
@click.option("--bandwidth", type=Number(), metavar="HZ", help="Bandwidth of the motion (default: from its spectrum).")
@gather("preparing", Preparing)
@click.option(
    "--gain",
    "gains",
    metavar="MOTOR=K",
    multiple=True,
    callback=parsed_by(numbers),
    help="Torque of a motor over its column, as for measured currents; may be repeated.",
)
@click.option("--resample", type=Number(), metavar="HZ", help="Sample the records evenly at this frequency.")
@click.option("--from", "first", type=Number(), metavar="S", help="Leave out what is before this time.")
@click.option("--to", "last", type=Number(), metavar="S", help="Leave out what is after this time.")
@click.option("--validate", metavar="FILE", type=InputFile(), help="Predict the torques of this record, too.")
@click.option("--save", metavar="FILE", type=OutputFile(), help="Save the machine with the estimates: .toml or .par.")
@draws
@writes
@JSON
def identify(
    machine: str,
    data: tuple[str, ...],
    given: Given,
    preparing: Preparing,
    validate: str | None,
    save: str | None,
    plots: Plots,
    as_json: bool,
) -> None:
    """Estimate dynamic parameters from measurements.

    DATA are CSV or NPZ files with t, q_<joint>, tau_<motor>.
    """
    from symoro_elastic.api import measured
    from symoro_elastic.identification.plots import plot
    from symoro_elastic.machine.formats import write_machine
    from symoro_elastic.machine.formats.reading import refuse_unwritable

    if save:
        refuse_unwritable(save)
    of_file = read(machine)
    with steps() as step:
        found = measured.identify(
            of_file, data, **vars(given), preparation=preparing.preparation, validate=validate, step=step
        )
        saved, warnings = found.saved(step) if save else (None, [])
    if save and saved:
        write_machine(saved, save)
        for warning in warnings:
            click.echo(f"warning: {warning}", err=True)
    print_result(found, as_json, **({"written": save} if save else {}))
    if save and not as_json:
        click.echo(f"wrote {save}")
    plots.write(partial(plot, found.found))
