"""The drive of a motor as a chain of small linear systems, with limits, between set point and torque.

    rf      = set point behind its filter
    e       = Kv (rf - x) + kfv rfd - xd                       x, xd: position and velocity of the motor
    xi'     = e + (sat(f) - f) Tn/(Kp Tt)                      f: torque that is wanted, behind its filters
    f       = filters(Kp (e + xi/Tn) + kfa rfdd + tau_ff)
    tau     = P sat(f)                                         P: dead time, current loop                   (D6)
    L T'    = sat(U) - R T - Ke' xd,   U = kp (tau_w - T + X) + share Ke' xd
    X'      = (tau_w - T)/ti + (sat(U) - U)/(kp Tt)            current i, voltage u: T = Kt n i, U = Kt n u        (D5)

In (I - g T) x = r a chain responds to an error e and a velocity xd with C e - Y xd + rho: transfer functions at
s = 1/g, and a term of the right side of its states. So a drive is a servo with gains kd = C + Y, kp = Kv C (D7), and
a push rho (D8). A limit has a slope of 1 within, of 0 beyond. It couples the integral part with the filters, whose own
transfer function at 1/g is F:

    xi (1 + (1 - slope) g F/Tt) = r + g e - (1 - slope) g (F (e Tn/Tt + b fed) + b rho_f),     b = Tn/(Kp Tt)

C, Y, F are not negative for any slope from 0 to 1, so nothing here is divided by zero, and no pivot of A + S vanishes.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

from symoro_elastic.foundation.scalar import Scalar, sum_of
from symoro_elastic.symbolic.expression import Graph
from symoro_elastic.symbolic.functions import amount, clamp, sign

Scalars = list[Scalar]


@dataclass(frozen=True)
class Block:
    """Linear system z' = A z + B u, y = C z + D u with a single input and output, and one or two named states."""

    names: tuple[str, ...]
    A: tuple[tuple[Scalar, ...], ...]
    B: tuple[Scalar, ...]
    C: tuple[Scalar, ...]
    D: Scalar

    def rates(self, z: Scalars, u: Scalar) -> Scalars:
        """Return the state derivatives z' = A z + B u."""
        return [_sum(row, z) + b * u for row, b in zip(self.A, self.B, strict=True)]

    def output(self, z: Scalars, u: Scalar) -> Scalar:
        """Return the output y = C z + D u."""
        return _sum(self.C, z) + self.D * u

    def implicit(self, g: Scalar, r: Scalars, u: Scalar) -> Scalars:
        """Return the solution z of (I - g A) z = r + g B u."""
        right = [x + (g * b) * u for x, b in zip(r, self.B, strict=True)]
        if not right:
            return []
        if len(right) == 1:
            return [right[0] * (1 / (1 - g * self.A[0][0]))]
        (a, b), (c, d) = ((1 - g * self.A[0][0], -g * self.A[0][1]), (-g * self.A[1][0], 1 - g * self.A[1][1]))
        over = 1 / (a * d - b * c)
        return [(over * d) * right[0] - (over * b) * right[1], (over * a) * right[1] - (over * c) * right[0]]

    def steady(self, u: Scalar, rates: Scalars | None = None) -> Scalars:
        """Return the states z with z' = 0, or z' = `rates`, at the input u."""
        right = [x - b * u for x, b in zip(rates or [0] * len(self.B), self.B, strict=True)]
        if len(right) < 2:
            return [x / self.A[0][0] for x in right]
        (a, b), (c, d) = self.A
        over = 1 / (a * d - b * c)
        return [(d * right[0] - b * right[1]) * over, (a * right[1] - c * right[0]) * over]


@dataclass(frozen=True)
class Limit:
    """The limit `level` of a signal f, and 1/Tt of the back-calculation of the integral part."""

    graph: Graph
    level: Scalar
    rate: Scalar

    def beyond(self, f: Scalar) -> Scalar:
        """Return the excess sat(f) - f of the signal f."""
        return self.saturate(f) - f

    def saturate(self, f: Scalar) -> Scalar:
        """Return the limited signal sat(f)."""
        return clamp(self.graph, f, -self.level, self.level)

    def slope(self, f: Scalar) -> Scalar:
        """Return 1 within the limit, 0 beyond."""
        return (1 + sign(self.graph, self.level - amount(self.graph, f))) / 2


class Inputs(NamedTuple):
    """Set point and its rates, position and velocity of the motor, torque added after the controller."""

    r: Scalar
    rd: Scalar
    rdd: Scalar
    x: Scalar
    xd: Scalar
    tau: Scalar


class Slopes(NamedTuple):
    """Slopes of the torque and voltage limits of a drive: 1 within the limit or without one, 0 beyond."""

    torque: Scalar = 1
    voltage: Scalar = 1


WITHIN = Slopes()


