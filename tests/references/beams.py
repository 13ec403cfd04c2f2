"""Uniform beams by Euler and Bernoulli, bars by d'Alembert: frequencies as roots, to 30 digits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np


def clamped_beam(mass: float, inertia: float, count: int) -> np.ndarray:
    """Circular frequencies over sqrt(EI/(mu L^4)): clamped, with a tip of mass/(mu L), inertia/(mu L^3)."""

    def determinant(beta: Any) -> Any:
        c, s, ch, sh = (f(beta) for f in (mpmath.cos, mpmath.sin, mpmath.cosh, mpmath.sinh))
        w, w1, w2, w3 = (ch - c, sh - s), (sh + s, ch - c), (ch + c, sh + s), (sh - s, ch + c)
        force = [x + mass * beta * y for x, y in zip(w3, w, strict=True)]
        moment = [x - inertia * beta**3 * y for x, y in zip(w2, w1, strict=True)]
        return (force[0] * moment[1] - force[1] * moment[0]) / ch**2

    return np.asarray([float(x**2) for x in _roots(determinant, 0.05, count)])


def free_beam(count: int) -> np.ndarray:
    """Circular frequencies over sqrt(EI/(mu L^4)) of a free beam."""
    return np.asarray([float(x**2) for x in _roots(lambda b: mpmath.cos(b) - 1 / mpmath.cosh(b), 1.0, count)])


def clamped_bar(tip: float, count: int) -> np.ndarray:
    """Circular frequencies over sqrt(EA/(mu L^2)): clamped, with a tip mass of `tip` beam masses; of torsion alike."""
    return np.asarray([float(x) for x in _roots(lambda b: tip * b * mpmath.sin(b) - mpmath.cos(b), 0.01, count)])


def _roots(f: Callable[[Any], Any], start: float, count: int) -> list[Any]:
    """The first roots above `start`, bracketed in steps of 0.02."""
    with mpmath.workdps(30):
        roots, x, step = list[Any](), mpmath.mpf(start), mpmath.mpf("0.02")
        while len(roots) < count:
            if f(x) * f(x + step) < 0:
                roots.append(mpmath.findroot(f, (x, x + step), solver="anderson"))
            x += step
        return roots
