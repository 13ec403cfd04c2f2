"""Commands that make pages to look at: view, live, report."""

from __future__ import annotations

import click

from symoro_elastic.api.options import Reporting, Serving, Viewing
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import MACHINE, InputFile, OutputFile, OutputPage, call, takes, writes
from symoro_elastic.cli.output import echo, staged_progress
from symoro_elastic.cli.reading import note, read, read_for
from symoro_elastic.foundation.file_forms import PAGES


@command("view")
@MACHINE
@click.option("--out", metavar="FILE", type=OutputFile(PAGES), required=True, help="Page to write: .html.")
@click.option("--beside", metavar="MACHINE", type=InputFile(), help="Second machine on the page.")
@takes(Viewing)
@writes
def view(machine: str, out: str, beside: str | None, options: Viewing) -> None:
    """Write one file, for any browser, that needs no network.

    Bodies as boxes of equal inertia, joints, springs and frames, a slider for each motor, modes that move, and the
    motions of a scene with their reference.
    """
    from symoro_elastic.api import drawings as api
    from symoro_elastic.foundation.output_files import write_text

    full_machine = read_for(options.scene, machine)
    other = read(beside) if beside else None
    with staged_progress("predict") as (announce, progress):
        page = call(api.view, full_machine, options, announce=announce, progress=progress)
        if other:
            page = page.beside(call(api.view, other, options, announce=announce, progress=progress))
        html = page.html
    for remark in page.remarks:
        note(remark)
    write_text(html, out, "--out")
    echo(f"wrote {out}")


@command("live")
@MACHINE
@takes(Serving)
def live(machine: str, options: Serving) -> None:
    """Serve it on this computer, at the printed address, until Ctrl+C: picture, modes, warnings, base
    parameters, operations, equations. Each save of any editor is shown at once; cells of a .toml file are written back.
    """
    from symoro_elastic.api import drawings

    drawings.live(machine, options, lambda address: echo(f"{address}\nCtrl+C ends it."))


@command("report")
@MACHINE
@click.option(
    "--out", metavar="PATH", type=OutputPage(), required=True, help="Page to write: .html; or the folder of the page."
)
@takes(Reporting)
@writes
def report(machine: str, out: str, options: Reporting) -> None:
    """Show picture, table, modes with pictures, frequency responses, requirements of a scene with [motion] and
    [wanted], operation counts, accuracy, equations whose symbols lead to their definitions. It needs no network.
    """
    from symoro_elastic.api import drawings

    full_machine = read_for(options.scene, machine)
    with staged_progress("machine") as (announce, progress):
        page = call(drawings.report, full_machine, options, announce=announce, progress=progress)
    echo(f"wrote {page.save(out)}")
