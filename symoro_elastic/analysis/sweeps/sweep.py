"""The result of a sweep: values at points, the influence of the quantities on them, and files.

Files are .csv with a row for each point, NetCDF with a dimension for each quantity of a grid, .npz.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import cache, cached_property
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.sweeps.design import Design
from symoro_elastic.analysis.sweeps.tasks import Outcome
from symoro_elastic.analysis.time_series.writing import CSV, write_columns
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.file_forms import SWEEPS, form_of
from symoro_elastic.foundation.output_files import permission, write_file
from symoro_elastic.foundation.packages import import_optional
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.names import did_you_mean, quote

FEWEST = 3
"""Least number of points for a correlation of ranks."""

NETCDF = ".nc"
"""Endings of files."""
REASON = "reason"
CONFIDENCE = 0.95
INDEPENDENT = ("random", "latin")
ALL = "all of them"


@dataclass(frozen=True, repr=False)
class Sweep(Result):
    """Results (N,) by name at the N points of a design; NaN with a reason for failed points.

    `units` are those of quantities and results, where they are known, `shares` those of points at which results are in
    the ranges that are required. Points are in the order of the design: of a grid
    the last quantity varies fastest.
    """

    machine: str
    of: str
    design: Design
    figures: Mapping[str, Array]
    reasons: tuple[str, ...]
    units: Mapping[str, str] = field(default_factory=dict)
    shares: tuple[Share, ...] = ()

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the swept quantities."""
        return self.design.names

    @property
    def points(self) -> Array:
        """Values of the quantities (N, quantities), SI units, radians."""
        return self.design.points

    @property
    def failures(self) -> int:
        """Number of points without a result."""
        return sum(map(bool, self.reasons))

    @cached_property
    def influence(self) -> Influence:
        """Influence of the quantities on each result: slopes on a grid, rank correlations in a sample."""
        return influence(self.design, self.figures)

    def on_grid(self, name: str) -> Array:
        """Return a result as an array with a dimension for each quantity of a grid."""
        return self.figures[name].reshape(self.design.lengths or (-1,))

    @property
    def headline(self) -> str:
        """Machine, points, quantities and results."""
        failed = f", {self.failures} without a result" if self.failures else ""
        where = f"{len(self.points)} points of {', '.join(self.quantities)}"
        return f"Sweep of {self.machine}: {self.of} at {where}{failed}"

    def dataset(self) -> Any:
        """Return an `xarray.Dataset`: a dimension for each quantity of a grid, or `point`; raises `InputError`."""
        return _dataset(self)

    def write(self, path: str | Path, *, force: bool = False) -> Path:
        """Write a .csv, .nc (NetCDF) or .npz file, and return its path; raises `InputError`."""
        with permission(force=force):
            save(self, path)
        return Path(path)


def sweep_of(
    machine: str,
    of: str,
    design: Design,
    outcomes: Sequence[Outcome],
    units: Mapping[str, str],
    patterns: Collection[str] = (),
    required: Mapping[str, tuple[float, float]] | None = None,
) -> Sweep:
    """Return the sweep of outcomes, with all results or those that match a pattern. Raises `InputError`.

    `required` are ranges of results, by name or pattern.
    """
    names = list(dict.fromkeys(name for outcome in outcomes for name in outcome.figures))
    names = _chosen(names, patterns, "--result")
    missing = {name: float("nan") for name in names}
    rows = [{**missing, **outcome.figures} for outcome in outcomes]
    figures = {name: np.array([row[name] for row in rows]) for name in names}
    conflicts = set(design.names).intersection(names)
    if conflicts or REASON in names:
        what = f"{min(conflicts | {REASON})!r} is a column already: give the result another name"
        raise InputError("symoro-elastic", "--of", what)
    reasons = tuple(outcome.reason for outcome in outcomes)
    known_units = {name: unit for name, unit in units.items() if unit}
    return Sweep(machine, of, design, figures, reasons, known_units, shares(design, figures, required or {}))


def _chosen(names: Collection[str], patterns: Collection[str], option: str) -> list[str]:
    """Return the names that match a pattern; raises `InputError` for a pattern without a match."""
    for pattern in patterns:
        if not any(_matches(name, pattern) for name in names):
            what = f"no result is called {quote(pattern)}{did_you_mean(pattern, names)}"
            raise InputError("symoro-elastic", option, what)
    return [name for name in names if not patterns or any(_matches(name, pattern) for pattern in patterns)]


