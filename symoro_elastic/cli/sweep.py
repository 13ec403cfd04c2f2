"""The command sweep: results of a machine over grids and samples of its parameters and positions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from symoro_elastic.api.declaration import read_options
from symoro_elastic.api.options import Sweeping
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import JSON, MACHINE, InputFile, OutputFile, Plots, draws, takes, writes
from symoro_elastic.cli.output import counted_ahead, print_result
from symoro_elastic.cli.reading import note, read_for
from symoro_elastic.foundation.file_forms import SWEEPS

if TYPE_CHECKING:
    from symoro_elastic.analysis.sweeps.sweep import Sweep
    from symoro_elastic.api.sweeps import Plan

JOURNAL = ".journal"


@command("sweep")
@MACHINE
@click.option("--sweep", "file", metavar="FILE", type=InputFile(), help="TOML file that describes the sweep.")
@takes(Sweeping)
@click.option(
    "--out",
    metavar="FILE",
    type=OutputFile(SWEEPS),
    help="Save all points: .csv, .nc (NetCDF) or .npz. Until the end FILE.journal keeps them: an interrupted sweep "
    "goes on from there.",
)
@draws
@writes
@JSON
def sweep(machine: str, file: str | None, options: Sweeping, out: str | None, plots: Plots, as_json: bool) -> None:
    """Give results of the modes, frequency responses, drives, ladder or simulation of MACHINE at each point, and the
    influence of each quantity on them.
    """
    from symoro_elastic.analysis.sweeps.sweep import refuse_form, save
    from symoro_elastic.api.sweeps import plan
    from symoro_elastic.foundation.output_files import remove_file

    if out:
        refuse_form(out)
    if file:
        options = _before_file(options, file)
    full_machine = read_for(options.scene, machine)
    swept = _compute(plan(full_machine, options), out)
    if out:
        save(swept, out)
        remove_file(f"{out}{JOURNAL}")
    print_result(swept, as_json, out)
    plots.write(swept.plots)


def _before_file(options: Sweeping, file: str) -> Sweeping:
    """Return the options of a file and of the command line, which has precedence."""
    context = click.get_current_context()
    values = read_options(file, Sweeping)
    for name, value in values.items():
        of_command = getattr(options, name)
        if isinstance(value, dict):
            values[name] = {**value, **of_command}
        elif context.get_parameter_source(name) is ParameterSource.COMMANDLINE:
            values[name] = of_command
    return replace(options, **values)


def _compute(planned: Plan, out: str | None) -> Sweep:
    """Return the results at all points; on Ctrl-C, report the file with the computed ones."""
    try:
        with counted_ahead("sweep") as progress:
            return planned.run(Path(f"{out}{JOURNAL}") if out else None, note, progress)
    except KeyboardInterrupt:
        advice = f"{out}{JOURNAL} keeps what was computed: give the command again to go on"
        note(f"interrupted, {advice if out and Path(out + JOURNAL).exists() else 'nothing was written'}")
        raise
