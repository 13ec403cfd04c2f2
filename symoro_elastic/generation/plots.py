"""Plots of written models: their operations, whole and reduced."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import bars, dots, legend
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.generation.pipeline import Generated
from symoro_elastic.generation.reduced import ReducedModel
from symoro_elastic.numerics.within.results import EntryError

MOST_ENTRIES = 60


@figures_of.register
def _(result: Generated) -> dict[str, Plot | str]:
    """Return a plot of products and sums by model, with those of the full machine if less was requested."""
    counts = {"products": [model.program.count.products for model in result.models]}
    counts["sums"] = [model.program.count.add for model in result.models]
    if any(full is not model for model, full in zip(result.models, result.whole, strict=True)):
        counts["products, whole machine"] = [model.program.count.products for model in result.whole]
        counts["sums, whole machine"] = [model.program.count.add for model in result.whole]
    title = f"{result.written[0].parent.name}: operations of a call"
    return {"operations": _operations(title, counts, [model.model.name for model in result.models])}


@figures_of.register
def _(model: ReducedModel) -> dict[str, Plot | str]:
    """Return plots of operations of the full and the reduced model, and of errors of its results by entry."""
    before, after = model.reduction.before, model.reduction.after
    counts = {"whole": [before.products, before.add], "left": [after.products, after.add]}
    entries = model.reduction.errors[:MOST_ENTRIES]
    errors = Plot(
        f"{model.model}: errors by what is left out", partial(_errors, entries), size=(8.0, 1.6 + 0.22 * len(entries))
    )
    return {"operations": _operations(model.headline, counts, ["products", "sums"]), "errors": errors}


def _errors(entries: Sequence[EntryError], axes: Any) -> None:
    columns = {name: [getattr(entry, name) for entry in entries] for name in ("unseen", "tolerance", "largest")}
    columns["at unseen states"], columns["largest value"] = columns.pop("unseen"), columns.pop("largest")
    dots(axes, columns, [f"{entry.output} {entry.index + 1}" for entry in entries])
    axes.set_xlabel("error, in the unit of the entry")
    legend(axes)


def _operations(title: str, counts: Mapping[str, Sequence[float]], rows: Sequence[str]) -> Plot:
    size = (8.0, 1.4 + (0.2 + 0.12 * len(counts)) * len(rows))
    return Plot(title, partial(_draw, counts, rows), size=size)


def _draw(counts: Mapping[str, Sequence[float]], rows: Sequence[str], axes: Any) -> None:
    bars(axes, counts, rows)
    axes.set_xlabel("operations of a call")
    legend(axes)
