"""Models on other libraries: `python -m tests.benchmarks.backends [MACHINE.toml ...] [--jacobians] [--json FILE]`.

For golden machines (or those named) and both models: how far CasADi and JAX, compiled, are from numpy and from C, in
units of the last place of the largest entry; Jacobians from the generated derivatives; how long JAX compiles. With
`--jacobians` JAX compiles Jacobians too: minutes for an arm of six joints, half a minute with the option of XLA's that
docs/backends.md names and that is used here.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import jax
import numpy as np

from symoro_elastic.codegen.backends.array_libraries import on_arrays
from symoro_elastic.codegen.backends.casadi_functions import casadi_functions
from tests.benchmarks.tables import print_table, progress, save_json
from tests.codegen.backends.compared import (
    BOTH,
    GOLDEN_MACHINES,
    ULP,
    Array,
    apart,
    each_state,
    inputs,
    jacobians,
    loaded,
    machine,
    on,
)

QUICKLY: dict[str, str | bool] = {"xla_cpu_use_fusion_emitters": False}
"""Options of XLA with which large functions compile in a fifth of the time, and run a little slower."""


def row(example: str, name: str, with_jacobians: bool) -> dict[str, Any]:
    import symoro_elastic as se

    arguments = [*each_state(inputs(example, name))]
    expected = [getattr(loaded(example), name)(*each) for each in arguments]
    in_c = getattr(se.load(machine(example), name, backend="c"), name)
    in_casadi, in_jax = getattr(on(casadi_functions, example), name), getattr(on(_on_jax, example), name)
    start = time.perf_counter()
    compiled = jax.jit(in_jax).lower(*arguments[0]).compile()
    seconds = time.perf_counter() - start
    found = {
        "machine": example,
        "model": name,
        "casadi": _worst(in_casadi, arguments, expected),
        "casadi, C": _worst(in_casadi, arguments, [in_c(*each) for each in arguments]),
        "jax": _worst(compiled, arguments, expected),
        "jax, C": _worst(compiled, arguments, [in_c(*each) for each in arguments]),
        "casadi Jacobian": _of_casadi(in_casadi, example, name, arguments),
        "jit, s": seconds,
    }
    return found | (_of_jax(in_jax, example, name, arguments) if with_jacobians else {})


def _on_jax(package: Any, module: Any) -> Any:
    return on_arrays(package, module, jax.numpy)


def _worst(function: Any, arguments: list[list[Array]], expected: list[Any]) -> float:
    return max(apart(function(*each), wanted) for each, wanted in zip(arguments, expected, strict=True))


def _of_casadi(function: Any, example: str, name: str, arguments: list[list[Array]]) -> float:
    """Largest difference from the generated derivatives, over the largest entry of each."""
    jacobian = function.jacobian()
    found = 0.0
    for each in arguments:
        matrices = jacobian.call([*each, *[0] * function.n_out()])
        by_name = dict(zip(jacobian.name_out(), matrices, strict=True))
        for (result, argument), (rows, wanted) in jacobians(example, name, each).items():
            found = max(found, ULP * apart(by_name[f"jac_{result}_{argument}"].full()[rows], wanted))
    return found


def _of_jax(function: Any, example: str, name: str, arguments: list[list[Array]]) -> dict[str, float]:
    start = time.perf_counter()
    lowered = jax.jit(jax.jacfwd(function, argnums=(0, 1, 2))).lower(*arguments[0])
    jacobian = lowered.compile(QUICKLY)
    seconds, found = time.perf_counter() - start, 0.0
    results, names = loaded(example).OUTPUTS[name], [*inputs(example, name)]
    for each in arguments:
        matrices = jacobian(*each)
        by_name = dict(zip(results, matrices if len(results) > 1 else (matrices,), strict=True))
        for (result, argument), (rows, wanted) in jacobians(example, name, each).items():
            matrix = np.asarray(by_name[result][names.index(argument)])[rows]
            found = max(found, ULP * apart(matrix, wanted))
    return {"jax Jacobian": found, "jit of it, s": seconds}


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.backends")
    parser.add_argument("machines", nargs="*", default=GOLDEN_MACHINES)
    parser.add_argument("--jacobians", action="store_true", help="compile JAX's Jacobians, too")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    jax.config.update("jax_enable_x64", True)
    calls = [(example, name) for example in given.machines for name in BOTH]
    rows = [row(*call, given.jacobians) for call in progress(calls, "backends")]
    columns = [*rows[0]]
    texts = [[_text(one[column], column) for column in columns] for one in rows]
    print_table("Units in the last place of the largest entry; Jacobians relative to theirs", columns, texts)
    if given.json:
        save_json(given.json, rows)
    return 0


def _text(figure: Any, column: str) -> str:
    if isinstance(figure, str):
        return figure
    return f"{figure:.1e}" if column.endswith("Jacobian") else f"{figure:.1f}"


if __name__ == "__main__":
    raise SystemExit(main())
