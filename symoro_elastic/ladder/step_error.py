"""The error that a method makes at a step, before anything is simulated: the method itself on the linear model.

    y' = y_r' + [0 I; -M^-1 K, -M^-1 D] (y - y_r) + [0; M^-1 R],    y = [q; v]

M, D, K, R are linear between their samples. W-methods take the T of generated steps: the inertia at the beginning of
the step, stiffness and damping of the joints themselves. The exact solution is that of a fine run.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.ladder.path import LinearPath, reference_states
from symoro_elastic.ladder.samples import between
from symoro_elastic.ladder.schemes import Method, Scheme
from symoro_elastic.ladder.small_motion import small_motion

FINE = 4
"""Steps of the fine run between samples of the model, at least."""
FINER = 2
"""Its steps in one of the method, at least."""
BLOCK = 256
"""Steps whose matrices are made at once."""
MOST_STEPS = 20_000
Solver = tuple[Array, Array, Array]


@dataclass(frozen=True)
class StepErrors:
    """Errors of methods on one path, with the springs `left_out` (entries of q) locked."""

    path: LinearPath
    left_out: tuple[int, ...] = ()

    @cached_property
    def rows(self) -> Array:
        """The entries of q that the equations of motion give."""
        return np.array([k for k in self.path.moved if k not in self.left_out], dtype=int)

    def errors(self, method: Method, steps: int) -> dict[str, float]:
        """Return the largest error of each output at the ends of so many even steps; infinite where it grows beyond.

        For methods with the T of generated steps, and explicit ones.
        """
        path, scheme = self.path, Scheme.of(method)
        t = np.linspace(0.0, path.t[-1], steps + 1)
        with np.errstate(over="ignore", invalid="ignore"):
            wrong = self._run(scheme, t) - self._exact(t)
            rates = self._rates(t, wrong)
            outputs = path.outputs.at(path.t, t)
            n = len(path.joints)
            terms = ((outputs.Cq, wrong[:, :n]), (outputs.Cv, wrong[:, n:]), (outputs.Ca, rates))
            found = np.abs(sum(np.einsum("toi,ti->to", C, x) for C, x in terms)).max(axis=0)
        return dict(zip(outputs.names, np.where(np.isfinite(found), found, np.inf).tolist(), strict=True))

    def _exact(self, t: Array) -> Array:
        """Return y (N, 2n) of the linear model at times t."""
        path, q = self.path, self._reference(t)
        steps = len(t) - 1
        finer = max(FINER, -(-FINE * (len(path.t) - 1) // steps))
        found = small_motion(path.finer(steps * finer + 1).restricted(self.rows[None]))
        n = len(path.joints)
        y = np.concatenate([q[0], q[1]], axis=1)
        y[:, self.rows] += found.d[::finer, 0]
        y[:, n + self.rows] += found.dd[::finer, 0]
        return y

    def _run(self, scheme: Scheme, t: Array) -> Array:
        """Return y (N, 2n) of the method."""
        h, (q, v, _) = float(t[1] - t[0]), self._reference(t[:1])
        y = [np.concatenate([q[0], v[0]])]
        for stages, solver in self._blocks(scheme, t):
            y.append(_stepped(scheme, h, y[-1], stages, solver, self.rows))
        return np.array(y)

    def _blocks(self, scheme: Scheme, t: Array) -> Iterator[tuple[list[tuple[Array, Array, Array]], Solver | None]]:
        """Matrices of each step: (slope (n, 2n), y_r (2n,), v' at y_r (n,)) of each stage, and what solves with T."""
        h = float(t[1] - t[0])
        for first in range(0, len(t) - 1, BLOCK):
            begins = t[first : min(first + BLOCK, len(t) - 1)]
            stages = [self._slopes(begins + c * h) for c in scheme.nodes]
            solvers = None if scheme.is_explicit else self._solver(begins, scheme.gamma * h)
            for k in range(len(begins)):
                solver = None if solvers is None else (solvers[0][k], *solvers[1:])
                yield [(slope[k], y[k], rate[k]) for slope, y, rate in stages], solver

    def _slopes(self, t: Array) -> tuple[Array, Array, Array]:
        """Return -M^-1 [K, D] (N, n, 2n), y_r (N, 2n) and v' at y_r (N, n)."""
        path, rows = self.path, self.rows
        M, D, K, R = (between(path.t, x, t) for x in (path.M, path.D, path.K, path.R))
        q, v, a = self._reference(t)
        solved = np.linalg.solve(M[:, rows[:, None], rows], np.concatenate([K, D, R[..., None]], axis=2)[:, rows])
        slope = np.zeros((len(t), len(path.joints), 2 * len(path.joints)))
        slope[:, rows] = -solved[..., :-1]
        a[:, rows] += solved[..., -1]
        return slope, np.concatenate([q, v], axis=1), a

    def _solver(self, t: Array, gh: float) -> Solver:
        """Return (M + S)^-1 (N, r, r) of the coordinates that move, S (r,) and gamma h k (r,)."""
        path, rows = self.path, self.rows
        S = gh * path.damping[rows] + gh**2 * path.stiffness[rows]
        M = between(path.t, path.M, t)[:, rows[:, None], rows]
        return np.linalg.inv(M + np.diag(S)), S, gh * path.stiffness[rows]

    def _rates(self, t: Array, wrong: Array) -> Array:
        """Return errors of accelerations (N, n) that errors of y (N, 2n) make."""
        return np.concatenate([
            np.einsum("tij,tj->ti", self._slopes(t[first : first + BLOCK])[0], wrong[first : first + BLOCK])
            for first in range(0, len(t), BLOCK)
        ])

    def _reference(self, t: Array) -> tuple[Array, Array, Array]:
        return reference_states(self.path.reference.machine, self.path.reference, t)


def _stepped(
    scheme: Scheme, h: float, y: Array, stages: list[tuple[Array, Array, Array]], solver: Solver | None, rows: Array
) -> Array:
    """Return y (2n,) after one step."""
    n = len(y) // 2
    k = np.zeros((len(scheme.b), 2 * n))
    for i, (slope, reference, rate) in enumerate(stages):
        Y = y + h * (scheme.a[i, :i] @ k[:i])
        f = np.concatenate([Y[n:], rate + slope @ (Y - reference)])
        if solver is None:
            k[i] = f
            continue
        w = (scheme.g[i, :i] / scheme.gamma) @ k[:i]
        k[i] = _solved(solver, scheme.gamma * h, f + w, rows) - w
    return y + h * (scheme.b @ k)


def _solved(solver: Solver, gh: float, r: Array, rows: Array) -> Array:
    """Return (I - gamma h T)^-1 r: (M + S) x = S r_v + gamma h k r_q, z_v = r_v - x, z_q = r_q + gamma h z_v."""
    inverse, S, k = solver
    n = len(r) // 2
    r_q, z_v = r[:n], r[n:].copy()
    z_v[rows] -= inverse @ (S * z_v[rows] + k * r_q[rows])
    return np.concatenate([r_q + gh * z_v, z_v])
