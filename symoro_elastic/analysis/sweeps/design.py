"""The points of a sweep: a full grid, or a sample of distributions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.sweeps.ranges import OPTION, Axis, Listed, Normal, Spread, Uniform, python_text
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError, among, refuse_numbers
from symoro_elastic.foundation.packages import import_optional

SAMPLINGS = ("latin", "random", "sobol")
"""Latin hypercube, Monte Carlo, Sobol's sequence."""
MOST_POINTS = 10_000_000


@dataclass(frozen=True)
class Design:
    """Points (N, quantities) of a sweep; in a grid of `lengths` the last quantity varies fastest.

    A sample has no lengths; `sampling` and `seed` are how it was drawn.
    """

    names: tuple[str, ...]
    points: Array
    lengths: tuple[int, ...] = ()
    sampling: str = "grid"
    seed: int = 0

    @property
    def is_grid(self) -> bool:
        """Whether the points form a full grid."""
        return bool(self.lengths)

    def along(self, k: int) -> Array:
        """Return the values of the k-th quantity in the order of the grid."""
        index = [slice(None) if j == k else 0 for j in range(len(self.lengths))]
        return np.asarray(self.points[:, k].reshape(self.lengths)[tuple(index)])


def design(
    axes: Mapping[str, Axis], samples: int | None = None, sampling: str | None = None, seed: int | None = None
) -> Design:
    """Return the grid of some axes, or with a number of samples a sample of their distributions.

    Raises `InputError` where axes and samples do not fit together, and for more points than can be computed.
    """
    if not axes:
        raise InputError("symoro-elastic", OPTION, "nothing to sweep: name a quantity and its values")
    if samples is None:
        for option, value in (("--sampling", sampling), ("--seed", seed)):
            if value is not None:
                raise InputError("symoro-elastic", option, "a grid is not random: give --samples, or leave it out")
        return _grid(axes)
    return _sample(axes, samples, sampling or SAMPLINGS[0], 0 if seed is None else seed)


def _grid(axes: Mapping[str, Axis]) -> Design:
    listed = {name: axis for name, axis in axes.items() if isinstance(axis, Listed)}
    for name in axes.keys() - listed.keys():
        what = f"{name} has a distribution: give the number of points by --samples, or give LOW:HIGH:COUNT"
        raise InputError("symoro-elastic", OPTION, what)
    lengths = tuple(axis.count for axis in listed.values())
    _refuse_many(math.prod(lengths), len(axes), "--over", "give fewer values")
    grids = np.meshgrid(*(axis.values() for axis in listed.values()), indexing="ij")
    return Design(tuple(axes), np.stack([x.ravel() for x in grids], axis=1), lengths)


def _sample(axes: Mapping[str, Axis], samples: int, sampling: str, seed: int) -> Design:
    among((sampling,), SAMPLINGS, "--sampling")
    for option, value, least in (("--samples", samples, 1), ("--seed", seed, 0)):
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise InputError("symoro-elastic", option, f"{python_text(value)}: give a whole number from {least}")
    spreads: list[Spread] = []
    for name, axis in axes.items():
        if not isinstance(axis, Uniform | Normal):
            what = f"{name} has a list of values, which cannot be sampled: give LOW:HIGH, or leave out --samples"
            raise InputError("symoro-elastic", OPTION, what)
        spreads.append(axis)
    if sampling == "sobol" and samples & (samples - 1):
        what = f"{samples} points of a Sobol sequence are not balanced: give {1 << samples.bit_length()}, a power of 2"
        raise InputError("symoro-elastic", "--samples", what)
    _refuse_many(samples, len(axes), "--samples", "give fewer")
    shares = _shares(samples, len(axes), sampling, seed)
    columns = [spread.quantiles(shares[:, k]) for k, spread in enumerate(spreads)]
    return Design(tuple(axes), np.stack(columns, axis=1), (), sampling, seed)


def _refuse_many(count: int, axes: int, option: str, way_out: str) -> None:
    refuse_numbers(count, f"{axes} axes", "symoro-elastic", option, way_out, MOST_POINTS)


def _shares(count: int, dimensions: int, sampling: str, seed: int) -> Array:
    """Return points (count, dimensions) between 0 and 1, both excluded, reproducible by the seed."""
    if sampling == "random":
        points = np.random.default_rng(seed).random((count, dimensions))
    else:
        qmc = import_optional("scipy.stats.qmc", "a sample", "sweep")
        engine = (qmc.LatinHypercube if sampling == "latin" else qmc.Sobol)(dimensions, seed=seed)
        points = engine.random(count)
    least = float(np.finfo(float).tiny)
    return np.clip(points, least, 1.0 - float(np.finfo(float).eps))


def rows(design: Design) -> Sequence[Sequence[float]]:
    """Return the points as lists of numbers."""
    points: list[list[float]] = design.points.tolist()
    return points
