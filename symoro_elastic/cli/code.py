"""Commands that make code and equations: generate, check, equations."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from symoro_elastic.cli import completion
from symoro_elastic.cli.options import (
    BASE,
    FOLD,
    FORM,
    FREE,
    JSON,
    MACHINE,
    MERGE_ANGLES,
    MODEL,
    ONLY,
    SCENE,
    OutputFile,
    OutputFolder,
    gather,
    writes,
)
from symoro_elastic.cli.output import counted, print_json, print_result, print_table, staged, steps, write_text
from symoro_elastic.cli.parsing import WholeRange, numbers, parsed_by
from symoro_elastic.cli.reading import Selection
from symoro_elastic.errors import InputError, among

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.scene import Scene


@dataclass(frozen=True)
class Reported:
    """Whether the C is compiled and reported on, by which compiler and with which options."""

    report: bool
    cc: str
    cflags: str


@click.command()
@MACHINE
@gather("selection", Selection)
@MODEL
@click.option(
    *("--target", "targets"),
    metavar="NAME",
    multiple=True,
    shell_complete=completion.TARGETS,
    help="Target: numpy, c (default: both), c-batch, cpp, matlab, cuda or fmu; may be repeated.",
)
@click.option(
    "--out", default="generated", show_default=True, type=OutputFolder(), help="Folder of generated machines."
)
@click.option(
    "--precision",
    "precisions",
    metavar="NAME",
    multiple=True,
    shell_complete=completion.PRECISIONS,
    help="Precision of the C code: double (default), single, mixed, double-double; may be repeated.",
)
@click.option("--report", is_flag=True, help="Report stack, size and instructions of the C code, compiled.")
@click.option("--cc", metavar="COMMAND", default="", help="Compiler of the report (default: that of this computer).")
@click.option("--cflags", metavar="OPTIONS", default="", help="Its options, after -O2, as in '-mcpu=cortex-m7'.")
@gather("reported", Reported)
@click.option("--fmi", type=WholeRange(2, 3), default=2, show_default=True, help="Version of FMI of an FMU.")
@click.option(
    "--at",
    "positions",
    metavar="JOINT=X",
    multiple=True,
    callback=parsed_by(numbers),
    help="Position of a motor where an FMU starts, rad or m (default 0); may be repeated.",
)
@FOLD
@FREE
@BASE
@ONLY
@SCENE
@MERGE_ANGLES
@FORM
@writes
@JSON
def generate(
    machine: str,
    selection: Selection,
    targets: tuple[str, ...],
    out: str,
    precisions: tuple[str, ...],
    reported: Reported,
    fmi: int,
    positions: dict[str, float],
    as_json: bool,
) -> None:
    """Generate C and numpy code for the models of MACHINE.

    The files go to OUT/<machine name>/.
    """
    from symoro_elastic.api import models as api
    from symoro_elastic.codegen.precision import DOUBLE, PRECISIONS
    from symoro_elastic.codegen.targets import DEFAULT_TARGETS, TARGETS
    from symoro_elastic.pipeline import TARGET_NAMES

    chosen = among(targets, TARGET_NAMES, "--target") or DEFAULT_TARGETS
    options = api.options_of_unit(chosen, selection.models, fmi, positions)
    if precisions and all(len(TARGETS[name].precisions) == 1 for name in chosen if name in TARGETS):
        raise InputError("symoro-elastic", "--precision", "is of the C code: add --target c, or leave it out")
    written_in = among(precisions, PRECISIONS, "--precision") or (DOUBLE.name,)
    tools = api.reporting(reported.report, reported.cc, reported.cflags, chosen)
    with steps() as announce:
        found, scene = selection.read(machine, announce)
        _warn_of_soft_springs(found, scene)
        made = api.written(found, out, chosen, scene, written_in, announce, tools, options)
    _warn_of_singular_starts(found, scene)
    if scene.merge_angles is not None and not any(model.merged for model in made.models):
        click.echo("note: sums of angles save nothing in these models, none was made", err=True)
    print_result(made, as_json)


def _warn_of_singular_starts(machine: Machine, scene: Scene) -> None:
    """Warn of loops that start next to a position where generated models give inf or NaN."""
    from symoro_elastic.machine.restrict import restricted
    from symoro_elastic.models.loops.description import described_loops, singular_starts

    for warning in singular_starts(described_loops(restricted(machine, scene))):
        click.echo(f"warning: {warning}", err=True)


def _warn_of_soft_springs(machine: Machine, scene: Scene) -> None:
    """Warn of a static spring that its load bends further than it bends back, motors at 0, where values are known."""
    if not scene.static:
        return
    from symoro_elastic.machine.restrict import restricted
    from symoro_elastic.vibration.soft_springs import SOFT, soft_static

    kept = restricted(machine, scene)
    try:
        weakest = soft_static(kept, {})
    except InputError:
        return
    if weakest:
        click.echo(f"warning: {scene.source or machine.label}: scene, static, {weakest}: {SOFT}", err=True)


@click.command()
@MACHINE
@gather("selection", Selection)
@MODEL
@FOLD
@FREE
@BASE
@ONLY
@SCENE
@FORM
@click.option("--seed", default=0, show_default=True, type=WholeRange(0), help="Seed of the random states.")
@click.option(
    "--self",
    "by_itself",
    is_flag=True,
    help="Count the digits that agree in the four rounding modes, without a reference.",
)
@JSON
def check(machine: str, selection: Selection, seed: int, by_itself: bool, as_json: bool) -> None:
    """Compare the generated code with 50-digit references.

    Compiles the C; C, numpy and the equations in floats are compared at random and at extreme states. Exit code 1
    where an error is out of bounds.
    """
    from symoro_elastic.api import models as api

    if by_itself:
        _check_by_itself(*selection.read(machine), seed, as_json)
        return
    with staged() as (announce, progress):
        found, asked = selection.read(machine, announce)
        result = api.check(found, scene=asked, seed=seed, announce=announce, progress=progress)
    print_result(result, as_json)
    if result.missing:
        raise InputError(machine, "C compiler", result.missing)
    if not result.ok:
        raise SystemExit(1)


def _check_by_itself(machine: Machine, scene: Scene, seed: int, as_json: bool) -> None:
    """`check --self`."""
    from symoro_elastic.codegen.compile import CompilationFailed, CompilerMissing
    from symoro_elastic.numerics.self_check import self_check
    from symoro_elastic.numerics.values import NoValues
    from symoro_elastic.numerics.verify import refuse_unverifiable
    from symoro_elastic.pipeline import in_form, refuse_degenerate
    from symoro_elastic.reports.self_check import least_digits, self_check_json, self_check_table

    source = machine.label
    refuse_degenerate(machine, scene)
    refuse_unverifiable(machine, scene)
    scene, _ = in_form(machine, scene)
    try:
        with counted("verify") as progress:
            found = self_check(machine, scene, seed=seed, progress=progress)
    except CompilerMissing as error:
        raise InputError(source, "C compiler", str(error)) from None
    except (CompilationFailed, NoValues) as error:
        raise InputError(source, "check --self", str(error)) from None
    if as_json:
        print_json(self_check_json(found))
        return
    print_table(self_check_table(found), f"{machine.name}: spread over the rounding modes, typical / worst")
    click.echo(f"at moderate states {least_digits(found):.1f} digits survive at worst")


@click.command()
@MACHINE
@gather("selection", Selection)
@click.option(
    *("--model",),
    default="direct_dynamics",
    show_default=True,
    metavar="NAME",
    shell_complete=completion.MODELS,
    help="Model to write out.",
)
@click.option(
    *("--format", "document"),
    default="latex",
    show_default=True,
    metavar="NAME",
    shell_complete=completion.DOCUMENTS,
    help="latex, html or pdf.",
)
@click.option("--out", metavar="FILE", type=OutputFile(), help="File to write (default: standard output).")
@FOLD
@ONLY
@SCENE
@writes
def equations(machine: str, selection: Selection, model: str, document: str, out: str | None) -> None:
    """Write the equations of a model as LaTeX, HTML or PDF.

    With their intermediate variables, in the order of evaluation.
    """
    from symoro_elastic.api import models as api
    from symoro_elastic.reports.pdf import find_engine, pdf

    among((document,), ("latex", "html", "pdf"), "--format")
    if document == "pdf":
        find_engine(machine)
    with steps() as announce:
        found, scene = replace(selection, models=(model,)).read(machine, announce)
        written = api.equations(found, scene=scene, announce=announce)
        announce("render")
        text = written.html if document == "html" else written.latex
        if document == "pdf":
            announce("compile")
            out = str(pdf(text, Path(out or f"{found.name}_{model}.pdf")))
    if out is None:
        click.echo(text, nl=False)
        return
    if document != "pdf":
        write_text(text, out)
    click.echo(f"wrote {out}", err=True)
