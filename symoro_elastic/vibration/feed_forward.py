"""Feed-forward: torques and motions of motors for a reference trajectory beyond the springs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.models.catalogue import trace
from symoro_elastic.numerics.implementations import numpy_model
from symoro_elastic.symbolic.expression import reachable
from symoro_elastic.symbolic.operations import SYMBOL
from symoro_elastic.time_series.writing import columns_of, write_columns
from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion
from symoro_elastic.vibration.reference_trajectory import ReferenceTrajectory

FEED_FORWARD = "feed_forward"
IN_MOTION = 1e-3  # of the largest value


@dataclass(frozen=True)
class FeedForward:
    """Feed-forward of all motors: t (N,) s, tau (N, m) of the motors, q and qd (N, n) of all moving joints.

    `reference` is the motion of what they drive, `orders` its derivatives that each motor needs; SI units, radians.
    """

    machine: Machine
    reference: ReferenceTrajectory
    orders: Mapping[str, int]
    q: Array
    qd: Array
    tau: Array

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


def orders(machine: Machine) -> dict[str, int]:
    """Return by motor how many derivatives of its reference trajectory the torques need. Raises `InputError`."""
    program = trace(machine, FEED_FORWARD).program
    nodes = reachable(x for output in program.outputs for x in output.entries)
    used, motors = {x.operands[0] for x in nodes if x.operation == SYMBOL}, machine.motor_joints
    return {
        joint.name: max((k for k, argument in enumerate(program.inputs) if argument.symbols[m] in used), default=0)
        for m, joint in enumerate(motors)
    }


def feed_forward(
    machine: Machine, reference: ReferenceTrajectory, values: Mapping[str, float] | None = None
) -> FeedForward:
    """Return the torques of motors for a reference trajectory, exact where springs have no damping.

    Raises `InputError` for a machine without feed-forward, and for a motion with too few derivatives.
    """
    valued = with_values(machine, values or {})
    needed = orders(valued)
    refuse_few(reference, needed, machine)
    parameters = EquationsOfMotion(valued).parameters
    model = numpy_model(valued, (FEED_FORWARD,))
    highest = max(needed.values(), default=0)
    arguments = np.zeros((highest + 1, len(reference.t), len(needed)))
    for m, (name, order) in enumerate(needed.items()):
        arguments[: order + 1, :, m] = reference.y[name][: order + 1]
    p = [model.parameters(**{p.name: parameters[p.name] for p in valued.parameters})] if valued.parameters else []
    tau, q, qd = (np.asarray(x) for x in model.feed_forward(*arguments, *p))
    return FeedForward(machine, reference, needed, q, qd, tau)


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
    """Return lines about doubtful derivatives, and about a trajectory that does not begin or end at rest."""
    doubts = command.reference.doubts.items()
    said = [f"{name}: {why}" for name, (k, why) in doubts if k <= command.orders[name]]
    for row, word, state in ((0, "begins", "started"), (-1, "ends", "stopped")):
        for name, order in command.orders.items():
            y = command.reference.y[name]
            moving = [k for k in range(1, order) if abs(y[k, row]) > IN_MOTION * np.abs(y[k]).max()]
            if moving:
                what = f"derivative {moving[0]} is not zero, so the machine is to be {state} by other means"
                said.append(f"{name} {word} in motion: {what}")
    return said


def figures(command: FeedForward) -> dict[str, Any]:
    """Return by motor: order needed and given, largest and rms torque, velocity, lead of the motor; notes."""
    q, qd = command.at_motors(command.q), command.at_motors(command.qd)
    motors = {}
    for m, name in enumerate(command.motors):
        tau = command.tau[:, m]
        motors[name] = {
            "order": command.orders[name],
            "given": command.reference.order(name),
            "torque": float(np.abs(tau).max()),
            "torque_rms": float(np.sqrt(np.mean(tau**2))),
            "velocity": float(np.abs(qd[:, m]).max()),
            "lead": float(np.abs(q[:, m] - command.reference.y[name][0]).max()),
        }
    return {
        "motion": command.reference.source, "duration": float(command.t[-1] - command.t[0]), "samples": len(command.t),
        "motors": motors, "notes": notes(command),
    }  # fmt: skip


def save_feed_forward(command: FeedForward, path: str | Path) -> None:
    """Write t, q_<joint>, qd_<joint>, tau_<motor> to .csv or .npz for `read_measurements`. Raises `InputError`."""
    joints = [joint.name for joint in command.machine.moving_joints]
    blocks = (("q", command.q, joints), ("qd", command.qd, joints), ("tau", command.tau, command.motors))
    write_columns(columns_of(command.t, *blocks), path)