def _matches(name: str, pattern: str) -> bool:
    return name == pattern or fnmatchcase(name, pattern)


def refuse_form(path: str | Path) -> None:
    """Raise `InputError` for a file whose suffix is not a known format, or whose format needs a package."""
    if form_of(path, SWEEPS, "--out") == NETCDF:
        _xarray()


def save(sweep: Sweep, path: str | Path) -> None:
    """Write a sweep in the format of the suffix, the same bytes for the same numbers. Raises `InputError`."""
    refuse_form(path)
    suffix = Path(path).suffix.lower()
    if suffix == CSV:
        write_columns(sweep.arrays() | {REASON: np.array(sweep.reasons)}, path, sweep.units)
    elif suffix == NETCDF:
        write_file(bytes(_dataset(sweep).to_netcdf(engine="scipy", format="NETCDF3_64BIT")), path, "--out")
    else:
        write_columns(sweep.arrays(), path)


def _dataset(sweep: Sweep) -> Any:
    """Return an `xarray.Dataset` with units and with reasons of failed points; raises `InputError`."""
    design = sweep.design
    dims = design.names if design.is_grid else ("point",)
    shape = design.lengths or (-1,)
    if design.is_grid:
        coords: dict[str, Any] = {name: (name, design.along(k)) for k, name in enumerate(design.names)}
    else:
        coords = {name: ("point", sweep.points[:, k]) for k, name in enumerate(design.names)}
    figures: dict[str, Any] = {name: (dims, x.reshape(shape)) for name, x in sweep.figures.items()}
    if sweep.failures:
        figures[REASON] = (dims, np.array([x.encode("utf-8") for x in sweep.reasons]).reshape(shape))
    names = {name: name.replace("/", "over") for name in figures}
    attributes: dict[str, Any] = {"title": f"{sweep.of} of {sweep.machine}", "sampling": design.sampling}
    attributes |= {} if design.is_grid else {"seed": design.seed}
    dataset = _xarray().Dataset({names[name]: x for name, x in figures.items()}, coords, attributes)
    for name in (*coords, *figures):
        if name in sweep.units:
            dataset[names.get(name, name)].attrs["units"] = sweep.units[name]
    return dataset


def _xarray() -> Any:
    import_optional("scipy.io", "NetCDF", "sweep")
    return import_optional("xarray", "NetCDF", "sweep")


# What quantities do to figures: local slopes on a grid, correlations of ranks in a sample.
@dataclass(frozen=True)
class Influence:
    """The influence (results, quantities) of the quantities on each result; NaN if unknown.

    On a grid it is the share of the range of the figure that its mean passes through along the quantity, -1 to 1, and
    `slopes` (figures, quantities) are the medians of the local slopes d ln f / d ln x. In a sample it is Spearman's
    correlation of ranks, without slopes.
    """

    figures: tuple[str, ...]
    quantities: tuple[str, ...]
    values: Array
    slopes: Array | None = None

    @property
    def title(self) -> str:
        """Title of the table of influences: the meaning of its numbers."""
        if self.slopes is None:
            return "influence: correlation of ranks"
        return "influence: share of the range / per cent by per cent"

    def strongest(self) -> list[int]:
        """Return the indices of the quantities, ordered by their largest influence on any result."""
        most = np.nan_to_num(np.abs(self.values)).max(axis=0, initial=0.0)
        return [int(k) for k in np.argsort(-most, kind="stable")]


def influence(design: Design, figures: Mapping[str, Array]) -> Influence:
    """Return the influence of the quantities of a design on results (N,)."""
    results = [(_of_grid if design.is_grid else _of_sample)(design, x) for x in figures.values()]
    values = np.array([row for row, _ in results]).reshape(len(figures), len(design.names))
    slopes = np.array([row for _, row in results]).reshape(values.shape) if design.is_grid else None
    return Influence(tuple(figures), design.names, values, slopes)


