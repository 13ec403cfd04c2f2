"""The sampled controllers of a machine's drives as programs: what a controller computes once in each period.

    e     = Kv (rf - q) + kfv rfd - v                 position controller; rf, rfd, rfdd behind the set-point filter
    xi    = xi + T e                                  integral part, by backward Euler
    tau_u = Kp (e + xi/Tn) + kfa rfdd + tau                                                                 (D6)
    u     = sat(filters(tau_u))                       held over the next period
    xi   += T (u - filters(tau_u)) Tn/(Kp Tt)         back-calculation, zero within the limit

Filters are those of Tustin's rule, s = w (z - 1)/(k (z + 1)) with k = tan(w T/2), right at their own frequency w. They
keep two states in the transposed direct form,

    y = b0 x + z1,    z1 = b1 x - a1 y + z2,    z2 = b2 x - a2 y.

Current loops and dead times belong to the machine.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.described import drives_of
from symoro_elastic.machine.drives import NO_NUMBER, TUNED, Average, Drive, Filter, LowPass, Notch, why_wrong
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Parts
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Joints, Model, Result, Results
from symoro_elastic.symbolic.functions import amount, clamp, cosine_sine, square_root
from symoro_elastic.symbolic.program import Section

CONTROL, START = "control", "control_start"
WHOLE = 1e-6
"""Relative deviation of a time from an integer number of periods that counts as rounding."""
MOST_SAMPLES = 4096
"""Maximum number of samples of a mean, which are states of the controller."""


def sampled_drives(machine: Machine) -> dict[int, Drive]:
    """Return the drives of all motors, by joint; raises `InputError` unless all have gains and one period."""
    configured, drives = drives_of(machine).by_motor, {}
    for j in machine.motors:
        name = machine.joint(j).name
        if name not in configured:
            raise machine.error(f"drives, {name}", "is missing: controllers are written of all motors together")
        drive = configured[name]
        if missing := [key for key in ("Kp", "Tn", "Kv") if getattr(drive, key) is TUNED]:
            raise machine.error(f"drives, {name}, {', '.join(missing)}", f"is {NO_NUMBER}")
        if drive.period is None:
            what = "is missing: a controller is code that is called once in each period, as 1e-3"
            raise machine.error(f"drives, {name}, period", what)
        drives[j] = drive
    machine.refuse_without_motors("drives")
    periods = {machine.joint(j).name: _numbers(machine, j, drive)["period"] for j, drive in drives.items()}
    common_period(periods, machine.label)
    return drives


def common_period(periods: Mapping[str, float], source: str) -> float:
    """Return the period of sampled drives, s, from those by motor; raises `InputError` for different ones."""
    if len({*periods.values()}) > 1:
        shown = ", ".join(f"{name} {period:g} s" for name, period in periods.items())
        raise InputError(source, "drives, period", f"{shown}: sampled drives have one period")
    return next(iter(periods.values()), 0.0)


def samples_of_mean(time: float, period: float) -> tuple[int, str]:
    """Return the number of samples of a moving average over a time, s, and an error message, empty for a valid time."""
    if time > MOST_SAMPLES * period * (1 + WHOLE):
        return 0, f"{time:g} s are more than {MOST_SAMPLES} periods of {period:g} s: give less, or use lowpass"
    samples = max(round(time / period), 1)
    if abs(samples * period - time) > WHOLE * time:
        return 0, f"{time:g} s is no whole number of periods of {period:g} s: give {samples * period:g}"
    return samples, ""


def _numbers(machine: Machine, j: int, drive: Drive) -> dict[str, float]:
    """Return the numbers of a drive by their keys, for the values of parameters in the file; raises `InputError`."""
    numbers = {}
    for key, formula in drive.formulas:
        try:
            numbers[key] = float(formula.value(machine.given_values))
            reason = why_wrong(key, numbers[key])
        except FormulaError as error:
            reason = str(error)
        if reason:
            raise machine.error(f"drives, {machine.joint(j).name}, {key}", reason)
    half = 1 / (2 * numbers["period"])
    for key, f in numbers.items():
        if key.endswith("frequency") and f >= half:
            what = f"{f:g} Hz is not below half the sampling rate, {half:g} Hz: give a lower one"
            raise machine.error(f"drives, {machine.joint(j).name}, {key}", what)
    if numbers.get("limits, windup", numbers["period"]) < numbers["period"]:
        what = f"{numbers['limits, windup']:g} s is below the period, {numbers['period']:g} s: give more"
        raise machine.error(f"drives, {machine.joint(j).name}, limits, windup", what)
    return numbers


@dataclass
class _Memory:
    """The states of the controller of joint j: names, labels, values after one period, values at rest."""

    bound: Bound
    j: int
    names: list[str] = field(default_factory=list)
    labels: list[str] = field(default_factory=list)
    later: list[Scalar] = field(default_factory=list)
    at_rest: list[Scalar] = field(default_factory=list)

    def state(self, label: str, at_rest: Scalar) -> Scalar:
        """Return a new state; the caller appends its value a period later to `later`, in the same order."""
        self.names.append(f"zc{self.j}_{len(self.names) + 1}")
        self.labels.append(f"{self.bound.machine.joint(self.j).name}.{label}")
        self.at_rest.append(at_rest)
        return self.bound.graph.symbol(self.names[-1])


@dataclass(frozen=True)
class _Coefficients:
    """Coefficients of a sampled filter y = b0 x + b1 x_1 + b2 x_2 - a1 y_1 - a2 y_2; order 1 has no b2 and a2."""

    b: tuple[Scalar, ...]
    a: tuple[Scalar, ...]

    def of(self, memory: _Memory, label: str, x: Scalar, at_rest: Scalar) -> Scalar:
        """Return y, and add the states of the filter; `at_rest` is the constant value of x and y at rest."""
        states: list[Scalar] = []
        for k in range(len(self.a)):
            above = sum((self.b[i + 1] - self.a[i] for i in range(k, len(self.a))), start=0 * at_rest)
            states.append(memory.state(f"{label}_{k + 1}", above * at_rest))
        y = self.b[0] * x + states[0]
        next_states = [*states[1:], 0]
        memory.later += [b * x - a * y + z for b, a, z in zip(self.b[1:], self.a, next_states, strict=True)]
        return y


def _coefficients(bound: Bound, section: Filter, period: Scalar) -> _Coefficients:
    """Return a filter by Tustin's rule with k = tan(pi f T)."""
    cosine, sine = cosine_sine(bound.graph, bound.graph.pi * (bound.cell(section.frequency) * period))
    k: Scalar = (Fraction(sine) if isinstance(sine, int) else sine) / cosine
    if isinstance(section, LowPass) and section.order == 1:
        b, a = k / (1 + k), (k - 1) / (1 + k)
        return _Coefficients((b, b), (a,))
    zeros: Scalar = 2 * bound.cell(section.depth) if isinstance(section, Notch) else 0  # twice the damping ratio
    poles: Scalar = 2 * bound.cell(section.width) if isinstance(section, Notch) else square_root(bound.graph, 2)
    below = 1 + poles * k + k * k
    a1, a2 = 2 * (k * k - 1) / below, (1 - poles * k + k * k) / below
    if isinstance(section, LowPass):
        b = k * k / below
        return _Coefficients((b, 2 * b, b), (a1, a2))
    return _Coefficients(((1 + zeros * k + k * k) / below, a1, (1 - zeros * k + k * k) / below), (a1, a2))


