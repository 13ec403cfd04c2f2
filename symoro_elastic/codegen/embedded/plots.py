"""Plots of the report of generated C: maximum costs by function."""

from __future__ import annotations

from functools import partial
from typing import Any

from symoro_elastic.codegen.embedded.report import CodeReport
from symoro_elastic.foundation.pictures import Plot
from symoro_elastic.foundation.plot_style import bars
from symoro_elastic.foundation.results import figures_of


@figures_of.register
def _(report: CodeReport) -> dict[str, Plot | str]:
    """Return the plot of costs: instructions, stack and code by function."""
    title = f"{report.file}, {report.command}: cost of a call, at most"
    size = (10.0, 1.6 + 0.3 * len(report.functions))
    return {"costs": Plot(title, partial(_costs, report), columns=3, size=size)}


def _costs(report: CodeReport, *axes: Any) -> None:
    rows = [function.name for function in report.functions]
    heads = {"instructions": "instructions", "stack": "stack, bytes", "code": "code, bytes"}
    for axis, (field, head) in zip(axes, heads.items(), strict=True):
        bars(axis, {head: [getattr(f.cost, field) or 0 for f in report.functions]}, rows if axis is axes[0] else [])
        axis.set_xlabel(head)
        axis.set_ylim(len(rows) - 0.4, -0.6)
