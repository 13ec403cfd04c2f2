"""Methods of fixed step on the nonlinear equations of motion: what predictions of their errors are held to.

Right sides are those of `Truth`; T is that of generated steps: the inertia at the beginning of a step, stiffness and
damping of the joints; for methods with exact derivatives central differences of the right side.
"""

from __future__ import annotations

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.integration.rosenbrock import Rosenbrock
from symoro_elastic.ladder.schemes import Method, gamma, nodes, stepped
from tests.ladder.truth import Truth


class NonlinearSteps:
    """Steps of one method with the first set of springs of a truth left out."""

    def __init__(self, truth: Truth, method: Method) -> None:
        self.truth, self.method = truth, method
        self.n = truth.free.shape[1]
        servo = truth.reference.servo
        self.stiffness, self.damping = truth.k.copy(), truth.damping.copy()
        if servo:
            self.stiffness[truth.motors] += servo[0]
            self.damping[truth.motors] += servo[1]

    def run(self, steps: int) -> tuple[Array, Array]:
        """q and v (steps + 1, n) at even times."""
        t = np.linspace(0.0, self.truth.t[-1], steps + 1)
        y = [np.concatenate([self.truth.reference.start.q, np.zeros(self.n)])]
        for k in range(steps):
            y.append(self._step(t[k], t[k + 1] - t[k], y[-1]))
        q, v = np.split(np.array(y), 2, axis=1)
        return q, v

    def rate(self, t: float, y: Array) -> Array:
        q, v = self._placed(t, y)
        return np.concatenate([v[0], self.truth.accelerations(t, q, v)[0]])

    def _placed(self, t: float, y: Array) -> tuple[Array, Array]:
        sets = self.truth.free.shape[0]
        q, v = self.truth._placed(t, np.tile(y, (sets, 1)))
        return q, v

    def _step(self, t: float, h: float, y: Array) -> Array:
        times = t + nodes(self.method) * h
        change = np.zeros(2 * self.n)
        if isinstance(self.method, Rosenbrock):
            change = (self.rate(t + 1e-6, y) - self.rate(t - 1e-6, y)) / 2e-6
        solve = self._solver(t, y, gamma(self.method) * h)
        after = stepped(self.method, h, y, lambda i, Y: self.rate(times[i], Y), solve, change)
        q, v = self._placed(t + h, after)
        return np.concatenate([q[0], v[0]])

    def _solver(self, t: float, y: Array, g: float):
        n, free = self.n, np.flatnonzero(self.truth.free[0])
        rows = np.concatenate([free, n + free])
        J = np.zeros((2 * n, 2 * n))
        if isinstance(self.method, Rosenbrock):
            for row in rows:
                change = 1e-6 * np.eye(2 * n)[row]
                J[:, row] = (self.rate(t, y + change) - self.rate(t, y - change)) / 2e-6
        else:
            q, v = self._placed(t, y)
            A = self.truth.dynamics(q, v)[0][0]
            J[free, n + free] = 1.0
            laws = np.hstack([np.diag(self.stiffness)[free][:, free], np.diag(self.damping)[free][:, free]])
            J[np.ix_(n + free, rows)] = -np.linalg.solve(A[np.ix_(free, free)], laws)
        whole = np.eye(2 * n) - g * J
        whole[:n, n:] = -g * np.eye(n)
        return lambda r: np.linalg.solve(whole, r)
