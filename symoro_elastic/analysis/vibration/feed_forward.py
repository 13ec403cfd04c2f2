"""Feed-forward: torques and motions of motors for a reference trajectory beyond the springs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.time_series.writing import write_columns
from symoro_elastic.analysis.vibration.beyond_limits import Beyond, beyond_limits
from symoro_elastic.analysis.vibration.driven_joints import MotionOfMotors, of_motors, with_motors_on_load_joints
from symoro_elastic.analysis.vibration.linearization import linearize, with_motors
from symoro_elastic.analysis.vibration.modes import modes
from symoro_elastic.analysis.vibration.reference_trajectory import ReferenceTrajectory
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError, refuse_numbers
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.checks import require_fixed_base
from symoro_elastic.machine.limits import TORQUE
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.state import State
from symoro_elastic.models.dynamics.feed_forward import (
    OverTime,
    damping_of,
    deflection_symbol,
    left_out_springs,
    motion_symbol,
    over_time,
)
from symoro_elastic.models.dynamics.load_coordinates import chains, load_positions
from symoro_elastic.models.steps.time_steps import dependent_motors
from symoro_elastic.numerics.evaluation.arrays import values_along
from symoro_elastic.numerics.evaluation.closed_positions import refuse_lost
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from symoro_elastic.numerics.motion.independent_joints import line_on_undetermined
from symoro_elastic.quantities import HIGHEST_DERIVATIVE
from symoro_elastic.symbolic.differentiation import Differentiation
from symoro_elastic.symbolic.expression import reachable
from symoro_elastic.symbolic.operations import SYMBOL

GAUSS_POINTS = 6

FEED_FORWARD = "feed_forward"
IN_MOTION = 1e-3  # of the largest value
JUMPS = "has dry friction, none at rest: its torque jumps where it starts, stops or reverses"
MOST_PLACES = 200


@dataclass(frozen=True, repr=False)
class FeedForward(Result):
    """Feed-forward of all motors: t (N,) s, tau (N, m) of the motors, q and qd (N, n) of all moving joints.

    `reference` is the motion of what they drive, `orders` its derivatives that each motor needs; SI units, radians.
    `lead` (N, m) is how far each motor is ahead of where it would be without deflections; `units` are those of what
    the motors drive, rad or m. `left_out` are springs that do not follow.
    Where motors follow from loops, `reference`, `orders`, `lead` and `units` are those of the independent joints, which
    are motors of `followed` instead; `following` is what the motors do.
    """

    machine: Machine
    reference: ReferenceTrajectory
    orders: Mapping[str, int]
    q: Array
    qd: Array
    tau: Array
    lead: Array
    units: tuple[str, ...]
    left_out: LeftOut | None = None
    followed: Machine | None = None
    following: MotionOfMotors | None = None

    @property
    def t(self) -> Array:
        """Times (N,), s."""
        return self.reference.t

    @property
    def motors(self) -> tuple[str, ...]:
        """Names of the motors."""
        return tuple(joint.name for joint in self.machine.motor_joints)

    def at_motors(self, block: Array) -> Array:
        """Return the columns of the motors of q or qd."""
        names = [joint.name for joint in self.machine.independent_joints]
        return block[:, [names.index(name) for name in self.motors]]

    @property
    def headline(self) -> str:
        """Machine, motors and samples."""
        return f"Feed-forward of {self.machine.name}: {len(self.motors)} motors, {len(self.t)} samples"

    @property
    def wanted(self) -> tuple[Joint, ...]:
        """Joints with a prescribed motion, including that of their load-side springs."""
        return (self.followed or self.machine).motor_joints

    @property
    def velocities(self) -> Array:
        """Velocities (N, m) of the motors."""
        return self.at_motors(self.qd) if self.following is None else self.following.xd

    @property
    def beyond(self) -> tuple[Beyond, ...]:
        """Exceeded limits of independent joints and of motor torques."""
        names = [joint.name for joint in self.machine.independent_joints]
        motion = {"position": self.q, "velocity": self.qd}
        by_quantity = {quantity: dict(zip(names, block.T, strict=True)) for quantity, block in motion.items()}
        torques = dict(zip(self.motors, self.tau.T, strict=True))
        return beyond_limits(self.machine, self.t, {**by_quantity, TORQUE: torques})


def orders(machine: Machine) -> dict[str, int]:
    """Return the required number of derivatives of the reference trajectory, by motor. Raises `InputError`."""
    require_fixed_base(machine, "feed-forward")
    led = with_motors_on_load_joints(machine)
    reduced = with_springs_held(led, left_out_springs(led))
    return _orders(reduced, over_time(reduced))


def _orders(machine: Machine, solved: OverTime) -> dict[str, int]:
    lagging = [x for derivatives in solved.lagging.values() for x in derivatives]
    roots = [*lagging, *solved.tau.values(), *solved.q.values(), *solved.qd.values()]
    used = {x.operands[0] for x in reachable(roots) if x.operation == SYMBOL}
    orders = {j: [k for k in range(HIGHEST_DERIVATIVE + 1) if motion_symbol(j, k) in used] for j in machine.motors}
    return {machine.joint(j).name: max(some, default=0) for j, some in orders.items()}


def feed_forward(
    machine: Machine, reference: ReferenceTrajectory, values: Mapping[str, float] | None = None
) -> FeedForward:
    """Return the torques of motors for a reference trajectory.

    Deflections of springs with damping are integrated along the samples, exact but for their spacing; without damping
    they are exact. Springs that are not behind a motor on its axis stay at their neutral positions (`left_out`).
    Where motors follow from loops, the trajectory is that of the independent joints (`driven_joints`).
    Raises `InputError` for a machine without feed-forward, and for a motion with too few derivatives.
    """
    valued = with_values(machine, values) if values else machine
    led = with_motors_on_load_joints(valued)
    command = _feed_forward(led, reference)
    if led.motors == valued.motors:
        return command
    motors = of_motors(valued, led, command.t, command.q, command.qd, command.tau)
    return replace(command, machine=valued, tau=motors.tau, followed=led, following=motors)


def _feed_forward(valued: Machine, reference: ReferenceTrajectory) -> FeedForward:
    """Return the torques of independent motors."""
    parameters = EquationsOfMotion(valued).parameters
    omitted = left_out_springs(valued)
    reduced = with_springs_held(valued, omitted)
    solved = over_time(reduced)
    needed = _orders(reduced, solved)
    refuse_few(reference, needed, valued)
    per_sample = 3 * len(valued.independent) + sum(len(rows) + 1 for rows in reference.y.values())
    what = f"{len(reference.t)} samples of {len(valued.independent)} joints"
    refuse_numbers(per_sample * len(reference.t), what, reference.source, "t", "give fewer, or a lower --sample-rate")
    symbols: dict[str, Any] = {p.name: parameters[p.name] for p in reduced.parameters}
    for j in reduced.motors:
        name = reduced.joint(j).name
        symbols |= {motion_symbol(j, k): reference.y[name][k] for k in range(needed[name] + 1)}
    for j, undamped in solved.lagging.items():
        lag = damping_of(solved.bound, j) / solved.bound.cell(reduced.joint(j).spring.stiffness)
        (tau,) = values_along([lag], symbols, 1)[0]
        deflection = lagging(reference.t, values_along(undamped, symbols, len(reference.t)), float(tau))
        symbols |= {deflection_symbol(j, k): x for k, x in enumerate(deflection)}
    return _assemble(valued, reference, needed, solved, symbols, omitted)


def _assemble(
    valued: Machine,
    reference: ReferenceTrajectory,
    needed: Mapping[str, int],
    solved: OverTime,
    symbols: Mapping[str, Any],
    omitted: list[str],
) -> FeedForward:
    """Return torques and motion of all joints; omitted joints are at rest."""
    bound = solved.bound
    N, motion = len(reference.t), EquationsOfMotion(valued)
    q, qd = np.tile(motion.neutral_positions(), (N, 1)), np.zeros((N, len(motion.joints)))
    columns = [valued.independent.index(j) for j in solved.q]
    q[:, columns], qd[:, columns] = (values_along(list(x.values()), symbols, N).T for x in (solved.q, solved.qd))
    tau = values_along([solved.tau[j] for j in valued.motors], symbols, N).T
    joints = [joint.name for joint in motion.joints]
    _refuse_without_value(reference, joints, q)
    refuse_lost(valued, "feed-forward", reference.t, State({"q": q}))
    _refuse_without_value(reference, [*joints, *(valued.joint(j).name for j in valued.motors)], np.hstack([qd, tau]))
    parameters = {p.name: symbols[p.name] for p in bound.machine.parameters}
    motors = {j: q[:, valued.independent.index(j)] for j in valued.motors}
    lead = _lead(bound, parameters, motors, {j: reference.y[valued.joint(j).name][0] for j in valued.motors})
    units = tuple(valued.joint(chain.joints[-1]).unit for chain in chains(bound))
    left_out = cost(valued, omitted, reference.t, q, qd)
    return FeedForward(valued, reference, needed, q, qd, tau, lead, units, left_out)


def _refuse_without_value(reference: ReferenceTrajectory, joints: Sequence[str], motion: Array) -> None:
    """Raise `InputError` for the first sample at which one of the columns (N, joints) is NaN or infinite."""
    missing = np.argwhere(~np.isfinite(motion))
    if len(missing):
        sample, column = missing[0]
        place = f"t = {reference.t[sample]:.4g} s, {joints[column]}"
        what = "no position was found that satisfies the loops and balances the springs"
        raise InputError(reference.source, place, f"{what}: give a slower or shorter motion")


def _lead(bound: Bound, parameters: Mapping[str, Any], q: Mapping[int, Array], y: Mapping[int, Array]) -> Array:
    """Return how far motors (N, m) at q (N,) lead the motion y (N,) of their loads, without deflections."""
    positions = load_positions(bound, chains(bound))
    variables = {name: q.get(j, 0.0) for name, j in bound.machine.variables.items()}
    columns = []
    for j, z in positions.items():
        gear = Differentiation([z]).by(bound.q[j]).of(z)
        value, turned = values_along([z, gear], {**parameters, **variables}, len(y[j]))
        columns.append((value - y[j]) / turned)
    return np.stack(columns, axis=1)


def starts(machine: Machine) -> dict[str, float]:
    """Return the load positions at the start of the machine's loops, by motor, rad or m; 0 without a start."""
    if not machine.loops:
        return {}
    led = with_motors_on_load_joints(machine)
    motion = EquationsOfMotion(led)
    bound = Bound(with_springs_held(led, left_out_springs(led)))
    variables = dict(zip((str(joint.variable) for joint in motion.joints), motion.position_of_loops(), strict=True))
    positions = load_positions(bound, chains(bound))
    values = values_along(list(positions.values()), {**motion.parameters, **variables}, 1)
    return {led.joint(j).name: float(x) for j, (x,) in zip(positions, values, strict=True)}


