"""Lemma 4: the maximum of a trigonometric polynomial is at most a known factor above its maximum on a grid.

The lemma is stated in an angle phi of the variable x:

- full turn: x = phi, the trigonometric degree n is the *order*;
- slide in [c - h, c + h]: x = c + h cos(phi), order n, the degree;
- arc, an angle within c - w ... c + w, w < pi: sin((x - c)/2) = sin(w/2) cos(phi), order 2 n.

**Lemma.** f of order m, |f| <= M everywhere, f = M cos(theta): theta is Lipschitz in phi with the constant m. Hence:

1. N > 2 m equidistant values of phi: max|f| <= max over them / cos(pi m/N). In several variables, one after another:
   the product of the factors.
2. A point where |f| = M, and any point that is d_j from it in phi_j, sum m_j d_j < pi/2:
   |f| >= M cos(sum m_j d_j) there.
3. Both hold for the largest of any family of such f at a point, as they hold for each f with the M of the family.

*Proof.* Let, with |f| < 1 (else scale), |theta'| > m at phi_0, and choose g = cos(m phi + s) so that g = f there on a
branch on which both rise, or both fall. g alternates between +1 and -1 at 2 m points of the circle, so f - g has
a zero between any two that are neighbours, and three on the branch of phi_0, where f is the steeper one: 2 m + 2 zeros.
A trigonometric polynomial of degree m has 2 m at most, so f = g, which has |theta'| = m: a contradiction. An even f
(slide) is such a polynomial of phi. On an arc put t = tan((x - c)/2) = tan(w/2) cos(tau): f and g = cos(2 n phi + s)
are both trigonometric polynomials of tau of degree 2 n over (1 + t^2)^n, because

    cos(phi) = cos(tau) (1 + T^2)^(1/2)/(1 + t^2)^(1/2),  sin(phi) = sin(tau)/(1 + t^2)^(1/2),  T = tan(w/2)

make sin and cos of 2 phi such quotients with n = 1; phi rises with tau, and zeros of f - g are counted as before.
(Riesz and Szego for the circle, Videnskii for arcs.) First part: some point of the grid is within pi/N of where |f| is
largest, other variables fixed; then the same for the next variable. Second part: along a way of one variable after
another theta changes by at most the sum; it is 0 or pi where |f| = M.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.machine.limits import Range

TURN, ARC, SLIDE = "turn", "arc", "slide"
UNIT = 2.0**-53
NARROWEST = 2.0**-24
"""Least relative width of a range, so that the rounding of nodes is below 1e-2 of their distance."""


@dataclass(frozen=True)
class Axis:
    """A variable of a polynomial: its kind, its range, and the degree of the polynomial in it.

    `basis` are functions of phi that are at most 1 and span all polynomials of this degree; `orders` are theirs.
    Leaving out those of high order leaves a polynomial of lower order.
    """

    name: str
    kind: str
    degree: int
    low: float
    high: float

    @property
    def is_even(self) -> bool:
        """Whether phi and -phi are the same x."""
        return self.kind != TURN

    @property
    def middle(self) -> float:
        """The middle of the range."""
        return self.low + (self.high - self.low) / 2

    @property
    def half(self) -> float:
        """At least half of the range."""
        return max(self.high - self.middle, self.middle - self.low) * (1 + 4 * UNIT)

    @cached_property
    def orders(self) -> tuple[int, ...]:
        """Orders in phi of the basis functions; for a full circle those of the cosines, then those of the sines."""
        n = self.degree
        if self.kind == TURN:
            return (*range(n + 1), *range(1, n + 1))
        if self.kind == SLIDE:
            return tuple(range(n + 1))
        return tuple(k + k % 2 for k in range(2 * n + 1))

    @cached_property
    def nodes(self) -> Array:
        """Interpolation nodes x, as many as functions of the basis."""
        size = len(self.orders)
        if self.kind == TURN:
            return np.asarray(np.arange(size) * (2 * math.pi / size))
        y: Array = np.cos((np.arange(size) + 0.5) * (math.pi / size))
        if self.kind == SLIDE:
            return np.asarray(self.middle + self.half * y)
        return np.asarray(self.middle + 2 * np.arcsin(math.sin(self.half / 2) * y))

    def basis(self, phi: Array) -> Array:
        """Return the functions of the basis at these phi, (points, functions)."""
        if self.kind == TURN:
            n = self.degree
            return np.stack([np.cos(k * phi) for k in range(n + 1)] + [np.sin(k * phi) for k in range(1, n + 1)], -1)
        columns = [np.cos(k * phi) for k in range(len(self.orders))]
        if self.kind == ARC:
            cosine = np.sqrt(1 - (math.sin(self.half / 2) * np.cos(phi)) ** 2)
            columns = [cosine * x if k % 2 else x for k, x in enumerate(columns)]
        return np.stack(columns, axis=-1)

    def positions(self, phi: Array) -> Array:
        """Return x, within the range, at these phi."""
        if self.kind == TURN:
            return np.minimum(self.low + np.mod(phi - self.low, 2 * math.pi), self.high)
        if self.kind == SLIDE:
            return self.middle + self.half * np.cos(phi)
        return self.middle + 2 * np.arcsin(math.sin(self.half / 2) * np.cos(phi))

    def phases(self, x: Array) -> Array:
        """Return phi at these x."""
        if self.kind == TURN:
            return x
        y = (x - self.middle) / self.half
        if self.kind == ARC:
            y = np.sin((x - self.middle) / 2) / math.sin(self.half / 2)
        return np.arccos(np.clip(y, -1, 1))

    @cached_property
    def at_nodes(self) -> Array:
        """The functions of the basis at the nodes, (nodes, functions)."""
        return self.basis(self.phases(self.nodes))

    @cached_property
    def from_values(self) -> Array:
        """The matrix from values at the nodes to coefficients."""
        return np.asarray(np.linalg.inv(self.at_nodes))

    @cached_property
    def mismatch(self) -> float:
        """Upper bound of the relative error of `from_values`, in the sum of magnitudes."""
        inverse, size = self.from_values, len(self.orders)
        computed = float(np.abs(inverse @ self.at_nodes - np.eye(size)).sum())
        return min(0.5, computed + 2 * size * self.basis_error * float(np.abs(inverse).sum()))

    @cached_property
    def amplification(self) -> float:
        """Bound of polynomials, and of the sums of their coefficients, whose values at the nodes are at most 1."""
        return float(np.abs(self.from_values).sum()) / (1 - self.mismatch) * (1 + 1e-9)

    @property
    def basis_error(self) -> float:
        """Upper bound of the error of `basis` at phi or at the nodes."""
        ends = max(abs(self.low), abs(self.high)) if self.is_even else 2 * math.pi
        return 64 * (1 + max(self.orders)) ** 2 * UNIT * (1 + ends / (self.half if self.is_even else 1.0))

    def grid(self, ratio: int, order: int) -> Array:
        """Return a grid of phi, `ratio` points per order, without repeats of x: maxima are within 1/cos(pi/ratio)."""
        points = ratio * order
        return np.asarray(np.arange(points // 2 + 1 if self.is_even else points) * (2 * math.pi / points))

    def cells(self, count: int) -> Array:
        """Return the middles of cells of phi, of half width pi/count (even), that cover all of x."""
        return np.asarray((np.arange(count // 2 if self.is_even else count) + 0.5) * (2 * math.pi / count))


def of_harmonics(squares: AnyArray, axis: int) -> AnyArray:
    """Return c_k^2 + s_k^2 by harmonic k along an axis of full turns, from squared coefficients (in place)."""
    before, n = (slice(None),) * axis, squares.shape[axis] // 2
    if n:
        squares[(*before, slice(1, n + 1))] += squares[(*before, slice(n + 1, None))]
    return squares[(*before, slice(n + 1))]


def axis_of(name: str, degree: int, span: Range, *, angle: bool) -> Axis:
    """Return the axis of a variable; an angle with a range of at least a turn has a full circle.

    A range below `NARROWEST` is widened, as bounds over it hold for the narrower one.
    """
    least = NARROWEST * max(abs(span.low), abs(span.high))
    if span.high - span.low < least:
        span = Range(span.low - least, span.high + least)
    if not angle:
        return Axis(name, SLIDE, degree, span.low, span.high)
    turns = span.high - span.low >= 2 * math.pi * (1 - 1e-9)
    return Axis(name, TURN if turns else ARC, degree, span.low, span.high)
