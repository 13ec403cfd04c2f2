"""The target `st`: function blocks of Structured Text (IEC 61131-3) for programmable controllers, in one file."""

from __future__ import annotations

import math
from collections.abc import Iterator

from symoro_elastic.codegen.local_names import with_local_names, with_own_results
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.precision import DOUBLE, SINGLE, Precision
from symoro_elastic.codegen.st.function import LONGEST_BLOCK, START, StBlock, StForm, StFunction
from symoro_elastic.codegen.st.lines import comment
from symoro_elastic.codegen.st.steps import step_blocks
from symoro_elastic.codegen.target import Target
from symoro_elastic.codegen.targets.c import sentences
from symoro_elastic.codegen.templates import render

TYPES = {DOUBLE.name: ("LREAL", ""), SINGLE.name: ("REAL", "_f32")}
"""Types of numbers and suffixes of names, by precision."""
ORDER = (
    "The order of operations is that of the C of the same models, without contraction of products and sums. "
    "Controllers that compute in registers of 80 bits, or have sines of their own, may differ in the last digits."
)
MEMORY = (
    "Variables keep their values between calls: an instance of a block serves one task. "
    "What depends on parameters only is computed at the first call."
)


def render_st(package: Package, precision: Precision = DOUBLE, longest: int = LONGEST_BLOCK) -> Files:
    """Return `<name>.st`, or `<name>_f32.st`; blocks have at most `longest` statements.

    Parameters without a value are inputs of the blocks. Raises `InputError` for time steps that are not written.
    """
    type_, suffix = TYPES[precision.name]
    package = with_local_names(with_own_results(package), ())
    form = StForm(package, type_, suffix)
    ordered = sorted(
        package.functions, key=lambda f: not f.name.endswith(START)
    )  # blocks are declared before their use
    functions = {f.name: StFunction(form, f, longest) for f in ordered}
    blocks = [block for function in functions.values() for block in function.blocks()]
    blocks += step_blocks(form, functions, package.source or package.name)
    context = {
        "head": list(_head(package, precision, form)),
        "types": [(length, name) for length, name in form.types.items() if length],
        "called": form.called,
        "functions": form.functions,
        "real": type_,
        "zero": form.number(0.0),
        "one": form.number(1.0),
        "pi": form.number(math.pi),
        "half_pi": form.number(math.pi / 2),
        "blocks": [vars(block) | {"comment": _comment(block), "interface": _interface(block)} for block in blocks],
    }
    return {f"{package.name}{suffix}.st": render("st/model.st.j2", **context)}


def _head(package: Package, precision: Precision, form: StForm) -> Iterator[str]:
    """Comments at the beginning of the file."""
    yield from comment(f"{package.name}: models as function blocks of Structured Text (IEC 61131-3).")
    for sentence in sentences(package, precision):
        yield from comment(sentence)
    yield from comment(ORDER)
    yield from comment(MEMORY)
    for wanted, given in form.names.changed.items():
        yield from comment(f"{wanted} is called {given} here.")


def _comment(block: StBlock) -> list[str]:
    return [line for text in block.about for line in comment(text, "  ")]


def _interface(block: StBlock) -> list[tuple[str, list[str]]]:
    """Declaration sections of a block with their lines, without empty arrays."""
    sections = (("VAR_INPUT", block.inputs), ("VAR_IN_OUT", block.in_outs), ("VAR_OUTPUT", block.results))
    return [(name, [line for array in arrays for line in array.declaration]) for name, arrays in sections if arrays]


ST = Target(
    name="st",
    title="Structured Text (IEC 61131-3): a function block a model",
    suffixes=(".st",),
    precisions=(DOUBLE, SINGLE),
    reserved=frozenset(),
    files=render_st,
)
