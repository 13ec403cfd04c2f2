"""Laws of drives in time: linear systems of their inputs u = (r, rd, rdd, x, xd, tau_0), and limits.

    z' = A z + B u + W sigma,    tau = C z + D u + d sigma,    sigma_j = sat(f_j) - f_j,    f = F z + G u + H sigma

f_1 is the set point of the torque behind its filters; d and W are what its limit takes from it further on, and what it
gives back to the integral part: sigma Tn/(Kp Tt). So a notch does not act within the limit, as in sampled controllers.
A limit of the current is one of this torque, Kt times it. f_2 is the voltage of a current controller, times Kt: its
limit acts on the current, and on the integral part of that controller by sigma/(kp ti).
x is the position that is controlled, tau_0 the torque that holds the machine at the start, behind the controller.
Filters of set points give the rates of what they let pass, so that nothing is differentiated.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symoro_elastic.analysis.control.cascade import (
    CURRENT,
    Biquad,
    Cascade,
    CurrentLoop,
    Element,
    FirstOrder,
    System,
    biquad_system,
    current_system,
    first_order_system,
    system_of,
)
from symoro_elastic.foundation.array_types import Array

INPUTS = R, RD, RDD, X, XD, TAU = tuple(range(6))
LIMITS = TORQUE, VOLTAGE = tuple(range(2))


@dataclass(frozen=True)
class DriveLaw:
    """The law of one drive; `rest` (n, 6) gives its states at rest by its inputs, `sizes` are those of its states."""

    A: Array
    B: Array
    C: Array
    D: Array
    F: Array
    G: Array
    H: Array
    W: Array
    d: Array
    limits: Array
    rest: Array
    sizes: Array

    def rates(self, z: Array, u: Array) -> Array:
        """Return z' (n,) at states (n,) and inputs (6,)."""
        found: Array = self.A @ z + self.B @ u + self.W @ self._beyond(z, u)
        return found

    def torques(self, z: Array, u: Array) -> Array:
        """Return tau (N,) at states (N, n) and inputs (N, 6)."""
        found: Array = z @ self.C + u @ self.D + self._beyond(z, u) @ self.d
        return found

    def slopes(self, z: Array, u: Array) -> tuple[Array, Array, Array, Array]:
        """Return the derivatives A, B, C, D at z (n,), u (6,): beyond its limit f_j counts no more."""
        changed = np.zeros((len(LIMITS), len(z) + len(INPUTS)))
        for j, out in enumerate(self._beyond(z, u) != 0):
            if out:
                changed[j] = -np.concatenate([self.F[j], self.G[j]]) - self.H[j] @ changed
        by_z, by_u = changed[:, : len(z)], changed[:, len(z) :]
        return self.A + self.W @ by_z, self.B + self.W @ by_u, self.C + self.d @ by_z, self.D + self.d @ by_u

    def _beyond(self, z: Array, u: Array) -> Array:
        f = z @ self.F.T + u @ self.G.T
        found = np.zeros_like(f)
        for j in self._finite:
            wanted = f[..., j] + found @ self.H[j]
            found[..., j] = np.clip(wanted, -self.limits[j], self.limits[j]) - wanted
        return found

    @cached_property
    def _finite(self) -> list[int]:
        return [j for j, limit in enumerate(self.limits) if limit < np.inf]


