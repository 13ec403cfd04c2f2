"""Laws of drives in time: linear systems of their inputs u = (r, rd, rdd, x, xd, tau_0), and the limit of the torque.

    z' = A z + B u + w sigma,    tau = C z + D u + d sigma,    sigma = sat(f) - f,    f = F z + G u

f is the set point of the torque behind its filters, d and w are what the limit takes from it further on, and what it
gives back to the integral part: sigma Tn/(Kp Tt). So a notch does not act within the limit, as in sampled controllers.
x is the position that is controlled, tau_0 the torque that holds the machine at the start, behind the controller.
Filters of set points give the rates of what they let pass, so that nothing is differentiated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.control.cascade import (
    CURRENT,
    Biquad,
    Cascade,
    Element,
    FirstOrder,
    System,
    biquad_system,
    first_order_system,
    system_of,
)
from symoro_elastic.foundation.array_types import Array

INPUTS = R, RD, RDD, X, XD, TAU = tuple(range(6))


@dataclass(frozen=True)
class DriveLaw:
    """The law of one drive; `rest` (n, 6) gives its states at rest by its inputs, `sizes` are those of its states."""

    A: Array
    B: Array
    C: Array
    D: Array
    F: Array
    G: Array
    w: Array
    d: float
    limit: float
    rest: Array
    sizes: Array

    def rates(self, z: Array, u: Array) -> Array:
        """Return z' (n,) at states (n,) and inputs (6,)."""
        found: Array = self.A @ z + self.B @ u + self.w * self._beyond(z, u)
        return found

    def torques(self, z: Array, u: Array) -> Array:
        """Return tau (N,) at states (N, n) and inputs (N, 6)."""
        found: Array = z @ self.C + u @ self.D + self.d * self._beyond(z, u)
        return found

    def slopes(self, z: Array, u: Array) -> tuple[Array, Array, Array, Array]:
        """Return the derivatives A, B, C, D at z (n,), u (6,): beyond the limit f counts no more."""
        out = float(self._beyond(z, u) != 0)
        A, B = self.A - out * np.outer(self.w, self.F), self.B - out * np.outer(self.w, self.G)
        return A, B, self.C - out * self.d * self.F, self.D - out * self.d * self.G

    def _beyond(self, z: Array, u: Array) -> Array:
        f = z @ self.F + u @ self.G
        found: Array = np.clip(f, -self.limit, self.limit) - f
        return found


class _Wiring:
    """Signals as rows over states, inputs and sigma; rates of the states."""

    def __init__(self, states: int) -> None:
        self.states, self.used = states, 0
        self.rates = np.zeros((states, states + len(INPUTS) + 1))
        *self.inputs, self.beyond = np.eye(states + len(INPUTS) + 1)[states:]

    def through(self, system: System, signal: Array) -> Array:
        """Return the signal behind a system."""
        own = slice(self.used, self.used + len(system.A))
        self.used = own.stop
        self.rates[own] = np.outer(system.B, signal)
        self.rates[own, own] += system.A
        found = system.D * signal
        found[own] += system.C
        return found

    def set_points(self, one: Biquad | FirstOrder | None) -> tuple[Array, Array, Array]:
        """Return rf, rfd and rfdd."""
        r, rd, rdd = self.inputs[R], self.inputs[RD], self.inputs[RDD]
        if one is None:
            return r, rd, rdd
        first = self.used
        rf = self.through(_of_set_point(one), r)
        rfd = self.rates[first].copy()
        over = 1 / one.time
        return rf, rfd, over * (self.rates[first + 1] if isinstance(one, Biquad) else rd - rfd)


def law_of(one: Cascade, of_delay: int = 1) -> DriveLaw:
    """Return the law of a drive, its dead time as so many approximations of Pade; a hold counts half of its period."""
    limited, shaped = one.torque_limit < np.inf, one.set_point
    assert shaped is None or isinstance(shaped, Biquad | FirstOrder)
    filters = tuple(x for x in one.path if limited and _is_filter(x))
    ahead = system_of(filters)
    behind = system_of(tuple(x for x in one.path if x not in filters), of_delay)
    before = 0 if shaped is None else len(_of_set_point(shaped).A)
    integral = int(one.Tn < np.inf)
    n = before + integral + len(ahead.A) + len(behind.A)
    of = _Wiring(n)
    rf, rfd, rfdd = of.set_points(shaped)
    e = one.Kv * (rf - of.inputs[X]) + one.velocity_forward * rfd - of.inputs[XD]
    tau_u = one.Kp * e + one.acceleration_forward * rfdd + of.inputs[TAU]
    if integral:
        Tt = one.Tn if one.windup is None else one.windup
        gives_way = of.beyond * (one.Tn / (one.Kp * Tt)) if limited else 0 * of.beyond
        tau_u = tau_u + one.Kp / one.Tn * of.through(_INTEGRAL, e + gives_way)
    f = of.through(ahead, tau_u)
    tau = of.through(behind, f + of.beyond if limited else f)
    if current := one.current:  # its states are the last two; the back-EMF acts on that of the torque
        of.rates[n - 2] -= current.drag / current.inductance * of.inputs[XD]
    rest = np.zeros((n, len(INPUTS)))
    if shaped is not None:
        rest[:before, [R, RD]] = _steady(shaped)
    parts = ((ahead, before + integral), (behind, before + integral + len(ahead.A)))
    for part, first in parts:
        rest[first : first + len(part.A), TAU] = -np.linalg.solve(part.A, part.B)
    sizes = np.concatenate([np.ones(before + integral), np.full(n - before - integral, one.Kp)])
    rates = (of.rates[:, :n], of.rates[:, n:-1])
    return DriveLaw(
        *rates, tau[:n], tau[n:-1], f[:n], f[n:-1], of.rates[:, -1], float(tau[-1]), one.torque_limit, rest, sizes
    )


def current_loop(one: Cascade, lag: float) -> DriveLaw:
    """Return z' = (tau_0 - z)/lag with torque z, or tau_0 where there is no lag: what a sampled drive is in between."""
    n = int(lag > 0)
    of = _Wiring(n)
    system = first_order_system(FirstOrder(CURRENT, lag)) if lag else System.gain(1.0)
    tau = of.through(system, of.inputs[TAU])
    none, rest = np.zeros(n), np.zeros((n, len(INPUTS)))
    rest[:, TAU] = 1
    rates, torque = (of.rates[:, :n], of.rates[:, n:-1]), (tau[:n], tau[n:-1])
    return DriveLaw(*rates, *torque, none, np.zeros(len(INPUTS)), none, 0.0, np.inf, rest, np.full(n, one.Kp))


def _is_filter(one: Element) -> bool:
    return isinstance(one, Biquad) or (isinstance(one, FirstOrder) and one.name != CURRENT)


_INTEGRAL = System(np.zeros((1, 1)), np.ones(1), np.ones(1), 0.0)


def _of_set_point(one: Biquad | FirstOrder) -> System:
    return biquad_system(one) if isinstance(one, Biquad) else first_order_system(one)


def _steady(one: Biquad | FirstOrder) -> Array:
    """Return the states of a filter by r and rd where rd has been constant for long."""
    if isinstance(one, FirstOrder):
        return np.array([[1, -one.time]])
    return np.array([[1, -2 * one.below * one.time], [0, one.time]])
