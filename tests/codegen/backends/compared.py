"""Models on other libraries beside those on numpy: states, parameters, and how far results are apart."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from inspect import signature
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

import symoro_elastic as se
from symoro_elastic.api.loaded import LoadedModel
from symoro_elastic.codegen.package import Package
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.states import moderate_states
from tests.closed_chains.machines import without_closed_form
from tests.golden import GOLDEN, ROOT

Array = np.ndarray[Any, Any]
GOLDEN_MACHINES = tuple(dict.fromkeys(golden.example for golden in GOLDEN))
BOTH = ("direct_dynamics", "inverse_dynamics")
ULP = float(np.finfo(float).eps)
STATES = 2


@cache
def machine(example: str) -> Machine:
    if example == "without_closed_form":
        return without_closed_form()
    return se.read(ROOT / "examples" / example, warn=lambda line: None)


@cache
def loaded(example: str, *models: str) -> LoadedModel:
    """Models on numpy; without names the direct and the inverse model, and their derivatives."""
    return se.load(machine(example), *(models or (*BOTH, *(f"{name}_derivatives" for name in BOTH))))


def on(library: Callable[[Package, ModuleType], Any], example: str, *models: str) -> Any:
    """The same models on a library, without tracing them again: what `load` does with them."""
    model = loaded(example, *models)
    return SimpleNamespace(**library(model._package, model._module))


def inputs(example: str, name: str, *models: str) -> dict[str, Array]:
    """Arguments of a function by name, a row for each state, and a set of parameters that exist, as p."""
    of, model = machine(example), loaded(example, *models)
    values = parameter_values(of)
    states = moderate_states(of, STATES, values=values)
    names = [*signature(getattr(model, name)).parameters][:-1]
    found = {
        argument: _placements(example, states.q) if argument == "T" else getattr(states, argument) for argument in names
    }
    return found | {"p": np.array([values[parameter] for parameter in model.PARAMETERS])}


def _placements(example: str, q: Array) -> Array:
    """Placements of the last frame, which it can reach, row by row."""
    p = inputs(example, "geometric_model", "geometric_model")["p"]
    return np.asarray(loaded(example, "geometric_model").geometric_model(q, p)[:, -1].reshape(len(q), 16))


def each_state(arguments: dict[str, Array]) -> Iterator[list[Array]]:
    """The arguments of each state in order, p the last."""
    *states, p = arguments.values()
    for k in range(STATES):
        yield [*(x[k] for x in states), p]


def apart(found: Any, expected: Any) -> float:
    """Largest difference of results over the largest entry of each, in units of the last place of 1."""
    pairs = zip(_all(found), _all(expected), strict=True)
    return max(_apart(np.asarray(x, dtype=float), np.asarray(y)) for x, y in pairs)


def _all(results: Any) -> list[Any]:
    return list(results) if isinstance(results, tuple | list) else [results]


def _apart(x: Array, y: Array) -> float:
    x = x.reshape(y.shape)
    assert np.array_equal(np.isnan(x), np.isnan(y))
    largest, difference = (np.nanmax(np.abs(z), initial=0.0) for z in (y, x - y))
    return float(difference / (largest or 1.0) / ULP)


def jacobians(example: str, name: str, arguments: list[Array]) -> dict[tuple[str, str], tuple[list[int], Array]]:
    """Generated derivatives by the result and the argument: their rows in the result, and the matrix."""
    model = loaded(example)
    found = getattr(model, f"{name}_derivatives")(*arguments)
    rows, whole = model.OUTPUTS[f"{name}_derivatives"], model.OUTPUTS[name]
    of = {f"d{result}_d{x}": (result, x) for result in whole for x in signature(getattr(model, name)).parameters}
    return {
        of[each]: ([whole[of[each][0]].index(row) for row in rows[each]], matrix)
        for each, matrix in zip(rows, found, strict=True)
    }