def refuse_few(reference: ReferenceTrajectory, needed: Mapping[str, int], machine: Machine) -> None:
    """Raise `InputError` for a motor without a reference trajectory, or with too few derivatives."""
    for name, order in needed.items():
        if name not in reference.y:
            raise InputError(reference.source, f"y_{name}", f"missing: motor {name} of {machine.name} needs a motion")
        order_given = reference.order(name)
        if order_given < order:
            smooth = f"a spline of degree {order} or more (--degree {order + 1}: smooth torques)"
            lacking = f"columns up to {reference.columns}{'d' * order}_{name}, or positions alone and {smooth}"
            why = f" ({reference.doubts[name][1]})" if reference.columns and name in reference.doubts else ""
            what = f"{order_given} derivatives of its motion are given{why}, {FEED_FORWARD} needs {order}"
            raise InputError(reference.source, name, f"{what}: give {lacking if reference.columns else smooth}")


def notes(command: FeedForward) -> list[str]:
    """Return lines about doubtful derivatives, dry friction, and a trajectory that does not begin or end at rest."""
    doubts = command.reference.doubts.items()
    lines = [line(command.left_out)] if command.left_out else []
    lines += [f"{name}: {why}" for name, (k, why) in doubts if k <= command.orders[name]]
    if command.following is not None and len(command.motors) > len(command.wanted):
        shared = dict.fromkeys(dependent_motors(command.machine), tuple(command.machine.motors))
        lines += line_on_undetermined(command.machine, shared)
    laws = [(joint.name, joint.friction) for joint in command.machine.motor_joints]
    lines += [f"{name} {JUMPS}" for name, law in laws if law.creep.is_zero and not law.coulomb.is_zero]
    for row, word, state in ((0, "begins", "started"), (-1, "ends", "stopped")):
        for name, order in command.orders.items():
            y = command.reference.y[name]
            moving = [k for k in range(1, order) if abs(y[k, row]) > IN_MOTION * np.abs(y[k]).max()]
            if moving:
                what = f"derivative {moving[0]} is not zero, so the machine is to be {state} by other means"
                lines.append(f"{name} {word} in motion: {what}")
    return lines


