"""Drives as expressions: chains of small linear systems between the error of a motor's velocity and its torque.

    e   = Kv (r - x_m) + kfv rd - xd_m                            x_m, xd_m: position and velocity of the motor
    tau = P (Kp (e + xi/Tn) + kfa rdd + tau_ff),   xi' = e        P: dead time, current loop, filters      (D6)

In (I - g T) x = r a chain answers an error e with C(1/g) e + rho: its transfer function at s = 1/g, and what the right
side of its states leaves. So a drive is a servo with the gains kd = C(1/g), kp = Kv kd there (D7), and a push rho (D8).
Dead times are Pade approximations of order 2, whose transfer function is positive on the real axis. States are
scaled as in `analysis.control`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.described import drives_of
from symoro_elastic.machine.drives import MOTOR, TUNED, Drive, Notch
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.symbolic.functions import square_root

Scalars = list[Scalar]


@dataclass(frozen=True)
class Block:
    """z' = A z + B u, y = C z + D u of one input, one output and one or two states, with names of these."""

    names: tuple[str, ...]
    A: tuple[tuple[Scalar, ...], ...]
    B: tuple[Scalar, ...]
    C: tuple[Scalar, ...]
    D: Scalar

    def rates(self, z: Scalars, u: Scalar) -> Scalars:
        """Return z'."""
        return [_sum(row, z) + b * u for row, b in zip(self.A, self.B, strict=True)]

    def output(self, z: Scalars, u: Scalar) -> Scalar:
        """Return y."""
        return _sum(self.C, z) + self.D * u

    def implicit(self, g: Scalar, r: Scalars, u: Scalar) -> Scalars:
        """Return z of (I - g A) z = r + g B u."""
        right = [x + (g * b) * u for x, b in zip(r, self.B, strict=True)]
        if len(right) == 1:
            return [right[0] * (1 / (1 - g * self.A[0][0]))]
        (a, b), (c, d) = ((1 - g * self.A[0][0], -g * self.A[0][1]), (-g * self.A[1][0], 1 - g * self.A[1][1]))
        over = 1 / (a * d - b * c)
        return [(over * d) * right[0] - (over * b) * right[1], (over * a) * right[1] - (over * c) * right[0]]


