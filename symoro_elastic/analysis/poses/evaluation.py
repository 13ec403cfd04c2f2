"""Results of generated models at one state, by the names of joints and frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.package import Result as ModelResult
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.names import no_such

ORDERS = {"q": "q", "qd": "qd", "qdd": "qdd", "tau": "tau"}
"""Quantities by the name after that of a joint and a dot: position, velocity, acceleration, torque."""
OF_JOINTS = {"q": "q", "qd": "qd", "qdd": "qdd", "qdd_motor": "qdd", "tau": "tau", "load": "tau"}
"""Quantities of joints by the arguments of functions that have them."""


@dataclass(frozen=True)
class EvaluatedResult:
    """One result of a model at a state: its entries by the names of rows, and of columns where it has them.

    An entry is a number, a vector by column, or a matrix; `meaning` has the unit.
    """

    name: str
    meaning: str
    entries: Mapping[str, Any]
    columns: tuple[str, ...] = ()


@dataclass(frozen=True, repr=False)
class Evaluation(Result):
    """Results of models by model, at a state given by signal (`shoulder.q`, `shoulder.qd`); all else is zero."""

    machine: str
    at: Mapping[str, float]
    models: Mapping[str, tuple[EvaluatedResult, ...]] = field(repr=False)

    @property
    def headline(self) -> str:
        """Machine, models, and the state."""
        state = ", ".join(f"{name} = {x:g}" for name, x in self.at.items()) or "all zero"
        return f"{self.machine} at {state}: {', '.join(self.models)}"


def evaluation(model: Any, package: Package, at: Mapping[str, float], source: str) -> Evaluation:
    """Return the results of all functions of a loaded model at a state by signal; raises `InputError`.

    A joint's name alone is its position. Functions with other arguments than a state of joints are rejected by name.
    """
    state = _state(package, at, source)
    results = {}
    for function in package.functions:
        values = getattr(model, function.name)(*_arguments(function, package, state, source))
        several = values if isinstance(values, tuple) else (values,)
        pairs = zip(function.results, several, strict=True)
        results[function.name] = tuple(_by_rows(result, np.asarray(x, dtype=float), package) for result, x in pairs)
    return Evaluation(package.name, dict(at), results)


def _state(package: Package, at: Mapping[str, float], source: str) -> dict[str, dict[str, float]]:
    """Return q, qd, qdd and tau by joint; raises `InputError` for names other than those of joints."""
    names = list(dict.fromkeys(axis.name for axis in (*package.axes, *(package.driven or ()))))
    state: dict[str, dict[str, float]] = {order: {} for order in ORDERS}
    for signal, x in at.items():
        joint, _, order = signal.partition(".")
        if joint not in names:
            raise InputError(source, f"--at, {signal}", no_such("moving joint", joint, names))
        if (order or "q") not in ORDERS:
            raise InputError(source, f"--at, {signal}", f"write {joint}, {joint}.qd, {joint}.qdd or {joint}.tau")
        state[order or "q"][joint] = x
    return state


def _arguments(
    function: Function, package: Package, state: Mapping[str, Mapping[str, float]], source: str
) -> list[Array]:
    """Return the arguments of a function but for p, which has its default."""
    arguments = []
    joints = [axis.name for axis in package.axes]
    for argument in function.arguments:
        if argument.name == "p":
            continue
        order = OF_JOINTS.get(argument.name)
        if order is None:
            what = f"it has the argument {argument.name} ({argument.meaning}): use se.load and call it"
            raise InputError(source, f"--model, {function.name}", what)
        names = list(package.motor_names) if argument.name in ("tau", "qdd_motor") else joints
        if argument.size != len(names):
            what = f"its {argument.name} does not follow the joints of the table: use se.load and call it"
            raise InputError(source, f"--model, {function.name}", what)
        arguments.append(np.array([state[order].get(name, 0.0) for name in names]))
    return arguments


def _by_rows(result: ModelResult, x: Array, package: Package) -> EvaluatedResult:
    """Return a result by the names of its rows; those of a result without are its entries' numbers."""
    rows = result.rows if len(result.rows) == len(x) and x.ndim else tuple(map(str, range(x.shape[0] if x.ndim else 1)))
    entries = dict(zip(rows, np.atleast_1d(x).tolist(), strict=True))
    joints = tuple(axis.name for axis in package.axes)
    columns = next((y for y in (result.columns, joints) if x.ndim > 1 and len(y) == x.shape[-1]), ())
    return EvaluatedResult(result.name, result.meaning, entries, columns)