def save_feed_forward(command: FeedForward, path: str | Path) -> None:
    """Write t, q_<joint>, qd_<joint>, tau_<motor> to .csv or .npz for `read_measurements`. Raises `InputError`."""
    write_columns(command.arrays(), path)


# Deflections of springs with damping: tau q' + q = u, integrated along samples of u and its derivatives.
#
# Between two samples u is a cubic p, and with s the time since the first,
#
#     q(s) = (q(0) - r(0)) exp(-s/tau) + r(s),    r = p - tau p' + tau^2 p'' - tau^3 p''',
#
# which is exact and stable however small tau is; where tau is longer than a step the same integral is taken by Gauss's
# rule, since r is a difference of large numbers there.
def lagging(t: Array, u: Array, tau: float) -> Array:
    """Return q, the first-order lag of u with time constant tau, s, and its derivatives (orders, N) at times t (N,).

    The start is that of a motion that went on before, as far as the derivatives tell: q = u at rest.
    """
    starts = u[-1, 0] * np.ones(len(u))
    for k in range(len(u) - 2, -1, -1):
        starts[k] = u[k, 0] - tau * starts[k + 1]
    interpolate = for_vibrations("scipy.interpolate")
    cubics = [interpolate.CubicHermiteSpline(t, x, slope) for x, slope in pairwise(u)]
    cubics.append(interpolate.CubicSpline(t, u[-1]))
    return np.stack([_integrate(t, p.c[::-1], start, tau) for p, start in zip(cubics, starts, strict=True)])


