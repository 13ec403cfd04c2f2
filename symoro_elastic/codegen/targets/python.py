"""The target `python`: a Python package of compiled functions, to be installed by pip; on arrays of numpy."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from inspect import getsource
from typing import Any

from symoro_elastic.codegen.c.calls import CalledFunction, called_functions
from symoro_elastic.codegen.c.lines import with_arguments, wrap_lines
from symoro_elastic.codegen.numpy_steps import numpy_methods
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files, function_context
from symoro_elastic.codegen.precision import DOUBLE
from symoro_elastic.codegen.target import Target
from symoro_elastic.codegen.targets.c import banner, digest_in, sentences
from symoro_elastic.codegen.targets.c_batch import C_BATCH, render_c_batch
from symoro_elastic.codegen.targets.numpy import NUMPY, constants_context, outputs_context
from symoro_elastic.codegen.templates import render
from symoro_elastic.foundation.errors import InputError

AXES = 3
"""Maximum number of axes of an array at a state: matrices of frames, derivatives of matrices."""
ARRAYS = 32
"""Maximum number of inputs or results: a time step of a floating base under servos and wrenches has 15."""
CALLS = "python_calls.c"
"""The file without names of a machine: it calls the functions of a table."""


def render_calls() -> Files:
    """Return the files of the module that calls functions of any table."""
    names = {"python_calls.h": "python/calls.h.j2", CALLS: "python/calls.c.j2"}
    return {name: render(template, axes=AXES, arrays=ARRAYS) for name, template in names.items()}


def render_table(package: Package) -> Files:
    """Return the C of a package, one state and many, and the table of its functions."""
    files = render_c_batch(package)
    text = render(
        "python/table.c.j2",
        name=package.name,
        macro=package.name.upper(),
        banner=banner(package, DOUBLE),
        digest_of_one=digest_in(files[f"{package.name}.h"]),
        digest_of_batch=digest_in(files[f"{package.name}_batch.h"]),
        functions=called_functions(package),
        has_parameters=bool(package.parameters),
        braces=lambda shape: "{" + ", ".join(map(str, shape or (0,))) + "}",
    )
    return files | {"python_calls.h": render_calls()["python_calls.h"], f"{package.name}_table.c": wrap_lines(text)}


def render_python(package: Package) -> Files:
    """Return the C, a Python package in the folder `<name>` with its stubs, and the file by which it is installed."""
    name = package.name
    if name == "numpy" or name in sys.stdlib_module_names:
        what = f"{name!r} is the name of a module that Python or numpy brings: give the machine another"
        raise InputError(package.source or name, "--target python, name", what)
    files = render_table(package) | render_calls()
    docstrings = _docstrings(package)
    context = constants_context(package) | {
        "functions": [function_context(f) | outputs_context(f) for f in package.functions],
        "called": [_declaration(function, docstrings[function.name]) for function in called_functions(package)],
        "sources": sorted(file for file in files if file.endswith(".c")),
        "headers": sorted(file for file in files if file.endswith(".h")),
    }
    templates = {
        f"{name}/__init__.py": "python/__init__.py.j2",
        f"{name}/__init__.pyi": "python/__init__.pyi.j2",
        "pyproject.toml": "python/pyproject.toml.j2",
    }
    files |= {file: render(template, **context) for file, template in templates.items()}
    first = "".join(f"# {line}\n" for line in sentences(package, DOUBLE))
    from symoro_elastic.codegen import arguments, real_numbers  # which import numpy

    for module in (arguments, real_numbers):
        files[f"{name}/_{module.__name__.rpartition('.')[2]}.py"] = first + getsource(module)
    return files | {f"{name}/py.typed": "# PEP 561\n"}


def _declaration(function: CalledFunction, text: Sequence[str]) -> dict[str, Any]:
    """Return the shapes of inputs, the heads of a function and of its stub, and the lines of its docstring."""
    *inputs, _ = (array.name for array in function.inputs)
    count = len(function.results)
    results = "Array" if count == 1 else f"tuple[{', '.join(['Array'] * count)}]"
    typed = [*(f"{name}: ArrayLike" for name in inputs), "p: ArrayLike = ...", "*", f"out: {results} | None = None"]
    return {
        "shapes": ", ".join(f"{array.name}={array.shapes}" for array in function.inputs),
        "head": with_arguments(f"def {function.name}", [*inputs, "p=DEFAULTS"], "):"),
        "stub": with_arguments(f"def {function.name}", typed, f") -> {results}: ..."),
        "text": text,
    }


def _docstrings(package: Package) -> dict[str, list[str]]:
    """Return the lines of the docstrings of models and time steps, as in the package for numpy."""
    docstrings = {}
    for function in package.functions:
        about, guaranteed = function_context(function), function.guaranteed.get(DOUBLE.name)
        more = guaranteed.lines if guaranteed else ()
        title = f"{about['title']} {about['equations']}."
        docstrings[function.name] = [title, "", f"{about['counts']}.", *about["documented"], *more]
    for step in (step for method in numpy_methods(package) for step in method.steps):
        title = f"One step h [s] of the {step.method.title}{step.variant.words}."
        docstrings[step.name] = [title, "", *step.described]
    return docstrings


PYTHON = Target(
    name="python",
    title="a Python package of compiled functions on arrays of numpy, installed by pip",
    suffixes=(*C_BATCH.suffixes, ".toml", ".py", ".pyi", ".typed"),
    precisions=(DOUBLE,),
    reserved=C_BATCH.reserved | NUMPY.reserved,
    files=lambda package, _: render_python(package),
)
