"""How often the spread over the rounding modes covers the true error of a result."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.packaging import package
from symoro_elastic.models.programs.catalogue import TracedModel, trace
from symoro_elastic.numerics.evaluation.arrays import EXTENDED, evaluate_arrays
from symoro_elastic.numerics.evaluation.values import ParameterValues, parameter_values
from symoro_elastic.numerics.verification.self_check import RoundingModes, Spread
from symoro_elastic.numerics.verification.states import States
from tests.extremes.corpus import DIRECT, INVERSE

AT_ONCE = 2000


def bracketed(machine: Machine, states: States) -> Iterator[tuple[str, str, float, float]]:
    """(model, result, share of the states whose error the spread covers, largest error over its spread).

    A result that is not a number is covered where the spread is infinite.
    """
    values = parameter_values(machine)
    traced = [trace(machine, name) for name in (DIRECT, INVERSE)]
    described = package(machine, traced, ())
    p = np.array([values[parameter.name] for parameter in described.parameters], dtype=float)
    with TemporaryDirectory() as folder:
        modes = RoundingModes(described, Path(folder))
        for model in traced:
            arguments = {name: getattr(states, name) for name in model.model.arguments} | {"p": p}
            for name, spread in modes.run(model.model.name, len(states), arguments).items():
                errors = _errors(model, name, spread, states, values)
                told = np.isfinite(spread.spread)
                share = np.max(errors[told] / spread.spread[told], initial=0.0)
                yield model.model.name, name, float(np.mean(errors <= spread.spread)), float(share)


def _errors(
    model: TracedModel, name: str, spread: Spread, states: States, values: ParameterValues
) -> NDArray[np.float64]:
    """Largest error of a state over its largest exact entry."""
    errors = np.empty(len(states))
    for start in range(0, len(states), AT_ONCE):
        part = slice(start, start + AT_ONCE)
        exact = evaluate_arrays(model, states[part], values, EXTENDED)[name]
        scale = np.abs(exact).max(axis=1, initial=0)
        with np.errstate(invalid="ignore"):
            difference = np.abs(spread.results[part] - exact).max(axis=1, initial=0)
        errors[part] = difference / np.where(scale > 0, scale, 1)
    return np.where(np.isfinite(errors), errors, np.inf)