@dataclass(frozen=True)
class _Controller:
    """The controller of a motor: its set point of torque, and its states."""

    u: Scalar
    memory: _Memory


class _Law:
    """The equations of the controller of joint j."""

    def __init__(self, bound: Bound, j: int, drive: Drive, signals: Mapping[str, Scalar]) -> None:
        self.bound, self.j, self.drive, self.given = bound, j, drive, signals
        self.Kv, self.Kp, self.Tn = (
            bound.cell(x) if isinstance(x, Formula) else 1 for x in (drive.Kv, drive.Kp, drive.Tn)
        )
        self.numbers = _numbers(bound.machine, j, drive)
        self.memory = _Memory(bound, j)
        assert drive.period is not None
        self.period = bound.cell(drive.period)

    def controller(self) -> _Controller:
        """Return the set point of the torque, and the states of the controller."""
        bound, drive, signals = self.bound, self.drive, self.given
        rf, rfd, rfdd = self._set_points()
        e = self._give_name(self.Kv * (rf - signals["measured"]) + rfd - signals["speed"], "ev")
        integral = None if drive.Tn is None else self.memory.state("integral", 0)
        where = len(self.memory.later)
        xi = 0 if integral is None else self._give_name(integral + self.period * e, "xi")
        tau_u = self._give_name(self.Kp * (e + xi / self.Tn) + rfdd + signals["tau"], "tauu")
        tau_f = self._filter_torque(tau_u)
        u, limits = tau_f, self._limits()
        for limit in limits:
            u = clamp(bound.graph, u, -limit, limit)
        if limits:
            u = self._give_name(u, "taul")
        if integral is not None:
            if limits:
                Tt = self.Tn if drive.windup is None else bound.cell(drive.windup)
                xi = xi + (u - tau_f) * (self.period * self.Tn / (self.Kp * Tt))
            self.memory.later.insert(where, xi)
        return _Controller(u, self.memory)

    def _limits(self) -> list[Scalar]:
        """Return the limits of the torque: the torque limit, and the current limit times Kt of the joint's axis."""
        bound, drive = self.bound, self.drive
        limits = [] if drive.torque_limit is None else [bound.cell(drive.torque_limit)]
        if drive.current_limit is not None:
            constant = bound.cell(bound.machine.joint(self.j).reflected_electrics.torque_constant)
            limits.append(amount(bound.graph, constant) * bound.cell(drive.current_limit))
        return limits

    def _set_points(self) -> tuple[Scalar, Scalar, Scalar]:
        """Return the filtered set points rf, kfv rfd and kfa rfdd; those with zero gain are zero."""
        bound, drive = self.bound, self.drive
        shares = (1, bound.cell(drive.velocity_forward), bound.cell(drive.acceleration_forward))
        set_points: list[Scalar] = []
        for name, share in zip(("r", "rd", "rdd"), shares, strict=True):
            x = self.given[name]
            if isinstance(drive.set_point, Average):
                x = self._mean(name, x) if share != 0 else x
            elif drive.set_point and share != 0:
                x = _coefficients(bound, drive.set_point, self.period).of(self.memory, name, x, x)
            set_points.append(share * x)
        return set_points[0], set_points[1], set_points[2]

    def _mean(self, name: str, x: Scalar) -> Scalar:
        """Return the moving average of x, whose past samples are states."""
        time, period = self.numbers["set_point, average"], self.numbers["period"]
        samples, wrong = samples_of_mean(time, period)
        if wrong:
            place = f"drives, {self.bound.machine.joint(self.j).name}, set_point, average"
            raise self.bound.machine.error(place, wrong)
        past = [self.memory.state(f"{name}_{k}", x) for k in range(1, samples)]
        self.memory.later += [x, *past[:-1]] if past else []
        return sum(past, start=x) * Fraction(1, samples)

    def _filter_torque(self, tau_u: Scalar) -> Scalar:
        """Return the filtered torque; at rest it is the feed-forward torque."""
        at_rest = self.given["tau"] + self.bound.cell(self.drive.acceleration_forward) * self.given["rdd"]
        for k, section in enumerate(self.drive.filters, start=1):
            of = _coefficients(self.bound, section, self.period)
            tau_u = self._give_name(of.of(self.memory, f"filter{k}", tau_u, at_rest), f"tauf{k}x")
        return tau_u

    def _give_name(self, x: Scalar, letters: str) -> Scalar:
        name = f"{letters}{self.j}" if not letters.endswith("x") else f"{letters[:-2]}{self.j}_{letters[-2]}"
        self.bound.names.give(x, name, Section("Controller", self.j, "(D6)"))
        return x


