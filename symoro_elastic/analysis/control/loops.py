"""The loops of one axis: what is open, how far from instability it is, what limits its gains.

    velocity loop   1 + Kp b,   b = (1 + 1/(Tn s)) P(s) s G_v
    position loop   1 + Kv X,   X = C G_p/(1 + C s G_v),   C = Kp (1 + 1/(Tn s)) P(s)

G_v is the motor's position by its torque, G_p the position that is controlled; the loops of other axes are closed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade, CurrentLoop, laplace
from symoro_elastic.analysis.control.closed_loop import closed_loop
from symoro_elastic.analysis.control.largest_gain import LargestGain, Terms, largest_gain, refined_minimum
from symoro_elastic.analysis.control.plant import Axis, Plant, response_slopes
from symoro_elastic.analysis.vibration.modes import damped_poles
from symoro_elastic.foundation.array_types import Array, ComplexArray

POINTS = 1200
AROUND = np.linspace(-4, 4, 17)
"""Places around a pole that frequencies are tried at, in its half widths."""
NARROWEST = 1e-6
PARTS = 3
"""Of dead times, where stability is asked: their approximation is then right up to five turns of phase or so."""
KEPT = 0.9
"""Of the distance without integral part, that remains with it."""
EXACT_ROOT, MOST_STEPS = 1e-13, 60
"""Relative change of a root that ends the search, and the most steps of it."""
SLOW = 0.02
"""Of the rate of a velocity loop: nearer to zero than this, poles are those of the position, which it leaves free."""


@dataclass(frozen=True)
class OpenAxis:
    """One axis of a plant without its drive, those of `others` closed; `fastest` is the least time of its drive, s.

    `idle` is its own current controller, which answers to the back-EMF where no torque is wanted.
    """

    plant: Plant
    motor: str
    others: tuple[Cascade, ...]
    fastest: float
    idle: Cascade | None = None

    @property
    def closed(self) -> tuple[Cascade, ...]:
        """The loops that are closed while the axis is open."""
        return (*self.others, self.idle) if self.idle else self.others

    @property
    def axis(self) -> Axis:
        """Its rows."""
        return self.plant.axes[self.motor]

    @cached_property
    def frequencies(self) -> Array:
        """Frequencies in Hz, ascending, that are close to each other around poles of the machine and of the others."""
        poles = [damped_poles(self.plant.linear)[0]]
        poles += [closed_loop(self.plant, self.closed).poles] if self.closed else []
        found = np.concatenate([pole[np.abs(pole) > 0] for pole in poles])
        found = found[found.imag >= 0]
        sizes = np.abs(found) / (2 * np.pi)
        half = np.maximum(np.abs(found.real) / np.abs(found), NARROWEST)
        around = (sizes[:, None] * (1 + half[:, None] * AROUND)).ravel()
        top = max([100.0, *(2 * sizes), *([2 / self.fastest] if self.fastest else [])])
        bottom = max(min([1e-2, *(sizes / 100)]), 1e-4)
        grid = np.geomspace(bottom, top, POINTS)
        return np.unique(np.concatenate([grid, around[(around > bottom) & (around < top)]]))

    @cached_property
    def on_grid(self) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """The responses at its frequencies."""
        return self._responses(self.frequencies)

    def responses(self, frequencies: Array | ComplexArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return s, G_p and G_v at frequencies in Hz."""
        return self.on_grid if frequencies is self.frequencies else self._responses(frequencies)

    def _responses(self, frequencies: Array | ComplexArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        s = laplace(frequencies)
        return (s, *self.plant.axis_responses(s, self.motor, self.closed))


@dataclass(frozen=True)
class AxisLoops:
    """The loops of a drive around an open axis."""

    open: OpenAxis
    cascade: Cascade

    @classmethod
    def around(cls, plant: Plant, cascade: Cascade, others: Sequence[Cascade]) -> AxisLoops:
        """Return the loops of a drive of a plant with other loops closed."""
        fastest = min((one.time for one in cascade.path if one.time), default=0.0)
        return cls(OpenAxis(plant, cascade.motor, tuple(others), fastest, cascade.idle), cascade)

    @property
    def plant(self) -> Plant:
        """The machine."""
        return self.open.plant

    @property
    def others(self) -> tuple[Cascade, ...]:
        """The drives of other axes that are closed."""
        return self.open.others

    @property
    def axis(self) -> Axis:
        """Its rows."""
        return self.open.axis

    @property
    def frequencies(self) -> Array:
        """Frequencies in Hz that are tried."""
        return self.open.frequencies

    def with_gains(self, **gains: float) -> AxisLoops:
        """Return the loops with other gains."""
        return replace(self, cascade=self.cascade.with_gains(**gains))

    def responses(self, frequencies: Array | ComplexArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return s, G_p and G_v at frequencies in Hz."""
        return self.open.responses(frequencies)

    def terms_of_Kp(self, frequencies: Array | ComplexArray) -> Terms:
        """Return a and b of the velocity loop, 1 + Kp b."""
        s, _, G_v = self.responses(frequencies)
        return np.ones_like(s), self.cascade.integral(s) * self.cascade.path_at(s) * s * G_v

    def terms_of_integral(self, frequencies: Array, least: float, usual: float) -> Terms:
        """Return a and b of the velocity loop by 1/Tn, 1 + Kp P s G_v and Kp P G_v, over the distance to keep.

        That is nine tenths of what it is without integral part, between the `least` and the `usual` distance.
        """
        s, _, G_v = self.responses(frequencies)
        proportional = self.cascade.Kp * self.cascade.path_at(s) * G_v
        a = 1 + proportional * s
        distance = np.clip(KEPT * np.abs(a), least, usual)
        return a / distance, proportional / distance

    def terms_of_Kv(self, frequencies: Array | ComplexArray) -> Terms:
        """Return a and b of the position loop, 1 + Kv X."""
        s, G_p, G_v = self.responses(frequencies)
        C = self.cascade.controller(s)
        return np.ones_like(s), C * G_p / (1 + C * s * G_v)

    def velocity_loop(self, frequencies: Array | ComplexArray) -> ComplexArray:
        """Return the open velocity loop at frequencies in Hz."""
        return self.cascade.Kp * self.terms_of_Kp(frequencies)[1]

    def position_loop(self, frequencies: Array | ComplexArray) -> ComplexArray:
        """Return the open position loop at frequencies in Hz."""
        return self.cascade.Kv * self.terms_of_Kv(frequencies)[1]

    def open_loops(self, frequencies: Array) -> dict[str, ComplexArray]:
        """Return both open loops at frequencies in Hz, by name."""
        return {"velocity": self.velocity_loop(frequencies), "position": self.position_loop(frequencies)}

    def followed(self, frequencies: Array) -> ComplexArray:
        """Return the controlled position by its set point, all loops closed, at frequencies in Hz."""
        s, G_p, G_v = self.responses(frequencies)
        closed = 1 + self.cascade.controller(s) * (self.cascade.Kv * G_p + s * G_v)
        found: ComplexArray = G_p / closed * (self.cascade.forward(s) + self._fed(s, self.cascade))
        for one in (other for other in self.others if other.torque_forward):
            torque = self.plant.axes[one.motor].velocity
            moved = self.plant.response(s, (*self.others, self.cascade), self.axis.position, torque)
            found = found + moved * self._fed(s, one)
        return found

    def _fed(self, s: ComplexArray, drive: Cascade) -> ComplexArray:
        """Return the torque that the inverse model makes a drive give by the set point of this axis."""
        if not drive.torque_forward:
            return np.zeros_like(s)
        found: ComplexArray = drive.path_at(s) * self.plant.needed_torque(s, drive.motor, self.cascade.motor)
        return found

    def is_stable(self, **gains: float) -> bool:
        """Whether the loops are, with some gains; positions that no loop holds are free, and do not count."""
        one = self.cascade.with_gains(**gains)
        is_open = np.isnan(one.Kv) or one.Kv == 0
        closed = {one.motor, *self.plant.held, *(other.motor for other in self.others)}
        is_free = is_open or not closed >= self.plant.axes.keys()
        rate = float(one.Kp * self.axis.velocity @ np.linalg.solve(self.plant.linear.M, self.axis.velocity))
        loop = closed_loop(self.plant, [*self.others, one.with_gains(Kv=0.0) if is_open else one], PARTS)
        return loop.is_stable(SLOW * rate if is_free else 0.0)


def largest_Kp(loops: AxisLoops, modulus: float) -> LargestGain | None:
    """Return the largest Kp of the velocity loop, with its integral time."""
    return largest_gain(loops.terms_of_Kp, loops.frequencies, modulus, lambda k: loops.is_stable(Kp=k, Kv=0.0))


def largest_integral(loops: AxisLoops, least: float, usual: float) -> LargestGain | None:
    """Return the largest 1/Tn of the velocity loop, which keeps nine tenths of its distance, or the `usual` one."""
    return largest_gain(
        lambda f: loops.terms_of_integral(f, least, usual),
        loops.frequencies,
        1.0,
        lambda k: loops.is_stable(Tn=1 / k, Kv=0.0),
    )


def largest_Kv(loops: AxisLoops, modulus: float) -> LargestGain | None:
    """Return the largest Kv of the position loop around the velocity loop."""
    return largest_gain(loops.terms_of_Kv, loops.frequencies, modulus, lambda k: loops.is_stable(Kv=k))


# What limits a gain


def influences(loops: AxisLoops, key: str, found: LargestGain) -> dict[str, float]:
    """Return d ln k / d ln p of the largest Kp or Kv at its frequency, by parameter, dead time, lag and filter.

    With g = |a + k b|^2, which stays as it is: dk = -k Re((a + k b)* db)/Re((a + k b)* b).
    """
    if not np.isfinite(found.gain):
        return {}
    at = np.array([found.frequency])
    a, b = (loops.terms_of_Kp if key == "Kp" else loops.terms_of_Kv)(at)
    distance = np.conj(a + found.gain * b)[0]
    along = (distance * b[0]).real
    slopes = slopes_of_terms(loops, key, found.frequency)
    return {name: float(-(distance * change).real / along) for name, change in slopes.items() if change}


def slopes_of_terms(loops: AxisLoops, key: str, frequency: float) -> dict[str, complex]:
    """Return p db/dp by name p, b being that of Kp or Kv."""
    s, G_p, G_v = (x[0] for x in loops.responses(np.array([frequency])))
    at = np.array([s])
    path, integral, C = (f(at)[0] for f in (loops.cascade.path_at, loops.cascade.integral, loops.cascade.controller))
    inner = 1 + C * s * G_v
    by_G_v, by_G_p, by_path = (
        (integral * path * s, 0.0, integral * path * s * G_v)
        if key == "Kp"
        else (-C * G_p * C * s / inner**2, C / inner, C * G_p / inner**2)
    )
    axis, linear, closed = loops.axis, loops.plant.linear, loops.open.closed
    of_v = response_slopes(loops.plant, s, closed, axis.velocity, axis.velocity)
    same = axis.position is axis.velocity
    of_p = of_v if same or not by_G_p else response_slopes(loops.plant, s, closed, axis.position, axis.velocity)
    values, mechanical = linear.motion.parameters, mechanical_names(loops.plant)
    found = {name: values[name] * (by_G_v * of_v[name] + by_G_p * of_p[name]) for name in mechanical}
    for one in loops.cascade.path:
        if isinstance(one, CurrentLoop):  # dG = - s dY G G_v
            by_Y = -s * one.dragged(at)[0] * G_v * (by_G_v * G_v + by_G_p * G_p)
            found |= {name: complex(by_path * H[0] + by_Y * Y[0]) for name, (H, Y) in one.slopes(at).items()}
        else:
            found[one.name] = complex(by_path * one.slope(at)[0])
    return found


def mechanical_names(plant: Plant) -> list[str]:
    """Return the parameters that no geometry depends on: rows of motors and signals do not change with them."""
    motion = plant.linear.motion
    geometry = {
        name
        for joint in motion.machine.joints
        for formula in (joint.gamma, joint.b, joint.alpha, joint.d, joint.theta, joint.r)
        for name in formula.names
    }
    return [name for name in motion.parameters if name not in geometry]


# How far a loop is from instability


@dataclass(frozen=True)
class Margins:
    """Of an open loop L: the least |1 + L|; the least phase, deg, to -180 where |L| = 1; the least factor to L = -1.

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
    """Return the least value over frequencies and its place, Hz, refined between its neighbours."""
    k = int(np.nanargmin(of(frequencies)))
    return refined_minimum(of, frequencies, k)


def crossings(of: Callable[[Array], Array], frequencies: Array) -> list[float]:
    """Return the frequencies, Hz, at which a function changes its sign."""
    values = of(frequencies)
    changes = np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0)
    if not len(changes):
        return []
    found: list[float] = roots(of, frequencies[changes], frequencies[changes + 1]).tolist()
    return found


def roots(of: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Return the places between `low` and `high` (n,) at which n functions are zero, all of them at a time.

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
    """Return each axis with the other ones closed."""
    return [AxisLoops.around(plant, one, [x for x in cascades if x is not one]) for one in cascades]
