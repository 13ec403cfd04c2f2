"""Averages that stand out from what all the others say: contacts, collisions, saturated motors.

Iteratively reweighted least squares with Cauchy's weights 1 / (1 + (r / 2.5 s)^2), s = 1.4826 median |r| of the rows of
each joint, finds parameters that outliers hardly move (Holland and Welsch 1977). Rows far off them are left out, and
least squares of the others has the usual standard deviations (Rousseeuw and Leroy 1987, reweighted least squares):
weights that depend on residuals would make these too small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symoro_elastic.analysis.identification.estimation import FROM_DATA, balanced
from symoro_elastic.analysis.identification.sensors import Columns
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.numerics.independence import independent_columns

CAUCHY = 2.5
TO_DEVIATION = 1.4826  # of the median of |r|
STANDS_OUT = 6.0  # standard deviations
ROUNDS = 30
MOST_NAMED = 4  # spans of time in a line


def outliers_of(columns: Columns) -> BoolArray:
    """Return which rows (rows, n) stand out; offsets of all motors and a delay are sought beside the parameters."""
    tau, slopes = columns.torques(0.0)
    Y = columns.joined(range(columns.offsets.shape[2]), slopes)[0]
    Y = Y[:, :, list(independent_columns(balanced(Y), FROM_DATA).kept)]
    used = Y.any(axis=2)
    weights = used.astype(float)
    deviation = np.ones(Y.shape[1])
    for _ in range(ROUNDS):
        root = np.sqrt(weights) / deviation
        X = np.linalg.lstsq((Y * root[:, :, None]).reshape(-1, Y.shape[2]), (tau * root).ravel(), rcond=None)[0]
        residuals = np.where(used, np.abs(tau - Y @ X), np.nan)
        medians = [float(np.median(r[~np.isnan(r)])) if (~np.isnan(r)).any() else 0.0 for r in residuals.T]
        found = TO_DEVIATION * np.array(medians)
        deviation = np.where(found > 0, found, 1.0)
        weights = used / (1 + (np.nan_to_num(residuals) / (CAUCHY * deviation)) ** 2)
    beyond: BoolArray = np.nan_to_num(residuals) > STANDS_OUT * np.where(found > 0, found, np.inf)
    return beyond


def without(columns: Columns, rows: BoolArray) -> Columns:
    """Return the columns with some rows (rows, n) left out."""
    kept = (~rows).astype(float)
    padded = np.pad(kept, ((0, len(columns.correlation)), (0, 0)))
    later = np.array([padded[k : k + len(kept)] for k in range(len(columns.correlation))])
    draws, torques = columns.draws, columns.torques
    return replace(
        columns, Y=columns.Y * kept[:, :, None], noise=tuple(D * kept[:, :, None] for D in columns.noise),
        offsets=columns.offsets * kept[:, :, None], correlation=columns.correlation * kept * later,
        torques=lambda delay: (torques(delay)[0] * kept, torques(delay)[1] * kept),
        draws=None if draws is None else lambda X: [D * kept for D in draws(X)],
    )  # fmt: skip


def said_of(t: Array, rows: BoolArray, used: BoolArray, joints: Sequence[str]) -> list[str]:
    """Return a line for each joint with rows at times t (rows) that are left out."""
    lines = []
    for k, joint in enumerate(joints):
        times = t[rows[:, k]]
        if not len(times):
            continue
        step = 3 * float(np.median(np.diff(t)))
        parts = np.split(times, np.flatnonzero(np.diff(times) > step) + 1)
        spans = [f"{x[0]:.4g} to {x[-1]:.4g} s" if len(x) > 1 else f"{x[0]:.4g} s" for x in parts]
        more = f" and {len(spans) - MOST_NAMED} more times" if len(spans) > MOST_NAMED else ""
        count = f"{len(times)} of {int(used[:, k].sum())} averages stand out and are left out"
        lines.append(f"outliers of {joint}: {count}, at {', '.join(spans[:MOST_NAMED])}{more}: look for contacts there")
    return lines or ["outliers: no average stands out, so nothing is left out"]
