"""Verification of generated code as tables, as data for JSON, and as rows of a data frame."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from symoro_elastic.foundation.results import Field, Part, declare, json_of, parts_of, table_of
from symoro_elastic.numerics.verification.forms import Choice, Form
from symoro_elastic.numerics.verification.self_check import ResultCheck, SelfCheck, Surviving
from symoro_elastic.numerics.verification.verify import ModelVerification, Verification, Worst


def _errors(worst: Worst | None) -> str:
    return f"{worst.moderate:.1e} / {worst.extreme:.1e}" if worst else "-"


def _moderate(model: ModelVerification) -> dict[str, float | None]:
    return {"numpy": model.numpy.moderate, "c": model.c.moderate if model.c else None}


declare(
    ModelVerification,
    Field("model", "name", "model", column="model", json=False),
    Field("c", lambda one: one.c.error if one.c else None, "C", text=lambda one: _errors(one.c), column="c"),
    Field("numpy", "numpy.error", "numpy", text=lambda one: _errors(one.numpy), column="numpy"),
    Field("equations", "equations.error", "floats", text=lambda one: _errors(one.equations), column="floats"),
    Field("moderate", _moderate),
    Field("bound", head="bound", form=".1e", column="bound"),
    Field("ok", head="", text=lambda one: "ok" if one.ok else "out of bounds", column="ok"),
)
declare(Verification, Field("models", rows=ModelVerification))


@parts_of.register
def _(result: Verification) -> list[Part]:
    """Return the table of worst errors at moderate and at extreme states, and the verdict."""
    verdict = "every error is within its bound" if result.ok else "out of bounds"
    title = f"{result.name}: worst relative error, moderate / extreme states"
    table = table_of(ModelVerification, result.models, title)
    return [table, f"{result.states} states against 50 digits: {verdict}"]


@json_of.register
def _(result: Verification) -> dict[str, Any]:
    """Return worst errors as plain data; `c` is null without a compiler."""
    models = {model.name: json_of(model) for model in result.models}
    compared = {"ok": result.ok and not result.missing, "states": result.states, "models": models}
    return compared | ({"missing": result.missing} if result.missing else {})


declare(Form, Field("operations"), Field("error_u", "error"))
declare(
    Choice, Field("chosen"), Field("reason"), Field("forms", lambda choice: {form.name: form for form in choice.forms})
)


def _spread(survives: Surviving) -> str:
    return f"{survives.typical:.1e} / {survives.worst:.1e}"


declare(
    ResultCheck,
    Field("model", head="model"),
    Field("result", head="result"),
    Field("moderate", head="moderate states", text=lambda check: _spread(check.moderate)),
    Field("digits", "moderate.digits", "digits", form=".1f"),
    Field("extreme", head="extreme states", text=lambda check: _spread(check.extreme)),
    Field("digits", "extreme.digits", "digits", form=".1f"),
    Field("worst", "extreme.at", "worst at"),
)


@parts_of.register
def _(result: SelfCheck) -> list[Part]:
    """Return the table of spreads over the rounding modes, and the digits that agree at worst."""
    title = f"{result.name}: spread over the rounding modes, typical / worst"
    sentence = f"at moderate states {result.least_digits:.1f} digits survive in the worst case"
    return [table_of(ResultCheck, result.checks, title), sentence]


@json_of.register
def _(result: SelfCheck) -> dict[str, Any]:
    """Return the spreads by model and result."""
    by_model: dict[str, Any] = {}
    for check in result.checks:
        spreads = {"moderate": asdict(check.moderate), "extreme": asdict(check.extreme)}
        by_model.setdefault(check.model, {})[check.result] = spreads
    return {"models": by_model}
