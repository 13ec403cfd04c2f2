"""Operation counts of models, as a table and as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from symoro_elastic.models.model import TracedModel
from symoro_elastic.symbolic.program import OperationCount, saved


def count_json(count: OperationCount) -> dict[str, int]:
    """Operations by kind."""
    return {"mul": count.mul, "add": count.add, "div": count.div, "sincos": count.sincos}


def models_json(models: Sequence[TracedModel], whole: Sequence[TracedModel]) -> dict[str, Any]:
    """Operation counts of each model, and of the whole machine where less was asked for."""
    found: dict[str, Any] = {}
    for model, full in zip(models, whole, strict=True):
        found[model.model.name] = count_json(model.program.count) | {"once": count_json(model.program.count_once)}
        if full is not model:
            found[model.model.name]["whole"] = count_json(full.program.count)
            found[model.model.name]["saved"] = dict(saved(full.program.count, model.program.count))
    return found


def models_table(models: Sequence[TracedModel], whole: Sequence[TracedModel]) -> Any:
    """Operation counts of each model, beside those of the whole machine where less was asked for."""
    from rich.table import Table

    partial = any(full is not model for model, full in zip(models, whole, strict=True))
    table = Table(
        "model", *(("whole machine", "asked", "saved") if partial else ("a call",)), "once for each parameter set"
    )
    for model, full in zip(models, whole, strict=True):
        once = operations(model.program.count_once)
        asked = operations(model.program.count)
        if not partial:
            table.add_row(model.model.name, asked, once)
        else:
            table.add_row(model.model.name, operations(full.program.count), asked, _share(full, model), once)
    return table


def operations(count: OperationCount) -> str:
    """`292x 277+ 10 sin/cos`; x counts products and divisions, + sums and differences."""
    if count == OperationCount():
        return "-"
    return f"{count.products}x {count.add}+" + (f" {count.sincos} sin/cos" if count.sincos else "")


def _share(full: TracedModel, asked: TracedModel) -> str:
    before, after = (m.program.count.products + m.program.count.add for m in (full, asked))
    return f"{before - after} ({(before - after) / before:.0%})" if before else "-"
