"""The border of stability of a cut with forces that change within the time between teeth, by semi-discretization.

With x' = A x + B F of the machine and its closed loops, y = C x and F = K b W(t) (y(t) - y(t - T)), the time T between
teeth is divided into N intervals h. In each of them W is its mean, and y(t - T) the polynomial of degree 3 through its
values at four of their ends, the two of the interval and one on either side:

    x_k+1 = P_k x_k + sum_i R_ki y_k-N+i,   i = -1 ... 2,
    P_k = e^(A_k h),   R_ki = -int_0^h e^(A_k (h - s)) l_i(s/h) ds K b B W_k

A_k = A + K b B W_k C, l_i the polynomials of Lagrange. The cut is stable where all eigenvalues of the map over T, of x
and the last N + 1 values of y, are within the unit circle (Insperger and Stepan 2002, 2004, who take the mean of two
values: with the polynomial errors in turning fall with the fourth power of h, in milling with the square of it, by W).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.control.cutting import Cut
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.packages import for_vibrations

FIRST, RATIO, HIGHEST = 0.5, 1.25, 8.0
"""Depths that are tried, of the one of the zeroth-order theory: from, by steps of, up to."""
NOTHING = 1e-4
"""Of that depth: less is no cut."""
EXACT = 1e-6
"""Relative error of a depth, beside that of the intervals."""
NODES = 4
"""Values of y that a polynomial goes through."""
DERIVATIVES = np.array([[0, 6, 0, 0], [-2, -3, 6, -1], [3, -6, 3, 0], [-3, 9, -9, 3]]) / np.array([[6], [6], [3], [3]])
"""Of the polynomials of Lagrange through -1, 0, 1, 2 (columns) at 0: value and first to third derivative (rows)."""


@dataclass(frozen=True)
class TimePeriodicCut:
    """A machine with closed loops, x' = A x + B F and y = C x, under a cut, divided into `intervals`."""

    A: Array
    B: Array
    C: Array
    cut: Cut
    intervals: int

    def growth(self, depth: float, speed: float) -> float:
        """Return the logarithm of the largest multiplier over the time between teeth: negative where it is stable."""
        step = self.cut.period(speed) / self.intervals
        n, m, N = len(self.A), len(self.C), self.intervals
        pushes = self.cut.coefficient * depth * self.B @ self.cut.factors(N)
        # The input and its derivatives by s/h, each the rate of the one before.
        together = np.zeros((N, n + NODES * m, n + NODES * m))
        together[:, :n, :n], together[:, :n, n : n + m] = (self.A + pushes @ self.C) * step, -pushes * step
        together[:, n:-m, n + m :] = np.eye((NODES - 1) * m)
        steps = for_vibrations("scipy.linalg").expm(together)
        by_value = np.einsum("kxjm,ji->kixm", steps[:, :n, n:].reshape(N, n, NODES, m), DERIVATIVES)
        # x and y_0 ... y_-N-1, over x_0 and y_-1 ... y_-N-1: columns of the map.
        size = n + (N + 1) * m
        x = np.eye(n, size)
        known = [*np.eye(size - n, size, n).reshape(N + 1, m, -1)[::-1], self.C @ x]
        for k in range(N):
            values = sum(by_value[k, i] @ known[k + i] for i in range(NODES))
            x = steps[k, :n, :n] @ x + values
            known.append(self.C @ x)
        # The last value of y is C x, which the next map has from x.
        whole = np.vstack([x, *known[-2 : -N - 3 : -1]])
        return float(np.log(np.abs(np.linalg.eigvals(whole)).max()))

    def limit(self, speed: float, near: float) -> float:
        """Return the least depth at which the cut gets unstable, by that of the zeroth-order theory, `near`.

        Infinite where it is stable up to 8 times of it. Islands between depths that are tried, 25 % apart, may be left
        out.
        """
        low = FIRST * near
        while self.growth(low, speed) >= 0:
            low /= 2
            if low < NOTHING * near:
                return 0.0
        high = low
        while high < HIGHEST * near:
            low, high = high, high * RATIO
            if self.growth(high, speed) >= 0:
                solve = for_vibrations("scipy.optimize").brentq
                return float(solve(lambda b: self.growth(b, speed), low, high, rtol=EXACT, xtol=EXACT * high))
        return np.inf
