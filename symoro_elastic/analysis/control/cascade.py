"""The cascade of a drive with numbers: its frequency response, and the drive as a linear system.

    tau = C(s) (Kv (r - q_m) + kfv s r - s qd...),   C(s) = Kp (1 + 1/(Tn s)) P(s)
    P(s) = e^(-s Td) (1 - e^(-s T))/(s T) / (1 + lag s) prod filters(s)

P is the path of the torque: dead time, the hold of a sampled controller, current loop, filters. r is the set point
behind its filter. The limit of the torque is separate: linear results neglect it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.drives import NEEDED, TUNED, Drive, Filter, LowPass, Notch, fault_of, why_wrong
from symoro_elastic.machine.formula import STEP, Formula, FormulaError
from symoro_elastic.machine.joints import Joint
from symoro_elastic.models.drives.control import samples_of_mean

ROOT_2 = 2**0.5
CURRENT = "lag of the current loop"


def is_gain(name: str) -> bool:
    """Return whether a name of `Cascade.slopes`, with or without its motor, is that of a gain."""
    return name.rpartition(", ")[2] in GAINS


def laplace(frequencies: Array | ComplexArray) -> ComplexArray:
    """Return s = 2 pi i f."""
    return (2j * np.pi * frequencies).astype(complex)


@dataclass(frozen=True)
class Biquad:
    """Filter (s^2 + 2 a w s + w^2)/(s^2 + 2 b w s + w^2), if `low` without s^2 and a s in the numerator; w = 2 pi f."""

    name: str
    frequency: float
    above: float
    below: float
    low: bool = False

    @property
    def time(self) -> float:
        """Time constant 1/w, s."""
        return 1 / self.w

    @property
    def w(self) -> float:
        """The angular frequency, rad/s."""
        return 2 * np.pi * self.frequency

    def at(self, s: ComplexArray) -> ComplexArray:
        """Return the frequency response at s."""
        return self._above(s) / self._below(s)

    @property
    def labels(self) -> dict[str, str]:
        """Names of the filter's numbers, by field."""
        widths = {} if self.low else {"above": f"depth of the {self.name}", "below": f"width of the {self.name}"}
        return {"frequency": self.name, **widths}

    def _above(self, s: ComplexArray) -> ComplexArray:
        if self.low:
            return np.full_like(s, self.w**2)
        return s * s + 2 * self.above * self.w * s + self.w**2

    def _below(self, s: ComplexArray) -> ComplexArray:
        return s * s + 2 * self.below * self.w * s + self.w**2


@dataclass(frozen=True)
class Timed:
    """An element with one number, its `time`, s."""

    name: str
    time: float

    @property
    def labels(self) -> dict[str, str]:
        """Name of the element's time, by field."""
        return {"time": self.name}


class FirstOrder(Timed):
    """1/(1 + T s): a lag, or a low-pass filter of order 1."""

    def at(self, s: ComplexArray) -> ComplexArray:
        """Return the frequency response at s."""
        return 1 / (1 + self.time * s)


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
        """Delay of the torque at low frequencies, s: -H'(0) = R ti/kp."""
        return self.resistance * self.ti / self.kp

    def at(self, s: ComplexArray) -> ComplexArray:
        """Return the frequency response H at s."""
        return self.kp * (self.ti * s + 1) / self._below(s)

    def drag_response(self, s: ComplexArray) -> ComplexArray:
        """Return Y, the frequency response from velocity to the braking torque of the back-EMF."""
        return self.drag * self.ti * s / self._below(s)

    @property
    def labels(self) -> dict[str, str]:
        """Names of its numbers, by field."""
        of_loop = {key: f"{key} of the current loop" for key in ("kp", "ti")}
        return {**of_loop, "resistance": "resistance", "inductance": "inductance", "drag": "back_emf"}

    def _below(self, s: ComplexArray) -> ComplexArray:
        return (self.inductance * s + self.resistance + self.kp) * self.ti * s + self.kp


