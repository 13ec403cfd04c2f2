"""Commands that make code and equations: generate, check, equations."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from symoro_elastic.api import kinds
from symoro_elastic.api.declaration import Options, in_si_units, option, part, switch
from symoro_elastic.api.options import Certifying, Checking, Generating, Reading, Writing
from symoro_elastic.cli.listed import command
from symoro_elastic.cli.options import JSON, MACHINE, call, takes, writes
from symoro_elastic.cli.output import echo, print_result, progress_bar, staged_progress, steps, write_text
from symoro_elastic.cli.reading import note, read, read_for, scene_of, warn
from symoro_elastic.foundation.errors import InputError, among
from symoro_elastic.foundation.file_forms import EQUATIONS, form_of

DOCUMENTS = ("latex", "html", "pdf")


@command("generate")
@MACHINE
@takes(Generating)
@takes(Reading, "reading", "base", "free")
@writes
@JSON
def generate(machine: str, options: Generating, reading: Reading, as_json: bool) -> None:
    """Write the files to OUT/<machine name>/."""
    from symoro_elastic.api import models as api

    build = api.build_of(options)
    with staged_progress() as (announce, progress):
        full_machine = read(machine, reading, announce)
        options = in_si_units(full_machine, options)
        scene = replace(scene_of(full_machine, options), merge_angles=options.merge_angles)
        generated = build.written(full_machine, scene, replace(options, announce=announce, progress=progress), warn)
    if scene.merge_angles is not None and not any(model.merged for model in generated.models):
        note("merging angles saves no operations in these models, so none were merged")
    print_result(generated, as_json)


class Proof(Options):
    """Option to prove errors for a box rather than measure them at states."""

    proven: bool = switch(
        "Prove ranges and rounding errors of results for all positions within [limits].", formerly=("--box",)
    )


@command("check")
@MACHINE
@takes(Certifying)
@takes(Proof, "proof")
@takes(Reading, "reading", "base", "free")
@click.option(
    "--self",
    "by_itself",
    is_flag=True,
    help="Count the digits that agree in the four rounding modes, without a reference.",
)
@JSON
def check(machine: str, options: Certifying, proof: Proof, reading: Reading, by_itself: bool, as_json: bool) -> None:
    """Compile the C; compare C, numpy and the equations in floats at random and at extreme states.

    With --proven bounds are those of all states within the limits, and divisors that may be zero are named: no draw of
    states is used. --precision, --limits, --sub-boxes and --polynomials belong to it. Exit code 1 where an error is out
    of bounds.
    """
    from symoro_elastic.api import models as api

    if proof.proven and by_itself:
        raise InputError("symoro-elastic", "--proven", "and --self exclude each other: give one of them")
    if proof.proven:
        _certify(machine, options, reading, as_json)
        return
    _refuse_proof_options(options)
    if by_itself:
        _check_by_itself(machine, options, reading, as_json)
        return
    with staged_progress() as (announce, progress):
        full_machine = read(machine, reading, announce)
        scene_of(full_machine, options)
        result = call(api.check, full_machine, part(Checking, options), announce=announce, progress=progress)
    print_result(result, as_json)
    if result.missing:
        raise InputError(machine, "C compiler", result.missing)
    if not result.ok:
        raise SystemExit(1)


def _refuse_proof_options(options: Certifying) -> None:
    """Raise `InputError` for options that belong to a proof."""
    usual = Certifying()
    for name, flag in (
        ("precisions", "--precision"),
        ("limits", "--limits"),
        ("sub_boxes", "--sub-boxes"),
        ("polynomials", "--polynomials"),
    ):
        if getattr(options, name) != getattr(usual, name):
            raise InputError("symoro-elastic", flag, "belongs to a proof: add --proven, or leave it out")


def _certify(machine: str, options: Certifying, reading: Reading, as_json: bool) -> None:
    """Print the certificates of models."""
    from symoro_elastic.api import models as api

    with staged_progress() as (announce, progress):
        full_machine = read(machine, reading, announce)
        certificates = call(api.certify, full_machine, options, announce=announce, progress=progress)
    print_result(certificates, as_json)


def _check_by_itself(machine: str, options: Certifying, reading: Reading, as_json: bool) -> None:
    """Print the digits of results that agree in the four rounding modes, for `check --self`."""
    from symoro_elastic.api import models as api

    full_machine = read_for(options, machine, reading)
    with progress_bar("verify") as progress:
        checked = api.check_by_itself(full_machine, replace(part(Checking, options), progress=progress))
    print_result(checked, as_json)


class Document(Options):
    """Format of equations, and their file."""

    format: str | None = option(
        None, "NAME", "Format: {names} (default: that of the suffix of --out, else latex).", names=lambda: DOCUMENTS
    )
    out: str | None = option(
        None, "FILE", "File to write: .tex, .html or .pdf (default: standard output).", kinds.output_file(*EQUATIONS)
    )

    def __post_init__(self) -> None:
        if self.format is not None:
            among((self.format,), DOCUMENTS, "--format")
        if self.format and self.out and self.form != self.format:
            what = f"{self.out} is not a file of {self.format}: leave --format out, or end the name otherwise"
            raise InputError("symoro-elastic", "--format", what)

    @property
    def form(self) -> str:
        """The format: that of the file, of --format, or LaTeX."""
        return EQUATIONS[form_of(self.out, EQUATIONS, "--out")] if self.out else self.format or "latex"


@command("equations")
@MACHINE
@takes(Writing)
@takes(Document, "document")
@writes
def equations(machine: str, options: Writing, document: Document) -> None:
    """With their intermediate variables, in the order of evaluation; several models make one page."""
    from symoro_elastic.api import models as api
    from symoro_elastic.pages.equations.pdf import find_engine, pdf

    if document.form == "pdf":
        find_engine(machine)
    with steps() as announce:
        full_machine = read(machine, announce=announce)
        scene_of(full_machine, options)
        written = call(api.equations, full_machine, options, announce=announce)
        announce("render")
        text, out = written.html if document.form == "html" else written.latex, document.out
        if document.form == "pdf":
            announce("compile")
            out = str(pdf(text, Path(out or f"{full_machine.name}_{'_'.join(written.models)}.pdf")))
    if out is None:
        echo(text, nl=False)
        return
    if document.form != "pdf":
        write_text(text, out)
    echo(f"wrote {out}", err=True)
