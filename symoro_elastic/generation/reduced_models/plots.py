"""Plots of a model within tolerances: its operations, whole and reduced, and its errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import bars, dots, legend
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.generation.reduced_models.model import ReducedModel
from symoro_elastic.numerics.within.results import EntryError

MOST_ENTRIES = 60


@figures_of.register
def _(model: ReducedModel) -> dict[str, Plot | str]:
    """Return plots of operations of the full and the reduced model, and of errors of its results by entry."""
    before, after = model.reduction.before, model.reduction.after
    counts = {"whole": [before.products, before.add], "left": [after.products, after.add]}
    entries = model.reduction.errors[:MOST_ENTRIES]
    errors = Plot(
        f"{model.model}: errors by what is left out", partial(_errors, entries), size=(8.0, 1.6 + 0.22 * len(entries))
    )
    return {"operations": operations_plot(model.headline, counts, ["products", "sums"]), "errors": errors}


def _errors(entries: Sequence[EntryError], axes: Any) -> None:
    columns = {name: [getattr(entry, name) for entry in entries] for name in ("unseen", "tolerance", "largest")}
    columns["at unseen states"], columns["largest value"] = columns.pop("unseen"), columns.pop("largest")
    dots(axes, columns, [f"{entry.output} {entry.index + 1}" for entry in entries])
    axes.set_xlabel("error, in the unit of the entry")
    legend(axes)


def operations_plot(title: str, counts: Mapping[str, Sequence[float]], rows: Sequence[str]) -> Plot:
    """Return bars of operations by row."""
    size = (8.0, 1.4 + (0.2 + 0.12 * len(counts)) * len(rows))
    return Plot(title, partial(_draw, counts, rows), size=size)


def _draw(counts: Mapping[str, Sequence[float]], rows: Sequence[str], axes: Any) -> None:
    bars(axes, counts, rows)
    axes.set_xlabel("operations of a call")
    legend(axes)
