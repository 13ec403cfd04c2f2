"""The command report: one page about a machine."""

from __future__ import annotations

from pathlib import Path

import click

from symoro_elastic.cli.options import MACHINE, SCENE, VALUE, OutputFolder, writes
from symoro_elastic.cli.output import staged
from symoro_elastic.cli.reading import read, scene_of
from symoro_elastic.errors import InputError


@click.command()
@MACHINE
@click.option("--out", metavar="FOLDER", type=OutputFolder(), required=True, help="Folder of the page.")
@SCENE
@VALUE
@writes
def report(machine: str, out: str, scene: str | None, values: dict[str, float]) -> None:
    """Write one page about MACHINE, to read and to print.

    Picture, table, modes with pictures, frequency responses, what a scene with [motion] and [wanted] requires,
    operation counts, accuracy, equations whose symbols lead to their definitions. It needs no network.
    """
    from symoro_elastic.api import pages

    if Path(out).suffix == ".html":
        raise InputError("symoro-elastic", "--out", f"give the folder of the page, not {out!r}: it is named there")
    whole = read(machine)
    scene_of(whole, scene)
    with staged("machine") as (announce, progress):
        found = pages.report(whole, scene, values=values, announce=announce, progress=progress)
    click.echo(f"wrote {found.save(out)}")
