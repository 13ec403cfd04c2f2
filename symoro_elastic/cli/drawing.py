"""The command view: a page on which the machine moves."""

from __future__ import annotations

from pathlib import Path

import click

from symoro_elastic.cli.options import AT, MACHINE, VALUE, InputFile, OutputFile, writes
from symoro_elastic.cli.output import staged
from symoro_elastic.cli.reading import read, scene_of
from symoro_elastic.errors import InputError


@click.command()
@MACHINE
@click.option("--out", metavar="FILE", type=OutputFile(), required=True, help="Page to write: .html.")
@click.option(
    "--scene",
    metavar="FILE",
    type=InputFile(),
    help="TOML file whose joints are locked, and whose [motion] is simulated and played (default: those of MACHINE).",
)
@AT
@VALUE
@writes
def view(machine: str, out: str, scene: str | None, positions: dict[str, float], values: dict[str, float]) -> None:
    """Write a page that shows MACHINE and moves it.

    One file, for any browser, that needs no network: bodies as boxes of equal inertia, joints, springs and frames, a
    slider for each motor, modes that move, and the motions of a scene beside their reference.
    """
    from symoro_elastic.api import drawings as api
    from symoro_elastic.output_files import write_text

    whole = read(machine)
    if Path(out).suffix not in (".html", ".htm"):
        raise InputError("symoro-elastic", "--out", f"{out!r} is no page: end the name with .html")
    asked = scene_of(whole, scene)
    with staged("predict") as (announce, progress):
        page = api.view(whole, scene or asked, at=positions, values=values, announce=announce, progress=progress)
        html = page.html
    for remark in page.remarks:
        click.echo(f"note: {remark}", err=True)
    write_text(html, out, "--out")
    click.echo(f"wrote {out}")
