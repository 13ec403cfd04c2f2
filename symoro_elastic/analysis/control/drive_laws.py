"""Laws of drives in time: linear systems of their inputs u = (r, rd, rdd, x, xd, tau_0), and limits.

    z' = A z + B u + W sigma,    tau = C z + D u + d sigma,    sigma_j = sat(f_j) - f_j,    f = F z + G u + H sigma

f_1 is the set point of the torque behind its filters; d and W are the effects of its excess further on, and what it
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
    current_system,
    first_order_system,
    system_of,
)
from symoro_elastic.foundation.array_types import Array

INPUTS = R, RD, RDD, X, XD, TAU = tuple(range(6))
LIMITS = TORQUE, VOLTAGE = tuple(range(2))


@dataclass(frozen=True)
class DriveLaw:
    """The law of a drive; `steady` (n, 6) gives its steady states by its inputs, `sizes` are scales of its states."""

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
    steady: Array
    sizes: Array

    def rates(self, z: Array, u: Array) -> Array:
        """Return z' (n,) at states (n,) and inputs (6,)."""
        return np.asarray(self.A @ z + self.B @ u + self.W @ self._beyond(z, u))

    def torques(self, z: Array, u: Array) -> Array:
        """Return tau (N,) at states (N, n) and inputs (N, 6)."""
        return np.asarray(z @ self.C + u @ self.D + self._beyond(z, u) @ self.d)

    def slopes(self, z: Array, u: Array) -> tuple[Array, Array, Array, Array]:
        """Return the derivatives A, B, C, D at z (n,), u (6,): the excess of a limited signal has no slope."""
        changed = np.zeros((len(LIMITS), len(z) + len(INPUTS)))
        for j, out in enumerate(self._beyond(z, u) != 0):
            if out:
                changed[j] = -np.concatenate([self.F[j], self.G[j]]) - self.H[j] @ changed
        by_z, by_u = changed[:, : len(z)], changed[:, len(z) :]
        return self.A + self.W @ by_z, self.B + self.W @ by_u, self.C + self.d @ by_z, self.D + self.d @ by_u

    def _beyond(self, z: Array, u: Array) -> Array:
        f = z @ self.F.T + u @ self.G.T
        excess = np.zeros_like(f)
        for j in self._finite:
            wanted = f[..., j] + excess @ self.H[j]
            excess[..., j] = np.clip(wanted, -self.limits[j], self.limits[j]) - wanted
        return excess

    @cached_property
    def _finite(self) -> list[int]:
        return [j for j, limit in enumerate(self.limits) if limit < np.inf]


class _Wiring:
    """Assembly of a drive law: signals as rows over states, inputs and limit excesses; rates of the states."""

    def __init__(self, states: int) -> None:
        self.states, self.used = states, 0
        self.rates = np.zeros((states, states + len(INPUTS) + len(LIMITS)))
        signals = np.eye(states + len(INPUTS) + len(LIMITS))[states:]
        self.inputs, self.beyond = signals[: len(INPUTS)], signals[len(INPUTS) :]

    def through(self, system: System, signal: Array) -> Array:
        """Append a system driven by a signal; return its output as a row."""
        own = slice(self.used, self.used + len(system.A))
        self.used = own.stop
        self.rates[own] = np.outer(system.B, signal)
        self.rates[own, own] += system.A
        output = system.D * signal
        output[own] += system.C
        return output

    def winding(self, loop: CurrentLoop, wanted: Array) -> tuple[Array, Array]:
        """Return the torque of a current controller at a winding, and its voltage times Kt."""
        tau = self.through(current_system(loop), wanted)
        i = self.used - 2
        self.rates[i] -= loop.drag / loop.inductance * self.inputs[XD]
        voltage = loop.kp * (wanted - tau) + loop.compensated * self.inputs[XD]
        voltage[i + 1] += loop.kp
        self.rates[i] += self.beyond[VOLTAGE] / loop.inductance
        self.rates[i + 1] += self.beyond[VOLTAGE] / (loop.kp * loop.ti)
        return tau, voltage

    def law(self, tau: Array, f: Array, voltage: Array, limits: Array, steady: Array, sizes: Array) -> DriveLaw:
        """Return the drive law with torque `tau`, limited signals `f` and `voltage`, and its limits."""
        n, m = self.states, self.states + len(INPUTS)
        judged = np.array([f, voltage])
        return DriveLaw(
            *(self.rates[:, :n], self.rates[:, n:m], tau[:n], tau[n:m]),
            *(judged[:, :n], judged[:, n:m], np.tril(judged[:, m:], -1), self.rates[:, m:], tau[m:]),
            *(limits, steady, sizes),
        )

    def set_points(self, shaper: Biquad | FirstOrder | None) -> tuple[Array, Array, Array]:
        """Return the filtered set point and its rates: rf, rfd and rfdd."""
        r, rd, rdd = self.inputs[R], self.inputs[RD], self.inputs[RDD]
        if shaper is None:
            return r, rd, rdd
        first = self.used
        rf = self.through(system_of((shaper,)), r)
        rfd = self.rates[first].copy()
        over = 1 / shaper.time
        return rf, rfd, over * (self.rates[first + 1] if isinstance(shaper, Biquad) else rd - rfd)


