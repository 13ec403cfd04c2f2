"""Plots of written models: their operations, whole and reduced."""

from __future__ import annotations

from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.results import figures_of
from symoro_elastic.generation.pipeline import Generated
from symoro_elastic.generation.reduced_models.plots import operations_plot


@figures_of.register
def _(result: Generated) -> dict[str, Plot | str]:
    """Return a plot of products and sums by model, with those of the full machine if less was requested."""
    counts = {"products": [model.program.count.products for model in result.models]}
    counts["sums"] = [model.program.count.add for model in result.models]
    if any(full is not model for model, full in zip(result.models, result.whole, strict=True)):
        counts["products, whole machine"] = [model.program.count.products for model in result.whole]
        counts["sums, whole machine"] = [model.program.count.add for model in result.whole]
    title = f"{result.written[0].parent.name}: operations of a call"
    return {"operations": operations_plot(title, counts, [model.model.name for model in result.models])}