class DeadTime(Timed):
    """Dead time, e^(-s Td)."""

    def at(self, s: ComplexArray) -> ComplexArray:
        """Return the frequency response at s."""
        return np.exp(-s * self.time)


class Hold(Timed):
    """Zero-order hold of the torque over a period T, (1 - e^(-s T))/(s T)."""

    def at(self, s: ComplexArray) -> ComplexArray:
        """Return the frequency response at s."""
        turned = s * self.time
        small = np.abs(turned) < 1e-6
        exact = -np.expm1(-turned) / np.where(small, 1, turned)
        return np.where(small, 1 - turned / 2, exact)


@dataclass(frozen=True)
class Mean:
    """The mean of `samples` at intervals of a `period`, s: (1 + e^(-s T) + ...)/samples."""

    name: str
    samples: int
    period: float

    @property
    def time(self) -> float:
        """Delay of the mean, s."""
        return (self.samples - 1) * self.period / 2

    def at(self, s: ComplexArray) -> ComplexArray:
        """Return the frequency response at s."""
        return np.asarray(np.exp(-np.multiply.outer(s, self.period * np.arange(self.samples))).mean(axis=-1))


Element = Biquad | FirstOrder | CurrentLoop | DeadTime | Hold
Number = tuple[int, str]
"""A number of a cascade: which element of its path, GAIN for a gain, and the field."""
GAIN, GAINS = -1, ("Kp", "Tn", "Kv")
ELECTRIC = ("torque_constant", "back_emf", "current.compensation")
"""Numbers of a winding that make its drag together."""
TURNS = np.array([1, 1j, -1, -1j])
RADIUS = 1e-4
"""Of a number: of the circle whose mean is a derivative, to the fourth power of it."""
SetPointElement = Biquad | FirstOrder | Mean


