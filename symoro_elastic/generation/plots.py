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
def _(made: Generated) -> dict[str, Plot | str]:
    """Return operations: products and sums of each model, beside those of the whole machine if less was requested."""
    counts = {"products": [one.program.count.products for one in made.models]}
    counts["sums"] = [one.program.count.add for one in made.models]
    if any(full is not one for one, full in zip(made.models, made.whole, strict=True)):
        counts["products, whole machine"] = [one.program.count.products for one in made.whole]
        counts["sums, whole machine"] = [one.program.count.add for one in made.whole]
    title = f"{made.written[0].parent.name}: operations of a call"
    return {"operations": _operations(title, counts, [one.model.name for one in made.models])}


@figures_of.register
def _(one: ReducedModel) -> dict[str, Plot | str]:
    """Return operations of the whole model and of what is left, and errors of the entries of its results."""
    before, after = one.reduction.before, one.reduction.after
    counts = {"whole": [before.products, before.add], "left": [after.products, after.add]}
    entries = one.reduction.errors[:MOST_ENTRIES]
    errors = Plot(
        f"{one.model}: errors by what is left out", partial(_errors, entries), size=(8.0, 1.6 + 0.22 * len(entries))
    )
    return {"operations": _operations(one.headline, counts, ["products", "sums"]), "errors": errors}


def _errors(entries: Sequence[EntryError], axes: Any) -> None:
    columns = {name: [getattr(one, name) for one in entries] for name in ("unseen", "tolerance", "largest")}
    columns["at unseen states"], columns["largest value"] = columns.pop("unseen"), columns.pop("largest")
    dots(axes, columns, [f"{one.output} {one.index + 1}" for one in entries])
    axes.set_xlabel("error, in the unit of the entry")
    legend(axes)


def _operations(title: str, counts: Mapping[str, Sequence[float]], rows: Sequence[str]) -> Plot:
    size = (8.0, 1.4 + (0.2 + 0.12 * len(counts)) * len(rows))
    return Plot(title, partial(_draw, counts, rows), size=size)


def _draw(counts: Mapping[str, Sequence[float]], rows: Sequence[str], axes: Any) -> None:
    bars(axes, counts, rows)
    axes.set_xlabel("operations of a call")
    legend(axes)
