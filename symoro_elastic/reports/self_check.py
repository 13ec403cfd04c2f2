"""Digits of generated C that agree in all rounding modes: a table for the terminal, and JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from symoro_elastic.numerics.self_check import ResultCheck, Surviving


def self_check_table(checks: Sequence[ResultCheck]) -> Any:
    """Return a table of the spread of each result over the rounding modes, and the digits that agree at worst."""
    from rich.table import Table

    table = Table("model", "result", "moderate states", "digits", "extreme states", "digits", "worst at")
    for check in checks:
        spreads = [cell for found in (check.moderate, check.extreme) for cell in _cells(found)]
        table.add_row(check.model, check.result, *spreads, check.extreme.at)
    return table


def _cells(found: Surviving) -> tuple[str, str]:
    return f"{found.typical:.1e} / {found.worst:.1e}", f"{found.digits:.1f}"


def self_check_json(checks: Sequence[ResultCheck]) -> dict[str, Any]:
    """Return the same figures by model and result."""
    found: dict[str, Any] = {}
    for check in checks:
        figures = {"moderate": asdict(check.moderate), "extreme": asdict(check.extreme)}
        found.setdefault(check.model, {})[check.result] = figures
    return {"models": found}


def least_digits(checks: Sequence[ResultCheck]) -> float:
    """Return the digits that agree in the worst result at the worst moderate state."""
    return min((check.moderate.digits for check in checks), default=0.0)
