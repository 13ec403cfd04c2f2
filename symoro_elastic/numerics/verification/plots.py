"""Plots of verifications: worst errors of generated code by model."""

from __future__ import annotations

from functools import partial
from typing import Any

from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import dots, legend
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.numerics.verification.self_check import SelfCheck
from symoro_elastic.numerics.verification.verify import Verification


@figures_of.register
def _(result: Verification) -> dict[str, Plot | str]:
    """Return errors: of C, of numpy and of the equations on floats, and the bound, one line for each model."""
    title = f"{result.name}: worst relative error against 50 digits, {result.states} states"
    return {"errors": Plot(title, partial(_errors, result), size=(8.0, 1.6 + 0.3 * len(result.models)))}


def _errors(result: Verification, axes: Any) -> None:
    errors: dict[str, list[float | None]] = {
        "C": [model.c.error if model.c else None for model in result.models],
        "numpy": [model.numpy.error for model in result.models],
        "floats": [model.equations.error for model in result.models],
        "bound": [model.bound for model in result.models],
    }
    dots(axes, errors, [model.name for model in result.models])
    axes.set_xlabel("relative error; none is drawn for 0")
    legend(axes)


@figures_of.register
def _(result: SelfCheck) -> dict[str, Plot | str]:
    """Return relative changes of each result with its order of operations and rounding, moderate and extreme states."""
    title = f"{result.name}: changes of results with order and rounding"
    return {"changes": Plot(title, partial(_changes, result), size=(8.0, 1.6 + 0.3 * len(result.checks)))}


def _changes(result: SelfCheck, axes: Any) -> None:
    moderate: list[float | None] = [10.0**-check.moderate.digits for check in result.checks]
    extreme: list[float | None] = [10.0**-check.extreme.digits for check in result.checks]
    dots(
        axes, {"moderate": moderate, "extreme": extreme}, [f"{check.model}, {check.result}" for check in result.checks]
    )
    axes.set_xlabel("relative change: ten to minus the digits that agree")
    legend(axes)
