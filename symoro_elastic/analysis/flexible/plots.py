"""Plot of a body by modes: its frequencies."""

from __future__ import annotations

from functools import partial
from typing import Any

from symoro_elastic.analysis.flexible.fe_body import FlexibleModes
from symoro_elastic.analysis.flexible.views import MOST_ROWS
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import dots
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