@dataclass(frozen=True)
class SetPoint:
    """Filter of a set point; `rate` is its angular frequency w."""

    block: Block
    rate: Scalar


@dataclass(frozen=True)
class Winding:
    """A controller of the current at a winding: `drag` is Kt n Ke n, `share` how much of it is compensated."""

    kp: Scalar
    ti: Scalar
    resistance: Scalar
    inductance: Scalar
    drag: Scalar
    share: Scalar
    limit: Limit | None

    names = ("torque", "current_integral")

    def rates(self, z: Scalars, wanted: Scalar, xd: Scalar) -> Scalars:
        """Return the state derivatives T' and X' of torque and current integral."""
        block, of_velocity = self.linear(1)
        rates = [x + b * xd for x, b in zip(block.rates(z, wanted), of_velocity, strict=True)]
        if self.limit:
            beyond = self.limit.beyond(self.voltage(z, wanted, xd))
            rates = [rates[0] + beyond / self.inductance, rates[1] + beyond * (self.limit.rate / self.kp)]
        return rates

    def voltage(self, z: Scalars, wanted: Scalar, xd: Scalar) -> Scalar:
        """Return the requested voltage times Kt n, before its limit."""
        return self.kp * (wanted - z[0] + z[1]) + self.share * self.drag * xd

    def linear(self, slope: Scalar) -> tuple[Block, tuple[Scalar, Scalar]]:
        """Return the linear system at a slope of the voltage limit, and the coefficients of xd in its rates."""
        gain, out = slope * self.kp / self.inductance, (1 - slope) * (self.limit.rate if self.limit else 0)
        into = 1 / self.ti - out
        A = ((-(self.resistance / self.inductance + gain), gain), (-into, -out))
        of_velocity = ((self.share * slope - 1) * self.drag / self.inductance, -out * self.share * self.drag / self.kp)
        return Block(self.names, A, (gain, into), (1, 0), 0), of_velocity


class _Walk:
    """Evaluation of blocks in sequence: reads their states from a list, and collects the state derivatives."""

    def __init__(self, own: Sequence[Scalar]) -> None:
        self._remaining, self.results = [*own], Scalars()

    def take(self, names: tuple[str, ...]) -> Scalars:
        """Return the next states of the list, as many as there are names."""
        own, self._remaining = self._remaining[: len(names)], self._remaining[len(names) :]
        return own

    def copy(self) -> Self:
        """Return an independent walk over the remaining entries, with results of its own."""
        other = copy.copy(self)
        other.results = []
        return other

    def through(self, blocks: tuple[Block, ...], u: Scalar) -> Scalar:
        """Return the output of blocks in series for the input u."""
        for block in blocks:
            u = block.output(self.states(block, u), u)
        return u

    def states(self, block: Block, u: Scalar) -> Scalars:
        """Return the states of the next block, and add their derivatives to the results."""
        own = self.take(block.names)
        self.results += block.rates(own, u)
        return own


class _Implicit(_Walk):
    """Evaluation of blocks in sequence for the implicit system (I - g T) x = r: reads r, and collects x."""

    def __init__(self, g: Scalar, r: Sequence[Scalar]) -> None:
        super().__init__(r)
        self.g = g

    def states(self, block: Block, u: Scalar) -> Scalars:
        """Return the states of the next block that solve the implicit system, and add them to the results."""
        states = block.implicit(self.g, self.take(block.names), u)
        self.results += states
        return states


class _Steady(_Walk):
    """Evaluation of blocks in sequence at rest: collects the steady states."""

    def states(self, block: Block, u: Scalar) -> Scalars:
        """Return the steady states of the next block, and add them to the results."""
        states = block.steady(u)
        self.results += states
        return states


