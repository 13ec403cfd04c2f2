"""The cascade of one drive with numbers: what it is in frequencies, and as a linear system of its own.

    tau = C(s) (Kv (r - q_m) + kfv s r - s qd...),   C(s) = Kp (1 + 1/(Tn s)) P(s)
    P(s) = e^(-s Td) (1 - e^(-s T))/(s T) / (1 + lag s) prod filters(s)

P is the path of the torque: dead time, the hold of a sampled controller, current loop, filters. r is the set point
behind its filter. The limit of the torque stands beside: linear results know none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.drives import NEEDED, TUNED, Drive, Filter, LowPass, Notch, fault_of, why_wrong
from symoro_elastic.machine.formula import FormulaError
from symoro_elastic.machine.joints import Joint
from symoro_elastic.models.drives.control import samples_of_mean

ROOT_2 = 2**0.5
CURRENT = "lag of the current loop"


def laplace(frequencies: Array | ComplexArray) -> ComplexArray:
    """Return s = 2 pi i f."""
    return (2j * np.pi * frequencies).astype(complex)


@dataclass(frozen=True)
class Biquad:
    """(s^2 + 2 a w s + w^2)/(s^2 + 2 b w s + w^2), or without s^2 and s above where it is `low`; w = 2 pi f."""

    name: str
    frequency: float
    above: float
    below: float
    low: bool = False

    @property
    def time(self) -> float:
        """Its time, 1/w, s."""
        return 1 / self.w

    @property
    def w(self) -> float:
        """The angular frequency, rad/s."""
        return 2 * np.pi * self.frequency

    def at(self, s: ComplexArray) -> ComplexArray:
        """Return its response."""
        return self._above(s) / self._below(s)

    def slope(self, s: ComplexArray) -> ComplexArray:
        """Return the derivative of the logarithm of its response by that of its frequency."""
        above = 2 * self.w if self.low else 2 * self.above * s + 2 * self.w
        change = above / self._above(s) - (2 * self.below * s + 2 * self.w) / self._below(s)
        return self.w * change

    def _above(self, s: ComplexArray) -> ComplexArray:
        if self.low:
            return np.full_like(s, self.w**2)
        return s * s + 2 * self.above * self.w * s + self.w**2

    def _below(self, s: ComplexArray) -> ComplexArray:
        return s * s + 2 * self.below * self.w * s + self.w**2


@dataclass(frozen=True)
class FirstOrder:
    """1/(1 + T s): a lag, or a low-pass filter of order 1."""

    name: str
    time: float

    def at(self, s: ComplexArray) -> ComplexArray:
        """Return its response."""
        return 1 / (1 + self.time * s)

    def slope(self, s: ComplexArray) -> ComplexArray:
        """Return the derivative of the logarithm of its response by that of its time."""
        return -self.time * s / (1 + self.time * s)


@dataclass(frozen=True)
class CurrentLoop:
    """A current controller at a winding, L i' = u - R i - Ke v, from wanted torque and velocity v to torque Kt i.

        tau = H tau_w - Y v,   H = kp (ti s + 1)/N,   Y = drag ti s/N,   N = L ti s^2 + (R + kp) ti s + kp

    `drag` is Kt Ke of the joint's axis, V A s^2/rad^2 or /m^2, times the share that is not compensated, `compensated`
    times the share that is.
    """

    kp: float
    ti: float
    resistance: float
    inductance: float
    drag: float
    name: str = "current loop"
    compensated: float = 0.0

    @property
    def time(self) -> float:
        """By how much torque is behind, s: -H'(0) = R ti/kp."""
        return self.resistance * self.ti / self.kp

    def at(self, s: ComplexArray) -> ComplexArray:
        """Return H."""
        return self.kp * (self.ti * s + 1) / self._below(s)

    def dragged(self, s: ComplexArray) -> ComplexArray:
        """Return Y, from velocity to the torque that brakes."""
        return self.drag * self.ti * s / self._below(s)

    def slopes(self, s: ComplexArray) -> dict[str, tuple[ComplexArray, ComplexArray]]:
        """Return the derivatives of the logarithms of H and Y by those of its numbers, by name."""
        turned, below = self.ti * s, self._below(s)
        by_R, by_L = -self.resistance * turned / below, -self.inductance * turned * s / below
        H, rest = self.at(s), self.kp / below
        none, one = np.zeros_like(s), np.ones_like(s)
        return {
            "resistance": (by_R, by_R),
            "inductance": (by_L, by_L),
            "kp of the current loop": (1 - H, -H),
            "ti of the current loop": (turned / (turned + 1) - 1 + rest, rest),
            "torque_constant": (none, one),
            "back_emf": (none, one),
        }

    def _below(self, s: ComplexArray) -> ComplexArray:
        return (self.inductance * s + self.resistance + self.kp) * self.ti * s + self.kp