def _integrate(t: Array, p: Array, start: float, tau: float) -> Array:
    h = np.diff(t)
    decay_factors = np.exp(-h / tau)
    gained = np.where(h > tau, _by_series(p, h, tau, decay_factors), _by_quadrature(p, h, tau))
    q = [start]
    for decay, gain in zip(decay_factors.tolist(), gained.tolist(), strict=True):
        q.append(decay * q[-1] + gain)
    return np.array(q)


def _by_series(p: Array, h: Array, tau: float, decay: Array) -> Array:
    """Return the lag's response to a cubic p over a step h by its particular solution r: r(h) - r(0) exp(-h/tau)."""
    r = p.copy()
    for k in (2, 1, 0):
        r[k] = p[k] - tau * (k + 1) * r[k + 1]
    return np.asarray(_value(r, h) - r[0] * decay)


def _by_quadrature(p: Array, h: Array, tau: float) -> Array:
    """Return the lag's response to a cubic p over a step h by quadrature of exp(-(h - s)/tau) p(s)/tau."""
    nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
    gained: Array = np.zeros_like(h)
    for node, weight in zip(nodes, weights, strict=True):
        s = h * (1 + node) / 2
        gained += weight * h / 2 / tau * np.exp(-(h - s) / tau) * _value(p, s)
    return gained


def _value(p: Array, s: Array) -> Array:
    return np.asarray(((p[3] * s + p[2]) * s + p[1]) * s + p[0])


@dataclass(frozen=True)
class LeftOut:
    """Omitted springs, by name: the largest deflection under the loads of the motion, rad or m.

    The deflection is that of a load that changes slowly. `frequency` is the lowest that these springs vibrate at, Hz,
    with all else held, at the start; None where there is none.
    """

    deflections: Mapping[str, float]
    units: Mapping[str, str]
    frequency: float | None


def with_springs_held(machine: Machine, names: list[str]) -> Machine:
    """Return the machine with the named springs locked at their neutral positions."""
    if not names:
        return machine
    return restrict(machine, Scene(locked={j.name: j.spring.neutral for j in machine.joints if j.name in names}))


def cost(machine: Machine, names: list[str], t: Array, q: Array, qd: Array) -> LeftOut | None:
    """Return the cost of omitting springs on a motion, t (N,), q and qd (N, n) of all moving joints."""
    if not names:
        return None
    motion = EquationsOfMotion(machine)
    rows = [motion.names.index(name) for name in names]
    qdd = np.gradient(qd, t, axis=0)
    places = np.unique(np.linspace(0, len(t) - 1, MOST_PLACES).astype(int))
    loads = np.array([motion.forces(q[k], qd[k], qdd[k])[rows] for k in places])
    stiffness = dict(zip(motion.springs, motion.spring_stiffnesses(q[0]), strict=True))
    bent = np.abs(loads).max(axis=0) / [stiffness[name] for name in names]
    units = {name: motion.joints[row].unit for name, row in zip(names, rows, strict=True)}
    return LeftOut(dict(zip(names, bent.tolist(), strict=True)), units, _frequency(machine, names, q[0], motion.names))


def _frequency(machine: Machine, names: list[str], start: Array, joints: list[str]) -> float | None:
    """Return the lowest frequency of springs with all other joints locked, Hz."""
    remaining = [j.name for j in machine.joints if j.kind is Kind.ELASTIC and j.name not in names]
    motion = EquationsOfMotion(with_springs_held(machine, remaining))
    motors = [motion.names[k] for k in motion.motors]
    at = {name: float(start[joints.index(name)]) for name in motors}
    try:
        state = equilibrium(motion, at)
        frequencies = modes(with_motors(linearize(motion, state, (), ()), motors)).frequencies
    except InputError:
        return None
    return float(frequencies[frequencies > 0].min()) if (frequencies > 0).any() else None


def line(cost: LeftOut) -> str:
    """Return a line on the omitted springs, their deflections and their frequency."""
    bent = ", ".join(f"{name} {x:.3g} {cost.units[name]}" for name, x in cost.deflections.items())
    sentence = "no motor controls these springs, so they are held at their neutral positions; the loads of this "
    sentence += f"motion would bend them by {bent}"
    return sentence if cost.frequency is None else f"{sentence}; they vibrate from {cost.frequency:.4g} Hz"
