"""Verification of generated code, as a table and as plain data."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from symoro_elastic.numerics.verify import Verification


def verification_table(result: Verification) -> Any:
    """Worst errors of each model: at moderate states / at extreme states."""
    from rich.table import Table

    table = Table("model", "C", "numpy", "floats", "bound", "")
    for model in result.models:
        errors = [
            f"{worst.moderate:.1e} / {worst.extreme:.1e}" if worst else "-"
            for worst in (model.c, model.numpy, model.equations)
        ]
        table.add_row(model.name, *errors, f"{model.bound:.1e}", "ok" if model.ok else "out of bounds")
    return table


def verification_json(result: Verification) -> dict[str, Any]:
    """Worst errors of each model as plain data; `c` is null without a compiler."""
    models = {
        model.name: {
            "numpy": model.numpy.error,
            "c": model.c.error if model.c else None,
            "equations": model.equations.error,
            "moderate": {"numpy": model.numpy.moderate, "c": model.c.moderate if model.c else None},
            "bound": model.bound,
            "ok": model.ok,
        }
        for model in result.models
    }
    found: dict[str, Any] = {"ok": result.ok and not result.missing, "states": result.states, "models": models}
    return found | ({"missing": result.missing} if result.missing else {})
