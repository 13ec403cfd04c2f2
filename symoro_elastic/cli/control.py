"""Commands about drives and cuts: control, tune, lobes."""

from __future__ import annotations

import click

from symoro_elastic.api.options import Controlling, Cutting, TuningDrives
from symoro_elastic.api.rows import WRITABLE
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import JSON, MACHINE, OutputMachine, Plots, call, draws, takes, writes
from symoro_elastic.cli.output import print_result, progress_bar, save_machine
from symoro_elastic.cli.reading import read_for

SAVED = click.option(
    "--save", metavar="FILE", type=OutputMachine(), help=f"Save the machine with the gains: {', '.join(WRITABLE)}."
)


@command("control")
@MACHINE
@takes(Controlling)
@SAVED
@draws
@writes
@JSON
def control(machine: str, options: Controlling, save: str | None, plots: Plots, as_json: bool) -> None:
    """Margins, bandwidth and compliance with the loops of [drives] closed, and the spring, mass, lag or dead time that
    limits each gain; computes gains that the file calls "tuned".
    """
    _control(machine, options, save, plots, as_json)


@command("tune")
@MACHINE
@takes(TuningDrives)
@SAVED
@draws
@writes
@JSON
def tune(machine: str, options: TuningDrives, save: str | None, plots: Plots, as_json: bool) -> None:
    """Kv, Kp, Tn of all drives, and what limits each; margins, bandwidth and compliance with them.

    As `control --tune`, which keeps the gains of the file without that option.
    """
    _control(machine, options, save, plots, as_json)


def _control(machine: str, options: TuningDrives, save: str | None, plots: Plots, as_json: bool) -> None:
    from symoro_elastic.analysis.control.control import with_gains
    from symoro_elastic.api import control as operations

    full_machine = read_for(options.scene, machine)
    operation = operations.control if isinstance(options, Controlling) else operations.tune
    with progress_bar("control") as progress:
        result = call(operation, full_machine, options, progress=progress)
    if save:
        save_machine(with_gains(full_machine, result), save, machine)
    print_result(result, as_json, save)
    plots.write(result.plots)


@command("lobes")
@MACHINE
@takes(Cutting)
@draws
@writes
@JSON
def lobes(machine: str, options: Cutting, plots: Plots, as_json: bool) -> None:
    """Maximum depth of cut without regenerative chatter, by speed and position.

    Loops of [drives] are closed, motors without a drive are held. Exact for forces of constant direction, as in
    turning; in milling (--across) by the mean of the forces over a turn, and exact with many --intervals.
    """
    from symoro_elastic.api import control as operations

    full_machine = read_for(options.scene, machine)
    with progress_bar("lobes") as progress:
        result = call(operations.lobes, full_machine, options, progress=progress)
    print_result(result, as_json)
    plots.write(result.plots)
