"""The target `matlab`: a package of functions for MATLAB and GNU Octave, and MEX source around the C."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from symoro_elastic.codegen.c_lines import in_comment
from symoro_elastic.codegen.described import Files
from symoro_elastic.codegen.local_names import with_local_names, with_own_results
from symoro_elastic.codegen.matlab import LONGEST_NAME, MatlabFunction, matlab_function, matlab_name, with_matlab_names
from symoro_elastic.codegen.matlab_arrays import MatlabArray
from symoro_elastic.codegen.matlab_mex import MexFunction, initializer, mex_model, mex_step, parameters_of
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.targets.c import OWN, banner, render_c, sentences, source_text
from symoro_elastic.codegen.templates import LINE, render


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
        "missing": ", ".join(missing[:10]) + (f" and {len(missing) - 10} more" if len(missing) > 10 else ""),
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


@dataclass(frozen=True)
class _Matlab:
    name: str = "matlab"
    title: str = "functions for MATLAB and GNU Octave, and MEX around C; states are columns"
    suffixes: tuple[str, ...] = (".m", "_mex.c", ".h", ".c")
    precisions: tuple[Precision, ...] = (DOUBLE,)
    reserved: frozenset[str] = frozenset()

    def render(self, package: Package, precisions: Sequence[Precision]) -> Files:
        """Return a folder `+<name>` of functions, `<name>_mex.c`, `<name>.h` and `<name>.c`, in double precision."""
        return render_matlab(package)


MATLAB = _Matlab()
