"""What quantities do to figures: local slopes on a grid, correlations of ranks in a sample."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.packages import imported
from symoro_elastic.sweeps.design import Design

FEWEST = 3
"""Points of which ranks are correlated."""


@dataclass(frozen=True)
class Influence:
    """A number (figures, quantities) that says how much each quantity does to each figure; NaN where it is unknown.

    On a grid it is the share of the range of the figure that its mean passes through along the quantity, -1 to 1, and
    `slopes` (figures, quantities) are the medians of the local slopes d ln f / d ln x. In a sample it is Spearman's
    correlation of ranks, and there are no slopes.
    """

    figures: tuple[str, ...]
    quantities: tuple[str, ...]
    values: Array
    slopes: Array | None = None

    @property
    def title(self) -> str:
        """What the numbers are."""
        if self.slopes is None:
            return "influence: correlation of ranks"
        return "influence: share of the range / per cent by per cent"

    def strongest(self) -> list[int]:
        """Return the numbers of the quantities, that with the largest influence on any figure first."""
        most = np.nan_to_num(np.abs(self.values)).max(axis=0, initial=0.0)
        return [int(k) for k in np.argsort(-most, kind="stable")]


def influence(design: Design, figures: Mapping[str, Array]) -> Influence:
    """Return what the quantities of a design do to figures (N,)."""
    each = [(_of_grid if design.is_grid else _of_sample)(design, x) for x in figures.values()]
    values = np.array([row for row, _ in each]).reshape(len(figures), len(design.names))
    slopes = np.array([row for _, row in each]).reshape(values.shape) if design.is_grid else None
    return Influence(tuple(figures), design.names, values, slopes)


def local_slopes(design: Design, figure: Array, k: int) -> Array:
    """Return d ln|f| / d ln|x| (lengths) by the k-th quantity of a grid, by central differences of the logarithms.

    A power of x has its exponent on any grid. NaN where the quantity has one value, is 0 or changes its sign, and at
    points without a value, with the value 0, or beside one that has none or one of the other sign.
    """
    x = design.along(k)
    if len(x) < 2 or not (x.min() > 0 or x.max() < 0):
        return np.full(design.lengths, np.nan)
    order = np.argsort(x, kind="stable")
    f = np.take(figure.reshape(design.lengths), order, axis=k)
    slopes = np.full(f.shape, np.nan)
    for sign in (1.0, -1.0):
        here = sign * f > 0
        logarithms = np.log(sign * f, where=here, out=np.full(f.shape, np.nan))
        slopes = np.where(here, np.gradient(logarithms, np.log(np.abs(x[order])), axis=k), slopes)
    found: Array = np.take(slopes, np.argsort(order, kind="stable"), axis=k)
    return found


def _of_grid(design: Design, figure: Array) -> tuple[Array, Array]:
    figure = np.where(np.isfinite(figure), figure, np.nan)
    shares, relative = np.full((2, len(design.names)), np.nan)
    there = figure[~np.isnan(figure)]
    whole = float(np.ptp(there)) if len(there) else 0.0
    on_grid = figure.reshape(design.lengths)
    for k in range(len(design.names)):
        x = design.along(k)
        if len(x) < 2 or not len(there):
            continue
        means = _means(np.moveaxis(on_grid, k, 0).reshape(len(x), -1))[np.argsort(x, kind="stable")]
        way = np.sign(np.nan_to_num(means[-1] - means[0])) or 1.0
        shares[k] = way * np.ptp(means[~np.isnan(means)]) / whole if whole else 0.0
        slopes = local_slopes(design, figure, k)
        usable = np.isfinite(slopes)
        relative[k] = np.median(slopes[usable]) if usable.any() else np.nan
    return shares, relative


def _means(rows: Array) -> Array:
    """Return the mean of each row over its numbers; NaN where it has none."""
    there = ~np.isnan(rows)
    count = there.sum(axis=1)
    found: Array = np.where(count > 0, np.where(there, rows, 0.0).sum(axis=1) / np.maximum(count, 1), np.nan)
    return found


def _of_sample(design: Design, figure: Array) -> tuple[Array, Array]:
    """Return Spearman's correlations over the points with a value; 0 where the figure does not change."""
    there = ~np.isnan(figure)
    found = np.full(len(design.names), np.nan)
    if there.sum() >= FEWEST:
        ranked = imported("scipy.stats", "correlation of ranks", "sweep").rankdata
        y = ranked(figure[there])
        for k in range(len(design.names)):
            x = ranked(design.points[there, k])
            both = float(np.ptp(x) * np.ptp(y))
            found[k] = np.corrcoef(x, y)[0, 1] if both else 0.0
    return found, found
