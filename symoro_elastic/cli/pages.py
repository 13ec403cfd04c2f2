"""Commands that make pages to look at: view, live, report."""

from __future__ import annotations

import click

from symoro_elastic.api.options import Reporting, Serving, Viewing
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import MACHINE, InputFile, OutputFile, OutputPage, call, takes, writes
from symoro_elastic.cli.output import staged_progress
from symoro_elastic.cli.reading import note, read, scene_of
from symoro_elastic.foundation.file_forms import PAGES


@command("view")
@MACHINE
@click.option("--out", metavar="FILE", type=OutputFile(PAGES), required=True, help="Page to write: .html.")
@click.option("--beside", metavar="MACHINE", type=InputFile(), help="Machine that is shown beside it.")
@takes(Viewing)
@writes
def view(machine: str, out: str, beside: str | None, options: Viewing) -> None:
    """Write one file, for any browser, that needs no network.

    Bodies as boxes of equal inertia, joints, springs and frames, a slider for each motor, modes that move, and the
    motions of a scene beside their reference.
    """
    from symoro_elastic.api import drawings as api
    from symoro_elastic.foundation.output_files import write_text

    whole = read(machine)
    scene_of(whole, options.scene)
    other = read(beside) if beside else None
    with staged_progress("predict") as (announce, progress):
        page = call(api.view, whole, options, announce=announce, progress=progress)
        if other:
            page = page.beside(call(api.view, other, options, announce=announce, progress=progress))
        html = page.html
    for remark in page.remarks:
        note(remark)
    write_text(html, out, "--out")
    click.echo(f"wrote {out}")


@command("live")
@MACHINE
@takes(Serving)
def live(machine: str, options: Serving) -> None:
    """Serve it on this computer, at the address that is printed, until Ctrl+C: picture, modes, warnings, base
    parameters, operations, equations. What any editor saves is shown at once; cells of a .toml file are written back.
    """
    from symoro_elastic.api import pages

    pages.live(machine, options, lambda address: click.echo(f"{address}\nCtrl+C ends it."))


@command("report")
@MACHINE
@click.option(
    "--out", metavar="PATH", type=OutputPage(), required=True, help="Page to write: .html; or the folder of the page."
)
@takes(Reporting)
@writes
def report(machine: str, out: str, options: Reporting) -> None:
    """Show picture, table, modes with pictures, frequency responses, what a scene with [motion] and [wanted] requires,
    operation counts, accuracy, equations whose symbols lead to their definitions. It needs no network.
    """
    from symoro_elastic.api import pages

    whole = read(machine)
    scene_of(whole, options.scene)
    with staged_progress("machine") as (announce, progress):
        page = call(pages.report, whole, options, announce=announce, progress=progress)
    click.echo(f"wrote {page.save(out)}")
