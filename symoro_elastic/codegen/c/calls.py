"""The functions of a package in C as generic code calls them: on pointers `x` to inputs and `y` to results."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symoro_elastic.codegen.c.lines import with_arguments
from symoro_elastic.codegen.c.steps import CSteps, StepText
from symoro_elastic.codegen.local_names import of_own_results
from symoro_elastic.codegen.package import Argument, Function, Package
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.time_steps import blocks_carried, entries_of_state, rows_of_nodes


@dataclass(frozen=True)
class CalledArray:
    """An array argument for one state, row by row; `matrix` is another valid shape, `is_shared`: one for all states."""

    name: str
    shape: tuple[int, ...]
    matrix: tuple[int, ...] = ()
    is_shared: bool = False

    @property
    def entries(self) -> int:
        """Number of entries for one state."""
        return math.prod(self.shape)

    @property
    def shapes(self) -> tuple[tuple[int, ...], ...]:
        """Accepted shapes, first the one used in C."""
        return (self.shape, self.matrix) if self.matrix else (self.shape,)


@dataclass(frozen=True)
class CalledFunction:
    """A model or time step as called from a wrapper: inputs with p, results, code lines for one state and a batch.

    A time step has the state among its inputs, and its first results are the state after it. `batch` is empty for
    functions without one.
    """

    name: str
    inputs: tuple[CalledArray, ...]
    results: tuple[CalledArray, ...]
    call: tuple[str, ...]
    batch: tuple[str, ...]


def called_functions(package: Package) -> list[CalledFunction]:
    """Return the models, then the time steps, of a package in double precision."""
    models = [called_model(package, function) for function in package.functions]
    if not package.steps:
        return models
    batched = {step.name for step in CSteps(package, DOUBLE, (), many=True).steps}
    steps = CSteps(package, DOUBLE, ()).steps
    return [*models, *(called_step(package, step, step.name in batched) for step in steps)]


def called_model(package: Package, function: Function) -> CalledFunction:
    """Return a model with its inputs and results, and the C lines that call it."""
    inputs = (*map(of_argument, function.arguments), parameters_of(package))
    results = tuple(CalledArray(result.name, result.shape) for result in function.results)
    arguments = [f"x[{k}]" for k in range(len(inputs))] + [f"y[{k}]" for k in range(len(results))]
    name = f"{package.name}_{function.name}"
    batch = _lines(f"{name}_batch", ["states", *arguments]) if function.arguments else ()
    return CalledFunction(function.name, inputs, results, _lines(name, arguments), batch)


def called_step(package: Package, step: StepText, has_batch: bool) -> CalledFunction:
    """Return a time step with its inputs and results, and the C lines that call it."""
    rows, nodes = rows_of_nodes(step.variant, package), len(step.method.nodes_of(step.variant))
    read = [CalledArray(a.name, (nodes, rows[a.name]) if a.name in rows else (a.entries,)) for a in step.read]
    state = [of_argument(block) for block in blocks_carried(step.variant, package)]
    errors = 2 * entries_of_state(package) + step.states
    error = [CalledArray("error", (errors,))] if step.with_error else []
    inputs = (*read, CalledArray("h", (), is_shared=True), *state, parameters_of(package))
    first = len(read) + 1
    arguments = [f"x[{k}]" for k in range(len(read))] + [f"x[{len(read)}][0]", f"x[{len(inputs) - 1}]"]
    arguments += [f"y[{k}]" for k in range(len(state) + len(error))]

    def lines(name: str, states: Sequence[str]) -> tuple[str, ...]:
        sizes = "*".join(["{}", *states, "sizeof(double)"])
        copied = [
            f"memcpy(y[{k}], x[{first + k}], {sizes.format(a.entries)});" for k, a in enumerate(state) if a.entries
        ]
        return (*copied, *_lines(name, [*states, *arguments]))

    batch = lines(f"{step.name}_batch", ["states"]) if has_batch else ()
    return CalledFunction(
        step.name.removeprefix(f"{package.name}_"), inputs, (*state, *error), lines(step.name, []), batch
    )


def of_argument(argument: Argument) -> CalledArray:
    """Return the called array of an argument, which may be passed as a square matrix."""
    side = argument.quantity.rows
    return CalledArray(argument.name, (argument.size,), (side, side) if side * side == argument.size > 0 else ())


def parameters_of(package: Package) -> CalledArray:
    """Return the called array of the parameters p, the last input of every function."""
    return CalledArray("p", (len(package.parameters),), is_shared=True)


def _lines(name: str, arguments: Sequence[str]) -> tuple[str, ...]:
    return tuple(with_arguments(name, arguments, ");").splitlines())


def wrapper_context(
    package: Package, function: Function, precision: Precision, after_p: Sequence[str] = ()
) -> dict[str, str]:
    """Return the template context of a function: `name`, `arguments` that a wrapper passes on, and its calls.

    `call` is for the state in row k of all arrays but p, `after_p` follows p; `all_states` is the call for a batch.
    """
    own = of_own_results(function).results
    inputs, results = package.inputs(function), {r.name: math.prod(r.shape) for r in own}
    pointers = [*(f"const {precision.state} *{name}" for name in inputs), *(f"{precision.state} *{r}" for r in results)]
    return {
        "name": precision.function(package.name, function.name),
        "arguments": ", ".join(pointers),
        "call": ", ".join([*_rows(inputs), *after_p, *_rows(results)]),
        "all_states": ", ".join([*inputs, *results]),
    }


def _rows(arrays: Mapping[str, int]) -> list[str]:
    """C expressions for row k of the arrays; all states share p."""
    return [name if name == "p" else f"{name} + {size}*k" for name, size in arrays.items()]