@dataclass(frozen=True)
class DeadTime:
    """e^(-s Td)."""

    name: str
    time: float

    def at(self, s: ComplexArray) -> ComplexArray:
        """Return its response."""
        return np.exp(-s * self.time)

    def slope(self, s: ComplexArray) -> ComplexArray:
        """Return the derivative of the logarithm of its response by that of its time."""
        return -s * self.time


@dataclass(frozen=True)
class Hold:
    """(1 - e^(-s T))/(s T): a torque that is held over a period."""

    name: str
    time: float

    def at(self, s: ComplexArray) -> ComplexArray:
        """Return its response."""
        turned = s * self.time
        small = np.abs(turned) < 1e-6
        exact = -np.expm1(-turned) / np.where(small, 1, turned)
        return np.where(small, 1 - turned / 2, exact)

    def slope(self, s: ComplexArray) -> ComplexArray:
        """Return the derivative of the logarithm of its response by that of its period."""
        turned = s * self.time
        small = np.abs(turned) < 1e-6
        exact = turned * np.exp(-turned) / np.where(small, 1, -np.expm1(-turned)) - 1
        return np.where(small, -turned / 2, exact)


@dataclass(frozen=True)
class Mean:
    """The mean of `samples` at intervals of a `period`, s: (1 + e^(-s T) + ...)/samples."""

    name: str
    samples: int
    period: float

    @property
    def time(self) -> float:
        """By how much it is behind, s."""
        return (self.samples - 1) * self.period / 2

    def at(self, s: ComplexArray) -> ComplexArray:
        """Return its response."""
        found: ComplexArray = np.exp(-np.multiply.outer(s, self.period * np.arange(self.samples))).mean(axis=-1)
        return found


Element = Biquad | FirstOrder | CurrentLoop | DeadTime | Hold
SetPointElement = Biquad | FirstOrder | Mean


@dataclass(frozen=True)
class Cascade:
    """A drive with numbers: `Kp` in N m s/rad or N s/m, `Kv` in 1/s, `Tn` in s, infinite without integral part.

    A gain that is sought is NaN. `path` are the elements between velocity controller and torque; `velocity_forward` is
    a share, `acceleration_forward` an inertia. `set_point` filters the set point. `torque_limit` N m or N, that of the
    current among it, and `voltage_limit`, V times Kt of the joint's axis, are infinite where there is none; `windup` is
    Tt in s, Tn where it is None.
    """

    motor: str
    Kv: float
    Kp: float
    Tn: float
    path: tuple[Element, ...]
    velocity_forward: float = 1.0
    acceleration_forward: float = 0.0
    sought: tuple[str, ...] = ()
    set_point: SetPointElement | None = None
    torque_limit: float = np.inf
    voltage_limit: float = np.inf
    windup: float | None = None
    torque_forward: bool = False

    @property
    def is_limited(self) -> bool:
        """Whether it has limits, which linear figures leave out."""
        return min(self.torque_limit, self.voltage_limit) < np.inf

    def with_gains(self, **gains: float) -> Cascade:
        """Return the cascade with other gains."""
        changes: dict[str, Any] = {**gains}
        return replace(self, **changes)

    @property
    def current(self) -> CurrentLoop | None:
        """Its current loop, the last of its path; None where that is a lag."""
        last = self.path[-1] if self.path else None
        return last if isinstance(last, CurrentLoop) else None

    @property
    def idle(self) -> Cascade | None:
        """What is left of it while no torque is wanted: its current loop, which the back-EMF drives."""
        one = self.current
        return Cascade(self.motor, 0.0, 0.0, np.inf, (one,), 0.0) if one else None

    def path_at(self, s: ComplexArray) -> ComplexArray:
        """Return P(s)."""
        found = np.ones_like(s)
        for one in self.path:
            found = found * one.at(s)
        return found

    def integral(self, s: ComplexArray) -> ComplexArray:
        """Return 1 + 1/(Tn s)."""
        return 1 + (1 / self.Tn) / s

    def controller(self, s: ComplexArray) -> ComplexArray:
        """Return C(s), from an error of velocity to torque."""
        return self.Kp * self.integral(s) * self.path_at(s)

    def forward(self, s: ComplexArray) -> ComplexArray:
        """Return what a position that is set does to the torque: F (C (Kv + kfv s) + kfa P s^2), F its filter."""
        shares = self.controller(s) * (self.Kv + self.velocity_forward * s)
        found = shares + self.acceleration_forward * self.path_at(s) * s * s
        return found * self.set_point.at(s) if self.set_point else found

    @property
    def set_point_delay(self) -> float:
        """By how much the filter of the set point is behind at a steady velocity, s: -F'(0)."""
        if isinstance(self.set_point, Biquad):
            return 2 * self.set_point.below * self.set_point.time
        return self.set_point.time if self.set_point else 0.0


