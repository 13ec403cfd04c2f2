"""Butcher tableaus of Runge-Kutta methods, written as they are printed in their sources."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from symoro_elastic.quantities.time_steps import TimeStep

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
    def printed(cls, name: str, title: str, order: int, text: str) -> Tableau:
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


RK4 = Tableau.printed(
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