@dataclass(frozen=True)
class Cascade:
    """A drive with numbers: `Kp` in N m s/rad or N s/m, `Kv` in 1/s, `Tn` in s, infinite without integral part.

    A gain to be tuned is NaN. `path` are the elements between velocity controller and torque; `velocity_forward` is
    a share, `acceleration_forward` an inertia. `set_point` filters the set point. `torque_limit` N m or N, that of the
    current among it, and `voltage_limit`, V times Kt of the joint's axis, are infinite where there is none; `windup` is
    Tt in s, Tn where it is None. `by_parameter` are p dx/dp of its numbers x by the name p of a parameter of the file.
    """

    motor: str
    Kv: float
    Kp: float
    Tn: float
    path: tuple[Element, ...]
    velocity_forward: float = 1.0
    acceleration_forward: float = 0.0
    tuned_gains: tuple[str, ...] = ()
    set_point: SetPointElement | None = None
    torque_limit: float = np.inf
    voltage_limit: float = np.inf
    windup: float | None = None
    torque_forward: bool = False
    by_parameter: Mapping[str, Mapping[Number, float]] = field(default_factory=dict)

    @property
    def is_limited(self) -> bool:
        """Whether the drive has limits, which linear results leave out."""
        return min(self.torque_limit, self.voltage_limit) < np.inf

    def with_gains(self, **gains: float) -> Cascade:
        """Return the cascade with these gains in place of its own; they do not depend on parameters."""
        changes: dict[str, Any] = {**gains}
        replaced = {(GAIN, key) for key in gains}
        by_parameter = {p: {x: y for x, y in by.items() if x not in replaced} for p, by in self.by_parameter.items()}
        return replace(self, **changes, by_parameter=by_parameter)

    @property
    def current(self) -> CurrentLoop | None:
        """Current loop of the drive, the last element of its torque path; None where a lag replaces it."""
        last = self.path[-1] if self.path else None
        return last if isinstance(last, CurrentLoop) else None

    @property
    def idle(self) -> Cascade | None:
        """The drive while no torque is required: its current loop alone, which the back-EMF drives."""
        last = len(self.path) - 1
        by = {p: {(0, key): y for (k, key), y in of.items() if k == last} for p, of in self.by_parameter.items()}
        return Cascade(self.motor, 0.0, 0.0, np.inf, self.path[-1:], 0.0, by_parameter=by) if self.current else None

    def path_at(self, s: ComplexArray) -> ComplexArray:
        """Return P(s), the response of the torque path."""
        response = np.ones_like(s)
        for element in self.path:
            response = response * element.at(s)
        return response

    def integral(self, s: ComplexArray) -> ComplexArray:
        """Return the integral part 1 + 1/(Tn s) of the controller."""
        return 1 + (1 / self.Tn) / s

    def controller(self, s: ComplexArray) -> ComplexArray:
        """Return C(s), from an error of velocity to torque."""
        return self.Kp * self.integral(s) * self.path_at(s)

    def forward(self, s: ComplexArray) -> ComplexArray:
        """Return the torque per set point of position: F (C (Kv + kfv s) + kfa P s^2) with its filter F."""
        shares = self.controller(s) * (self.Kv + self.velocity_forward * s)
        torque = shares + self.acceleration_forward * self.path_at(s) * s * s
        return torque * self.set_point.at(s) if self.set_point else torque

    def feedback(self, s: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return the torque per controlled position, Kv C, and per position of the motor, s (C + Y)."""
        C = self.controller(s)
        return self.Kv * C, s * (C + self.current.drag_response(s) if self.current else C)

    @property
    def _numbers(self) -> dict[Number, float]:
        """Finite numbers of the drive, by element and field."""
        gains = {(GAIN, key): getattr(self, key) for key in GAINS if np.isfinite(getattr(self, key))}
        return gains | {(k, key): getattr(part, key) for k, part in enumerate(self.path) for key in part.labels}

    @property
    def names(self) -> dict[str, str]:
        """Labels in `slopes` of the parameters of the file, by the parameter's name.

        A number of the drive, motor.place, has the name of the last number that it makes.
        """
        labels = [*map(self._label, self._numbers)]
        names = {}
        for parameter, by in self.by_parameter.items():
            motor, _, place = parameter.partition(".")
            label = self._label([*by][-1]) if by else parameter
            is_place = place in ELECTRIC or labels.count(label) > 1
            names[parameter] = parameter if not place else f"{motor}, {place}" if is_place else label
        return names

    @property
    def repeated_names(self) -> set[str]:
        """Labels in `slopes` of drive numbers set by a parameter of the file, under whose label they already appear."""
        labels = {self._label(number) for by in self.by_parameter.values() for number in by}
        return labels - {*self.names.values()}

    def slopes(self, of: Callable[[Cascade], ComplexArray]) -> dict[str, ComplexArray]:
        """Return p d of/dp of an analytic function `of` of the drive's numbers, by name p.

        Parameters of the file have their names, and all that they change; numbers are named as in "motor, dead time".
        """
        numbers, names = self._numbers, self.names
        by_name = [(names[p], by) for p, by in self.by_parameter.items()]
        parameters, labels = set(names.values()), {number: self._label(number) for number in numbers}
        by_name += [(labels[number], {number: x}) for number, x in numbers.items() if labels[number] not in parameters]
        slopes = {number: self._slope(of, number, x) for number, x in numbers.items()}
        totals: dict[str, ComplexArray] = {}
        for name, by in by_name:
            for number, x in by.items():
                totals[name] = totals.get(name, np.zeros_like(slopes[number])) + x * slopes[number]
        return totals

    def _slope(self, of: Callable[[Cascade], ComplexArray], number: Number, x: float) -> ComplexArray:
        """Return the derivative by one number: the mean over a small circle (Cauchy)."""
        radius = RADIUS * (abs(x) or 1.0)
        values = [of(self._with(number, x + radius * turn)) / (radius * turn) for turn in TURNS]
        return np.asarray(np.mean(values, axis=0), dtype=complex)

    def _with(self, number: Number, x: complex) -> Cascade:
        k, key = number
        changed: dict[str, Any] = {key: x}
        if k == GAIN:
            return replace(self, **changed)
        return replace(self, path=(*self.path[:k], replace(self.path[k], **changed), *self.path[k + 1 :]))

    def _label(self, number: Number) -> str:
        k, key = number
        return f"{self.motor}, {key if k == GAIN else self.path[k].labels[key]}"

    @property
    def set_point_delay(self) -> float:
        """Delay of the set point's filter at a constant velocity, s: -F'(0)."""
        if isinstance(self.set_point, Biquad):
            return 2 * self.set_point.below * self.set_point.time
        return self.set_point.time if self.set_point else 0.0


def cascade_of(joint: Joint, drive: Drive, values: Mapping[str, float], source: str) -> Cascade:
    """Return the drive of a joint with values of its formulas; raises `InputError` for impossible numbers."""
    motor = joint.name
    key, what = fault_of(drive, joint)
    if key:
        raise InputError(source, f"drives, {motor}, {key}", what)
    formulas = dict(drive.formulas)
    numbers = {key: _value(motor, key, formula.value, values, source) for key, formula in formulas.items()}
    if drive.current:
        electrics = joint.reflected_electrics
        formulas |= {key: getattr(electrics, key) for key in (*NEEDED, "back_emf")}
        numbers |= {key: formulas[key].value(values) for key in (*NEEDED, "back_emf")}
        for key in NEEDED:
            if not (x := getattr(joint.electrics, key).value(values)) > 0:
                raise InputError(source, f"motors, {motor}, {key}", f"{x:g} is not above zero")
    tuned_gains = tuple(key for key in GAINS if getattr(drive, key) is TUNED)
    gains = {key: numbers.get(key, np.nan) for key in GAINS}
    if drive.Tn is None:
        gains["Tn"] = np.inf
    Kt = abs(numbers.get("torque_constant", 1.0))
    return Cascade(
        *(motor, gains["Kv"], gains["Kp"], gains["Tn"], tuple(_path(drive, numbers))),
        *(numbers["feed_forward, velocity"], numbers["feed_forward, acceleration"], tuned_gains),
        set_point=_set_point(motor, drive, numbers, source),
        torque_limit=min(numbers.get("limits, torque", np.inf), Kt * numbers.get("limits, current", np.inf)),
        voltage_limit=Kt * numbers.get("limits, voltage", np.inf),
        windup=numbers.get("limits, windup"),
        torque_forward=drive.torque_forward,
        by_parameter=_by_parameter(drive, formulas, values),
    )


def _by_parameter(
    drive: Drive, formulas: Mapping[str, Formula], values: Mapping[str, float]
) -> dict[str, dict[Number, float]]:
    """Return p dx/dp of the numbers x of a cascade by the names p in formulas of a drive and its winding."""
    slopes: dict[str, dict[Number, float]] = {}
    for name in sorted({name for formula in formulas.values() for name in formula.names}):
        numbers: dict[str, Any] = {key: x.with_slope(values, name) for key, x in formulas.items()}
        moved = {(GAIN, key): numbers[key] for key in GAINS if key in numbers}
        moved |= {(k, key): getattr(part, key) for k, part in enumerate(_path(drive, numbers)) for key in part.labels}
        slopes[name] = {number: values[name] * x.imag / STEP for number, x in moved.items() if x.imag}
    return slopes


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
    """Yield the elements of the torque's path, without those of no effect (by real parts of numbers)."""
    period = numbers.get("period", 0.0)
    if (dead := numbers.get("dead_time", period)).real:
        yield DeadTime("dead time", dead)
    if period.real:
        yield Hold("period", period)
    if numbers["current, lag"].real:
        yield FirstOrder(CURRENT, numbers["current, lag"])
    for k, stage in enumerate(drive.filters, start=1):
        yield _filter(stage, f"filter {k}", numbers)
    if drive.current:  # constants of the rotor's own axis count with the ratio
        Kt, share = numbers["torque_constant"], numbers["current, compensation"]
        both = Kt * (numbers["back_emf"] if numbers["back_emf"].real else Kt)
        loop = (numbers["current, kp"], numbers["current, ti"], numbers["resistance"], numbers["inductance"])
        yield CurrentLoop(*loop, both * (1 - share), compensated=both * share)


def _filter(stage: Filter, place: str, numbers: Mapping[str, float]) -> Biquad | FirstOrder:
    f = numbers[f"{place}, frequency"]
    if isinstance(stage, Notch):
        return Biquad(f"notch at {f.real:g} Hz", f, numbers[f"{place}, depth"], numbers[f"{place}, width"])
    name = f"low-pass filter at {f.real:g} Hz"
    return FirstOrder(name, 1 / (2 * np.pi * f)) if stage.order == 1 else Biquad(name, f, 0.0, ROOT_2 / 2, low=True)


def _set_point(motor: str, drive: Drive, numbers: Mapping[str, float], source: str) -> SetPointElement | None:
    """Return the filter of the set point; raises `InputError` for a mean over a fractional number of samples."""
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
        """Return the series connection: `other` acts on the output of this system."""
        n, m = len(self.B), len(other.B)
        A = np.block([[self.A, np.zeros((n, m))], [np.outer(other.B, self.C), other.A]])
        B = np.concatenate([self.B, other.B * self.D])
        return System(A, B, np.concatenate([other.D * self.C, other.C]), self.D * other.D)


def system_of(path: tuple[Element, ...], parts: int = 1) -> System:
    """Return P as a linear system: dead times and holds by approximations of Pade of order 2 of `parts` of their sum.

    A hold counts half of its period.
    """
    delay = sum(element.time for element in path if isinstance(element, DeadTime))
    delay += sum(element.time / 2 for element in path if isinstance(element, Hold))
    system = System.gain(1.0)
    for _ in range(parts if delay else 0):
        system = system.then(_pade(delay / parts))
    for element in path:
        if isinstance(element, FirstOrder):
            system = system.then(first_order_system(element))
        elif isinstance(element, Biquad):
            system = system.then(biquad_system(element))
        elif isinstance(element, CurrentLoop):
            system = system.then(current_system(element))
    return system


def _pade(delay: float) -> System:
    """(1 - d s/2 + (d s)^2/12)/(1 + d s/2 + (d s)^2/12), with states scaled by the delay."""
    a, b = 12 / delay, 6 / delay
    A = np.array([[0.0, a], [-1 / delay, -b]])
    return System(A, np.array([0.0, 1 / delay]), np.array([0.0, -12.0]), 1.0)


def omitted_limits(cascades: Iterable[Cascade]) -> list[str]:
    """Return a line about limits of drives, which linear results omit; none without limits."""
    limited = [drive for drive in cascades if drive.is_limited]
    what = "torque, current and voltage" if any(drive.current for drive in limited) else "torque"
    motors = ", ".join(drive.motor for drive in limited)
    return [f"limits of {what} ({motors}) are omitted: these results are linear"] if limited else []


def first_order_system(lag: FirstOrder) -> System:
    """Return a lag as a linear system."""
    rate = 1 / lag.time
    return System(np.array([[-rate]]), np.array([rate]), np.array([1.0]), 0.0)


def current_system(loop: CurrentLoop) -> System:
    """Return a current loop as a linear system: the torque, and the integral part over kp, as a torque."""
    rate = loop.kp / loop.inductance
    A = np.array([[-(loop.kp + loop.resistance) / loop.inductance, rate], [-1 / loop.ti, 0.0]])
    return System(A, np.array([rate, 1 / loop.ti]), np.array([1.0, 0.0]), 0.0)


def biquad_system(element: Biquad) -> System:
    """Return a filter of order 2 as a linear system, with states scaled by its frequency."""
    w = element.w
    A = np.array([[0.0, w], [-w, -2 * element.below * w]])
    if element.low:
        return System(A, np.array([0.0, w]), np.array([1.0, 0.0]), 0.0)
    return System(A, np.array([0.0, w]), np.array([0.0, 2 * (element.above - element.below)]), 1.0)
