"""Feed-forward: torques and motions of motors for a reference trajectory beyond the springs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.errors import InputError
from symoro_elastic.machine.checks import refuse_floating
from symoro_elastic.machine.machine import Joint, Machine
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.feed_forward import OverTime, deflection_symbol, motion_symbol, over_time
from symoro_elastic.models.feed_forward_checks import damping_of
from symoro_elastic.models.load_coordinates import chains, load_positions
from symoro_elastic.models.motor_coordinates import dependent_motors
from symoro_elastic.numerics.arrays import values_along
from symoro_elastic.numerics.loop_passages import refuse_lost
from symoro_elastic.quantities import HIGHEST_DERIVATIVE
from symoro_elastic.results import Part, Result, Titled
from symoro_elastic.scalar import Scalar
from symoro_elastic.sizes import refuse_numbers
from symoro_elastic.symbolic.differentiation import Differentiation
from symoro_elastic.symbolic.expression import reachable
from symoro_elastic.symbolic.operations import SYMBOL
from symoro_elastic.time_series.writing import columns_of, write_columns
from symoro_elastic.vibration.driven_joints import MotionOfMotors, followed, of_motors
from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion
from symoro_elastic.vibration.lag import lagging
from symoro_elastic.vibration.left_out import LeftOut, cost, held, left_out_springs, line
from symoro_elastic.vibration.reference_trajectory import ReferenceTrajectory
from symoro_elastic.vibration.shared_motors import undetermined

FEED_FORWARD = "feed_forward"
IN_MOTION = 1e-3  # of the largest value
JUMPS = "has dry friction, none at rest: its torque jumps where it starts, stops or reverses"


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
        names = [joint.name for joint in self.machine.moving_joints]
        return block[:, [names.index(name) for name in self.motors]]

    @property
    def headline(self) -> str:
        """Machine, motors and samples."""
        return f"FeedForward of {self.machine.name}: {len(self.motors)} motors, {len(self.t)} samples"

    def parts(self) -> list[Part]:
        """Return the table of motors, the samples, and notes."""
        from symoro_elastic.vibration.tables import feed_forward_table

        found = figures(self)
        samples = f"{found['duration']:.6g} s, {found['samples']} samples"
        return [Titled(feed_forward_table(self), f"{self.machine.name}: {found['motion']}"), samples, *found["notes"]]

    def as_json(self) -> dict[str, Any]:
        """Return orders, largest torques and notes as plain data."""
        return figures(self)

    def arrays(self) -> dict[str, Array]:
        """Return t, q_<joint>, qd_<joint>, tau_<motor>, a row a sample."""
        return columns(self)

    def columns(self) -> dict[str, Array]:
        """Return the same as `arrays`."""
        return self.arrays()

    @property
    def wanted(self) -> tuple[Joint, ...]:
        """The joints whose motion is wanted, that of the springs behind them with it."""
        return (self.followed or self.machine).motor_joints

    @property
    def velocities(self) -> Array:
        """Velocities (N, m) of the motors."""
        return self.at_motors(self.qd) if self.following is None else self.following.xd


def orders(machine: Machine) -> dict[str, int]:
    """Return by motor how many derivatives of its reference trajectory the torques need. Raises `InputError`."""
    refuse_floating(machine, "feed-forward")
    led = followed(machine)
    kept = held(led, left_out_springs(led))
    return _orders(kept, over_time(Bound(kept)))


def _refuse_large(machine: Machine, reference: ReferenceTrajectory) -> None:
    """Raise `InputError` where the motion of all joints and the derivatives of the motors' have no room."""
    each = 3 * len(machine.moving) + sum(len(rows) + 1 for rows in reference.y.values())
    what = f"{len(reference.t)} samples of {len(machine.moving)} joints"
    refuse_numbers(each * len(reference.t), what, reference.source, "t", "give fewer, or a lower --rate")


def _orders(machine: Machine, solved: OverTime) -> dict[str, int]:
    used = {x.operands[0] for x in reachable(_roots(solved)) if x.operation == SYMBOL}
    highest = range(HIGHEST_DERIVATIVE + 1)
    return {
        machine.joint(j).name: max((k for k in highest if motion_symbol(j, k) in used), default=0)
        for j in machine.motors
    }


def _roots(solved: OverTime) -> list[Scalar]:
    lagging = [x for derivatives in solved.lagging.values() for x in derivatives]
    return [*lagging, *solved.tau.values(), *solved.q.values(), *solved.qd.values()]


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
    led = followed(valued)
    found = _feed_forward(led, reference)
    if led.motors == valued.motors:
        return found
    motors = of_motors(valued, led, found.t, found.q, found.qd, found.tau)
    return replace(found, machine=valued, tau=motors.tau, followed=led, following=motors)


