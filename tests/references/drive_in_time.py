"""The drive of a motor as equations by hand (D4) to (D6), in many digits; slopes by differences of straight pieces."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from mpmath import mpf, pi, sqrt

from symoro_elastic.machine.drives import Drive, LowPass, Notch
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint

STEP = mpf("1e-15")
"""For slopes: the law is piecewise straight, so a difference is exact."""


@dataclass
class Given:
    """Set points r, rd, rdd, position x, velocity xd, and the torque that is added."""

    r: Any
    rd: Any
    rdd: Any
    x: Any
    xd: Any
    tau: Any


class DriveInTime:
    """Rates of states and torque; `numbers` are taken from formulas without parameters."""

    def __init__(self, joint: Joint, drive: Drive, number: Callable[[float], Any] = mpf) -> None:
        self.drive, self.number = drive, number
        own = joint.electrics
        self.n = number(joint.ratio.value()) if not joint.ratio.is_zero else number(1)
        self.Kt, self.Ke = self._of(own.torque_constant), self._of(own.torque_constant)
        if not own.back_emf.is_zero:
            self.Ke = self._of(own.back_emf)
        self.R, self.L = self._of(own.resistance), self._of(own.inductance)

    def _of(self, formula: Formula) -> Any:
        return self.number(formula.value())

    @property
    def limit(self) -> Any:
        """Of the torque, by that of the current, too; None where there is none."""
        drive, found = self.drive, []
        if drive.torque_limit is not None:
            found.append(self._of(drive.torque_limit))
        if drive.current_limit is not None:
            found.append(abs(self.Kt * self.n) * self._of(drive.current_limit))
        return min(found, default=None)

    def answer(self, z: Sequence[Any], u: Given) -> tuple[list[Any], Any]:
        """z' and the torque: states of set point, integral, filters before a limit, dead time, lag or winding.

        Filters are behind the dead time and the lag where there is no limit.
        """
        drive, left, rates = self.drive, list(z), []
        rf, rfd, rfdd = u.r, u.rd, u.rdd
        if isinstance(drive.set_point, LowPass):
            w = 2 * pi * self._of(drive.set_point.frequency)
            if drive.set_point.order == 1:
                rf = left.pop(0)
                rfd = w * (u.r - rf)
                rfdd = w * (u.rd - rfd)
                rates.append(rfd)
            else:
                rf, scaled = left.pop(0), left.pop(0)
                rfd = w * scaled
                rfdd = w * w * (u.r - rf) - sqrt(mpf(2)) * w * rfd
                rates += [rfd, rfdd / w]
        Kp, Kv = self._of(drive.Kp), self._of(drive.Kv)
        e = Kv * (rf - u.x) + self._of(drive.velocity_forward) * rfd - u.xd
        tau = Kp * e + self._of(drive.acceleration_forward) * rfdd + u.tau
        place, Tn = len(rates), None
        if drive.Tn is not None:
            Tn = self._of(drive.Tn)
            tau += Kp * left.pop(0) / Tn
        if self.limit is not None:
            tau = self._filtered(tau, left, rates)
            held = min(max(tau, -self.limit), self.limit)
            if Tn is not None:
                e += (held - tau) * Tn / (Kp * (Tn if drive.windup is None else self._of(drive.windup)))
            tau = held
        if drive.Tn is not None:
            rates.insert(place, e)
        tau = self._delayed(tau, left, rates)
        if self.limit is None:
            tau = self._filtered(tau, left, rates)
        if drive.current is not None:
            tau = self._wound(tau, u.xd, left, rates)
        assert not left
        return rates, tau

    def _delayed(self, tau: Any, left: list[Any], rates: list[Any]) -> Any:
        if self.drive.dead_time is not None:  # Pade: 1 - (d s)/(1 + d s/2 + (d s)^2/12)
            d = self._of(self.drive.dead_time)
            a, b = left.pop(0), left.pop(0)
            rates += [12 * b / d, (tau - a - 6 * b) / d]
            tau = tau - 12 * b
        if not self.drive.lag.is_zero:
            own = left.pop(0)
            rates.append((tau - own) / self._of(self.drive.lag))
            tau = own
        return tau

    def _filtered(self, tau: Any, left: list[Any], rates: list[Any]) -> Any:
        for one in self.drive.filters:
            w = 2 * pi * self._of(one.frequency)
            if isinstance(one, LowPass) and one.order == 1:
                own = left.pop(0)
                rates.append(w * (tau - own))
                tau = own
                continue
            below = sqrt(mpf(2)) / 2 if isinstance(one, LowPass) else self._of(one.width)
            y, scaled = left.pop(0), left.pop(0)  # (s^2 + 2 below w s + w^2) y = w^2 tau, scaled = y'/w
            rates += [w * scaled, w * (tau - y - 2 * below * scaled)]
            tau = tau + 2 * (self._of(one.depth) - below) * scaled if isinstance(one, Notch) else y
        return tau

    def _wound(self, tau: Any, xd: Any, left: list[Any], rates: list[Any]) -> Any:
        """In A and V: i_w = tau/(Kt n); the states are Kt n i and Kt n xi/ti."""
        of = self.drive.current
        assert of is not None
        unit, kp, ti = self.Kt * self.n, self._of(of.kp), self._of(of.ti)
        wanted, i, xi = tau / unit, left.pop(0) / unit, left.pop(0) / unit * ti
        u = kp * (wanted - i + xi / ti) + self._of(of.compensation) * self.Ke * self.n * xd
        most = self.drive.voltage_limit
        held = u if most is None else min(max(u, -self._of(most)), self._of(most))
        xid = wanted - i + (held - u) / kp  # Tt = ti
        rates += [unit * (held - self.R * i - self.Ke * self.n * xd) / self.L, unit * xid / ti]
        return unit * i

    def slopes(self, z: Sequence[Any], u: Given) -> dict[str, Any]:
        """Z, Q, V, by_z, by_q, by_v: derivatives of rates and torque by z, x and xd."""
        rates, torque = self.answer(z, u)

        def by(changed: list[Any], given: Given) -> tuple[list[Any], Any]:
            new, moved = self.answer(changed, given)
            return [(a - b) / STEP for a, b in zip(new, rates, strict=True)], (moved - torque) / STEP

        columns = [by([x + (k == j) * STEP for k, x in enumerate(z)], u) for j in range(len(z))]
        Q, by_q = by([*z], Given(**{**vars(u), "x": u.x + STEP}))
        V, by_v = by([*z], Given(**{**vars(u), "xd": u.xd + STEP}))
        Z = [[column[k] for column, _ in columns] for k in range(len(z))]
        return {"Z": Z, "by_z": [x for _, x in columns], "Q": Q, "by_q": by_q, "V": V, "by_v": by_v}