@dataclass(frozen=True)
class Chain:
    """Blocks of a motor's drive: set-point filter, controller, filters `ahead` of the limit, path of the torque."""

    Kv: Scalar
    velocity_forward: Scalar
    acceleration_forward: Scalar
    controller: Block
    path: tuple[Block, ...]
    set_point: SetPoint | None = None
    ahead: tuple[Block, ...] = ()
    limit: Limit | None = None
    winding: Winding | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the states."""
        before = (self.set_point.block,) if self.set_point else ()
        blocks = (*before, self.controller, *self.ahead, *self.path)
        own = tuple(name for block in blocks for name in block.names)
        return (*own, *(self.winding.names if self.winding else ()))

    @property
    def is_limited(self) -> bool:
        """Whether the drive has limits, so that its slopes change with the state."""
        return self.limit is not None or (self.winding is not None and self.winding.limit is not None)

    def answer(self, z: Sequence[Scalar], u: Inputs) -> tuple[Scalars, Scalar]:
        """Return the rates of the states, and the torque."""
        rates, torque, _ = self._answer(z, u)
        return rates, torque

    def slopes(self, z: Sequence[Scalar], u: Inputs) -> Slopes:
        """Return the slopes of the limits at a state."""
        return self._answer(z, u)[2]

    def _answer(self, z: Sequence[Scalar], u: Inputs) -> tuple[Scalars, Scalar, Slopes]:
        walk, slopes = _Walk(z), Slopes()
        rf, rfd, rfdd = self._set_point_and_rates(walk, u.r, u.rd) if self.set_point else (u.r, u.rd, u.rdd)
        e = self.Kv * (rf - u.x) + self.velocity_forward * rfd - u.xd
        own, before = walk.take(self.controller.names), len(walk.results)
        tau_u = self.controller.output(own, e) + (self.acceleration_forward * rfdd + u.tau)
        f = walk.through(self.ahead, tau_u)
        if self.limit:
            slopes = slopes._replace(torque=self.limit.slope(f))
            e, f = e + (self._back * self.limit.beyond(f) if own else 0), self.limit.saturate(f)
        walk.results[before:before] = self.controller.rates(own, e)
        torque = walk.through(self.path, f)
        if self.winding:
            own = walk.take(self.winding.names)
            walk.results += self.winding.rates(own, torque, u.xd)
            if self.winding.limit:
                slopes = slopes._replace(voltage=self.winding.limit.slope(self.winding.voltage(own, torque, u.xd)))
            torque = own[0]
        return walk.results, torque, slopes

    def at_rest(self, r: Scalar, rd: Scalar, tau: Scalar) -> Scalars:
        """Return the steady states of a drive at the torque tau, and with a set point that moves at the rate rd."""
        walk = _Steady([])
        if self.set_point:
            block = self.set_point.block
            walk.results += block.steady(r, block.steady(rd))
        walk.results += [0] * len(self.controller.names)
        walk.through((*self.ahead, *self.path), tau)
        if self.winding:
            walk.results += [tau, tau * (self.winding.resistance / self.winding.kp)]
        return walk.results

    def implicit(
        self, g: Scalar, r: Sequence[Scalar], e: Scalar, xd: Scalar = 0, slopes: Slopes = WITHIN
    ) -> tuple[Scalars, Scalar]:
        """Return states and torque of (I - g T) x = r by the error and the velocity there: linear in r, e and xd.

        The torque for r = 0 and e = 1 is C(1/g), that for xd = 1 is -Y(1/g); that for e = xd = 0 is rho.
        """
        walk, fed = _Implicit(g, r), 0 * e
        if self.set_point:
            rf, rfd, rfdd = self._set_point_and_rates(walk, 0, 0)
            e, fed = e + self.Kv * rf + self.velocity_forward * rfd, self.acceleration_forward * rfdd
        if self.limit and self.controller.names:
            own = [self._integral(walk, e, fed, slopes.torque)]
            walk.results += own
            tau_u = self.controller.output(own, e)
        else:
            tau_u = walk.through((self.controller,), e)
        f = walk.through(self.ahead, tau_u + fed)
        torque = walk.through(self.path, slopes.torque * f)
        if self.winding:
            block, of_velocity = self.winding.linear(slopes.voltage)
            sides = walk.take(self.winding.names)
            own = block.implicit(g, [x + (g * b) * xd for x, b in zip(sides, of_velocity, strict=True)], torque)
            walk.results += own
            torque = own[0]
        return walk.results, torque

    @property
    def _back(self) -> Scalar:
        """Factor b = Tn/(Kp Tt) of the back-calculation of the integral part."""
        assert self.limit is not None
        return self.limit.rate / self.controller.C[0]

    def _integral(self, walk: _Implicit, e: Scalar, fed: Scalar, slope: Scalar) -> Scalar:
        """Return the integral part of a drive beyond its limit, in the implicit system with the filters before it."""
        assert self.limit is not None
        (r,) = walk.take(self.controller.names)
        F = _Implicit(walk.g, [0] * sum(len(block.names) for block in self.ahead)).through(self.ahead, 1)
        rho = walk.copy().through(self.ahead, 0)
        out = (1 - slope) * walk.g
        right = r + walk.g * e - out * self._back * (F * (self.controller.D * e + fed) + rho)
        return right * (1 / (1 + out * F * self.limit.rate))

    def _set_point_and_rates(self, walk: _Walk, r: Scalar, rd: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        """Return the filtered set point and its rates rf, rfd, rfdd, which are states of the filter and their rates."""
        assert self.set_point is not None
        block, w = self.set_point.block, self.set_point.rate
        z = walk.states(block, r)
        rates = block.rates(z, r)
        return z[0], rates[0], w * (rates[1] if len(z) > 1 else rd - rates[0])


def _sum(row: tuple[Scalar, ...], z: Scalars) -> Scalar:
    return sum_of(a * x for a, x in zip(row, z, strict=True))
