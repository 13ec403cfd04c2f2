"""A package as a Python package for numpy."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from symoro_elastic.codegen.body import PYTHON, Writer
from symoro_elastic.codegen.guaranteed import Guaranteed
from symoro_elastic.codegen.local_names import with_local_names
from symoro_elastic.codegen.numpy_steps import numpy_methods
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.package_context import Files, function_context, package_context
from symoro_elastic.codegen.precision import DOUBLE
from symoro_elastic.codegen.printers import Printer
from symoro_elastic.codegen.target import Target, words
from symoro_elastic.codegen.templates import Literal, in_brackets, render, with_digest
from symoro_elastic.codegen.time_steps import Literals, settling_of
from symoro_elastic.quantities import QUANTITIES
from symoro_elastic.symbolic.operations import MAXIMUM, MINIMUM

KEYWORDS = words(
    """
    False None True and as assert async await break class continue def del elif else except finally for from global if
    import in is lambda nonlocal not or pass raise return try while with yield
    """
)
BUILTINS = words(
    """
    range len tuple list dict zip enumerate isinstance print abs min max sum any all map type object ValueError
    TypeError KeyError
    """
)
OWN = words(
    """
    JOINTS DEPENDENT MOTORS MOTOR_NAMES ELASTIC PARAMETERS DEFAULTS FRAMES OUTPUTS Z_NAMES parameters p c math np numpy
    nan inf
    """
)
"""Identifiers of the templates."""


def render_numpy(package: Package) -> Files:
    """`__init__.py`, `_runtime.py` that carries programs out, and a module of straight-line code for each model."""
    package = with_local_names(package, OWN)
    functions = [_python_function(package, function) for function in package.functions]
    methods = numpy_methods(package)
    context = constants_context(package) | {
        "functions": functions,
        "extrema": any(function["extrema"] for function in functions),
        "steps": [step for method in methods for step in method.steps],
    }
    matrices = json.dumps({row.name: row.rows for row in QUANTITIES.values() if row.rows})
    files = {
        "__init__.py": render("numpy/__init__.py.j2", **context),
        "_runtime.py": render("numpy/runtime.py.j2", matrices=matrices, extrema=context["extrema"]),
    }
    if methods:
        kinds = {method.text.kind for method in methods}
        has = {"kinds": kinds, "base": package.base, "states": package.states}
        has |= {"loads": settling_of(package, Literals(DOUBLE))}
        files["_steps.py"] = render("numpy/steps.py.j2", name=package.name, methods=methods, **has)
    for function in functions:
        files[f"{function['module']}.py"] = render("numpy/program.py.j2", name=package.name, function=function)
    return with_digest(files)


def constants_context(package: Package) -> dict[str, Any]:
    """Return the template context of names and default values, without `functions`."""
    values = [Literal("np.nan" if math.isnan(p.value) else repr(p.value)) for p in package.parameters]
    named = zip(package.parameters, values, strict=True)
    parameters = [{"name": p.name, "python_value": value} for p, value in named]
    return package_context(package) | {"states": package.states, "parameters": parameters}


def outputs_context(function: Function) -> dict[str, Any]:
    """Return the labels of rows and columns of the results of a model."""
    outputs = [{"name": r.name, "rows": r.rows} for r in function.results]
    return {"outputs": outputs, "columns": function.columns}


def _python_function(package: Package, function: Function) -> dict[str, Any]:
    arguments = [a.name for a in function.arguments]
    parameters = [p.symbol for p in package.parameters]
    prepare, body = _bodies(function, parameters, package.joint_names)
    text = "\n".join([*prepare, *body])
    about, guaranteed = function_context(function), function.guaranteed.get(DOUBLE.name)
    return (
        about
        | outputs_context(function)
        | {
            "documented": [*about["documented"], *(guaranteed.lines if guaranteed else ())],
            "in_box": _in_box(package.inputs(function), guaranteed) if guaranteed else [],
            "module": f"_{function.name}",
            "signature": ", ".join([*arguments, "p=DEFAULTS"]),
            "call": ", ".join([*arguments, "p=p"]),
            "program_signature": ", ".join(["_f", *arguments, "c"]),
            "sizes": ", ".join(f"{a.name}={a.size}" for a in function.arguments),
            "parameters": len(parameters),
            "shapes": _tuple(_tuple(r.shape) for r in function.results),
            "extrema": any(f"_f.{name}(" in text for name in (MINIMUM, MAXIMUM)),
            "prepare_body": "\n".join(prepare),
            "body": "\n".join(body),
        }
    )


def _in_box(sizes: Mapping[str, int], guaranteed: Guaranteed) -> list[dict[str, Any]]:
    """Arguments with ranges, and the lower and upper bounds of their entries."""
    ends = {name: guaranteed.ends(name, sizes[name]) for name in guaranteed.arguments}
    return [{"name": name, "low": _numbers(low), "high": _numbers(high)} for name, (low, high) in ends.items()]


def _numbers(numbers: Iterable[float]) -> str:
    """Python source of a tuple of numbers."""
    return _tuple(f"{'-' if x < 0 else ''}np.inf" if math.isinf(x) else repr(x) for x in numbers)


def _bodies(function: Function, parameters: list[str], joints: tuple[str, ...]) -> tuple[list[str], list[str]]:
    """Lines that compute parameter-only values, and lines that compute a state from them."""
    program = function.program
    printer = Printer(program, functions=PYTHON.functions)
    writer = Writer(printer, PYTHON, joints)
    lines = writer.statements(program.statements)
    results = [_tuple(map(printer.value, output.entries), 2) for output in program.outputs]
    used = frozenset(printer.referenced)
    printer.referenced.clear()
    once = writer.statements(program.once)
    constants = [name for name in (*parameters, *(s.name for s in program.once)) if name in used]
    prepare = [*_unpack("p", parameters, {*printer.referenced, *constants}), *once]
    unpacked = [line for a in program.inputs for line in _unpack(a.name, a.symbols, used)]
    body = [*unpacked, *_unpack("c", constants, used), *lines, "", "    # Results.", "    return ("]
    body += [f"        {result}," for result in results]
    return [*prepare, f"    return {_tuple(constants, 1)}"], [*body, "    )"]


def _unpack(array: str, symbols: Iterable[str], used: Collection[str]) -> list[str]:
    """The line that unpacks an array into names; `_` replaces unused ones."""
    names = [symbol if symbol in used else "_" for symbol in symbols]
    return [] if set(names) <= {"_"} else [f"    {_tuple(names, 1)} = {array}"]


def _tuple(items: Iterable[object], depth: int = 0) -> str:
    """Python source of a tuple, its further lines indented as a statement at this depth."""
    return in_brackets("(", [Literal(item) for item in items], ")").replace("\n", "\n" + "    " * depth)


NUMPY = Target(
    name="numpy",
    title="a Python package that needs numpy only; states stack along leading axes",
    suffixes=(".py",),
    precisions=(DOUBLE,),
    reserved=KEYWORDS | BUILTINS,
    files=lambda package, _: render_numpy(package),
)
