"""The target `matlab`: a package of functions for MATLAB and GNU Octave, and MEX source around the C."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from symoro_elastic.codegen.c.lines import in_comment, with_arguments
from symoro_elastic.codegen.c.steps import StepText
from symoro_elastic.codegen.local_names import with_local_names, with_own_results
from symoro_elastic.codegen.matlab_arrays import MatlabArray, of_argument, of_result
from symoro_elastic.codegen.matlab_function import (
    LONGEST_NAME,
    MatlabFunction,
    matlab_function,
    matlab_name,
    with_matlab_names,
)
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.precision import DOUBLE
from symoro_elastic.codegen.target import Target
from symoro_elastic.codegen.targets.c import OWN, banner, render_c, sentences, source_text
from symoro_elastic.codegen.templates import LINE, render
from symoro_elastic.codegen.time_steps import blocks_carried, entries_of_state, rows_of_nodes
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
    files[f"{mex}.c"] = render("matlab/mex.c.j2", **shared, **_mex(package))
    return files | render_c(package, DOUBLE)


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
    """Lines about an array: name, size and meaning in three columns."""
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
    functions = _mex_functions(with_local_names(with_own_results(package), OWN))
    missing = [p.name for p in package.parameters if math.isnan(p.value)]
    return {
        "banner": banner(package, DOUBLE),
        "functions": functions,
        "initializer": initializer,
        "most_inputs": max(len(f.inputs) for f in functions),
        "most_results": max(len(f.results) for f in functions),
        "names": textwrap.wrap(", ".join(f.name for f in functions), LINE, drop_whitespace=False),
        "missing": some_of(missing),
        "parameters": package.parameters,
    }


def _mex_functions(package: Package) -> list[MexFunction]:
    """The models, then the time steps."""
    steps = source_text(package, DOUBLE).steps.steps if package.steps else []
    return [*(mex_model(package, f) for f in package.functions), *(mex_step(package, step) for step in steps)]


def number(value: float) -> str:
    """Source of a number."""
    return "NaN" if math.isnan(value) else repr(value)


def cells(names: Sequence[str]) -> str:
    """Source of a row of texts."""
    return _listed("{", ["'" + name.replace("'", "''") + "'" for name in names], "}", ", ")


def column(values: Sequence[float]) -> str:
    """Source of a column of numbers."""
    return _listed("[", [number(value) for value in values], "]", "; ") if values else "zeros(0, 1)"


def indices(values: Sequence[int]) -> str:
    """Source of a row of indices, which MATLAB counts from 1."""
    return _listed("[", [str(value + 1) for value in values], "]", " ")


def _listed(opening: str, items: Sequence[str], closing: str, between: str) -> str:
    """Items in brackets, in lines of their own where they are many."""
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


# The functions of a package in C as MEX source calls them: their arrays, and a call of each.
@dataclass(frozen=True)
class MexFunction:
    """A function: its inputs, with p, its results, and the lines that call it with x and y."""

    name: str
    inputs: tuple[MatlabArray, ...]
    results: tuple[MatlabArray, ...]
    lines: tuple[str, ...]

    @property
    def words(self) -> str:
        """The inputs before p."""
        return ", ".join(array.name for array in self.inputs[:-1])


def mex_model(package: Package, function: Function) -> MexFunction:
    """Return a model of a package, whose results have names of their own."""
    inputs = (*map(of_argument, function.arguments), parameters_of(package))
    results = tuple(map(of_result, function.results))
    given = [f"x[{k}]" for k in range(len(inputs))] + [f"y[{k}]" for k in range(len(results))]
    call = with_arguments(f"{package.name}_{function.name}", given, ");")
    return MexFunction(function.name, inputs, results, tuple(call.splitlines()))


def mex_step(package: Package, step: StepText) -> MexFunction:
    """Return a time step: the state is among its inputs, and its first results are the state after the step."""
    nodes = len(step.method.nodes_of(step.variant))
    rows = rows_of_nodes(step.variant, package)
    read = [
        MatlabArray(array.name, "", rows[array.name], nodes, by_columns=True)
        if array.name in rows
        else MatlabArray(array.name, "", array.entries)
        for array in step.read
    ]
    state = _state(package, step)
    errors = 2 * entries_of_state(package) + step.states
    error = [MatlabArray("error", "", errors)] if step.with_error else []
    inputs = (*read, MatlabArray("h", "", 1), *state, parameters_of(package))
    first = len(read) + 1
    copied = [
        f"memcpy(y[{k}], x[{first + k}], {array.entries}*sizeof(double));"
        for k, array in enumerate(state)
        if array.rows
    ]
    given = [f"x[{k}]" for k in range(len(read))] + [f"x[{len(read)}][0]", f"x[{len(inputs) - 1}]"]
    given += [f"y[{k}]" for k in range(len(state) + len(error))]
    call = with_arguments(step.name, given, ");")
    name = step.name.removeprefix(f"{package.name}_")
    return MexFunction(name, inputs, (*state, *error), (*copied, *call.splitlines()))


def parameters_of(package: Package) -> MatlabArray:
    """Return the last input of every function."""
    return MatlabArray("p", "parameters", len(package.parameters))


def _state(package: Package, step: StepText) -> list[MatlabArray]:
    """The arrays that a time step changes."""
    blocks = ((block, of_argument(block)) for block in blocks_carried(step.variant, package))
    return [array if block in package.base else replace(array, meaning="") for block, array in blocks]


def initializer(array: MatlabArray) -> str:
    """Source of the array in the table of the template."""
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
