"""Texts on a package and its functions that all targets write."""

from __future__ import annotations

import textwrap
from typing import Any

from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.templates import LINE
from symoro_elastic.symbolic.program import OperationCount

Files = dict[str, str]
SINGULAR = "accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular"


def count_text(count: OperationCount) -> str:
    """Operations in words: `292x 277+, 10 sin/cos`."""
    return f"{count.products}x {count.add}+, {count.sincos} sin/cos"


def operations(count: OperationCount) -> str:
    """Return `292x 277+ 10 sin/cos`; x counts products and divisions, + sums and differences."""
    if count == OperationCount():
        return "-"
    return f"{count.products}x {count.add}+" + (f" {count.sincos} sin/cos" if count.sincos else "")


def count_json(count: OperationCount) -> dict[str, int]:
    """Return operations by kind."""
    return {"mul": count.mul, "add": count.add, "div": count.div, "sincos": count.sincos}


def package_context(package: Package) -> dict[str, Any]:
    """The template context of a package."""
    return {
        "name": package.name,
        "summary": package.scene,
        "joints": package.axes,
        "motors": package.motors,
        "motor_names": package.motor_names,
        "has_motors_in_q": package.has_motors_in_q,
        "dependent": package.dependent,
        "elastic": package.elastic,
        "frames": package.frames,
    }


def function_context(function: Function) -> dict[str, Any]:
    """The template context of a function."""
    program = function.program
    counts = f"{count_text(program.count)} a call"
    if program.once:
        counts += f"; {count_text(program.count_once)} once for each parameter set"
    arguments = [f"{a.name} ({a.size}): {a.meaning}" for a in function.arguments]
    results = [f"{r.name} {_shape(r.shape)}: {r.meaning}" for r in function.results]
    more = [*([SINGULAR] if function.divides else []), *_rows(function), *_columns(function)]
    return {
        "name": function.name,
        "title": function.title[:1].upper() + function.title[1:],
        "equations": function.equations,
        "counts": counts,
        "documented": [*arguments, *(f"-> {text}" for text in results), *more],
    }


def _rows(function: Function) -> list[str]:
    """Lines that name the rows of results if a scene has selected rows."""
    chosen = [result for result in function.results if result.rows and not result.whole]
    texts = [f"rows of {result.name}: {', '.join(result.rows)}" for result in chosen]
    return [line for text in texts for line in textwrap.wrap(text, LINE)]


def _columns(function: Function) -> list[str]:
    """Lines that name the columns of results, once if all results have the same."""
    texts = [f"columns of {r.name}: {', '.join(r.columns)}" for r in function.results if r.columns]
    if function.columns:
        texts = [f"columns: {', '.join(function.columns)}"]
    return [line for text in texts for line in textwrap.wrap(text, LINE)]


def _shape(shape: tuple[int, ...]) -> str:
    return "(" + " x ".join(map(str, shape)) + ")"
