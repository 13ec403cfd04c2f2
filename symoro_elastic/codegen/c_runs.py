"""Functions of C that carry out many time steps, one after another."""

from __future__ import annotations

from dataclasses import dataclass

from symoro_elastic.codegen.c_lines import INDENT, fitted, with_arguments
from symoro_elastic.codegen.c_steps import CSteps, StepText
from symoro_elastic.codegen.templates import render


@dataclass(frozen=True)
class Run:
    """A function that carries out many steps: arrays that are read, each with its length for a step, and written ones.

    Arrays that are `kept` are the same for all steps. `head` and `call` are those of the function and of its steps.
    """

    name: str
    read: dict[str, int]
    kept: tuple[str, ...]
    written: dict[str, int]
    head: str
    call: str


def runs(text: CSteps) -> list[Run]:
    """Return the functions that carry out many steps, for each method and way to give the motors."""
    return [_run(step, bool(text.constants)) for step in text.steps if not step.with_error]


def _run(step: StepText, prepared: bool) -> Run:
    read, written = ({array.name: array.entries for array in arrays} for arrays in (step.read, step.written))
    constant = [f"const double *{name}" for name in read]
    states = [f"double *{name}" for name in written]
    head = [*("size_t steps", *constant, "double h", "const double *p", *states), "double *record"]
    kept = step.variant.of_step
    rows = [name if name in kept else f"{name} + s*{size}U" for name, size in read.items()]
    call = [*rows, "h", "p", *(["c"] if prepared else []), *written]
    name = f"{step.name}_prepared" if prepared else step.name
    return Run(
        name=step.name,
        read=read,
        kept=kept,
        written=written,
        head=with_arguments(f"void {step.name}_run", head),
        call=with_arguments(f"{INDENT * 2}{name}", call, ");"),
    )


def render_runs(name: str, text: CSteps) -> dict[str, str]:
    """Return the file of the functions that carry out many steps of a package, in double precision."""
    made = render("c/run.c.j2", name=name, macro=text.macro, constants=text.constants, runs=runs(text))
    return {f"{name}_run.c": fitted(made)}