GIVEN = ("measured", "speed", "r", "rd", "rdd", "tau")


def _controllers(bound: Bound) -> Iterator[_Controller]:
    """Yield the controllers of all motors, in their order."""
    entries = bound.arguments()
    for k, (j, drive) in enumerate(sampled_drives(bound.machine).items()):
        signals = {name: bound.graph.symbol(entries[name][k]) for name in GIVEN}
        yield _Law(bound, j, drive, signals).controller()


def _control(bound: Bound, _: Joints) -> Results:
    controllers = [*_controllers(bound)]
    later = [x for controller in controllers for x in controller.memory.later]
    return {
        "u": Result(bound.motors, tuple(controller.u for controller in controllers)),
        "zc_next": Result(None, tuple(later), (len(later),), column_labels=_labels(controllers)),
    }


def _start(bound: Bound, _: Joints) -> Results:
    controllers = [*_controllers(bound)]
    at_rest = [x for controller in controllers for x in controller.memory.at_rest]
    return {"zc": Result(None, tuple(at_rest), (len(at_rest),), column_labels=_labels(controllers))}


def _labels(controllers: Sequence[_Controller]) -> tuple[str, ...]:
    return tuple(label for controller in controllers for label in controller.memory.labels)


def _arguments(bound: Bound, _: Results) -> dict[str, tuple[str, ...]]:
    states = tuple(x for controller in _controllers(bound) for x in controller.memory.names)
    return {name: bound.arguments()[name] for name in GIVEN} | {"zc": states}


CONTROLLERS = (
    Model(
        CONTROL,
        "set points of the torques by the sampled controllers of the motors, and their states a period later",
        "(D6)",
        (*GIVEN, "zc"),
        ("u", "zc_next"),
        _control,
        Parts.WHOLE,
        own_arguments=_arguments,
    ),
    Model(
        START,
        "states of the sampled controllers at rest at a set point, under torques that hold the machine",
        "(D6)",
        ("r", "rd", "rdd", "tau"),
        ("zc",),
        _start,
        Parts.WHOLE,
    ),
)