@dataclass(frozen=True)
class Chain:
    """The drive of one motor: its controller and what is behind it."""

    Kv: Scalar
    velocity_forward: Scalar
    acceleration_forward: Scalar
    controller: Block
    path: tuple[Block, ...]

    @property
    def blocks(self) -> tuple[Block, ...]:
        """All parts, in the order of the states."""
        return (self.controller, *self.path)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the states."""
        return tuple(name for block in self.blocks for name in block.names)

    def error(self, behind: Scalar, xd: Scalar, rd: Scalar) -> Scalar:
        """Return e of a motor that is `behind` its set point."""
        return self.Kv * behind + self.velocity_forward * rd - xd

    def answer(self, z: Scalars, e: Scalar, fed: Scalar) -> tuple[Scalars, Scalar]:
        """Return the rates of the states, and the torque; `fed` is added behind the controller."""
        rates: Scalars = []
        u, parts = e, self._parts(z)
        for block, own in zip(self.blocks, parts, strict=True):
            rates += block.rates(own, u)
            u = block.output(own, u) + (fed if block is self.controller else 0)
        return rates, u

    def implicit(self, g: Scalar, r: Scalars, e: Scalar) -> tuple[Scalars, Scalar]:
        """Return states and torque of (I - g T) x = r, by the error there: linear in r and e.

        The torque for r = 0, e = 1 is C(1/g), by which a drive is a servo; that for e = 0 is rho.
        """
        states: Scalars = []
        u, parts = e, self._parts(r)
        for block, own in zip(self.blocks, parts, strict=True):
            found = block.implicit(g, own, u) if own else []
            states += found
            u = block.output(found, u)
        return states, u

    def _parts(self, z: Scalars) -> Iterator[Scalars]:
        first = 0
        for block in self.blocks:
            yield z[first : first + len(block.names)]
            first += len(block.names)


def driven_motors(machine: Machine) -> Mapping[int, Drive]:
    """Return the drives of motors, by joint, with which time steps can be taken: none where one cannot.

    A gain that is left to tuning has no number, the position of a load is not the motor's own, and neither the samples
    of a controller nor limits, filters of set points and controllers of currents are in chains.
    """
    named, drives = {machine.joint(j).name: j for j in machine.motors}, drives_of(machine).by_motor
    for one in drives.values():
        others = (one.period, one.torque_limit, one.set_point, one.current)
        if TUNED in (one.Kv, one.Kp, one.Tn) or one.measured != MOTOR or any(x is not None for x in others):
            return {}
    return {j: drives[name] for name, j in named.items() if name in drives}


def chains_of(bound: Bound) -> dict[int, Chain]:
    """Return the drives of a bound machine, by the joints of their motors."""
    return {j: _chain(bound, one) for j, one in driven_motors(bound.machine).items()}


def state_names(machine: Machine, drives: bool) -> tuple[str, ...]:
    """Return names of states beside positions and velocities: of friction by joint, then of `drives` by motor."""
    friction = [f"{machine.joint(j).name}.friction" for j in machine.bristles]
    chains = chains_of(Bound(machine)) if drives else {}
    return (*friction, *(f"{machine.joint(j).name}.{name}" for j, one in chains.items() for name in one.names))


def state_symbols(chains: Mapping[int, Chain], stem: str) -> dict[int, tuple[str, ...]]:
    """Return names of the variables of the states of drives, by motor."""
    return {j: tuple(f"{stem}{j}_{k}" for k in range(1, len(one.names) + 1)) for j, one in chains.items()}


def _chain(bound: Bound, drive: Drive) -> Chain:
    kp, kv = (bound.cell(gain) for gain in (drive.Kp, drive.Kv))  # type: ignore[arg-type]  # none is tuned
    if drive.Tn is None:
        controller = Block((), (), (), (), kp)
    else:
        controller = Block(("speed_integral",), ((0,),), (1,), (kp / bound.cell(drive.Tn),), kp)  # type: ignore[arg-type]
    fed = (bound.cell(drive.velocity_forward), bound.cell(drive.acceleration_forward))
    return Chain(kv, *fed, controller, tuple(_path(bound, drive)))


def _path(bound: Bound, drive: Drive) -> Iterator[Block]:
    """Yield the parts of the torque's path, as `analysis.control.cascade.system_of` has them."""
    delay = bound.cell(drive.dead_time) if drive.dead_time else 0
    if not _is_zero(delay):
        over = 1 / delay
        A = ((0, 12 * over), (-over, -6 * over))
        yield Block(("dead_time_1", "dead_time_2"), A, (0, over), (0, -12), 1)
    lag = bound.cell(drive.lag)
    if not _is_zero(lag):
        yield _first_order("torque", 1 / lag)
    for k, one in enumerate(drive.filters, start=1):
        w = 2 * bound.graph.pi * bound.cell(one.frequency)
        names = (f"filter_{k}_1", f"filter_{k}_2")
        if isinstance(one, Notch):
            below = bound.cell(one.width)
            yield _biquad(names, w, below, (0, 2 * (bound.cell(one.depth) - below)), 1)
        elif one.order == 1:
            yield _first_order(f"filter_{k}", w)
        else:
            yield _biquad(names, w, square_root(bound.graph, 2) / 2, (1, 0), 0)


def _first_order(name: str, rate: Scalar) -> Block:
    return Block((name,), ((-rate,),), (rate,), (1,), 0)


def _biquad(names: tuple[str, str], w: Scalar, below: Scalar, C: tuple[Scalar, Scalar], D: Scalar) -> Block:
    return Block(names, ((0, w), (-w, -2 * below * w)), (0, w), C, D)


def _is_zero(x: Scalar) -> bool:
    return isinstance(x, int) and x == 0


def _sum(row: tuple[Scalar, ...], z: Scalars) -> Scalar:
    total: Scalar = 0
    for a, x in zip(row, z, strict=True):
        total = total + a * x
    return total
