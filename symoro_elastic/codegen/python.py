"""A package as a Python package for numpy."""

from __future__ import annotations

import math
from typing import Any

from symoro_elastic.codegen.body import PYTHON, Bodies, bodies, numbered
from symoro_elastic.codegen.described import Files, described, shared
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.templates import Literal, in_brackets, render


def render_numpy(package: Package) -> Files:
    """`__init__.py`, `_run.py` and one module of straight-line code for each model."""
    functions = [_python_function(package, function) for function in package.functions]
    context = shared(package) | {
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


def _python_function(package: Package, function: Function) -> dict[str, Any]:
    printed: Bodies = bodies(function, numbered(p.name for p in package.parameters), package.joint_names, PYTHON)
    groups = [in_brackets("(", [Literal(v) for v in values], ")").replace("\n", "\n    ") for values in printed.results]
    returned = "    return (\n        " + ",\n        ".join(g.replace("\n", "\n    ") for g in groups) + ",\n    )"
    constants = in_brackets("(", [Literal(name) for name in printed.constants], ")").replace("\n", "\n    ")
    return described(function) | {
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
