"""Commands for measured machines: identify."""

from __future__ import annotations

import click

from symoro_elastic.cli.options import JSON, MACHINE
from symoro_elastic.cli.output import print_json, steps
from symoro_elastic.cli.reading import numbers, read


@click.command()
@MACHINE
@click.argument("data", metavar="DATA...", nargs=-1, required=True, type=click.Path())
@click.option("--value", "values", metavar="NAME=X", multiple=True, help="Value of a parameter, lengths say.")
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
    from symoro_elastic.identification.measurements import read_measurements
    from symoro_elastic.identification.plots import plot

    found = read(machine)
    with steps() as step:
        step("read")
        records = [read_measurements(path, found) for path in data]
        result = identification.identify(
            found, records, numbers(values, "--value"), numbers(known, "--known"), bandwidth, step=step
        )
    if as_json:
        print_json(identification.as_json(result))
    else:
        click.echo(identification.table(result))
        click.echo("\n".join(result.notes))
    if plots:
        written = plot(result, plots)
        click.echo(f"wrote {plots}: {', '.join(path.name for path in written)}", err=True)
