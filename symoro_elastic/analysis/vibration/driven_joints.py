"""Feed-forward for motors on dependent joints: the motion of the independent joints is prescribed, as of a platform.

A machine with motors at the independent joints in place of those that follow needs forces Gamma_u there; the motors
themselves exert S_m^T tau (L3).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.models.bound.state import State
from symoro_elastic.models.loops.plan import lacks_closed_form
from symoro_elastic.models.steps.time_steps import dependent_motors
from symoro_elastic.models.tree.once import once_for_each_machine
from symoro_elastic.numerics.evaluation.closed_positions import JointCoordinates
from symoro_elastic.numerics.evaluation.values import given_values
from symoro_elastic.numerics.motion.independent_joints import share_torques, shares, with_independent_motors

ADVICE = "choose other dependent joints (dependent = [...]), or simulate the motion under servos"
DETERMINED = 1e-9
"""Of the largest singular value of S_m, of the rates of motors: below, motors do not move by themselves."""


@dataclass(frozen=True)
class MotionOfMotors:
    """Positions x and velocities xd (N, m) of all motors, and their torques tau (N, m), SI units."""

    x: Array
    xd: Array
    tau: Array


@once_for_each_machine
def with_motors_on_load_joints(machine: Machine) -> Machine:
    """Return the machine in which the joints with a prescribed motion are motors.

    They are its motors where these are independent, or get so with closed forms; else the independent joints but
    springs. Raises `InputError` where loops then have no closed form.
    """
    motors = dependent_motors(machine)
    if not motors:
        return machine
    other = with_independent_motors(machine)
    if not dependent_motors(other) and not lacks_closed_form(other):
        return other
    if lacks_closed_form(machine):
        names = ", ".join(machine.joint(j).name for j in motors)
        what = "its motor follows from a loop without closed form, whose derivatives by time are not known"
        raise machine.error(f"joint {names}", f"feed-forward: {what}: {ADVICE}")
    led = [j for j in machine.independent if machine.joint(j).kind is Kind.PASSIVE]
    kinds = dict.fromkeys(motors, Kind.PASSIVE) | dict.fromkeys(led, Kind.MOTOR)
    rows = enumerate(machine.joints, 1)
    joints = tuple(replace(row, kind=kinds[j], sharing=ZERO) if j in kinds else row for j, row in rows)
    named = [tuple(machine.joint(j).name for j in machine.dependent_in(loop)) for loop in machine.loops]
    loops = tuple(replace(loop, dependent=names) for loop, names in zip(machine.loops, named, strict=True))
    return replace(machine, joints=joints, loops=loops)


def of_motors(machine: Machine, led: Machine, t: Array, q: Array, qd: Array, forces: Array) -> MotionOfMotors:
    """Return positions, velocities and torques of motors equivalent to `forces` (N, k) at prescribed joints of `led`.

    q, qd are states (N, n) at times t (N,). Torques of more motors than freedoms are weighed by `sharing` (L31). Raises
    `InputError` where motors cannot exert just these.
    """
    motion = JointCoordinates(machine, machine.motors)
    n, heads = q.shape[1], list(led.motor_entries)
    x, xd = motion(State({"q": q, "qd": qd}))
    places, rates = np.repeat(q, n, axis=0), np.tile(np.eye(n), (len(q), 1))
    S_m = motion(State({"q": places, "qd": rates}))[1].reshape(len(q), n, -1).swapaxes(1, 2)
    _refuse_springs(machine, S_m, heads)
    S_m = S_m[:, :, heads]
    _refuse_singular(machine, led, t, S_m)
    if S_m.shape[1] == S_m.shape[2]:
        return MotionOfMotors(x, xd, np.linalg.solve(S_m.swapaxes(1, 2), forces[..., None])[..., 0])
    share = shares(machine, given_values(machine))
    tau = [share_torques(S, Gamma, share) for S, Gamma in zip(S_m, forces, strict=True)]
    return MotionOfMotors(x, xd, np.array(tau))


def _refuse_springs(machine: Machine, S_m: Array, heads: list[int]) -> None:
    """Raise `InputError` for a spring that motors on dependent joints act on, S_m (N, m, n)."""
    largest = np.abs(S_m).max()
    for k in sorted(set(range(S_m.shape[2])).difference(heads)):
        if np.abs(S_m[:, :, k]).max() > DETERMINED * largest:
            name = machine.independent_joints[k].name
            what = "feed-forward: motors on dependent joints act on this spring itself: lock it in a scene, or choose "
            raise machine.error(f"joint {name}", what + "other dependent joints (dependent = [...])")


def _refuse_singular(machine: Machine, led: Machine, t: Array, S_m: Array) -> None:
    """Raise `InputError` if motors do not move every joint with a prescribed motion, S_m (N, m, k)."""
    names = ", ".join(joint.name for joint in led.motor_joints)
    motors, joints = S_m.shape[1:]
    if motors < joints:
        what = f"feed-forward: {motors} motors cannot prescribe the motion of {joints} joints: lock some in a scene"
        raise machine.error(f"joints {names}", what)
    sizes = np.linalg.svd(np.nan_to_num(S_m, posinf=0.0, neginf=0.0), compute_uv=False)
    singular = ~(sizes[:, -1] > DETERMINED * sizes[:, 0])
    if singular.any():
        when = f"feed-forward: at {t[np.argmax(singular)]:.4g} s the motors do not act on all of them"
        raise machine.error(f"joints {names}", f"{when}: give a motion that keeps away from this singular position")
