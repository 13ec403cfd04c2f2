"""What an identification found, as text and as figures."""

from __future__ import annotations

import math
from collections.abc import Mapping

from symoro_elastic.identification.identify import Identification
from symoro_elastic.identification.validation import Fit, own_fit


def file_values(result: Identification) -> dict[str, float]:
    """Return the values that the machine's file gives, by label; those that it does not give are missing."""
    nominal = {e.unknown.label: e.unknown.nominal for e in result.estimates}
    return {label: x for label, x in nominal.items() if not math.isnan(x)}


def table(result: Identification, true: Mapping[str, float] | None = None, head: str = "true") -> str:
    """Return the estimates as aligned text; `true` values by label where they are known, under the title `head`."""
    heads = ["parameter", *([head] if true is not None else []), "estimated", "std", "std %", "unit", "verdict"]
    rows = [heads]
    for e in result.estimates:
        given = [_number((true or {}).get(e.unknown.label, math.nan))] if true is not None else []
        percent = "-" if not math.isfinite(e.relative) else f"{100 * e.relative:.2g}"
        verdict = f"{e.verdict}: {e.reason}" if e.reason else str(e.verdict)
        rows.append([e.unknown.formula, *given, _number(e.value), _number(e.std), percent, e.unknown.unit, verdict])
    widths = [max(len(row[k]) for row in rows) for k in range(len(heads) - 1)]
    return "\n".join(
        "  ".join([row[0].ljust(widths[0]), *(x.rjust(w) for x, w in zip(row[1:-1], widths[1:], strict=True)), row[-1]])
        for row in rows
    )


def _number(x: float) -> str:
    return "-" if math.isnan(x) else f"{x:.5g}"


def as_json(result: Identification, validation: Fit | None = None) -> dict[str, object]:
    """Return the figures for JSON: parameters, joints' residuals, condition number, notes."""
    solution, own = result.estimation.solution, own_fit(result)
    return {
        "parameters": {
            e.unknown.label: {
                "formula": e.unknown.formula,
                "value": _finite(e.value),
                "file": _finite(e.unknown.nominal),
                "std": _finite(e.std),
                "relative_std": _finite(e.relative),
                "unit": e.unknown.unit,
                "verdict": str(e.verdict),
                "reason": e.reason,
            }
            for e in result.estimates
        },
        "neutral_positions": {name: {"value": v, "std": s} for name, (v, s) in result.neutral.items()},
        "residual_std": dict(zip(result.estimation.joints, solution.sigma.tolist(), strict=True)),
        "residual_percent": {name: _finite(x) for name, x in own.percent.items()},
        **({} if validation is None else {"validation": _figures(validation)}),
        "condition": solution.condition,
        "samples": len(result.t),
        "not_identifiable": list(result.estimation.not_identifiable),
        "notes": list(result.notes),
    }


def _figures(fit: Fit) -> dict[str, object]:
    return {
        "source": fit.source,
        "residual_rms": fit.residual,
        "residual_percent": {name: _finite(x) for name, x in fit.percent.items()},
    }


def _finite(x: float) -> float | None:
    return x if math.isfinite(x) else None


def neutral_positions(result: Identification) -> list[str]:
    """Return a line for each spring with an identified neutral position."""
    units = {joint.name: joint.unit for joint in result.machine.joints}
    return [
        f"neutral position of {name}: {q0:.5g} {units[name]}, std {std:.2g}"
        for name, (q0, std) in result.neutral.items()
    ]
