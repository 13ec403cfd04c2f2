"""The command view: a page on which the machine moves."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from symoro_elastic.cli.options import AT, MACHINE, VALUE, InputFile, OutputFile, writes
from symoro_elastic.cli.output import staged
from symoro_elastic.cli.reading import read, scene_of
from symoro_elastic.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.drawing.motions import Played
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.simulation.reference import Reference


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
    from symoro_elastic.drawing.page import machine_page
    from symoro_elastic.drawing.shown import shown_machine
    from symoro_elastic.machine.named_cells import with_values
    from symoro_elastic.machine.restrict import restricted
    from symoro_elastic.output_files import write_text

    whole = read(machine)
    found = restricted(whole, scene_of(whole, scene))
    found = with_values(found, values) if values else found
    shown = shown_machine(found, positions, list(_played(whole, found, scene or machine)))
    page = machine_page(shown)
    for remark in (*shown.remarks, *(one.remark for one in shown.motions if one.remark)):
        click.echo(f"note: {remark}", err=True)
    write_text(page, out, "--out")
    click.echo(f"wrote {out}")


def _played(whole: Machine, machine: Machine, source: str) -> Iterator[Played]:
    """The motions of a file, simulated where that is possible."""
    from symoro_elastic.machine.formats.motions import read_motions
    from symoro_elastic.simulation.reference import reference_of

    if Path(source).suffix.lower() == ".toml":
        for motion in read_motions(source, whole):
            yield _simulated(reference_of(machine, motion))


def _simulated(reference: Reference) -> Played:
    """A motion as it is simulated; its reference where it cannot be, with the reason."""
    from symoro_elastic.codegen.compile import CompilationFailed, CompilerMissing
    from symoro_elastic.drawing.motions import reference_motion, simulated_motion
    from symoro_elastic.model_ladder.simulate import Request, simulate

    try:
        with staged("predict") as (announce, progress):
            return simulated_motion(simulate(reference, Request(), announce, progress))
    except (InputError, CompilerMissing, CompilationFailed) as error:
        what = error.what if isinstance(error, InputError) else str(error)
        return reference_motion(reference, f"{reference.prescribed.place}: the reference only: {what}")
