"""Motors on dependent joints: a machine in its own and in its motors' coordinates, and torques over time.

Reference motions are given in motor coordinates; the machine in the coordinates of its file keeps its closed forms.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.prescribed_motion import PrescribedMotion
from symoro_elastic.machine.restrict import with_held_joints
from symoro_elastic.models.bound.state import State
from symoro_elastic.models.loops.plan import lacks_closed_form
from symoro_elastic.models.steps.time_steps import dependent_motors
from symoro_elastic.numerics.evaluation.closed_positions import JointCoordinates
from symoro_elastic.numerics.evaluation.values import given_values
from symoro_elastic.numerics.motion.independent_joints import followers, with_independent_motors
from symoro_elastic.numerics.verification.implementations import numpy_model

PLACE = "drives, feed_forward, torque"


@dataclass(frozen=True)
class MotorCoordinates:
    """Map from the joints of `other`, a copy of a machine in which motors are independent, to those of the machine."""

    machine: Machine
    other: Machine

    def positions(self, named: Mapping[str, float]) -> dict[str, float]:
        """Return positions of the independent joints of `other` by name, from positions `named` of the machine.

        Springs that are not named are neutral, other joints where loops start. Raises `InputError`.
        """
        usual = zip(self.machine.independent_joints, self._usual, strict=True)
        q = np.array([named.get(joint.name, x) for joint, x in usual])
        q_other = JointCoordinates(self.machine, self.other.independent)(State({"q": q[None]}))[0][0]
        if not np.isfinite(q_other).all():
            at = ", ".join(f"{j.name}={x:g}" for j, x in zip(self.machine.independent_joints, q, strict=True))
            raise self.machine.error(f"loop {self._loops}", f"it does not close at {at}: start somewhere else")
        return dict(zip((joint.name for joint in self.other.independent_joints), q_other.tolist(), strict=True))

    def own(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return q, qd, qdd (3, N, n) of the machine at states (N, n) of `other`; NaN for an open loop."""
        return self._own(State({"q": q, "qd": qd, "qdd": qdd}))

    def forces(self, q: Array, torques: Array) -> Array:
        """Return generalized forces (n,) of motor torques at q (n,): S_m^T torques, S_m = d(motor rates)/dqd (L3)."""
        return np.asarray(self._motors(State({"q": np.tile(q, (len(q), 1)), "qd": np.eye(len(q))}))[1] @ torques)

    @cached_property
    def _own(self) -> JointCoordinates:
        return JointCoordinates(self.other, self.machine.independent)

    @cached_property
    def _motors(self) -> JointCoordinates:
        return JointCoordinates(self.machine, self.machine.motors)

    @property
    def _usual(self) -> list[float]:
        values = given_values(self.machine)
        start = {name: x.value(values) for loop in self.machine.loops for name, x in loop.start.items()}
        return [
            joint.spring.neutral.value(values) if joint.kind is Kind.ELASTIC else start.get(str(joint.variable), 0.0)
            for joint in self.machine.independent_joints
        ]

    @property
    def _loops(self) -> str:
        return ", ".join(loop.name for loop in self.machine.loops)


def with_motors_that_follow_exactly(machine: Machine, prescribed: PrescribedMotion) -> Machine:
    """Return the machine in coordinates in which all motors are independent.

    Raises `InputError` for motors that other motors move: their motions cannot all be prescribed.
    """
    if not dependent_motors(machine):
        return machine
    other = with_independent_motors(machine)
    for j, leaders in followers(other).items():
        names = ", ".join(other.joint(k).name for k in leaders)
        what = f"simulate: {names} moves it, so its motion cannot be prescribed too: give all motors servos"
        raise prescribed.error(f"servo, {other.joint(j).name}", what)
    return other


class InverseModelOfMotors:
    """Torques (N, m) of all motors along their set points, for a machine whose other joints stay at q (n,)."""

    def __init__(self, machine: Machine, q: Array) -> None:
        """Build the model; raises `InputError` for dependent motors, and for joints that cannot be locked."""
        if dependent_motors(machine):
            raise machine.error(PLACE, "motors follow from a loop: leave it out, or make them independent")
        if machine.bristles:
            raise machine.error(PLACE, "friction with states (bristle) is not in the inverse model of motors")
        joints, motors = machine.independent_joints, set(machine.motor_entries)
        locked = {joint.name: Formula.parse(x) for k, (joint, x) in enumerate(zip(joints, q.tolist(), strict=True))
                if k not in motors}  # fmt: skip
        try:
            stiff = with_held_joints(machine, locked, "locked")
        except InputError as error:
            what = f"{error.what}: the inverse model holds all joints but those of motors"
            raise machine.error(PLACE, what) from None
        if lacks_closed_form(stiff):
            raise machine.error(PLACE, "a loop has no closed form: leave it out")
        self._order = np.argsort(stiff.motor_entries)
        self._model: Any = numpy_model(stiff, ("inverse_dynamics",))

    def __call__(self, r: Array, rd: Array, rdd: Array) -> Array:
        """Return the torques (N, m) at set points and their rates (N, m)."""
        q, qd = r[:, self._order], rd[:, self._order]
        torques, *_ = State({"q": q, "qd": qd, "qdd_motor": rdd}).results(self._model.inverse_dynamics)
        return np.asarray(torques)