def cascade_of(joint: Joint, drive: Drive, values: Mapping[str, float], source: str) -> Cascade:
    """Return the drive of a joint with values of its formulas; raises `InputError` for numbers that no drive has."""
    motor = joint.name
    key, what = fault_of(drive, joint)
    if key:
        raise InputError(source, f"drives, {motor}, {key}", what)
    numbers = {key: _value(motor, key, formula.value, values, source) for key, formula in drive.formulas}
    sought = tuple(key for key in ("Kp", "Tn", "Kv") if getattr(drive, key) is TUNED)
    gains = {key: numbers.get(key, np.nan) for key in ("Kv", "Kp", "Tn")}
    if drive.Tn is None:
        gains["Tn"] = np.inf
    shares = (numbers["feed_forward, velocity"], numbers["feed_forward, acceleration"])
    Kt = _torque_constant(joint, drive, values)
    path = (*_path(drive, numbers), *_current(joint, drive, numbers, values, source))
    return Cascade(
        *(motor, gains["Kv"], gains["Kp"], gains["Tn"], path, *shares, sought),
        set_point=_set_point(motor, drive, numbers, source),
        torque_limit=min(numbers.get("limits, torque", np.inf), Kt * numbers.get("limits, current", np.inf)),
        voltage_limit=Kt * numbers.get("limits, voltage", np.inf),
        windup=numbers.get("limits, windup"),
        torque_forward=drive.torque_forward,
    )


def _value(
    motor: str, key: str, value_of: Callable[[Mapping[str, float]], float], values: Mapping[str, float], source: str
) -> float:
    try:
        x = float(value_of(values))
        reason = why_wrong(key, x)
    except FormulaError as error:
        reason = str(error)
    if reason:
        raise InputError(source, f"drives, {motor}, {key}", reason)
    return x


def _path(drive: Drive, numbers: Mapping[str, float]) -> Iterator[Element]:
    """Yield the elements of the torque's path that do something."""
    period = numbers.get("period", 0.0)
    if dead := numbers.get("dead_time", period):
        yield DeadTime("dead time", dead)
    if period:
        yield Hold("period", period)
    if numbers["current, lag"]:
        yield FirstOrder(CURRENT, numbers["current, lag"])
    for k, one in enumerate(drive.filters, start=1):
        yield _filter(one, f"filter {k}", numbers)


def _current(
    joint: Joint, drive: Drive, numbers: Mapping[str, float], values: Mapping[str, float], source: str
) -> Iterator[CurrentLoop]:
    """Yield the loop of a current controller; constants of the rotor's own axis count with the ratio."""
    if drive.current is None:
        return
    winding = {key: getattr(joint.electrics, key).value(values) for key in NEEDED}
    for key, x in winding.items():
        if not x > 0:
            raise InputError(source, f"motors, {joint.name}, {key}", f"{x:g} is not above zero")
    constants = joint.reflected_electrics
    Kt = constants.torque_constant.value(values)
    Ke = constants.back_emf.value(values) or Kt
    share, R, L = numbers["current, compensation"], winding["resistance"], winding["inductance"]
    numbered = (numbers["current, kp"], numbers["current, ti"], R, L, Kt * Ke * (1 - share))
    yield CurrentLoop(*numbered, compensated=Kt * Ke * share)