def _feed_forward(valued: Machine, reference: ReferenceTrajectory) -> FeedForward:
    """Return the torques of motors that all own independent variables."""
    parameters = EquationsOfMotion(valued).parameters
    omitted = left_out_springs(valued)
    kept = held(valued, omitted)
    solved = over_time(bound := Bound(kept))
    needed = _orders(kept, solved)
    refuse_few(reference, needed, valued)
    _refuse_large(valued, reference)
    symbols: dict[str, Any] = {p.name: parameters[p.name] for p in kept.parameters}
    for j in kept.motors:
        name = kept.joint(j).name
        symbols |= {motion_symbol(j, k): reference.y[name][k] for k in range(needed[name] + 1)}
    for j, undamped in solved.lagging.items():
        lag = damping_of(bound, j) / bound.cell(bound.machine.joint(j).spring.stiffness)
        (tau,) = values_along([lag], symbols, 1)[0]
        deflection = lagging(reference.t, values_along(undamped, symbols, len(reference.t)), float(tau))
        symbols |= {deflection_symbol(j, k): x for k, x in enumerate(deflection)}
    return _assembled(valued, reference, needed, solved, symbols, omitted, bound)


def _assembled(
    valued: Machine,
    reference: ReferenceTrajectory,
    needed: Mapping[str, int],
    solved: OverTime,
    symbols: Mapping[str, Any],
    omitted: list[str],
    bound: Bound,
) -> FeedForward:
    """Return torques and motion of all joints; those left out are at rest."""
    N, motion = len(reference.t), EquationsOfMotion(valued)
    q, qd = np.tile(motion.neutral_positions(), (N, 1)), np.zeros((N, len(motion.joints)))
    columns = [valued.moving.index(j) for j in solved.q]
    q[:, columns], qd[:, columns] = (values_along(list(x.values()), symbols, N).T for x in (solved.q, solved.qd))
    tau = values_along([solved.tau[j] for j in valued.motors], symbols, N).T
    joints = [joint.name for joint in motion.joints]
    _refuse_without_value(reference, joints, q)
    refuse_lost(valued, "feed-forward", reference.t, q)
    _refuse_without_value(reference, [*joints, *(valued.joint(j).name for j in valued.motors)], np.hstack([qd, tau]))
    parameters = {p.name: symbols[p.name] for p in bound.machine.parameters}
    motors = {j: q[:, valued.moving.index(j)] for j in valued.motors}
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
        what = "no position was found that fulfils the loops and balances the springs: give a slower or shorter motion"
        raise InputError(reference.source, place, what)


def _lead(bound: Bound, parameters: Mapping[str, Any], q: Mapping[int, Array], y: Mapping[int, Array]) -> Array:
    """Return (N, m) how far motors at q (N,) are ahead of the motion y (N,) of their loads, without deflections."""
    positions = load_positions(bound, chains(bound))
    variables = {name: q.get(j, 0.0) for name, j in bound.machine.variables.items()}
    columns = []
    for j, z in positions.items():
        gear = Differentiation([z]).by(bound.q[j]).of(z)
        placed, turned = values_along([z, gear], {**parameters, **variables}, len(y[j]))
        columns.append((placed - y[j]) / turned)
    return np.stack(columns, axis=1)


def starts(machine: Machine) -> dict[str, float]:
    """Return by motor where its load is at the start of the machine's loops, rad or m; 0 where no loop has one."""
    if not machine.loops:
        return {}
    led = followed(machine)
    motion = EquationsOfMotion(led)
    bound = Bound(held(led, left_out_springs(led)))
    variables = dict(zip((str(joint.variable) for joint in motion.joints), motion.position_of_loops(), strict=True))
    positions = load_positions(bound, chains(bound))
    found = values_along(list(positions.values()), {**motion.parameters, **variables}, 1)
    return {led.joint(j).name: float(x) for j, (x,) in zip(positions, found, strict=True)}


