"""What a machine has beside its model, outside the band of a test: smooth terms of each response, fitted with it.

A mode above the band adds s^n (a0 + a1 f^2 + a2 f^4 + ...), n = 0, 1, 2 for positions, velocities, accelerations: the
residual terms of modal analysis (Ewins, Modal Testing). Coefficients are complex, for modes are damped, and unknown to
the size of the response; intervals of parameters know of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from symoro_elastic.foundation.array_types import Array, ComplexArray

POWERS = (0, 1, 2)
"""Of (f / f_max)^2."""


@dataclass(frozen=True)
class Background:
    """Terms (m, N) of each line, which are complex, and its median; coefficients are real, line after line."""

    terms: tuple[ComplexArray, ...]
    sizes: tuple[float, ...] = ()

    @property
    def count(self) -> int:
        """Coefficients of all lines."""
        return sum(len(one) for one in self.terms)

    @property
    def rows(self) -> list[slice]:
        """The coefficients of each line."""
        ends = np.cumsum([0, *map(len, self.terms)]).tolist()
        return [slice(*pair) for pair in pairwise(ends)]

    def over(self, sd: Sequence[Array]) -> Array:
        """Return the terms (m, N) over the standard deviations of lines, real parts of a line before imaginary ones."""
        columns = []
        for one, own, rows in zip(self.terms, sd, self.rows, strict=True):
            found = np.zeros((self.count, 2 * len(own)))
            found[rows] = np.concatenate([one.real / own, one.imag / own], axis=1)
            columns.append(found)
        return np.concatenate(columns, axis=1)

    def largest(self, c: Array) -> float:
        """Return the largest root mean square of what coefficients c add to a line, over its median response."""
        each = zip(self.terms, self.rows, self.sizes, strict=True)
        return max(
            (float(np.sqrt(np.mean(np.abs(c[rows] @ one) ** 2)) / size) for one, rows, size in each), default=0.0
        )


def background_of(lines: Sequence[tuple[Array, ComplexArray, int]]) -> Background:
    """Return the terms of lines, from frequencies, responses and orders n; their unit is the median response."""
    terms, sizes = [], []
    for f, H, order in lines:
        u, size = f / f[-1], float(np.median(np.abs(H)))
        shapes = np.array([(1j * u) ** order * u ** (2 * power) for power in POWERS]) * size
        terms.append(np.concatenate([shapes, 1j * shapes]))
        sizes.append(size)
    return Background(tuple(terms), tuple(sizes))
