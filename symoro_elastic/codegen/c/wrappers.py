"""What C around a generated function needs of it: its arguments, and calls for states that are rows of arrays."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from symoro_elastic.codegen.local_names import of_own_results
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.precision import Precision


def wrapper_context(
    package: Package, function: Function, precision: Precision, after_p: Sequence[str] = ()
) -> dict[str, str]:
    """Return the context of a function in a template: `name`, `arguments` that a wrapper hands on, and its calls.

    `call` is that of the state in row k of each array but p, with `after_p` behind p; `all_states` is that of a batch.
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
    """Row k of each array; all states share p."""
    return [name if name == "p" else f"{name} + {size}*k" for name, size in arrays.items()]
