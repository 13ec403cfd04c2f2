"""Methods of integration in one form, and what they do to y' = lambda y: stability, damping.

    Y_i = y + h sum_j a_ij k_j,    w_i = sum_j (g_ij / gamma) k_j
    (I - gamma h T) z = f(t + c_i h, Y_i) + w_i,    k_i = z - w_i,    y(t + h) = y + h sum_i b_i k_i

T is an approximate Jacobian; with gamma = 0 the method is explicit.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from symoro_elastic.array_types import Array, ComplexArray

ROUNDING = 1e-9
"""Growth of a step, relative, that is rounding of a pole and no instability."""
FASTEST = 12.0
"""Of |lambda h| in the search for a limit: no explicit method of up to 8 stages reaches it."""
POINTS, HALVINGS = 1200, 30
HALF = 0.5
"""Part of the amplitude that a vibration keeps over a period, below which it counts as damped."""


class WMethod(Protocol):
    """A Rosenbrock-W method: rows of a and g hold what is left of the diagonal; g_ii = gamma."""

    order: int
    gamma: float
    a: tuple[tuple[float, ...], ...]
    g: tuple[tuple[float, ...], ...]
    b: tuple[float, ...]


class ExplicitMethod(Protocol):
    """An explicit Runge-Kutta method: nodes with rows of A, and weights."""

    order: int

    @property
    def stages(self) -> tuple[tuple[float, tuple[float, ...]], ...]:
        """c_i and row i of A."""

    @property
    def weights(self) -> tuple[float, ...]:
        """b."""


Method = WMethod | ExplicitMethod


@dataclass(frozen=True)
class Scheme:
    """The coefficients of a method: gamma, a and g (s, s) with zeros on and above the diagonal, b (s,)."""

    order: int
    gamma: float
    a: Array
    g: Array
    b: Array

    @classmethod
    def of(cls, method: Method) -> Scheme:
        """Return the coefficients of a method in this form."""
        if isinstance(gamma := getattr(method, "gamma", None), float):
            return cls(method.order, gamma, _square(method.a), _square(method.g), np.array(method.b))  # type: ignore[union-attr]
        a = _square([row for _, row in method.stages])  # type: ignore[union-attr]
        return cls(method.order, 0.0, a, np.zeros_like(a), np.array(method.weights))  # type: ignore[union-attr]

    @cached_property
    def nodes(self) -> Array:
        """c (s,): parts of a step after which the right side is taken."""
        nodes: Array = self.a.sum(axis=1)
        return nodes

    @property
    def is_explicit(self) -> bool:
        """Whether a step solves nothing."""
        return self.gamma == 0.0

    def growth(self, z: ComplexArray) -> ComplexArray:
        """Return R(z): what a step makes of y, for y' = lambda y, T = lambda and z = lambda h."""
        k: list[ComplexArray] = []
        for a, g in zip(self.a, self.g, strict=True):
            inside = 1 + z * sum((x * rate for x, rate in zip(a, k, strict=False)), start=np.zeros_like(z))
            w = sum((x * rate for x, rate in zip(g, k, strict=False)), start=np.zeros_like(z)) / (self.gamma or 1.0)
            k.append((inside + w) / (1 - self.gamma * z) - w)
        return 1 + z * sum(x * rate for x, rate in zip(self.b, k, strict=True))


def _square(rows: object) -> Array:
    listed = [tuple(map(float, row)) for row in rows]  # type: ignore[attr-defined]
    matrix = np.zeros((len(listed), len(listed)))
    for i, row in enumerate(listed):
        matrix[i, : len(row)] = row
    return matrix
