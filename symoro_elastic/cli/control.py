"""Commands about drives and cuts: control, lobes."""

from __future__ import annotations

import click

from symoro_elastic.api.options import Controlling, Cutting
from symoro_elastic.api.rows import WRITABLE
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import JSON, MACHINE, OutputMachine, Plots, call, draws, takes, writes
from symoro_elastic.cli.output import print_result, progress_bar, save_machine
from symoro_elastic.cli.reading import read, scene_of


@command("control")
@MACHINE
@takes(Controlling)
@click.option(
    "--save", metavar="FILE", type=OutputMachine(), help=f"Save the machine with the gains: {', '.join(WRITABLE)}."
)
@draws
@writes
@JSON
def control(machine: str, options: Controlling, save: str | None, plots: Plots, as_json: bool) -> None:
    """Margins, bandwidth and compliance with the loops of [drives] closed, and the spring, mass, lag or dead time that
    limits each gain; gains that the file calls "tuned" are found.
    """
    from symoro_elastic.analysis.control.control import with_gains
    from symoro_elastic.api import control as operations

    whole = read(machine)
    scene_of(whole, options.scene)
    with progress_bar("control") as progress:
        found = call(operations.control, whole, options, progress=progress)
    if save:
        save_machine(with_gains(whole, found), save, machine)
    print_result(found, as_json, save)
    plots.write(found.plots)


@command("lobes")
@MACHINE
@takes(Cutting)
@draws
@writes
@JSON
def lobes(machine: str, options: Cutting, plots: Plots, as_json: bool) -> None:
    """Waves that the tool leaves on the surface die out below this depth.

    Loops of [drives] are closed, motors without a drive are held. Exact for forces of constant direction, as in
    turning; in milling (--across) by the mean of the forces over a turn, and exact with many --intervals.
    """
    from symoro_elastic.api import control as operations

    whole = read(machine)
    scene_of(whole, options.scene)
    with progress_bar("lobes") as progress:
        found = call(operations.lobes, whole, options, progress=progress)
    print_result(found, as_json)
    plots.write(found.plots)
