"""Plots of a body by modes, its frequencies, and of errors by numbers of joints and modes."""

from __future__ import annotations

from functools import partial
from typing import Any

from symoro_elastic.analysis.flexible.parts import FlexibleParts
from symoro_elastic.analysis.flexible.reduction import FlexibleModes
from symoro_elastic.analysis.flexible.views import LEAST, MOST_ROWS, count_text
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import dots, legend
from symoro_elastic.foundation.results import figures_of


@figures_of.register
def _(result: FlexibleModes) -> dict[str, Plot | str]:
    """Return the frequencies of the first modes with the joint held, Hz."""
    count = min(result.body.count, MOST_ROWS)
    return {"frequencies": Plot(result.headline, partial(_frequencies, result, count), size=(8.0, 1.4 + 0.3 * count))}


def _frequencies(result: FlexibleModes, count: int, axes: Any) -> None:
    frequencies = result.body.frequencies[:count].tolist()
    dots(axes, {"frequency": frequencies}, [f"mode {k}" for k in range(1, count + 1)])
    axes.set_xlabel("frequency with the joint held, Hz")


@figures_of.register
def _(result: FlexibleParts) -> dict[str, Plot | str]:
    """Return errors of frequencies and of the compliance by part and number of joints or modes, in percent."""
    return {"errors": Plot(result.headline, partial(_errors, result), size=(8.0, 1.6 + 0.4 * len(result.rows)))}


def _errors(result: FlexibleParts, axes: Any) -> None:
    columns = {}
    for k, what in enumerate(("frequencies", "compliance")):
        for evidence in ("predicted", "measured"):
            errors = [getattr(row, evidence)[k] for row in result.rows]
            columns[f"{what}, {evidence}"] = [100 * x if x > LEAST else 0.0 for x in errors]
    dots(axes, columns, [f"{row.part}, {count_text(row)}" for row in result.rows])
    axes.set_xlabel("error, %")
    legend(axes)
