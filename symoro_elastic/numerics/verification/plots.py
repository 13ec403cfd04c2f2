"""Plots of verifications: worst errors of generated code by model."""

from __future__ import annotations

from functools import partial
from typing import Any

from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import dots, legend
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.numerics.verification.verify import Verification


@figures_of.register
def _(result: Verification) -> dict[str, Plot | str]:
    """Return errors: of C, of numpy and of the equations on floats, and the bound, one line for each model."""
    title = f"{result.name}: worst relative error against 50 digits, {result.states} states"
    return {"errors": Plot(title, partial(_errors, result), size=(8.0, 1.6 + 0.3 * len(result.models)))}


def _errors(result: Verification, axes: Any) -> None:
    errors: dict[str, list[float | None]] = {
        "C": [one.c.error if one.c else None for one in result.models],
        "numpy": [one.numpy.error for one in result.models],
        "floats": [one.equations.error for one in result.models],
        "bound": [one.bound for one in result.models],
    }
    dots(axes, errors, [one.name for one in result.models])
    axes.set_xlabel("relative error; none is drawn for 0")
    legend(axes)
