"""What every target says of a package and of its functions."""

from __future__ import annotations

import textwrap
from typing import Any

from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.templates import LINE
from symoro_elastic.symbolic.program import OperationCount

Files = dict[str, str]
SOLVED = ("qdd", "dqdd", "V0d", "dV0d")
SINGULAR = "accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular"


def count_text(count: OperationCount) -> str:
    """Operations in words: `292x 277+, 10 sin/cos`."""
    return f"{count.products}x {count.add}+, {count.sincos} sin/cos"


def shared(package: Package) -> dict[str, Any]:
    """What the templates of a whole package are told."""
    return {
        "name": package.name,
        "summary": package.scene,
        "joints": package.axes,
        "motors": package.motors,
        "elastic": package.elastic,
        "frames": package.frames,
    }


def described(function: Function) -> dict[str, Any]:
    """What the templates are told of a function."""
    program = function.program
    counts = f"{count_text(program.count)} a call"
    if program.once:
        counts += f"; {count_text(program.count_once)} once for each parameter set"
    arguments = [f"{a.name} ({a.size}): {a.meaning}" for a in function.arguments]
    results = [f"{r.name} {_shape(r.shape)}: {r.meaning}" for r in function.results]
    more = [*_singular(function), *_rows(function), *_columns(function)]
    return {
        "name": function.name,
        "title": function.title[:1].upper() + function.title[1:],
        "equations": function.equations,
        "counts": counts,
        "documented": [*arguments, *(f"-> {text}" for text in results), *more],
    }


def _singular(function: Function) -> list[str]:
    """What accelerations are where there is nothing to divide by; motors may give all of them."""
    given = [(argument.size,) for argument in function.arguments if argument.name == "qdd_motor"]
    solved = [r for r in function.results if r.name.startswith(SOLVED) and (r.name != "qdd" or r.shape not in given)]
    return [SINGULAR] if solved else []


def _rows(function: Function) -> list[str]:
    """Rows of results, in lines, where a scene has chosen them."""
    chosen = [result for result in function.results if result.rows and not result.whole]
    texts = [f"rows of {result.name}: {', '.join(result.rows)}" for result in chosen]
    return [line for text in texts for line in textwrap.wrap(text, LINE)]


def _columns(function: Function) -> list[str]:
    """Labels of columns, in lines: once where all results have the same."""
    texts = [f"columns of {r.name}: {', '.join(r.columns)}" for r in function.results if r.columns]
    if function.columns:
        texts = [f"columns: {', '.join(function.columns)}"]
    return [line for text in texts for line in textwrap.wrap(text, LINE)]


def _shape(shape: tuple[int, ...]) -> str:
    return "(" + " x ".join(map(str, shape)) + ")"
