"""Butcher tableaus of Runge-Kutta methods, written as they are printed in their sources."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

from symoro_elastic.quantities.time_steps import TimeStep

if TYPE_CHECKING:
    from symoro_elastic.foundation.array_types import Array

Coefficients = tuple[Fraction, ...]


@dataclass(frozen=True)
class Tableau:
    """Coefficients of an explicit Runge-Kutta method: nodes c, matrix A (strictly lower triangular), weights b."""

    name: str
    title: str
    order: int
    c: Coefficients
    A: tuple[Coefficients, ...]
    b: Coefficients

    @classmethod
    def from_text(cls, name: str, title: str, order: int, text: str) -> Tableau:
        """Return the tableau of a text: lines `c_i | a_i1 a_i2 ...`, the last one `| b_1 b_2 ...`."""
        *stages, (_, weights) = [line.split("|") for line in text.strip().splitlines()]
        nodes = tuple(Fraction(node) for node, _ in stages)
        return cls(name, title, order, nodes, tuple(row(entries) for _, entries in stages), row(weights))

    @cached_property
    def stages(self) -> tuple[tuple[float, tuple[float, ...]], ...]:
        """c_i and the row i of A, in double precision."""
        return tuple((float(c), tuple(map(float, row))) for c, row in zip(self.c, self.A, strict=True))

    @cached_property
    def weights(self) -> tuple[float, ...]:
        """The weights b in double precision."""
        return tuple(map(float, self.b))


def row(text: str) -> Coefficients:
    """Return the coefficients of a text, exact as they are printed."""
    return tuple(map(Fraction, text.split()))


RK4 = Tableau.from_text(
    TimeStep.RK4,
    "classical Runge-Kutta method, order 4",
    4,
    """
    0   |
    1/2 | 1/2
    1/2 | 0    1/2
    1   | 0    0    1
        | 1/6  2/6  2/6  1/6
    """,
)
"""The classical method of fourth order: Kutta, Zeitschrift fuer Mathematik und Physik 46 (1901); Hairer, Norsett and
Wanner, Solving Ordinary Differential Equations I, section II.1, table 1.2."""


Rate: TypeAlias = "Callable[[float, Array], Array]"
"""f of y' = f(t, y)."""


# Steps of explicit Runge-Kutta methods.
def step(tableau: Tableau, rate: Rate, t: float, y: Array, h: float) -> Array:
    """Return y at t + h of y' = f(t, y), where `rate` is f and y an array of any shape.

    k_i = f(t + c_i h, y + h sum_j a_ij k_j),    y(t + h) = y + h sum_i b_i k_i
    """
    k: list[Array] = []
    for c, row in tableau.stages:
        k.append(rate(t + c * h, _moved(y, h, row, k)))
    return _moved(y, h, tableau.weights, k)


def _moved(y: Array, h: float, weights: Iterable[float], k: Iterable[Array]) -> Array:
    """Return y + h sum_j a_j k_j; terms with a_j = 0 are left out."""
    for a, rate in zip(weights, k, strict=True):
        if a:
            y = y + (h * a) * rate
    return y
