"""The target `matlab`: a package of functions for MATLAB and GNU Octave, and MEX source around the C."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence
from typing import Any

from symoro_elastic.codegen.c.calls import CalledFunction, called_functions
from symoro_elastic.codegen.c.lines import in_comment
from symoro_elastic.codegen.local_names import with_local_names, with_own_results
from symoro_elastic.codegen.matlab_function import (
    LONGEST_NAME,
    MatlabArray,
    MatlabFunction,
    matlab_function,
    matlab_name,
    of_argument,
    of_result,
    of_step,
    with_matlab_names,
)
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.precision import DOUBLE
from symoro_elastic.codegen.target import Target
from symoro_elastic.codegen.targets.c import OWN, banner, digest_in, render_c, sentences
from symoro_elastic.codegen.templates import LINE, render
from symoro_elastic.foundation.errors import some_of


def render_matlab(package: Package) -> Files:
    """Return `+<name>/<model>.m`, `parameters.m`, `constants.m`, `build.m`; `<name>_mex.c`, and the files of C."""
    name = matlab_name(package.name)
    mex = f"{package.name[: LONGEST_NAME - 4]}_mex"
    named = with_matlab_names(package)
    functions = [matlab_function(named, function) for function in named.functions]
    shared: dict[str, Any] = {"name": package.name, "package": name, "mex": mex, "macro": package.name.upper()}
    shared |= {"origin": sentences(package, DOUBLE)}
    files = {
        f"+{name}/{f.name}.m": render("matlab/function.m.j2", **shared, **_function(f, package)) for f in functions
    }
    files[f"+{name}/parameters.m"] = render("matlab/parameters.m.j2", **shared, **_parameters(package))
    files[f"+{name}/constants.m"] = render("matlab/constants.m.j2", **shared, **_constants(with_own_results(package)))
    files[f"+{name}/build.m"] = render("matlab/build.m.j2", **shared)
    in_c = render_c(package, DOUBLE)
    shared["digest_of_c"] = digest_in(in_c[f"{package.name}.h"])
    files[f"{mex}.c"] = render("matlab/mex.c.j2", **shared, **_mex(package))
    return files | in_c


def _function(function: MatlabFunction, package: Package) -> dict[str, Any]:
    inputs = [*function.arguments, parameters_of(package)]
    widths = [
        max(map(len, texts)) for texts in zip(*((a.name, a.sizes) for a in [*inputs, *function.results]), strict=True)
    ]
    return {
        "f": function,
        "inputs": inputs,
        "call": ", ".join(array.name for array in inputs),
        "inputs_help": [line for array in inputs for line in _help(array, widths)],
        "results_help": [line for array in function.results for line in _help(array, widths)],
        "described": [line for text in function.described for line in textwrap.wrap(text, LINE)],
    }


def _help(array: MatlabArray, widths: Sequence[int]) -> list[str]:
    """Help lines about an array: name, size and meaning in three columns."""
    name, size = widths
    head = f"{array.name:{name}}  {array.sizes:{size}}  "
    return textwrap.wrap(array.meaning, LINE + 10, initial_indent=head, subsequent_indent=" " * len(head))


def _parameters(package: Package) -> dict[str, Any]:
    parameters = package.parameters
    texts = [f"{number(p.value)}{f' {in_comment(p.unit)}' if p.unit else ''}" for p in parameters]
    return {
        "parameters": [{"name": p.name, "text": text} for p, text in zip(parameters, texts, strict=True)],
        "width": max((len(p.name) for p in parameters), default=0),
        "names": cells([p.name for p in parameters]),
        "values": column([p.value for p in parameters]),
    }


def _constants(package: Package) -> dict[str, Any]:
    of_columns = {f.name: f.columns for f in package.functions if f.columns}
    return {
        "dependent": package.dependent,
        "has_motors_in_q": package.has_motors_in_q,
        "columns": of_columns,
        "lines": [*_names(package), *_outputs(package, of_columns)],
    }


def _names(package: Package) -> Iterator[str]:
    yield f"m.JOINTS = {cells([axis.name for axis in package.axes])};"
    if package.dependent is not None:
        yield f"m.DEPENDENT = {cells([axis.name for axis in package.dependent])};"
    yield f"m.MOTOR_NAMES = {cells(package.motor_names)};"
    if package.has_motors_in_q:
        yield f"m.MOTORS = {indices(package.motors)};"
    yield f"m.ELASTIC = {indices(package.elastic)};"
    yield f"m.FRAMES = {cells(package.frames)};"
    yield f"m.PARAMETERS = {cells([p.name for p in package.parameters])};"
    yield f"m.DEFAULTS = {column([p.value for p in package.parameters])};"


def _outputs(package: Package, of_columns: dict[str, tuple[str, ...]]) -> Iterator[str]:
    for function in package.functions:
        for result in function.results:
            yield f"m.OUTPUTS.{function.name}.{result.name} = {cells(result.rows)};"
    for name, columns in of_columns.items():
        yield f"m.COLUMNS.{name} = {cells(columns)};"


def _mex(package: Package) -> dict[str, Any]:
    named = with_local_names(with_own_results(package), OWN)
    functions = [mex_function(named, called) for called in called_functions(named)]
    missing = [p.name for p in package.parameters if math.isnan(p.value)]
    return {
        "banner": banner(package, DOUBLE),
        "functions": functions,
        "initializer": initializer,
        "most_inputs": max(len(f["inputs"]) for f in functions),
        "most_results": max(len(f["results"]) for f in functions),
        "names": textwrap.wrap(", ".join(f["name"] for f in functions), LINE, drop_whitespace=False),
        "missing": some_of(missing),
        "parameters": package.parameters,
    }


def number(value: float) -> str:
    """MATLAB source of a number."""
    return "NaN" if math.isnan(value) else repr(value)


def cells(names: Sequence[str]) -> str:
    """MATLAB source of a row of texts."""
    return _in_lines("{", ["'" + name.replace("'", "''") + "'" for name in names], "}", ", ")


def column(values: Sequence[float]) -> str:
    """MATLAB source of a column of numbers."""
    return _in_lines("[", [number(value) for value in values], "]", "; ") if values else "zeros(0, 1)"


def indices(values: Sequence[int]) -> str:
    """MATLAB source of a row of indices, counted from 1."""
    return _in_lines("[", [str(value + 1) for value in values], "]", " ")


def _in_lines(opening: str, items: Sequence[str], closing: str, between: str) -> str:
    """Items in brackets, each on its own line if they do not fit on one."""
    line = opening + between.join(items) + closing
    if len(line) <= LINE - 20:
        return line
    lines, current = [], ""
    for item in items:
        if current and len(current) + len(item) > LINE - 20:
            lines.append(f"{current.rstrip()} ...")
            current = ""
        current += item + between
    return "\n        ".join([f"{opening} ...", *lines, f"{current.removesuffix(between)}{closing}"])


def mex_function(package: Package, called: CalledFunction) -> dict[str, Any]:
    """Return the template context of a MEX function: its arrays in MATLAB, and the lines that call it."""
    model = next((f for f in package.functions if f.name == called.name), None)
    if model:
        inputs, results = [*map(of_argument, model.arguments), parameters_of(package)], [*map(of_result, model.results)]
    else:
        inputs, results = ([*map(of_step, arrays)] for arrays in (called.inputs, called.results))
    words = ", ".join(array.name for array in inputs[:-1])
    return {"name": called.name, "inputs": inputs, "results": results, "lines": called.call, "words": words}


def parameters_of(package: Package) -> MatlabArray:
    """Return the MATLAB array of the parameters p, the last input of every function."""
    return MatlabArray("p", "parameters", len(package.parameters))


def initializer(array: MatlabArray) -> str:
    """C source of an array's entry in the table of the MEX template."""
    pages, rows, columns = array.transposition
    lengths = ", ".join(map(str, array.dims))
    sizes = f'"{array.name}", "{array.size}", "{array.sizes}", {len(array.dims)}, {{{lengths}}}'
    return f"{{{sizes}, {pages}U, {rows}U, {columns}U}}"


MATLAB = Target(
    name="matlab",
    title="functions for MATLAB and GNU Octave, and MEX around C; states are columns",
    suffixes=(".m", "_mex.c", ".h", ".c"),
    precisions=(DOUBLE,),
    reserved=frozenset(),
    files=lambda package, _: render_matlab(package),
)
