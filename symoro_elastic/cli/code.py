"""Commands that make code and equations: generate, check, equations."""

from __future__ import annotations

from pathlib import Path

import click

from symoro_elastic.cli.options import BASE, FOLD, JSON, MACHINE, MODEL, SCENE
from symoro_elastic.cli.output import counted, print_json, print_table, steps, write_text
from symoro_elastic.cli.reading import among, read, scene_of
from symoro_elastic.errors import InputError


@click.command()
@MACHINE
@MODEL
@click.option("--target", "targets", metavar="NAME", multiple=True, help="numpy or c; both unless said.")
@click.option("--out", default="generated", show_default=True, type=click.Path(), help="Folder of generated machines.")
@FOLD
@BASE
@SCENE
@JSON
def generate(
    machine: str,
    models: tuple[str, ...],
    targets: tuple[str, ...],
    out: str,
    fold: tuple[str, ...],
    base: bool,
    scene: str | None,
    as_json: bool,
) -> None:
    """Write the models of MACHINE as code to OUT/<machine name>/."""
    from symoro_elastic.codegen.targets import TARGETS
    from symoro_elastic.generate import generate
    from symoro_elastic.report.tables import models_json, models_table

    chosen = among(targets, TARGETS, "--target") or tuple(TARGETS)
    with steps() as step:
        step("read")
        found = read(machine, base)
        asked = scene_of(found, scene, models, fold)
        made = generate(found, asked, chosen, Path(out), step)
    if as_json:
        print_json({"written": [str(p) for p in made.written], "models": models_json(made.models, made.whole)})
        return
    click.echo(f"wrote {made.written[0].parent}: {', '.join(path.name for path in made.written)}")
    print_table(models_table(made.models, made.whole))
    click.echo("x products and divisions, + sums and differences")


@click.command()
@MACHINE
@MODEL
@FOLD
@BASE
@SCENE
@click.option("--seed", default=0, show_default=True, help="Chooses the random states.")
@JSON
def check(
    machine: str,
    models: tuple[str, ...],
    fold: tuple[str, ...],
    base: bool,
    scene: str | None,
    seed: int,
    as_json: bool,
) -> None:
    """Compile the C, and compare C, numpy and the equations on floats with 50 digits.

    At random and at extreme states; exit code 1 where an error is out of bounds.
    """
    from symoro_elastic.codegen.compile import CompilationFailed
    from symoro_elastic.generate import refuse_degenerate
    from symoro_elastic.numerics.values import NoValues
    from symoro_elastic.numerics.verify import refuse_unverifiable, verify
    from symoro_elastic.report.tables import verification_json, verification_table

    found = read(machine, base)
    asked = scene_of(found, scene, models, fold)
    refuse_degenerate(found, asked)
    refuse_unverifiable(found, asked)
    try:
        with counted("verify") as progress:
            result = verify(found, asked, seed=seed, progress=progress)
    except (CompilationFailed, NoValues) as error:
        raise InputError(machine, "check", str(error)) from None
    if as_json:
        print_json(verification_json(result))
    else:
        print_table(verification_table(result), f"{found.name}: worst relative error, moderate / extreme states")
        verdict = "every error is within its bound" if result.ok else "out of bounds"
        click.echo(f"{result.states} states against 50 digits: {verdict}")
    if result.missing:
        raise InputError(machine, "C compiler", result.missing)
    if not result.ok:
        raise SystemExit(1)


@click.command()
@MACHINE
@click.option("--model", default="direct_dynamics", show_default=True, metavar="NAME", help="Model to write out.")
@click.option("--format", "form", default="latex", show_default=True, metavar="NAME", help="latex, html or pdf.")
@click.option("--out", metavar="FILE", type=click.Path(), help="File to write; standard output unless said.")
@FOLD
@SCENE
def equations(machine: str, model: str, form: str, out: str | None, fold: tuple[str, ...], scene: str | None) -> None:
    """Write the equations of a model with their intermediate variables, in order."""
    from symoro_elastic.generate import described
    from symoro_elastic.report.page import html_page, latex_document
    from symoro_elastic.report.pdf import pdf

    among((form,), ("latex", "html", "pdf"), "--format")
    with steps() as step:
        step("trace")
        found = read(machine)
        package = described(found, scene_of(found, scene, (model,), fold))
        step("render")
        text = (html_page if form == "html" else latex_document)(package, package.functions[0])
        if form == "pdf":
            step("compile")
            out = str(pdf(text, Path(out or f"{found.name}_{model}.pdf")))
    if out is None:
        click.echo(text, nl=False)
        return
    if form != "pdf":
        write_text(text, out)
    click.echo(f"wrote {out}", err=True)
