"""A package as C."""

from __future__ import annotations

import math
from typing import Any

from symoro_elastic.codegen.body import C, bodies
from symoro_elastic.codegen.described import Files, described, shared
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.templates import render


def render_c(package: Package) -> Files:
    """`<name>.h` and `<name>.c`."""
    macro = package.name.upper()
    functions = [_c_function(package, macro, function) for function in package.functions]
    context = shared(package) | {
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


def in_comment(text: str) -> str:
    """A user's text as it may stand in a comment of C: one line that does not end the comment."""
    line = "".join(character if character.isprintable() else " " for character in text)
    return line.replace("*/", "* /").replace("/*", "/ *")


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
    return described(function) | {
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


def _c_number(value: float) -> str:
    return "NAN" if math.isnan(value) else repr(value)