def refuse_few(reference: ReferenceTrajectory, needed: Mapping[str, int], machine: Machine) -> None:
    """Raise `InputError` for a motor whose reference trajectory is not given, or with too few derivatives."""
    for name, order in needed.items():
        if name not in reference.y:
            raise InputError(reference.source, f"y_{name}", f"missing: motor {name} of {machine.name} needs a motion")
        given = reference.order(name)
        if given < order:
            smooth = f"a spline of degree {order} or more (--degree {order + 1}: smooth torques)"
            lacking = f"columns up to {reference.columns}{'d' * order}_{name}, or positions alone and {smooth}"
            why = f" ({reference.doubts[name][1]})" if reference.columns and name in reference.doubts else ""
            what = f"{given} derivatives of its motion are given{why}, {FEED_FORWARD} needs {order}"
            raise InputError(reference.source, name, f"{what}: give {lacking if reference.columns else smooth}")


def notes(command: FeedForward) -> list[str]:
    """Return lines about doubtful derivatives, dry friction, and a trajectory that does not begin or end at rest."""
    doubts = command.reference.doubts.items()
    said = [line(command.left_out)] if command.left_out else []
    said += [f"{name}: {why}" for name, (k, why) in doubts if k <= command.orders[name]]
    said += _shared(command)
    said += [f"{name} {JUMPS}" for name in _with_dry_friction(command.machine)]
    for row, word, state in ((0, "begins", "started"), (-1, "ends", "stopped")):
        for name, order in command.orders.items():
            y = command.reference.y[name]
            moving = [k for k in range(1, order) if abs(y[k, row]) > IN_MOTION * np.abs(y[k]).max()]
            if moving:
                what = f"derivative {moving[0]} is not zero, so the machine is to be {state} by other means"
                said.append(f"{name} {word} in motion: {what}")
    return said


def _shared(command: FeedForward) -> list[str]:
    """Return a line on more motors than joints whose motion is wanted, where no file shares out their torques."""
    if command.following is None or len(command.motors) == len(command.wanted):
        return []
    return undetermined(command.machine, {j: tuple(command.machine.motors) for j in dependent_motors(command.machine)})


def _with_dry_friction(machine: Machine) -> list[str]:
    """Return the motors that have dry friction that jumps."""
    laws = ((joint.name, joint.friction) for joint in machine.motor_joints)
    return [name for name, law in laws if law.creep.is_zero and not law.coulomb.is_zero]


def figures(command: FeedForward) -> dict[str, Any]:
    """Return by motor: order needed and given, largest and rms torque, velocity, lead of the motor; notes."""
    wanted = [joint.name for joint in command.wanted]
    motors: dict[str, dict[str, float]] = {}
    for m, name in enumerate(command.motors):
        tau = command.tau[:, m]
        own = command.following is None
        motors[name] = {
            **(_derivatives(command, name) if own else {}),
            "torque": float(np.abs(tau).max()),
            "torque_rms": float(np.sqrt(np.mean(tau**2))),
            "velocity": float(np.abs(command.velocities[:, m]).max()),
            **({"lead": float(np.abs(command.lead[:, m]).max())} if own else {}),
        }
    joints = {name: _derivatives(command, name) for name in wanted} if command.following else {}
    return {
        "motion": command.reference.source, "duration": float(command.t[-1] - command.t[0]), "samples": len(command.t),
        "motors": motors, **({"joints": joints} if joints else {}),
        "left_out": _left_out(command), "notes": notes(command),
    }  # fmt: skip


def _derivatives(command: FeedForward, name: str) -> dict[str, float]:
    """Return how many derivatives of the wanted motion of a joint are needed and given."""
    return {"order": command.orders[name], "given": command.reference.order(name)}


def _left_out(command: FeedForward) -> dict[str, Any] | None:
    """Return the largest deflections of springs that are left out, rad or m, and their lowest frequency, Hz."""
    found = command.left_out
    return {"deflections": dict(found.deflections), "frequency": found.frequency} if found else None


def save_feed_forward(command: FeedForward, path: str | Path) -> None:
    """Write t, q_<joint>, qd_<joint>, tau_<motor> to .csv or .npz for `read_measurements`. Raises `InputError`."""
    write_columns(columns(command), path)


def columns(command: FeedForward) -> dict[str, Array]:
    """Return t, q_<joint>, qd_<joint>, tau_<motor>, a row a sample."""
    joints = [joint.name for joint in command.machine.moving_joints]
    blocks = [("q", command.q, joints), ("qd", command.qd, joints), ("tau", command.tau, command.motors)]
    if command.following:
        own = [name not in joints for name in command.motors]
        names = [name for name in command.motors if name not in joints]
        blocks[2:2] = [("q", command.following.x[:, own], names), ("qd", command.following.xd[:, own], names)]
    return columns_of(command.t, *blocks)
