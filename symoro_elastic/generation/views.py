"""Written files and their models: how they are printed and exported."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from symoro_elastic.codegen.package_context import count_json, operations
from symoro_elastic.foundation.results import Field, Part, Table, declare, json_of, parts_of, plain
from symoro_elastic.generation.pipeline import Generated
from symoro_elastic.generation.reduced_models.model import ReducedModel
from symoro_elastic.models.programs.catalogue import TracedModel
from symoro_elastic.symbolic.program import saving

declare(
    TracedModel,
    Field("model", "model.name", column="model"),
    Field("products", "program.count.products", column="products"),
    Field("sums", "program.count.add", column="sums"),
    Field("sincos", "program.count.sincos", column="sincos"),
)
declare(Generated, Field("models", rows=TracedModel))


@parts_of.register
def _(result: Generated) -> list[Part]:
    """Return the written files, and a table of operations by model."""
    written = f"wrote {result.written[0].parent}: {', '.join(path.name for path in result.written)}"
    notes = [f"note: {note}" for note in result.notes]
    chosen = [result.form.sentence] if result.form else []
    reports = [part for report in result.reports for part in report.parts()]
    counts: list[Part] = [models_table(result.models, result.whole), "x products and divisions, + sums and differences"]
    left_out = [part for model in result.reduced for part in model.parts()]
    return [written, *notes, *counts, *left_out, *chosen, *reports]


@json_of.register
def _(result: Generated) -> dict[str, Any]:
    """Return the paths, the operation counts by model, and the reports by file if they were requested."""
    more: dict[str, Any] = {"notes": list(result.notes)} if result.notes else {}
    more |= {"reports": plain({report.file: report for report in result.reports})} if result.reports else {}
    more |= {"form": plain(result.form)} if result.form else {}
    more |= {"reduced": {_name(x, result.reduced): json_of(x) for x in result.reduced}} if result.reduced else {}
    written = [str(path) for path in result.written]
    return {"written": written, "models": models_json(result.models, result.whole), **more}


def _name(model: ReducedModel, models: Sequence[ReducedModel]) -> str:
    """The name of a model, with its precision where it is not the first of this name."""
    first = next(other for other in models if other.model == model.model)
    return model.model if model is first else f"{model.model}, {model.certificates[0].precision}"


def models_json(models: Sequence[TracedModel], whole: Sequence[TracedModel]) -> dict[str, Any]:
    """Return operation counts by model, and those of the full machine if less was requested."""
    counts: dict[str, Any] = {}
    for model, full in zip(models, whole, strict=True):
        counts[model.model.name] = count_json(model.program.count) | {"once": count_json(model.program.count_once)}
        if full is not model:
            counts[model.model.name]["whole"] = count_json(full.program.count)
            counts[model.model.name]["saved"] = dict(saving(full.program.count, model.program.count))
    return counts


def models_table(models: Sequence[TracedModel], whole: Sequence[TracedModel]) -> Table:
    """Return a table of operation counts by model, with those of the full machine if less was requested."""
    partial = any(full is not model for model, full in zip(models, whole, strict=True))
    counted = ("whole machine", "asked", "saved") if partial else ("a call",)
    table = Table(("model", *counted, "once for each parameter set"))
    for model, full in zip(models, whole, strict=True):
        counts = [operations(model.program.count)]
        before, after = (m.program.count.products + m.program.count.add for m in (full, model))
        if partial:
            share = f"{before - after} ({(before - after) / before:.0%})" if before else "-"
            counts = [operations(full.program.count), *counts, share]
        table.add_row(model.model.name, *counts, operations(model.program.count_once))
    return table
