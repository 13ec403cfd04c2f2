"""Written files and their models: how they are printed and exported."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from symoro_elastic.codegen.package_context import count_json, operations
from symoro_elastic.foundation.results import Field, Part, Table, declare, json_of, parts_of, plain
from symoro_elastic.generation.pipeline import Generated
from symoro_elastic.generation.reduced import ReducedModel, said
from symoro_elastic.models.catalogue import TracedModel
from symoro_elastic.numerics.guarantees.certificates import Certificates
from symoro_elastic.symbolic.program import saving

declare(
    TracedModel,
    Field("model", "model.name", column="model"),
    Field("products", "program.count.products", column="products"),
    Field("sums", "program.count.add", column="sums"),
    Field("sincos", "program.count.sincos", column="sincos"),
)
declare(Generated, Field("models", rows=TracedModel))


declare(
    ReducedModel,
    Field("within", lambda one: {name or "all": str(x) for name, x in one.within.tolerances.items()}),
    Field("operations", lambda one: dict(zip(("whole", "left"), one.operations, strict=True))),
    Field("lost", lambda one: one.lost and asdict(one.lost)),
    Field("solved_exactly", "solved"),
    Field("shift_of_frequencies", "reduction.shift"),
    Field("unproven", "reduction.unproven"),
    Field("ended", "reduction.ended"),
    Field("left_out", lambda one: [change.term for change in one.reduction.left_out]),
    Field("certificates", lambda one: [certificate.as_json() for certificate in one.certificates]),
)


@parts_of.register
def _(one: ReducedModel) -> list[Part]:
    """Return what is left of a model, and its errors."""
    certificates = Certificates(one.certificates[0].machine, one.certificates) if one.certificates else None
    return [said(one), *(certificates.parts() if certificates else ())]


@parts_of.register
def _(made: Generated) -> list[Part]:
    """Return what was written, and the operations of each model."""
    written = f"wrote {made.written[0].parent}: {', '.join(path.name for path in made.written)}"
    notes = [f"note: {note}" for note in made.notes]
    chosen = [made.form.sentence] if made.form else []
    reports = [part for report in made.reports for part in report.parts()]
    counts: list[Part] = [models_table(made.models, made.whole), "x products and divisions, + sums and differences"]
    left_out = [part for one in made.reduced for part in one.parts()]
    return [written, *notes, *counts, *left_out, *chosen, *reports]


@json_of.register
def _(made: Generated) -> dict[str, Any]:
    """Return the paths, the operation counts of each model, and the reports by file if they were requested."""
    more: dict[str, Any] = {"notes": list(made.notes)} if made.notes else {}
    more |= {"reports": plain({report.file: report for report in made.reports})} if made.reports else {}
    more |= {"form": plain(made.form)} if made.form else {}
    more |= {"reduced": {_name(one, made.reduced): json_of(one) for one in made.reduced}} if made.reduced else {}
    return {"written": [str(path) for path in made.written], "models": models_json(made.models, made.whole), **more}


def _name(one: ReducedModel, found: Sequence[ReducedModel]) -> str:
    """The name of a model, and its precision where another target has another one."""
    alike = [other for other in found if other.model == one.model]
    return one.model if one is alike[0] else f"{one.model}, {one.certificates[0].precision}"


def models_json(models: Sequence[TracedModel], whole: Sequence[TracedModel]) -> dict[str, Any]:
    """Return operation counts of each model, and of the whole machine if less was requested."""
    counts: dict[str, Any] = {}
    for model, full in zip(models, whole, strict=True):
        counts[model.model.name] = count_json(model.program.count) | {"once": count_json(model.program.count_once)}
        if full is not model:
            counts[model.model.name]["whole"] = count_json(full.program.count)
            counts[model.model.name]["saved"] = dict(saving(full.program.count, model.program.count))
    return counts


def models_table(models: Sequence[TracedModel], whole: Sequence[TracedModel]) -> Table:
    """Return operation counts of each model, beside those of the whole machine if less was requested."""
    partial = any(full is not model for model, full in zip(models, whole, strict=True))
    each = ("whole machine", "asked", "saved") if partial else ("a call",)
    table = Table(("model", *each, "once for each parameter set"))
    for model, full in zip(models, whole, strict=True):
        counts = [operations(model.program.count)]
        if partial:
            counts = [operations(full.program.count), *counts, _share(full, model)]
        table.add_row(model.model.name, *counts, operations(model.program.count_once))
    return table


def _share(full: TracedModel, asked: TracedModel) -> str:
    before, after = (m.program.count.products + m.program.count.add for m in (full, asked))
    return f"{before - after} ({(before - after) / before:.0%})" if before else "-"
