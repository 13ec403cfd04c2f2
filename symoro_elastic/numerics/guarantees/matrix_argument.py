"""Lemma 8, direct models through the inertia matrix: errors of x of A x = b, without following the elimination.

Errors grow by the depth of an elimination where they are followed from operation to operation; those of a matrix do
not. Let A be symmetric and positive definite in a box, and W a matrix without entry below zero such that, everywhere,

    d' A^-1 d <= |d|' W |d|        for all d                                                    (`least_inertia.py`)

With the norm |v|_A = (v' A v)^(1/2) and Cauchy, |v_i| <= (W_ii)^(1/2) |v|_A, for v_i = (A^-1 e_i)' A v.

**Elimination.** The program has A~, b~ with |A~ - A| <= EA and |b~ - b| <= Eb, and carries out A~ = R' D^-1 R
(`mechanics/factorization.py`, L = D^-1 R): r_ik = A~_ik - sum r_ji r_jk/d_j over the j that come before i. Let each
term be rounded k times beside the sums. A sum of t such terms and of c, in any order, is s with
s (1 + h) = c - sum terms (1 + h'), |h|, |h'| <= g(t + k), g(m) = m u/(1 - m u), for roundings that c has, too, cancel
(N. Higham, Accuracy and Stability of Numerical Algorithms, lemma 8.4). So, with all d_j > 0,

    |A~ - R' D^-1 R|_ik <= g(t_ik + k) sum |r_ji||r_jk|/d_j <= g(t_ik + k) (p_i p_k)^(1/2),   p_i = sum r_ji^2/d_j

by Cauchy, and p_i <= A~_ii/(1 - g). The same holds for both substitutions, where matrices R' D^-1 and R are off by
g(f_i + k) and g(f'_j + k) of their entries. Together (A~ + F) x~ = b~ with

    |F_ik| <= sum_j (g(t_ik + k) + g(f_i + k) + g(f'_j + k)) |r_ji||r_jk|/d_j (1 + 4 g)
           <= (g(t_ik + k) + g(f_i + k) + max_j g(f'_j + k)) (1 + 4 g) (A~_ii A~_kk)^(1/2)

The first is smaller where entries beside the diagonal are: with r_ik = A~_ik - ..., d_j as below,

    |r_ik| <= rho_ik = |A_ik| + E_ik + sum_j rho_ji rho_jk W_jj/(1 - kappa)

**Pivots.** Let E = EA + |F|, c_i = (W_ii)^(1/2), kappa = c' E c < 1. Each A + G with |G| <= E has
|v' G v| <= kappa v' A v, hence (1 - kappa) A <= A + G <= (1 + kappa) A, and so are Schur complements: the computed d_j
are within kappa d_j of the exact ones, which are 1/W_jj or more. They are positive: multiply all roundings by s, and
let s rise from 0 to 1; until some d_j is zero the bounds hold, and d_j is at least 1 - kappa times the exact one, so
none gets there.

**Errors.** A (x~ - x) = (b~ - b) - (A~ - A + F) x~ = d. With q = |x~ - x|_A and |x|_A^2 = b' A^-1 b <= B = |b|' W |b|:

    |d| <= Eb + E (X + q c) = e + q v,   |x_i| <= X_i <= c_i B^(1/2),   q^2 = d' A^-1 d <= (e + q v)' W (e + q v)

bounds q where v' W v < 1, and |x~_i - x_i| <= c_i q. Several W may be used: each bounds q.

**Joint by joint.** The norm does not tell joints apart: a small inertia has the errors of the large ones. Where all
entries of the inverse are bounded, |A^-1| <= W, so are |x| <= |A^-1 m| + W |b - m|, for any m: signs in b count; and,
from any bound Y of |x~ - x|, |x~ - x| <= W (e + E Y), of which the smaller counts, and so on. The norm of x profits,
too: |x|_A^2 = b' x <= |b|' X.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.models.linear_system import LinearSystem
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.running_error import Bounds, Rounding
from symoro_elastic.symbolic.expression import Expression, Operand
from symoro_elastic.symbolic.operations import NEGATE

OUTWARDS = 1 + 1e-9
"""Of sums of numbers that are not negative: more than their rounding."""
REPEATED = 3
"""How often bounds of errors are made smaller, joint by joint."""


@dataclass(frozen=True)
class Given:
    """What is known of A x = b by sub-box: entries, errors of A (n, n, sub-boxes) and b (n, sub-boxes), largest |x|."""

    A: Interval
    A_error: Array
    b: Interval
    b_error: Array
    x: Array

    @classmethod
    def of(cls, system: LinearSystem, bounds: Bounds) -> Given:
        """Those of the nodes of a program."""
        size = len(system.joints)

        def stacked(entries: Sequence[Array]) -> Array:
            return np.array([np.broadcast_to(x, bounds.shape) for x in entries])

        def ranges(entries: Sequence[Operand]) -> Interval:
            found = [_range(x, bounds) for x in entries]
            return Interval(stacked([x.low for x in found]), stacked([x.high for x in found]))

        A, shape = [x for row in system.A for x in row], (size, size, -1)
        return cls(
            Interval(*(end.reshape(shape) for end in ranges(A))),
            stacked([_error(x, bounds) for x in A]).reshape(shape),
            ranges(system.right),
            stacked([_error(x, bounds) for x in system.right]),
            stacked([_range(x, bounds).magnitude if _is_known(x, bounds) else np.array(np.inf) for x in system.x]),
        )


def _range(x: Operand, bounds: Bounds) -> Interval:
    """The range of an entry, whose sign may stand outside of its node."""
    if isinstance(x, Expression) and x.operation == NEGATE:
        return -bounds.range_of(x.positive)
    return bounds.range_of(x)


def _is_known(x: Operand, bounds: Bounds) -> bool:
    """Whether a program has an entry: accelerations that are not asked for are not computed."""
    return not isinstance(x, Expression) or x.positive.id in bounds.range


def _error(x: Operand, bounds: Bounds) -> Array:
    return bounds.error_of(x.positive if isinstance(x, Expression) else x)


@dataclass(frozen=True)
class Solved:
    """By joint and sub-box: errors and magnitudes of x, errors of the pivots; infinite where nothing is proven."""

    error: Array
    magnitude: Array
    pivot_error: Array


def solved(
    system: LinearSystem, given: Given, bounds_of_inverse: Sequence[Array], entries: Array, rounding: Rounding
) -> Solved:
    """What lemma 8 proves of a system; `bounds_of_inverse` are W, (n, n, sub-boxes) or (n, n, 1).

    `entries` is one that bounds all entries of the inverse; infinite where there is none.
    """
    diagonal, b = np.einsum("iib->ib", given.A.high), given.b.magnitude
    with np.errstate(all="ignore"):
        inverses = np.array(np.broadcast_arrays(*bounds_of_inverse, entries, given.A.high)[:-1])
        c = np.sqrt(np.einsum("wiib->wib", inverses).min(axis=0))
        size = np.sqrt(_least(_form(inverses, b, b)))
        most = np.fmin(np.fmin(given.x, c * size * OUTWARDS), _times(entries, b))
        size = np.fmin(size, np.sqrt(np.einsum("ib,ib->b", b, most)) * OUTWARDS)
        most = np.fmin(most, c * size * OUTWARDS)
        lost = _lost(system, diagonal, c, size, rounding)
        E = (given.A_error + _of_elimination(system, given, c, lost, rounding) + lost) * OUTWARDS
        kappa, v = _kappa(E, c), np.einsum("ikb,kb->ib", E, c) * OUTWARDS
        e = (given.b_error + np.einsum("ikb,kb->ib", E, most) + lost) * OUTWARDS
        q = np.where(kappa < 1, _least(_largest_norm(inverses, e, v)), np.inf)
        error = c * q * OUTWARDS
        for _ in range(REPEATED):
            error = np.fmin(error, _times(entries, e + _times(E, error)))
        found = Solved(error, most, np.where(kappa < 1, kappa, np.inf) * diagonal * OUTWARDS)
    return Solved(*(np.where(np.isnan(x), np.inf, x) for x in (found.error, found.magnitude, found.pivot_error)))


def _times(W: Array, x: Array) -> Array:
    """W x by sub-box, of numbers that are not negative."""
    found: Array = (W * x).sum(axis=1) * OUTWARDS
    return found


def _kappa(E: Array, c: Array) -> Array:
    found: Array = np.einsum("ib,ikb,kb->b", c, E, c) * OUTWARDS
    return found


def _form(W: Array, x: Array, y: Array) -> Array:
    """x' W y by W and sub-box."""
    found: Array = np.einsum("ib,wikb,kb->wb", x, W, y) * OUTWARDS
    return found


