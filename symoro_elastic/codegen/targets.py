"""A package rendered for each target: file names and their texts."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable
from typing import Any

from symoro_elastic.codegen.body import PYTHON, Bodies, C, bodies, numbered
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.templates import LINE, Literal, in_brackets, render
from symoro_elastic.symbolic.program import OperationCount

Files = dict[str, str]


def render_c(package: Package) -> Files:
    """`<name>.h` and `<name>.c`."""
    macro = package.name.upper()
    functions = [_c_function(package, macro, function) for function in package.functions]
    context = _shared(package) | {
        "macro": macro,
        "functions": functions,
        "parameters": [
            {"name": p.name, "unit": in_comment(p.unit), "c_value": _c_number(p.value)} for p in package.parameters
        ],
        "uses_sign": any("sign(" in f["body"] for f in functions),
    }
    return {
        f"{package.name}.h": render("c/model.h.j2", **context),
        f"{package.name}.c": render("c/model.c.j2", **context),
    }


def render_numpy(package: Package) -> Files:
    """`__init__.py`, `_run.py` and one module of straight-line code for each model."""
    functions = [_python_function(package, function) for function in package.functions]
    context = _shared(package) | {
        "functions": functions,
        "modules": ["_run", *(f["module"] for f in functions)],
        "parameters": [
            {"name": p.name, "python_value": Literal("np.nan" if math.isnan(p.value) else repr(p.value))}
            for p in package.parameters
        ],
    }
    files = {"__init__.py": render("numpy/__init__.py.j2", **context), "_run.py": render("numpy/run.py.j2")}
    for function in functions:
        files[f"{function['module']}.py"] = render("numpy/program.py.j2", name=package.name, function=function)
    return files


TARGETS: dict[str, Callable[[Package], Files]] = {"numpy": render_numpy, "c": render_c}


def in_comment(text: str) -> str:
    """A user's text as it may stand in a comment of C: one line that does not end the comment."""
    line = "".join(character if character.isprintable() else " " for character in text)
    return line.replace("*/", "* /").replace("/*", "/ *")


def count_text(count: OperationCount) -> str:
    """Operations in words: `292x 277+, 10 sin/cos`."""
    return f"{count.products}x {count.add}+, {count.sincos} sin/cos"


def _shared(package: Package) -> dict[str, Any]:
    return {
        "name": package.name,
        "summary": package.scene,
        "joints": package.axes,
        "motors": package.motors,
        "elastic": package.elastic,
        "frames": package.frames,
    }


def _described(function: Function) -> dict[str, Any]:
    program = function.program
    counts = f"{count_text(program.count)} a call"
    if program.once:
        counts += f"; {count_text(program.count_once)} once for each parameter set"
    arguments = [f"{a.name} ({a.size}): {a.meaning}" for a in function.arguments]
    results = [f"{r.name} {_shape(r.shape)}: {r.meaning}" for r in function.results]
    return {
        "name": function.name,
        "title": function.title[:1].upper() + function.title[1:],
        "equations": function.equations,
        "counts": counts,
        "documented": [*arguments, *(f"-> {text}" for text in results), *_columns(function)],
    }


def _columns(function: Function) -> list[str]:
    """Labels of columns, in lines."""
    labels = [label for result in function.results for label in result.columns]
    return textwrap.wrap("columns: " + ", ".join(labels), LINE) if labels else []


def _shape(shape: tuple[int, ...]) -> str:
    return "(" + " x ".join(map(str, shape)) + ")"


def _c_function(package: Package, macro: str, function: Function) -> dict[str, Any]:
    printed = bodies(function, {p.name: f"{macro}_P_{p.name}" for p in package.parameters}, package.joint_names, C)
    parameters = ["p"] if package.parameters else []
    inputs = [a.name for a in function.arguments] + parameters
    results = [r.name for r in function.results]
    prepared = [*inputs, "c", *results]
    unused = [name for name in inputs if name not in printed.used]
    body = [f"    (void){name};" for name in unused] + printed.lines + ["", "    /* Results. */"]
    for result, values in zip(results, printed.results, strict=True):
        body += [f"    {result}[{k}] = {value};" for k, value in enumerate(values)]
    body += [f"    (void){r.name};" for r in function.results if 0 in r.shape]
    stored = [f"    c[{k}] = {name};" for k, name in enumerate(printed.constants)]
    return _described(function) | {
        "c_name": f"{package.name}_{function.name}",
        "c_arguments": _signature(inputs, results),
        "prepared_arguments": _signature([*inputs, "c"], results),
        "prepared_call": ", ".join(prepared),
        "constants": printed.constants,
        "constants_macro": f"{macro}_{function.name.upper()}_CONSTANTS",
        "prepare_body": "\n".join([*printed.once, "", *stored]),
        "body": "\n".join(body),
    }


def _signature(inputs: list[str], results: list[str]) -> str:
    return ", ".join([*(f"const double *{name}" for name in inputs), *(f"double *{name}" for name in results)])


def _python_function(package: Package, function: Function) -> dict[str, Any]:
    printed: Bodies = bodies(function, numbered(p.name for p in package.parameters), package.joint_names, PYTHON)
    groups = [in_brackets("(", [Literal(v) for v in values], ")").replace("\n", "\n    ") for values in printed.results]
    returned = "    return (\n        " + ",\n        ".join(g.replace("\n", "\n    ") for g in groups) + ",\n    )"
    constants = in_brackets("(", [Literal(name) for name in printed.constants], ")").replace("\n", "\n    ")
    return _described(function) | {
        "module": f"_{function.name}",
        "signature": ", ".join([*(a.name for a in function.arguments), "p=DEFAULTS"]),
        "program_signature": ", ".join(["_f", *(a.name for a in function.arguments), "p", "c"]),
        "sizes": function.arguments,
        "shapes": in_brackets("(", [Literal(_tuple(r.shape)) for r in function.results], ")"),
        "outputs": [{"name": r.name, "rows": r.rows} for r in function.results],
        "columns": next((r.columns for r in function.results if r.columns), ()),
        "prepare_body": "\n".join([*printed.once, f"    return {constants}"]),
        "body": "\n".join([*printed.lines, "", "    # Results.", returned]),
    }


def _tuple(shape: tuple[int, ...]) -> str:
    return f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"


def _c_number(value: float) -> str:
    return "NAN" if math.isnan(value) else repr(value)
