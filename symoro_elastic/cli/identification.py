"""Commands for measured machines: excite, identify, update."""

from __future__ import annotations

import click

from symoro_elastic.api.measuring_options import Exciting, Identifying, Updating
from symoro_elastic.api.rows import WRITABLE
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import (
    JSON,
    MACHINE,
    InputFile,
    OutputFile,
    OutputMachine,
    Plots,
    call,
    draws,
    takes,
    writes,
)
from symoro_elastic.cli.output import print_parts, print_result, progress_bar, save_machine, say, steps
from symoro_elastic.cli.reading import read
from symoro_elastic.foundation.file_forms import COLUMNS

SAVED = click.option(
    "--save", metavar="FILE", type=OutputMachine(), help=f"Save the machine with the estimates: {', '.join(WRITABLE)}."
)


@command("excite")
@MACHINE
@click.option(
    "--out", required=True, metavar="FILE", type=OutputFile(COLUMNS), help="Save the trajectory: .csv or .npz."
)
@takes(Exciting)
@draws
@writes
@JSON
def excite(machine: str, out: str, options: Exciting, plots: Plots, as_json: bool) -> None:
    """Find a Fourier series within limits whose regressor has a low condition number, started from rest and stopped,
    written as t, q_<motor>, qd_, qdd_. Elastic joints follow their springs; passive ones are assumed to stay at
    zero.
    """
    from symoro_elastic.api import measured

    of_file = read(machine)
    with progress_bar("search") as progress:
        excited = call(measured.excite, of_file, options, progress=progress)
    excited.save(out)
    print_result(excited, as_json, out)
    plots.write(excited.plots)


@command("identify")
@MACHINE
@click.argument("records", metavar="DATA...", nargs=-1, required=True, type=InputFile())
@takes(Identifying)
@SAVED
@draws
@writes
@JSON
def identify(machine: str, options: Identifying, save: str | None, plots: Plots, as_json: bool) -> None:
    """Read DATA, CSV or NPZ files with t, q_<joint>, tau_<motor>.

    Lists (.toml) of vibration tests among DATA are fitted together with the logs.
    """
    from symoro_elastic.api import measured

    of_file = read(machine)
    with steps() as step:
        identified = call(measured.identify, of_file, options, announce=step)
        saved, warnings = identified.saved(step) if save else (None, [])
    if save and saved:
        save_machine(saved, save, machine)
        for warning in warnings:
            say(f"warning: {warning}")
    print_result(identified, as_json, save)
    plots.write(identified.plots)


@command("update")
@MACHINE
@click.argument("tests", metavar="TESTS", type=InputFile())
@takes(Updating)
@SAVED
@click.option("--next", "is_next", is_flag=True, help="Say which test to make next, and what it would tell.")
@draws
@writes
@JSON
def update(machine: str, options: Updating, save: str | None, is_next: bool, plots: Plots, as_json: bool) -> None:
    """Read TESTS, a list (.toml) of frequency responses, natural frequencies or ring-downs at known positions.

    Reports parameters that the tests cannot determine, and bands that the model does not explain.
    """
    from symoro_elastic.api import measured
    from symoro_elastic.foundation.results import plain

    of_file = read(machine)
    with steps() as step:
        updated = call(measured.update, of_file, options, announce=step)
        candidates = updated.next_tests() if is_next else []
    saved, lines = updated.saved() if save else (None, [])
    if save and saved:
        save_machine(saved, save, machine)
        for line in lines:
            say(f"warning: {line}")
    print_result(updated, as_json, save, **({"next_tests": plain(candidates)} if is_next else {}))
    if is_next and not as_json:
        print_parts([updated.table_of_next(candidates)])
    plots.write(updated.plots)
