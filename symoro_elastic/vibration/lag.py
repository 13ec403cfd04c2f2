"""Deflections of springs with damping: tau q' + q = u, integrated along samples of u and its derivatives.

Between two samples u is a cubic p, and with s the time since the first,

    q(s) = (q(0) - r(0)) exp(-s/tau) + r(s),    r = p - tau p' + tau^2 p'' - tau^3 p''',

which is exact and stable however small tau is; where tau is longer than a step the same integral is taken by Gauss's
rule, since r is a difference of large numbers there.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.packages import for_vibrations

GAUSS_POINTS = 6


def lagging(t: Array, u: Array, tau: float) -> Array:
    """Return q and its derivatives (orders, N) from those of u (orders, N) at times t (N,), s, and tau > 0, s.

    The start is that of a motion that went on before, as far as the derivatives tell: q = u at rest.
    """
    starts = u[-1, 0] * np.ones(len(u))
    for k in range(len(u) - 2, -1, -1):
        starts[k] = u[k, 0] - tau * starts[k + 1]
    return np.stack([_integrated(t, p, starts[k], tau) for k, p in enumerate(_cubics(t, u))])


def _cubics(t: Array, u: Array) -> list[Array]:
    """Return by order the coefficients (4, N - 1), the constant first, of cubics between samples."""
    interpolate = for_vibrations("scipy.interpolate")
    below = [interpolate.CubicHermiteSpline(t, x, slope) for x, slope in pairwise(u)]
    return [curve.c[::-1] for curve in (*below, interpolate.CubicSpline(t, u[-1]))]


def _integrated(t: Array, p: Array, start: float, tau: float) -> Array:
    h = np.diff(t)
    left = np.exp(-h / tau)
    gained = np.where(h > tau, _by_series(p, h, tau, left), _by_quadrature(p, h, tau))
    q = [start]
    for decay, gain in zip(left.tolist(), gained.tolist(), strict=True):
        q.append(decay * q[-1] + gain)
    return np.array(q)


def _by_series(p: Array, h: Array, tau: float, left: Array) -> Array:
    """Return r(h) - r(0) exp(-h/tau)."""
    r = p.copy()
    for k in (2, 1, 0):
        r[k] = p[k] - tau * (k + 1) * r[k + 1]
    gained: Array = _value(r, h) - r[0] * left
    return gained


def _by_quadrature(p: Array, h: Array, tau: float) -> Array:
    """Return the integral of exp(-(h - s)/tau) p(s) / tau over a step."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    gained: Array = np.zeros_like(h)
    for node, weight in zip(nodes, weights, strict=True):
        s = h * (1 + node) / 2
        gained += weight * h / 2 / tau * np.exp(-(h - s) / tau) * _value(p, s)
    return gained


def _value(p: Array, s: Array) -> Array:
    value: Array = ((p[3] * s + p[2]) * s + p[1]) * s + p[0]
    return value
