"""Commands for measured machines: excite, identify."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from symoro_elastic.cli.options import JSON, MACHINE
from symoro_elastic.cli.output import counted, print_json, print_table, steps
from symoro_elastic.cli.reading import numbers, parameter_values, ranges, read

if TYPE_CHECKING:
    from symoro_elastic.identification.identify import Identification

VALUE = click.option(
    "--value", "values", metavar="NAME=X", multiple=True, help="Value of a parameter, lengths say; may be repeated."
)


def limit(option: str, metavar: str, of: str) -> Callable[..., Any]:
    """An option for limits, of all motors or of one."""
    text = f"{of}, of all motors or of one (NAME=...); may be repeated. SI units."
    return click.option(f"--{option}", metavar=metavar, multiple=True, required=True, help=text)


@click.command()
@MACHINE
@click.option("--out", required=True, metavar="FILE", type=click.Path(), help="Trajectory to write: .csv or .npz.")
@limit("position", "[NAME=]LOW:HIGH", "Range of position")
@limit("velocity", "[NAME=]MAX", "Largest velocity")
@limit("acceleration", "[NAME=]MAX", "Largest acceleration")
@click.option(
    "--frequency",
    default=0.1,
    show_default=True,
    metavar="HZ",
    type=click.FloatRange(0, min_open=True),
    help="Of the motion, one over its period.",
)
@click.option("--harmonics", default=5, show_default=True, type=click.IntRange(1, 50), help="Of the Fourier series.")
@click.option(
    "--periods",
    default=3,
    show_default=True,
    type=click.IntRange(1, 1000),
    help="To repeat the motion, start and stop apart.",
)
@click.option(
    "--rate",
    default=1000.0,
    show_default=True,
    metavar="HZ",
    type=click.FloatRange(0, min_open=True),
    help="Of the samples.",
)
@click.option("--evaluations", default=1500, show_default=True, type=click.IntRange(1), help="Motions to try.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0), help="Chooses the first motions.")
@VALUE
@click.option("--known", metavar="LABEL", multiple=True, help="Parameter that is not to be identified.")
@click.option("--plots", metavar="FOLDER", type=click.Path(), help="Draw the motion and the search there.")
@JSON
def excite(
    machine: str,
    out: str,
    position: tuple[str, ...],
    velocity: tuple[str, ...],
    acceleration: tuple[str, ...],
    frequency: float,
    harmonics: int,
    periods: int,
    rate: float,
    evaluations: int,
    seed: int,
    values: tuple[str, ...],
    known: tuple[str, ...],
    plots: str | None,
    as_json: bool,
) -> None:
    """Find a motion of the motors of MACHINE that shows its parameters, and write it as t, q_<motor>, qd_, qdd_.

    A Fourier series within limits whose regressor has a low condition number, started from rest and stopped.
    Elastic joints follow their springs; passive ones are taken to stay at zero.
    """
    from symoro_elastic.identification import excitation, trajectory
    from symoro_elastic.identification.plots import plot_excitation

    trajectory.refuse_file(out)
    found = read(machine)
    given = {"--position": position, "--velocity": velocity, "--acceleration": acceleration}
    limits = trajectory.limits_of(found, {option: ranges(texts, option) for option, texts in given.items()})
    trajectory.refuse_rate(rate, frequency, harmonics, periods)
    with counted("search") as progress:
        best = excitation.excite(
            found, limits, frequency, harmonics, parameter_values(values, found), known,
            evaluations=evaluations, seed=seed, progress=lambda done, total, _: progress(done, total),
        )  # fmt: skip
    sampled = trajectory.trajectory(best.motion, limits, periods, rate)
    trajectory.write(sampled, found, out)
    figures = trajectory.figures(best, sampled, limits, found)
    if as_json:
        print_json({"written": out, **figures})
    else:
        print_table(trajectory.table(figures), f"{found.name}: reached of the limits")
        click.echo("\n".join(trajectory.lines(figures)))
        click.echo(f"wrote {out}")
    if plots:
        written = plot_excitation(best, sampled, limits, found, plots)
        click.echo(f"wrote {plots}: {', '.join(path.name for path in written)}", err=True)


@click.command()
@MACHINE
@click.argument("data", metavar="DATA...", nargs=-1, required=True, type=click.Path())
@VALUE
@click.option("--known", metavar="LABEL=X", multiple=True, help="Value of a column that is not to be estimated.")
@click.option("--bandwidth", type=float, metavar="HZ", help="Of the motion, where its spectrum is not to decide.")
@click.option("--plots", metavar="FOLDER", type=click.Path(), help="Draw measured and predicted torques there.")
@JSON
def identify(
    machine: str,
    data: tuple[str, ...],
    values: tuple[str, ...],
    known: tuple[str, ...],
    bandwidth: float | None,
    plots: str | None,
    as_json: bool,
) -> None:
    """Estimate the parameters of MACHINE from measurements: CSV or NPZ with t, q_<joint>, tau_<motor>."""
    from symoro_elastic.identification import identify as identification
    from symoro_elastic.identification.plots import plot
    from symoro_elastic.time_series.measurements import read_measurements

    found = read(machine)
    with steps() as step:
        step("read")
        records = [read_measurements(path, found) for path in data]
        result = identification.identify(
            found, records, parameter_values(values, found), numbers(known, "--known"), bandwidth, step=step
        )
    if as_json:
        print_json(identification.as_json(result))
    else:
        click.echo(identification.table(result))
        click.echo("\n".join([*neutral_positions(result), *result.notes]))
    if plots:
        written = plot(result, plots)
        click.echo(f"wrote {plots}: {', '.join(path.name for path in written)}", err=True)


def neutral_positions(result: Identification) -> list[str]:
    """A line for each spring whose neutral position was found."""
    units = {joint.name: "m" if joint.sigma == 1 else "rad" for joint in result.machine.joints}
    return [
        f"neutral position of {name}: {q0:.5g} {units[name]}, std {std:.2g}"
        for name, (q0, std) in result.neutral.items()
    ]