def _least(found: Array) -> Array:
    """The least of several bounds, by sub-box; those that are no numbers prove nothing."""
    least: Array = np.min(np.where(np.isnan(found), np.inf, found), axis=0)
    return least


def _largest_norm(W: Array, e: Array, v: Array) -> Array:
    """The largest q with q^2 <= (e + q v)' W (e + q v), by W and sub-box."""
    left, across = 1 - _form(W, v, v), _form(W, v, e)
    root = np.sqrt(across**2 + left * _form(W, e, e))
    found: Array = np.where(left > 0, (across + root) / left * OUTWARDS, np.inf)
    return found


def _of_elimination(system: LinearSystem, given: Given, c: Array, lost: Array, rounding: Rounding) -> Array:
    """|F_ik| by sub-box: by the diagonal, and by the rows of R where these are known."""

    def g(count: Array) -> Array:
        times = (count + system.roundings) * rounding.u
        return times / (1 - times)

    shared, backward = g(system.shared) + g(system.forward)[:, None], g(system.backward)
    more = 1 + 4 * (shared.max() + backward.max())
    computed = np.einsum("iib->ib", given.A.high + given.A_error)
    F: Array = ((shared + backward.max()) * more)[..., None] * np.sqrt(computed[:, None] * computed)
    E = (given.A_error + F + lost) * OUTWARDS
    left = 1 - _kappa(E, c)
    inverse = np.where(left > 0, c**2 / left, np.inf)
    rho, most = given.A.magnitude + E, np.sqrt(computed[:, None] * computed) * more
    by_rows = np.zeros_like(F)
    for j in range(len(rho)):
        row = np.minimum(rho[j, j:], most[j, j:])
        terms = row[:, None] * row * inverse[j]
        terms[0] = terms[:, 0] = row
        by_rows[j:, j:] += (shared[j:, j:] + backward[j])[..., None] * terms
        rho[j + 1 :, j + 1 :] += terms[1:, 1:]
    found: Array = np.fmin(F, by_rows * more * OUTWARDS)
    return found


def _lost(system: LinearSystem, diagonal: Array, c: Array, norm: Array, rounding: Rounding) -> Array:
    """More than what is lost below the smallest numbers in an entry of A or b, by sub-box.

    A term, such as (r_ji (1/d_j)) r_jk, is off by the smallest number times a factor, and there are 3 n terms at most.
    """
    factors = 1 + diagonal.max(axis=0) + 1 / diagonal.min(axis=0) + c.max(axis=0) ** 2
    size = len(system.joints) + system.roundings
    found: Array = 64 * size * rounding.least * (factors * (1 + c.max(axis=0) * norm)) ** 2
    return found
