"""The border of stability of a cut with forces that change within the time between teeth, by semi-discretization.

With x' = A x + B F of the machine and its closed loops, y = C x and F = K b W(t) (y(t) - y(t - T)), the time T between
teeth is divided into N intervals h. In each of them W is its mean, and y(t - T) the mean of its values at both ends:

    x_k+1 = P_k x_k + R_k (y_k-N + y_k-N+1)/2,   P_k = e^(A_k h),   R_k = -int_0^h e^(A_k s) ds K b B W_k,

A_k = A + K b B W_k C. The cut is stable where all eigenvalues of the map over T, of x and the last N values of y, are
within the unit circle (Insperger and Stepan 2002, 2004). Errors fall with the square of h.
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
        together = np.zeros((N, n + m, n + m))
        together[:, :n, :n], together[:, :n, n:] = self.A + pushes @ self.C, -pushes
        steps = for_vibrations("scipy.linalg").expm(together * step)
        # x and y_0 ... y_-N, over x_0 and y_-1 ... y_-N: columns of the map.
        x = np.eye(n, n + N * m)
        past = [self.C @ x, *np.eye(N * m, n + N * m, n).reshape(N, m, -1)]
        known = past[::-1]
        for k, one in enumerate(steps):
            x = one[:n, :n] @ x + one[:n, n:] @ (known[k] + known[k + 1]) / 2
            known.append(self.C @ x)
        # The last value of y is C x, which the next map has from x.
        whole = np.vstack([x, *known[-2 : -N - 2 : -1]])
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