def local_slopes(design: Design, figure: Array, k: int) -> Array:
    """Return d ln|f| / d ln|x| (lengths) by the k-th quantity of a grid, by central differences of the logarithms.

    A power of x has its exponent on any grid. NaN where the quantity has one value, is 0 or changes its sign, and at
    points without a value, with the value 0, or next to one without value or of the other sign.
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
    return np.asarray(np.take(slopes, np.argsort(order, kind="stable"), axis=k))


def _of_grid(design: Design, figure: Array) -> tuple[Array, Array]:
    figure = np.where(np.isfinite(figure), figure, np.nan)
    shares, relative = np.full((2, len(design.names)), np.nan)
    there = figure[~np.isnan(figure)]
    total = float(np.ptp(there)) if len(there) else 0.0
    on_grid = figure.reshape(design.lengths)
    for k in range(len(design.names)):
        x = design.along(k)
        if len(x) < 2 or not len(there):
            continue
        means = _means(np.moveaxis(on_grid, k, 0).reshape(len(x), -1))[np.argsort(x, kind="stable")]
        way = np.sign(np.nan_to_num(means[-1] - means[0])) or 1.0
        shares[k] = way * np.ptp(means[~np.isnan(means)]) / total if total else 0.0
        slopes = local_slopes(design, figure, k)
        usable = np.isfinite(slopes)
        relative[k] = np.median(slopes[usable]) if usable.any() else np.nan
    return shares, relative


def _means(rows: Array) -> Array:
    """Return the mean of each row without its NaN; NaN for a row without numbers."""
    there = ~np.isnan(rows)
    count = there.sum(axis=1)
    return np.asarray(np.where(count > 0, np.where(there, rows, 0.0).sum(axis=1) / np.maximum(count, 1), np.nan))


def _of_sample(design: Design, figure: Array) -> tuple[Array, Array]:
    """Return Spearman's correlations over the points with a value; 0 for a constant result."""
    there = ~np.isnan(figure)
    correlations = np.full(len(design.names), np.nan)
    if there.sum() >= FEWEST:
        ranked = import_optional("scipy.stats", "correlation of ranks", "sweep").rankdata
        y = ranked(figure[there])
        for k in range(len(design.names)):
            x = ranked(design.points[there, k])
            both = float(np.ptp(x) * np.ptp(y))
            correlations[k] = np.corrcoef(x, y)[0, 1] if both else 0.0
    return correlations, correlations


@dataclass(frozen=True)
class Share:
    """Fraction of points with a result in its range: number `within` of `points`, and its confidence interval."""

    name: str
    low: float
    high: float
    within: int
    points: int
    interval: tuple[float, float] | None

    @property
    def share(self) -> float:
        """The fraction of the points."""
        return self.within / self.points


def shares(
    design: Design, figures: Mapping[str, Array], required: Mapping[str, tuple[float, float]]
) -> tuple[Share, ...]:
    """Return the fraction of points within its range for each result, and that within all ranges.

    `required` are ranges by name of a result, or by pattern. A point without a result is not within. Raises
    `InputError` for a name that no result has.
    """
    rows: list[Share] = []
    everywhere = np.ones(len(design.points), dtype=bool)
    for pattern, ends in required.items():
        low, high = _ends(pattern, ends)
        for name in _chosen(figures, [pattern], "--require"):
            inside = (figures[name] >= low) & (figures[name] <= high)
            everywhere &= inside
            rows.append(_share(design, name, low, high, inside))
    if len(rows) > 1:
        rows.append(_share(design, ALL, -np.inf, np.inf, everywhere))
    return tuple(rows)


def _ends(name: str, bounds: object) -> tuple[float, float]:
    if isinstance(bounds, Sequence) and len(bounds) == 2 and all(isinstance(x, Real) for x in bounds):
        low, high = map(float, bounds)
        if low <= high:
            return low, high
    raise InputError("symoro-elastic", "--require", f"{quote(name)}: {bounds!r} is not (low, high)")


def _share(design: Design, name: str, low: float, high: float, inside: BoolArray) -> Share:
    within, points = int(inside.sum()), len(inside)
    interval = interval_of(within, points) if design.sampling in INDEPENDENT else None
    return Share(name, low, high, within, points, interval)


@cache
def interval_of(within: int, points: int) -> tuple[float, float]:
    """Return the Clopper-Pearson confidence interval of a probability, from `within` of `points` draws."""
    test = import_optional("scipy.stats", "an interval of confidence", "sweep").binomtest(within, points)
    interval = test.proportion_ci(CONFIDENCE, "exact")
    return float(interval.low), float(interval.high)
