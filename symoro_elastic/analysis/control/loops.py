"""The loops of an axis: open-loop responses, margins, and the largest gains.

    velocity loop   1 + Kp b,   b = (1 + 1/(Tn s)) P(s) s G_v
    position loop   1 + Kv X,   X = C G_p/(1 + C s G_v),   C = Kp (1 + 1/(Tn s)) P(s)

G_v is the motor's position by its torque, G_p the position that is controlled; the loops of other axes are closed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade, laplace
from symoro_elastic.analysis.control.closed_loop import closed_loop
from symoro_elastic.analysis.control.largest_gain import LargestGain, Terms, largest_gain, refined_minimum
from symoro_elastic.analysis.control.plant import Axis, Plant, response_slopes
from symoro_elastic.analysis.vibration.modes import damped_poles
from symoro_elastic.foundation.array_types import Array, ComplexArray

POINTS = 1200
FLANKS, FARTHEST = 4 * 2 ** (np.arange(1, 25) / 2), 1e-2
AROUND = np.concatenate([-FLANKS[::-1], np.linspace(-4, 4, 17), FLANKS])
"""Places around a pole that frequencies are tried at, in its half widths, as far as `FARTHEST` of its frequency."""
NARROWEST = 1e-6
PARTS = 3
"""Of dead times, where stability is asked: their approximation is then right up to five turns of phase or so."""
NOTHING = 1e-12
"""Of a relative derivative: a smaller one is rounding."""
KEPT = 0.9
"""Of the distance without integral part, that remains with it."""
EXACT_ROOT, MOST_STEPS = 1e-13, 60
"""Relative change of a root that ends the search, and the most steps of it."""
SLOW = 0.02
"""Of the rate of a velocity loop: nearer to zero than this, poles are those of the position, which it leaves free."""


@dataclass(frozen=True)
class OpenAxis:
    """An axis of a plant with its drive open, those of `others` closed; `fastest` is the open drive's least time, s.

    `idle` is its own current controller, which answers to the back-EMF where no torque is wanted.
    """

    plant: Plant
    motor: str
    others: tuple[Cascade, ...]
    fastest: float
    idle: Cascade | None = None

    @property
    def closed_drives(self) -> tuple[Cascade, ...]:
        """Drives whose loops are closed while the axis is open."""
        return (*self.others, self.idle) if self.idle else self.others

    @property
    def axis(self) -> Axis:
        """Rows (n,) of the motor's velocity and of the position that its drive controls."""
        return self.plant.axes[self.motor]

    @cached_property
    def frequencies(self) -> Array:
        """Frequencies in Hz, ascending, dense around poles of the machine and of the other drives."""
        poles = [damped_poles(self.plant.linear)[0]]
        poles += [closed_loop(self.plant, self.closed_drives).poles] if self.closed_drives else []
        eigenvalues = np.concatenate([pole[np.abs(pole) > 0] for pole in poles])
        eigenvalues = eigenvalues[eigenvalues.imag >= 0]
        sizes = np.abs(eigenvalues) / (2 * np.pi)
        half = np.maximum(np.abs(eigenvalues.real) / np.abs(eigenvalues), NARROWEST)
        away = half[:, None] * AROUND
        around = (sizes[:, None] * (1 + away))[(np.abs(AROUND) <= 4) | (np.abs(away) < FARTHEST)]
        top = max([100.0, *(2 * sizes), *([2 / self.fastest] if self.fastest else [])])
        bottom = max(min([1e-2, *(sizes / 100)]), 1e-4)
        grid = np.geomspace(bottom, top, POINTS)
        return np.unique(np.concatenate([grid, around[(around > bottom) & (around < top)]]))

    @cached_property
    def on_grid(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Responses s, G_p, G_v at `frequencies`."""
        return self._responses(self.frequencies)

    def responses(self, frequencies: Array | ComplexArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return s, G_p and G_v at frequencies in Hz."""
        return self.on_grid if frequencies is self.frequencies else self._responses(frequencies)

    def _responses(self, frequencies: Array | ComplexArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        s = laplace(frequencies)
        return (s, *self.plant.axis_responses(s, self.motor, self.closed_drives))


@dataclass(frozen=True)
class AxisLoops:
    """The loops of a drive around an open axis."""

    open: OpenAxis
    cascade: Cascade

    @classmethod
    def around(cls, plant: Plant, cascade: Cascade, others: Sequence[Cascade]) -> AxisLoops:
        """Return the loops of a drive of a plant with other loops closed."""
        fastest = min((element.time for element in cascade.path if element.time), default=0.0)
        return cls(OpenAxis(plant, cascade.motor, tuple(others), fastest, cascade.idle), cascade)

    @property
    def plant(self) -> Plant:
        """Plant of the axis, the machine at one position."""
        return self.open.plant

    @property
    def others(self) -> tuple[Cascade, ...]:
        """Drives of the other axes, whose loops are closed."""
        return self.open.others

    @property
    def axis(self) -> Axis:
        """Rows (n,) of the motor's velocity and of the position that its drive controls."""
        return self.open.axis

    @property
    def frequencies(self) -> Array:
        """Frequencies of the search, Hz."""
        return self.open.frequencies

    def with_gains(self, **gains: float) -> AxisLoops:
        """Return the loops with other gains."""
        return replace(self, cascade=self.cascade.with_gains(**gains))

    def responses(self, frequencies: Array | ComplexArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return s, G_p and G_v at frequencies in Hz."""
        return self.open.responses(frequencies)

    def terms(self, key: str, frequencies: Array | ComplexArray) -> Terms:
        """Return a and b of the velocity loop, 1 + Kp b, or of the position loop, 1 + Kv b."""
        responses = self.responses(frequencies)
        return np.ones_like(responses[0]), over_gain(key, self.cascade, *responses)

    def terms_of_integral(self, frequencies: Array, least: float, usual: float) -> Terms:
        """Return a and b of the velocity loop by 1/Tn, 1 + Kp P s G_v and Kp P G_v, over the required margin.

        That is nine tenths of what it is without integral part, between the `least` and the `usual` distance.
        """
        s, _, G_v = self.responses(frequencies)
        proportional = self.cascade.Kp * self.cascade.path_at(s) * G_v
        a = 1 + proportional * s
        distance = np.clip(KEPT * np.abs(a), least, usual)
        return a / distance, proportional / distance

    def velocity_loop(self, frequencies: Array | ComplexArray) -> ComplexArray:
        """Return the open velocity loop at frequencies in Hz."""
        return self.cascade.Kp * self.terms("Kp", frequencies)[1]

    def position_loop(self, frequencies: Array | ComplexArray) -> ComplexArray:
        """Return the open position loop at frequencies in Hz."""
        return self.cascade.Kv * self.terms("Kv", frequencies)[1]

    def open_loops(self, frequencies: Array) -> dict[str, ComplexArray]:
        """Return both open loops at frequencies in Hz, by name."""
        return {"velocity": self.velocity_loop(frequencies), "position": self.position_loop(frequencies)}

    def position_response(self, frequencies: Array) -> ComplexArray:
        """Return the controlled position per set point, all loops closed, at frequencies in Hz."""
        s, G_p, G_v = self.responses(frequencies)
        closed = 1 + self.cascade.controller(s) * (self.cascade.Kv * G_p + s * G_v)
        response: ComplexArray = G_p / closed * (self.cascade.forward(s) + self._fed_torque(s, self.cascade))
        for drive in (drive for drive in self.others if drive.torque_forward):
            torque = self.plant.axes[drive.motor].velocity
            moved = self.plant.response(s, (*self.others, self.cascade), self.axis.position, torque)
            response = response + moved * self._fed_torque(s, drive)
        return response

    def _fed_torque(self, s: ComplexArray, drive: Cascade) -> ComplexArray:
        """Return the feed-forward torque of a drive, by the inverse model, per set point of this axis."""
        if not drive.torque_forward:
            return np.zeros_like(s)
        return np.asarray(drive.path_at(s) * self.plant.needed_torque(s, drive.motor, self.cascade.motor))

    def is_stable(self, **gains: float) -> bool:
        """Return whether the closed loops are stable with these gains; free positions without a loop do not count."""
        drive = self.cascade.with_gains(**gains)
        is_open = np.isnan(drive.Kv) or drive.Kv == 0
        closed = {drive.motor, *self.plant.held, *(other.motor for other in self.others)}
        is_free = is_open or not closed >= self.plant.axes.keys()
        rate = float(drive.Kp * self.axis.velocity @ np.linalg.solve(self.plant.linear.M, self.axis.velocity))
        loop = closed_loop(self.plant, [*self.others, drive.with_gains(Kv=0.0) if is_open else drive], PARTS)
        return loop.is_stable(SLOW * rate if is_free else 0.0)


def largest_Kp(loops: AxisLoops, modulus: float) -> LargestGain | None:
    """Return the largest Kp of the velocity loop, with its integral time."""
    terms = partial(loops.terms, "Kp")
    return largest_gain(terms, loops.frequencies, modulus, lambda k: loops.is_stable(Kp=k, Kv=0.0))


def largest_integral(loops: AxisLoops, least: float, usual: float) -> LargestGain | None:
    """Return the largest 1/Tn of the velocity loop that keeps nine tenths of its margin, or the `usual` value."""
    return largest_gain(
        lambda f: loops.terms_of_integral(f, least, usual),
        loops.frequencies,
        1.0,
        lambda k: loops.is_stable(Tn=1 / k, Kv=0.0),
    )


def largest_Kv(loops: AxisLoops, modulus: float) -> LargestGain | None:
    """Return the largest Kv of the position loop around the velocity loop."""
    return largest_gain(partial(loops.terms, "Kv"), loops.frequencies, modulus, lambda k: loops.is_stable(Kv=k))


# What limits a gain


def over_gain(key: str, drive: Cascade, s: ComplexArray, G_p: ComplexArray, G_v: ComplexArray) -> ComplexArray:
    """Return b, the open loop of Kp or Kv divided by this gain."""
    if key == "Kp":
        return drive.integral(s) * drive.path_at(s) * s * G_v
    C = drive.controller(s)
    return C * G_p / (1 + C * s * G_v)


def influences(loops: AxisLoops, key: str, largest: LargestGain) -> dict[str, float]:
    """Return d ln k / d ln p of the largest Kp or Kv at its frequency, by name p of parameters and drive numbers.

    With g = |a + k b|^2, which stays as it is: dk = -k Re((a + k b)* db)/Re((a + k b)* b).
    """
    if not np.isfinite(largest.gain):
        return {}
    a, b = loops.terms(key, np.array([largest.frequency]))
    distance = np.conj(a + largest.gain * b)[0]
    along = (distance * b[0]).real
    slopes = loop_slopes(loops, key, largest.frequency, lambda drive, *G: over_gain(key, drive, *G))
    relative = {name: float(-(distance * change).real / along) for name, change in slopes.items()}
    return {name: x for name, x in relative.items() if abs(x) > NOTHING}


def loop_slopes(
    loops: AxisLoops, key: str, frequency: float, of: Callable[..., ComplexArray], gain: float = 1.0
) -> dict[str, complex]:
    """Return p d/dp by name p of a loop of Kp or Kv: of `gain` times the function `of` of the drive and its responses.

    Numbers of its own drive are named without their motor.
    """
    s, G_p, G_v = loops.responses(np.array([frequency]))
    C, plant, closed = loops.cascade.controller(s)[0], loops.plant, loops.open.closed_drives
    inner = 1 + C * s[0] * G_v[0]
    by_v, by_p = over_gain("Kp", loops.cascade, s, G_p, np.ones_like(s))[0], 0.0
    if key == "Kv":
        by_v, by_p = -C * G_p[0] * C * s[0] / inner**2, C / inner
    velocity, position = plant.rows(loops.cascade.motor)
    totals = {name: complex(x[0]) for name, x in loops.cascade.slopes(lambda drive: of(drive, s, G_p, G_v)).items()}
    for row, by in ((velocity, by_v), (position, by_p)):
        for name, x in response_slopes(plant, complex(s[0]), closed, row, velocity).items() if by else ():
            totals[name] = totals.get(name, 0.0) + gain * by * x
    own = f"{loops.cascade.motor}, "
    return {name.removeprefix(own): x for name, x in totals.items()}


# How far a loop is from instability


@dataclass(frozen=True)
class Margins:
    """Margins of an open loop L: least |1 + L|; phase margin, deg, at |L| = 1; gain margin, the least factor to L = -1.

    Each with its frequency, Hz; NaN where there is none.
    """

    modulus: float
    modulus_frequency: float
    phase: float
    phase_frequency: float
    gain: float
    gain_frequency: float


def margins(of: Callable[[Array], ComplexArray], frequencies: Array) -> Margins:
    """Return the margins of an open loop over frequencies in Hz."""
    modulus = least(lambda f: np.abs(1 + of(f)), frequencies)
    crossovers = crossings(lambda f: np.log(np.abs(of(f))), frequencies)
    phases = [(abs(np.degrees(np.angle(-of(np.array([f]))[0]))), f) for f in crossovers]
    turns = [f for f in crossings(lambda f: of(f).imag, frequencies) if of(np.array([f]))[0].real < 0]
    factors = [(float(-1 / of(np.array([f]))[0].real), f) for f in turns]
    above = [(k, f) for k, f in factors if k > 1]
    none = (np.nan, np.nan)
    phase, gain = min(phases, default=none), min(above, default=none)
    return Margins(*modulus, float(phase[0]), float(phase[1]), float(gain[0]), float(gain[1]))


def least(of: Callable[[Array], Array], frequencies: Array) -> tuple[float, float]:
    """Return the least value over frequencies and its frequency, Hz, refined between neighbours."""
    k = int(np.nanargmin(of(frequencies)))
    return refined_minimum(of, frequencies, k)


def crossings(of: Callable[[Array], Array], frequencies: Array) -> list[float]:
    """Return the frequencies, Hz, at which a function changes its sign: its zeros, and its real poles."""
    values = of(frequencies)
    changes = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0)
    if not len(changes):
        return []
    places = roots(of, frequencies[changes], frequencies[changes + 1])
    ends = np.minimum(np.abs(values[changes]), np.abs(values[changes + 1]))
    zeros: list[float] = places[np.abs(of(places)) <= ends].tolist()
    return zeros


def roots(of: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Return the zeros of n functions between `low` and `high` (n,), all at once.

    Regula falsi of Illinois: an end that stays counts half the next time (Dowell and Jarratt 1971).
    """
    low, high, f_low, f_high = low.copy(), high.copy(), of(low), of(high)
    for _ in range(MOST_STEPS):
        slope = f_high - f_low
        x = high - f_high * np.divide(high - low, slope, out=np.zeros_like(slope), where=slope != 0)
        if not (np.abs(x - high) > EXACT_ROOT * np.abs(x)).any():
            break
        f = of(x)
        turned = np.sign(f) * np.sign(f_high) < 0
        low, f_low = np.where(turned, high, low), np.where(turned, f_high, f_low / 2)
        high, f_high = x, f
    return high


def loops_of(plant: Plant, cascades: Sequence[Cascade]) -> list[AxisLoops]:
    """Return the loops of the axes, the other axes closed."""
    return [AxisLoops.around(plant, cascade, [x for x in cascades if x is not cascade]) for cascade in cascades]