class _Wiring:
    """Signals as rows over states, inputs and sigma; rates of the states."""

    def __init__(self, states: int) -> None:
        self.states, self.used = states, 0
        self.rates = np.zeros((states, states + len(INPUTS) + len(LIMITS)))
        signals = np.eye(states + len(INPUTS) + len(LIMITS))[states:]
        self.inputs, self.beyond = signals[: len(INPUTS)], signals[len(INPUTS) :]

    def through(self, system: System, signal: Array) -> Array:
        """Return the signal behind a system."""
        own = slice(self.used, self.used + len(system.A))
        self.used = own.stop
        self.rates[own] = np.outer(system.B, signal)
        self.rates[own, own] += system.A
        found = system.D * signal
        found[own] += system.C
        return found

    def winding(self, one: CurrentLoop, wanted: Array) -> tuple[Array, Array]:
        """Return the torque behind a current controller and a winding, and the voltage times Kt."""
        tau = self.through(current_system(one), wanted)
        i = self.used - 2
        self.rates[i] -= one.drag / one.inductance * self.inputs[XD]
        voltage = one.kp * (wanted - tau) + one.compensated * self.inputs[XD]
        voltage[i + 1] += one.kp
        self.rates[i] += self.beyond[VOLTAGE] / one.inductance
        self.rates[i + 1] += self.beyond[VOLTAGE] / (one.kp * one.ti)
        return tau, voltage

    def law(self, tau: Array, f: Array, voltage: Array, limits: Array, rest: Array, sizes: Array) -> DriveLaw:
        """Return the law with these signals."""
        n, m = self.states, self.states + len(INPUTS)
        judged = np.array([f, voltage])
        return DriveLaw(
            *(self.rates[:, :n], self.rates[:, n:m], tau[:n], tau[n:m]),
            *(judged[:, :n], judged[:, n:m], np.tril(judged[:, m:], -1), self.rates[:, m:], tau[m:]),
            *(limits, rest, sizes),
        )

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
    before_limit, behind_it = parts_of_path(one)
    ahead, behind = system_of(before_limit), system_of(behind_it, of_delay)
    before = 0 if shaped is None else len(_of_set_point(shaped).A)
    integral = int(one.Tn < np.inf)
    electric = 2 if one.current else 0
    n = before + integral + len(ahead.A) + len(behind.A) + electric
    of = _Wiring(n)
    rf, rfd, rfdd = of.set_points(shaped)
    e = one.Kv * (rf - of.inputs[X]) + one.velocity_forward * rfd - of.inputs[XD]
    tau_u = one.Kp * e + one.acceleration_forward * rfdd + of.inputs[TAU]
    if integral:
        Tt = one.Tn if one.windup is None else one.windup
        gives_way = of.beyond[TORQUE] * (one.Tn / (one.Kp * Tt)) if limited else 0 * of.beyond[TORQUE]
        tau_u = tau_u + one.Kp / one.Tn * of.through(_INTEGRAL, e + gives_way)
    f = of.through(ahead, tau_u)
    wanted = of.through(behind, f + of.beyond[TORQUE] if limited else f)
    tau, voltage = of.winding(one.current, wanted) if one.current else (wanted, 0 * wanted)
    rest = np.zeros((n, len(INPUTS)))
    if shaped is not None:
        rest[:before, [R, RD]] = _steady(shaped)
    first = before + integral
    for part in (ahead, behind, *([current_system(one.current)] if one.current else [])):
        rest[first : first + len(part.A), TAU] = -np.linalg.solve(part.A, part.B)
        first += len(part.A)
    sizes = np.concatenate([np.ones(before + integral), np.full(n - before - integral, one.Kp)])
    return of.law(tau, f, voltage, np.array([one.torque_limit, one.voltage_limit]), rest, sizes)


def parts_of_path(one: Cascade) -> tuple[tuple[Element, ...], tuple[Element, ...]]:
    """Return the path of a torque before its limit, filters where there is one, and behind, up to the winding."""
    ahead = tuple(x for x in one.path if one.torque_limit < np.inf and _is_filter(x))
    return ahead, tuple(x for x in one.path if x not in (*ahead, one.current))


def current_loop(one: Cascade, lag: float) -> DriveLaw:
    """Return the law from a wanted torque tau_0 to torque: a lag, a current controller at its winding, or nothing.

    It is what a sampled drive is in between.
    """
    n = 2 if one.current else int(lag > 0)
    of, wanted = _Wiring(n), np.zeros(n + len(INPUTS) + len(LIMITS))
    wanted[n + TAU] = 1
    voltage, rest = 0 * wanted, np.zeros((n, len(INPUTS)))
    if one.current:
        tau, voltage = of.winding(one.current, wanted)
        part = current_system(one.current)
        rest[:, TAU] = -np.linalg.solve(part.A, part.B)
    else:
        tau = of.through(first_order_system(FirstOrder(CURRENT, lag)) if lag else System.gain(1.0), wanted)
        rest[:, TAU] = 1
    return of.law(tau, 0 * wanted, voltage, np.array([np.inf, one.voltage_limit]), rest, np.full(n, one.Kp))


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
