"""Poles and zeros of a transfer function; zeros on the imaginary axis are antiresonances.

Zeros are the finite s at which [[s^2 M + s D + K, -F], [Cq + s Cv + s^2 Ca, 0]] is singular. How many there are
follows from the first Markov parameter that does not vanish. Those at s = 0 follow from the structure: powers of s in
the output, and states on which nothing depends but their own derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.analysis.vibration.linearization import Linearization
from symoro_elastic.analysis.vibration.modes import damped_poles
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_vibrations

VANISHING_PARAMETER = 1e-10
CANCELLING = 1e-6
NO_RESPONSE = 1e-12
"""Of the largest response that a motion of this size can have."""
PLACES, OFF_POLES = 12, 1j * np.pi / 3
"""How many s a response is looked at, and their angle: between the imaginary axis and unstable poles."""


@dataclass(frozen=True)
class PolesAndZeros:
    """Poles and zeros of the transfer function from `input` to `output`, rad/s; cancelled pairs are omitted.

    `is_zero`: the transfer function is 0 at every s, without poles and zeros.
    """

    input: str
    output: str
    poles: ComplexArray
    zeros: ComplexArray
    is_zero: bool = False

    @property
    def resonances(self) -> Array:
        """|p| / 2 pi of the oscillating pole pairs, Hz, ascending."""
        return _swinging(self.poles)

    @property
    def antiresonances(self) -> Array:
        """|z| / 2 pi of the zero pairs near the imaginary axis (damping ratio below 0.1), Hz, ascending."""
        near = self.zeros[np.abs(self.zeros.real) <= 0.1 * np.abs(self.zeros)]
        return _swinging(near)


def _swinging(roots: ComplexArray) -> Array:
    return np.asarray(np.sort(np.abs(roots[roots.imag > 0])) / (2 * np.pi))


def poles_and_zeros(linear: Linearization, ins: str, outs: str) -> PolesAndZeros:
    """Return poles and zeros from one input to one output of a linearization; raises `InputError` for other names."""
    j, i = _number(linear, ins, linear.inputs, "input"), _number(linear, outs, linear.outputs, "output")
    poles, _ = damped_poles(linear)
    if _is_zero(linear, i, j, poles):
        none = np.zeros(0, dtype=complex)
        return PolesAndZeros(linear.inputs[j], linear.outputs[i], none, none, is_zero=True)
    zeros = _zeros(linear, i, j)
    rate = float(np.abs(poles).max(initial=1.0))
    left_poles, left_zeros = _cancel(poles, zeros, CANCELLING * rate)
    return PolesAndZeros(linear.inputs[j], linear.outputs[i], left_poles, left_zeros)


def _number(linear: Linearization, name: str, names: tuple[str, ...], what: str) -> int:
    if name not in names:
        raise InputError(linear.motion.source, what, f"{name!r} is not one of {', '.join(names)}")
    return names.index(name)


def _is_zero(linear: Linearization, i: int, j: int, poles: ComplexArray) -> bool:
    """Return whether G is 0 within rounding, from below the slowest to above the fastest pole."""
    scale = 1 / np.sqrt(np.diag(linear.M))
    both, b = np.outer(scale, scale), linear.F[:, j] * scale
    rates = np.abs(poles[poles != 0])
    places = np.geomspace(rates.min(initial=1.0) / 2, rates.max(initial=1.0) * 2, PLACES) * np.exp(OFF_POLES)
    for s in places:
        moved = np.linalg.solve((s * s * linear.M + s * linear.D + linear.K) * both, b.astype(complex))
        row = (linear.Cq[i] + s * linear.Cv[i] + s * s * linear.Ca[i]) * scale
        if abs(row @ moved) > NO_RESPONSE * np.linalg.norm(row) * np.linalg.norm(moved):
            return False
    return True


def _zeros(linear: Linearization, i: int, j: int) -> ComplexArray:
    """Return zeros in rad/s, computed with time in units of the fastest pole."""
    n = len(linear.K)
    scale = 1 / np.sqrt(np.diag(linear.M))
    both = np.outer(scale, scale)
    M, D, K = linear.M * both, linear.D * both, linear.K * both
    rate = float(np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(M, K))).max(initial=0.0))) or 1.0
    b = linear.F[:, j] * scale
    c = np.array([linear.Cq[i], linear.Cv[i] * rate, linear.Ca[i] * rate**2]) * scale
    b, c = b / np.abs(b).max(), c / np.abs(c).max()
    at_zero = int(np.argmax(c.any(axis=1)))
    c = np.concatenate([c[at_zero:], np.zeros((at_zero, n))])
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K) / rate**2, -np.linalg.solve(M, D) / rate]])
    B = np.concatenate([np.zeros(n), np.linalg.solve(M, b)])
    C = np.concatenate([c[0], c[1]]) + c[2] @ A[n:]
    feed = float(c[2] @ B[n:])
    active = _without_idle(A, C)
    at_zero += len(A) - len(active)
    A, B, C = A[np.ix_(active, active)], B[active], C[active]
    return np.concatenate([np.zeros(at_zero), rate * _of_pencil(A, B, C, feed)])


def _without_idle(A: Array, C: Array) -> NDArray[np.intp]:
    """Return the states that other states or the output depend on; each other state adds a zero at 0."""
    active: NDArray[np.intp] = np.arange(len(A), dtype=np.intp)
    while len(active) and (idle := ~(A[np.ix_(active, active)].any(axis=0) | (C[active] != 0))).any():
        active = active[~idle]
    return active


def _of_pencil(A: Array, B: Array, C: Array, feed: float) -> ComplexArray:
    """Return the finite zeros of a state space, ascending."""
    count, n = _finite(A, B, C, feed), len(A)
    if not count:
        return np.zeros(0, dtype=complex)
    pencil = np.block([[A, B[:, None]], [C[None], np.array([[feed]])]])
    of_s = np.zeros_like(pencil)
    of_s[:n, :n] = np.eye(n)
    over, under = for_vibrations("scipy.linalg").eig(pencil, of_s, right=False, homogeneous_eigvals=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        roots = np.where(np.abs(under) > 0, over / under, np.inf)
    roots = roots[np.argsort(np.abs(roots), kind="stable")][:count]
    zeros = roots[np.isfinite(roots)]
    return np.asarray(zeros[np.lexsort((zeros.imag, np.abs(zeros).round(6)))], dtype=complex)


def _finite(A: Array, B: Array, C: Array, feed: float) -> int:
    """Return the number of finite zeros: states minus the relative degree."""
    if abs(feed) > VANISHING_PARAMETER * np.linalg.norm(C) * np.linalg.norm(B):
        return len(A)
    moved = B
    for degree in range(1, len(A) + 1):
        if abs(C @ moved) > VANISHING_PARAMETER * np.linalg.norm(C) * np.linalg.norm(moved):
            return len(A) - degree
        moved = A @ moved
    return 0


def _cancel(poles: ComplexArray, zeros: ComplexArray, near: float) -> tuple[ComplexArray, ComplexArray]:
    """Return the poles and zeros that do not cancel each other; zeros at 0, which are exact, cancel last."""
    remaining, uncancelled = list(zeros), []
    for pole in poles:
        close = [k for k, zero in enumerate(remaining) if abs(zero - pole) <= near]
        if close:
            remaining.pop(min(close, key=lambda k: (remaining[k] == 0, abs(remaining[k] - pole))))
        else:
            uncancelled.append(pole)
    return np.array(uncancelled, dtype=complex), np.array(remaining, dtype=complex)
