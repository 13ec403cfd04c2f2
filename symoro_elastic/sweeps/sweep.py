"""The result of a sweep: figures at points, and what each quantity does to them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.array_types import AnyArray, Array
from symoro_elastic.errors import InputError
from symoro_elastic.machine.names import did_you_mean, quoted
from symoro_elastic.output_files import permission
from symoro_elastic.results import Part, Result, Titled
from symoro_elastic.sweeps.design import Design
from symoro_elastic.sweeps.influence import Influence, influence
from symoro_elastic.sweeps.points import Outcome

REASON = "reason"


@dataclass(frozen=True, repr=False)
class Sweep(Result):
    """Figures (N,) by name at the N points of a design; NaN where a point has none, with the reason.

    `units` are those of quantities and figures, where they are known. Points are in the order of the design: of a grid
    the last quantity varies fastest.
    """

    machine: str
    of: str
    design: Design
    figures: Mapping[str, Array]
    reasons: tuple[str, ...]
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of what is swept."""
        return self.design.names

    @property
    def points(self) -> Array:
        """Values of the quantities (N, quantities), SI units, radians."""
        return self.design.points

    @property
    def failed(self) -> int:
        """Number of points without figures."""
        return sum(map(bool, self.reasons))

    @cached_property
    def influence(self) -> Influence:
        """What each quantity does to each figure: slopes on a grid, rank correlations in a sample."""
        return influence(self.design, self.figures)

    def on_grid(self, name: str) -> Array:
        """Return a figure as an array with a dimension for each quantity of a grid."""
        return self.figures[name].reshape(self.design.lengths or (-1,))

    @property
    def headline(self) -> str:
        """Machine, points, quantities and figures."""
        failed = f", {self.failed} without result" if self.failed else ""
        where = f"{len(self.points)} points of {', '.join(self.quantities)}"
        return f"Sweep of {self.machine}: {self.of} at {where}{failed}"

    def parts(self) -> list[Part]:
        """Return the table of figures, that of what has influence, and what failed."""
        from symoro_elastic.sweeps.tables import figures_table, influence_table, sweep_lines

        tables = [Titled(figures_table(self), self.headline)]
        if len(self.points) > 1:
            tables.append(Titled(influence_table(self), self.influence.title))
        return [*tables, *sweep_lines(self)]

    def as_json(self) -> dict[str, Any]:
        """Return points, figures and influences as plain data; null where there is no value."""
        from symoro_elastic.sweeps.tables import sweep_json

        return sweep_json(self)

    def arrays(self) -> dict[str, AnyArray]:
        """Return quantities and figures by name, (N,) each."""
        return {**dict(zip(self.quantities, self.points.T, strict=True)), **self.figures}

    def columns(self) -> dict[str, Any]:
        """Return a row for each point: quantities, figures, the reason where there are none."""
        return {**self.arrays(), REASON: list(self.reasons)}

    def dataset(self) -> Any:
        """Return an `xarray.Dataset`: a dimension for each quantity of a grid, or `point`; raises `InputError`."""
        from symoro_elastic.sweeps.files import dataset

        return dataset(self)

    def write(self, path: str | Path, *, force: bool = False) -> Path:
        """Write a .csv, .nc (NetCDF) or .npz file, and return its path; raises `InputError`."""
        from symoro_elastic.sweeps.files import save

        with permission(force=force):
            save(self, path)
        return Path(path)


def swept(
    machine: str,
    of: str,
    design: Design,
    outcomes: Sequence[Outcome],
    units: Mapping[str, str],
    patterns: Collection[str] = (),
) -> Sweep:
    """Return the sweep of these outcomes; of all figures, or of those that match a pattern. Raises `InputError`."""
    names = list(dict.fromkeys(name for one in outcomes for name in one.figures))
    names = _chosen(names, patterns)
    missing = {name: float("nan") for name in names}
    rows = [{**missing, **one.figures} for one in outcomes]
    figures = {name: np.array([row[name] for row in rows]) for name in names}
    taken = set(design.names).intersection(names)
    if taken or REASON in names:
        what = f"{min(taken | {REASON})!r} is a column already: give the figure another name"
        raise InputError("symoro-elastic", "--of", what)
    reasons = tuple(one.reason for one in outcomes)
    return Sweep(machine, of, design, figures, reasons, {name: unit for name, unit in units.items() if unit})


def _chosen(names: list[str], patterns: Collection[str]) -> list[str]:
    """Return the names that match a pattern; raises `InputError` for a pattern that none matches."""
    for pattern in patterns:
        if not any(_matches(name, pattern) for name in names):
            what = f"there is no figure {quoted(pattern)}{did_you_mean(pattern, names)}"
            raise InputError("symoro-elastic", "--figure", what)
    return [name for name in names if not patterns or any(_matches(name, pattern) for pattern in patterns)]


def _matches(name: str, pattern: str) -> bool:
    return name == pattern or fnmatchcase(name, pattern)
