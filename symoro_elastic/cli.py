"""The command line: generate, check, show, equations, identify. Heavy imports wait until they are needed."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from symoro_elastic import __version__
from symoro_elastic.errors import InputError

if TYPE_CHECKING:
    from symoro_elastic.machine.machine import Machine
    from symoro_elastic.machine.scene import Scene

MACHINE = click.argument("machine", metavar="MACHINE", type=click.Path())
MODEL = click.option("--model", "models", metavar="NAME", multiple=True, help="Model to make; may be repeated.")
FOLD = click.option("--fold", metavar="NAME|all", multiple=True, help="Parameter to make a constant; may be repeated.")
BASE = click.option("--base", is_flag=True, help="Group the inertial parameters first.")
SCENE = click.option(
    "--scene", metavar="FILE", type=click.Path(), help="TOML file saying what is asked of the machine."
)
JSON = click.option("--json", "as_json", is_flag=True, help="Print figures as one JSON object.")


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="symoro-elastic")
def cli() -> None:
    """Symbolic models of robots and machine tools with elastic joints, as standalone numpy and C code.

    MACHINE is a .toml file or a SYMORO .par file.
    """


@cli.command()
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

    chosen = _known(targets, TARGETS, "--target") or tuple(TARGETS)
    with _progress() as step:
        step("read")
        found = _read(machine, base)
        asked = _scene(found, scene, models, fold)
        made = generate(found, asked, chosen, Path(out), step)
    if as_json:
        _print_json({"written": [str(p) for p in made.written], "models": models_json(made.models, made.whole)})
        return
    click.echo(f"wrote {made.written[0].parent}: {', '.join(path.name for path in made.written)}")
    _print_table(models_table(made.models, made.whole))
    click.echo("x products and divisions, + sums and differences")


@cli.command()
@MACHINE
@SCENE
@JSON
def show(machine: str, scene: str | None, as_json: bool) -> None:
    """Print the table of MACHINE, its parameters, and what is degenerate."""
    from symoro_elastic.generate import found_degeneracies
    from symoro_elastic.grouping import base_formulas, checked_grouping, conditioning_text
    from symoro_elastic.machine.machine import Kind
    from symoro_elastic.machine.restrict import restricted
    from symoro_elastic.report.tables import machine_table

    found = _read(machine)
    asked = _scene(found, scene, (), ())
    kept = restricted(found, asked)
    degenerate = [f"{joints}: {message}" for message, joints in found_degeneracies(found, asked)]
    grouping, cross_check = checked_grouping(kept)
    if as_json:
        by_kind = {k: [joint.name for joint in kept.joints if joint.kind is k] for k in Kind}
        _print_json(
            {
                "name": kept.name,
                "joints": [kept.joints[j - 1].name for j in kept.moving],
                "motors": by_kind[Kind.MOTOR],
                "elastic": by_kind[Kind.ELASTIC],
                "parameters": [p.name for p in kept.parameters],
                "base_parameters": base_formulas(grouping, cross_check),
                "base_parameters_check": cross_check.message,
                "base_parameters_condition": cross_check.conditioning.condition,
                "degenerate": degenerate,
            }
        )
        return
    _print_table(machine_table(kept), kept.name)
    for parameter in kept.parameters:
        click.echo(f"{parameter.name} = {parameter.value or 'no value'} {parameter.unit}".rstrip())
    click.echo(f"\nbase inertial parameters: {cross_check.message}")
    for name, formula in base_formulas(grouping, cross_check).items():
        click.echo(f"  {name} = {formula}")
    click.echo(conditioning_text(cross_check))
    click.echo("\n".join(f"degenerate: {message}" for message in degenerate) or "no degenerate joints")


@cli.command()
@MACHINE
@click.argument("file", metavar="FILE", type=click.Path())
@BASE
def convert(machine: str, file: str, base: bool) -> None:
    """Write MACHINE to FILE, a .toml or a .par, with its base inertial parameters only if asked."""
    from symoro_elastic.machine.formats import write_machine

    if Path(file).exists():
        raise InputError(file, "FILE", "exists already: choose another name, or remove it")
    write_machine(_read(machine, base), file)
    click.echo(f"wrote {file}")


@cli.command()
@JSON
def models(as_json: bool) -> None:
    """List the models with their arguments, results, shapes, units and equations."""
    from symoro_elastic.report.tables import catalogue_json, catalogue_table

    if as_json:
        _print_json(catalogue_json())
    else:
        _print_table(catalogue_table())
        click.echo(
            "n joints that move, m motors; frames: all rows of the table, or those a scene asks for "
            "('tool in ram' is seen from ram); a point of a body is a fixed row of the table"
        )


@cli.command()
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

    found = _read(machine, base)
    asked = _scene(found, scene, models, fold)
    refuse_degenerate(found, asked)
    refuse_unverifiable(found, asked)
    try:
        with _counted("verify") as progress:
            result = verify(found, asked, seed=seed, progress=progress)
    except (CompilationFailed, NoValues) as error:
        raise InputError(machine, "check", str(error)) from None
    if as_json:
        _print_json(verification_json(result))
    else:
        _print_table(verification_table(result), f"{found.name}: worst relative error, moderate / extreme states")
        verdict = "every error is within its bound" if result.ok else "out of bounds"
        click.echo(f"{result.states} states against 50 digits: {verdict}")
    if result.missing:
        raise InputError(machine, "C compiler", result.missing)
    if not result.ok:
        raise SystemExit(1)


@cli.command()
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

    _known((form,), ("latex", "html", "pdf"), "--format")
    with _progress() as step:
        step("trace")
        found = _read(machine)
        package = described(found, _scene(found, scene, (model,), fold))
        step("render")
        text = (html_page if form == "html" else latex_document)(package, package.functions[0])
        if form == "pdf":
            step("compile")
            out = str(pdf(text, Path(out or f"{found.name}_{model}.pdf")))
    if out is None:
        click.echo(text, nl=False)
        return
    if form != "pdf":
        _write(text, out)
    click.echo(f"wrote {out}", err=True)


@cli.command()
@MACHINE
@click.argument("data", metavar="DATA...", nargs=-1, required=True, type=click.Path())
@click.option("--value", "values", metavar="NAME=X", multiple=True, help="Value of a parameter, lengths say.")
@click.option("--known", metavar="LABEL=X", multiple=True, help="Value of a column that is not to be estimated.")
@click.option("--bandwidth", type=float, metavar="HZ", help="Of the motion, where its spectrum is not to decide.")
@click.option("--plots", metavar="FOLDER", type=click.Path(), help="Draw measured and predicted torques there.")
@JSON
def identify(
    machine: str,
    data: tuple[str, ...],
    values: tuple[str, ...],
    known: tuple[str, ...],
    bandwidth: float | None,
    plots: str | None,
    as_json: bool,
) -> None:
    """Estimate the parameters of MACHINE from measurements: CSV or NPZ with t, q_<joint>, tau_<motor>."""
    from symoro_elastic.identification import identify as identification
    from symoro_elastic.identification.measurements import read_measurements
    from symoro_elastic.identification.plots import plot

    found = _read(machine)
    with _progress() as step:
        step("read")
        records = [read_measurements(path, found) for path in data]
        result = identification.identify(
            found, records, _numbers(values, "--value"), _numbers(known, "--known"), bandwidth, step=step
        )
    if as_json:
        _print_json(identification.as_json(result))
    else:
        click.echo(identification.table(result))
        click.echo("\n".join(result.notes))
    if plots:
        written = plot(result, plots)
        click.echo(f"wrote {plots}: {', '.join(path.name for path in written)}", err=True)


def main() -> None:
    """Run the command line; whatever a user can mend ends in one line on stderr and exit code 2."""
    try:
        code = cli.main(args=sys.argv[1:] or ["--help"], standalone_mode=False)
    except InputError as error:
        code = _fail(str(error))
    except click.ClickException as error:
        code = _fail(_usage(error))
    except click.Abort:
        code = 130
    except BrokenPipeError:
        code = 0
    sys.exit(code if isinstance(code, int) else 0)


def _fail(line: str) -> int:
    click.echo("error: " + " ".join(line.split()), err=True)
    return 2


def _usage(error: click.ClickException) -> str:
    command = getattr(getattr(error, "ctx", None), "command_path", "symoro-elastic")
    return f"{command}: {error.format_message()} See {command} --help"


def _read(path: str, base: bool = False) -> Machine:
    from symoro_elastic.machine.formats import read_machine

    machine, warnings = read_machine(path)
    for warning in warnings:
        click.echo(f"warning: {warning}", err=True)
    if not base:
        return machine
    from symoro_elastic.grouping import base_machine

    return base_machine(machine)


def _scene(machine: Machine, file: str | None, models: Sequence[str], fold: Sequence[str]) -> Scene:
    """The scene of the file or of the machine, with what the command line adds."""
    from dataclasses import replace

    from symoro_elastic.machine.formats import read_scene
    from symoro_elastic.machine.resolve import resolve
    from symoro_elastic.machine.scene import ALL, Scene
    from symoro_elastic.models.catalogue import MODELS

    scene = read_scene(file, machine, MODELS) if file else machine.scene or Scene()
    if models:
        scene = replace(scene, models=tuple(dict.fromkeys(models)))
    if fold:
        everything = ALL in fold or scene.fold == ALL
        scene = replace(scene, fold=ALL if everything else (*scene.fold, *fold))
    return resolve(scene, machine, MODELS, file or machine.source)


def _known(names: Sequence[str], known: Sequence[str] | dict[str, Any], option: str) -> tuple[str, ...]:
    for name in names:
        if name not in known:
            raise InputError("symoro-elastic", option, f"there is no {name!r}: choose from {', '.join(known)}")
    return tuple(dict.fromkeys(names))


def _numbers(given: Sequence[str], option: str) -> dict[str, float]:
    """`NAME=X` by name."""
    found = {}
    for text in given:
        name, _, number = text.partition("=")
        try:
            found[name.strip()] = float(number)
        except ValueError:
            raise InputError("symoro-elastic", option, f"{text!r} is not NAME=NUMBER") from None
    return found


def _print_json(figures: dict[str, Any]) -> None:
    click.echo(json.dumps(figures))


def _print_table(table: Any, title: str = "") -> None:
    from rich import box
    from rich.console import Console

    table.box, table.title = box.SIMPLE_HEAD, title or None
    Console(highlight=False, width=None if sys.stdout.isatty() else 160).print(table)


def _write(text: str, out: str) -> None:
    from symoro_elastic.machine.formats.files import save_text

    save_text(text, out)


@contextmanager
def _counted(step: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on a terminal's stderr, and nothing elsewhere."""
    if not sys.stderr.isatty():
        yield lambda _done, _total: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(step)
        yield lambda done, total: bar.update(task, completed=done, total=total)


@contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """Shows the current step on a terminal's stderr, and nothing elsewhere."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console

    with Console(stderr=True).status("read") as status:
        yield status.update