def _torque_constant(joint: Joint, drive: Drive, values: Mapping[str, float]) -> float:
    """Return the amount of Kt of the joint's own axis, 1 without a controller of the current."""
    return abs(joint.reflected_electrics.torque_constant.value(values)) if drive.current else 1.0


def _filter(one: Filter, place: str, numbers: Mapping[str, float]) -> Biquad | FirstOrder:
    f = numbers[f"{place}, frequency"]
    if isinstance(one, Notch):
        return Biquad(f"notch at {f:g} Hz", f, numbers[f"{place}, depth"], numbers[f"{place}, width"])
    name = f"low-pass filter at {f:g} Hz"
    return FirstOrder(name, 1 / (2 * np.pi * f)) if one.order == 1 else Biquad(name, f, 0.0, ROOT_2 / 2, low=True)


def _set_point(motor: str, drive: Drive, numbers: Mapping[str, float], source: str) -> SetPointElement | None:
    """Return the filter of the set point; raises `InputError` for a mean that is of no whole number of samples."""
    if drive.set_point is None:
        return None
    if isinstance(drive.set_point, LowPass):
        return _filter(drive.set_point, "set_point", numbers)
    time, period = numbers["set_point, average"], numbers["period"]
    samples, wrong = samples_of_mean(time, period)
    if wrong:
        raise InputError(source, f"drives, {motor}, set_point, average", wrong)
    return Mean(f"mean of {samples} samples", samples, period)


# As linear systems


@dataclass(frozen=True)
class System:
    """x' = A x + B u, y = C x + D u, of one input and one output."""

    A: Array
    B: Array
    C: Array
    D: float

    @classmethod
    def gain(cls, D: float) -> System:
        """Return a system without states."""
        return cls(np.zeros((0, 0)), np.zeros(0), np.zeros(0), D)

    def then(self, other: System) -> System:
        """Return the system whose output is that of `other` to its own."""
        n, m = len(self.B), len(other.B)
        A = np.block([[self.A, np.zeros((n, m))], [np.outer(other.B, self.C), other.A]])
        B = np.concatenate([self.B, other.B * self.D])
        return System(A, B, np.concatenate([other.D * self.C, other.C]), self.D * other.D)


def system_of(path: tuple[Element, ...], parts: int = 1) -> System:
    """Return P as a linear system: dead times and holds by approximations of Pade of order 2 of `parts` of their sum.

    A hold counts half of its period.
    """
    delay = sum(one.time for one in path if isinstance(one, DeadTime))
    delay += sum(one.time / 2 for one in path if isinstance(one, Hold))
    found = System.gain(1.0)
    for _ in range(parts if delay else 0):
        found = found.then(_pade(delay / parts))
    for one in path:
        if isinstance(one, FirstOrder):
            found = found.then(first_order_system(one))
        elif isinstance(one, Biquad):
            found = found.then(biquad_system(one))
        elif isinstance(one, CurrentLoop):
            found = found.then(current_system(one))
    return found


def _pade(delay: float) -> System:
    """(1 - d s/2 + (d s)^2/12)/(1 + d s/2 + (d s)^2/12), with states scaled by the delay."""
    a, b = 12 / delay, 6 / delay
    A = np.array([[0.0, a], [-1 / delay, -b]])
    return System(A, np.array([0.0, 1 / delay]), np.array([0.0, -12.0]), 1.0)


def first_order_system(one: FirstOrder) -> System:
    """Return a lag as a linear system."""
    rate = 1 / one.time
    return System(np.array([[-rate]]), np.array([rate]), np.array([1.0]), 0.0)


def current_system(one: CurrentLoop) -> System:
    """Return a current loop as a linear system: the torque, and the integral part over kp, as a torque."""
    rate = one.kp / one.inductance
    A = np.array([[-(one.kp + one.resistance) / one.inductance, rate], [-1 / one.ti, 0.0]])
    return System(A, np.array([rate, 1 / one.ti]), np.array([1.0, 0.0]), 0.0)


def biquad_system(one: Biquad) -> System:
    """Return a filter of order 2 as a linear system, with states scaled by its frequency."""
    w = one.w
    A = np.array([[0.0, w], [-w, -2 * one.below * w]])
    if one.low:
        return System(A, np.array([0.0, w]), np.array([1.0, 0.0]), 0.0)
    return System(A, np.array([0.0, w]), np.array([0.0, 2 * (one.above - one.below)]), 1.0)
