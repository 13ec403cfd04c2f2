"""The functions of a package in C as MEX source calls them: their arrays, and a call of each."""

from __future__ import annotations

from dataclasses import dataclass

from symoro_elastic.codegen.c_lines import with_arguments
from symoro_elastic.codegen.c_steps import StepText
from symoro_elastic.codegen.matlab_arrays import MatlabArray, of_argument, of_result
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.time_steps import entries_of_state, rows_of_nodes


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
    state = _state(package)
    error = [MatlabArray("error", "", 2 * entries_of_state(package))] if step.with_error else []
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


def _state(package: Package) -> list[MatlabArray]:
    """The arrays that a time step changes."""
    found = [MatlabArray(name, "", len(package.axes)) for name in ("q", "qd")]
    if package.takes_dependent:
        found.append(MatlabArray("q_dep", "", len(package.dependent or ())))
    return [*found, *map(of_argument, package.base)]


def initializer(array: MatlabArray) -> str:
    """Source of the array in the table of the template."""
    pages, rows, columns = array.turned
    lengths = ", ".join(map(str, array.dims))
    sizes = f'"{array.name}", "{array.size}", "{array.sizes}", {len(array.dims)}, {{{lengths}}}'
    return f"{{{sizes}, {pages}U, {rows}U, {columns}U}}"