def law_of(drive: Cascade, of_delay: int = 1) -> DriveLaw:
    """Return the law of a drive with Pade elements `of_delay` for its dead time; a hold counts half of its period."""
    limited, shaped = drive.torque_limit < np.inf, drive.set_point
    assert shaped is None or isinstance(shaped, Biquad | FirstOrder)
    before_limit, behind_it = parts_of_path(drive)
    ahead, behind = system_of(before_limit), system_of(behind_it, of_delay)
    before = 0 if shaped is None else len(system_of((shaped,)).A)
    integral = int(drive.Tn < np.inf)
    electric = 2 if drive.current else 0
    n = before + integral + len(ahead.A) + len(behind.A) + electric
    of = _Wiring(n)
    rf, rfd, rfdd = of.set_points(shaped)
    e = drive.Kv * (rf - of.inputs[X]) + drive.velocity_forward * rfd - of.inputs[XD]
    tau_u = drive.Kp * e + drive.acceleration_forward * rfdd + of.inputs[TAU]
    if integral:
        Tt = drive.Tn if drive.windup is None else drive.windup
        gives_way = of.beyond[TORQUE] * (drive.Tn / (drive.Kp * Tt)) if limited else 0 * of.beyond[TORQUE]
        tau_u = tau_u + drive.Kp / drive.Tn * of.through(_INTEGRAL, e + gives_way)
    f = of.through(ahead, tau_u)
    wanted = of.through(behind, f + of.beyond[TORQUE] if limited else f)
    tau, voltage = of.winding(drive.current, wanted) if drive.current else (wanted, 0 * wanted)
    steady = np.zeros((n, len(INPUTS)))
    if shaped is not None:
        steady[:before, [R, RD]] = _steady(shaped)
    first = before + integral
    for part in (ahead, behind, *([current_system(drive.current)] if drive.current else [])):
        steady[first : first + len(part.A), TAU] = -np.linalg.solve(part.A, part.B)
        first += len(part.A)
    sizes = np.concatenate([np.ones(before + integral), np.full(n - before - integral, drive.Kp)])
    return of.law(tau, f, voltage, np.array([drive.torque_limit, drive.voltage_limit]), steady, sizes)


def parts_of_path(drive: Cascade) -> tuple[tuple[Element, ...], tuple[Element, ...]]:
    """Return the elements of the torque path before the limit (filters) and after it, up to the winding."""
    filters = [x for x in drive.path if isinstance(x, Biquad) or (isinstance(x, FirstOrder) and x.name != CURRENT)]
    ahead = tuple(filters if drive.torque_limit < np.inf else ())
    return ahead, tuple(x for x in drive.path if x not in (*ahead, drive.current))


def current_loop(drive: Cascade, lag: float) -> DriveLaw:
    """Return the law from a required torque tau_0 to torque: a lag, a current controller at its winding, or direct.

    It is what a sampled drive is in between.
    """
    n = 2 if drive.current else int(lag > 0)
    of, wanted = _Wiring(n), np.zeros(n + len(INPUTS) + len(LIMITS))
    wanted[n + TAU] = 1
    voltage, steady = 0 * wanted, np.zeros((n, len(INPUTS)))
    if drive.current:
        tau, voltage = of.winding(drive.current, wanted)
        part = current_system(drive.current)
        steady[:, TAU] = -np.linalg.solve(part.A, part.B)
    else:
        tau = of.through(first_order_system(FirstOrder(CURRENT, lag)) if lag else System.gain(1.0), wanted)
        steady[:, TAU] = 1
    return of.law(tau, 0 * wanted, voltage, np.array([np.inf, drive.voltage_limit]), steady, np.full(n, drive.Kp))


_INTEGRAL = System(np.zeros((1, 1)), np.ones(1), np.ones(1), 0.0)


def _steady(shaper: Biquad | FirstOrder) -> Array:
    """Return the steady states of a filter per r and rd, at constant rd."""
    if isinstance(shaper, FirstOrder):
        return np.array([[1, -shaper.time]])
    return np.array([[1, -2 * shaper.below * shaper.time], [0, shaper.time]])
