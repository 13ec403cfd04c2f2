"""A machine whose motors follow from loops, in its own coordinates and in those of its motors.

Reference motions are given in motor coordinates; the machine in the coordinates of its file keeps its closed forms.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.prescribed_motion import PrescribedMotion
from symoro_elastic.models.motor_coordinates import dependent_motors
from symoro_elastic.models.state import State
from symoro_elastic.numerics.closed_positions import JointCoordinates
from symoro_elastic.numerics.independent_joints import with_independent_motors
from symoro_elastic.numerics.motion.shared_motors import followers
from symoro_elastic.numerics.values import given_values


@dataclass(frozen=True)
class MotorCoordinates:
    """The joints of a machine from those of `other`, the same machine with independent motors."""

    machine: Machine
    other: Machine

    def positions(self, named: Mapping[str, float]) -> dict[str, float]:
        """Return positions of the independent joints of `other` by name, those of the machine being as `named`.

        Springs that are not named are neutral, other joints where loops start. Raises `InputError`.
        """
        q = np.array(
            [named.get(joint.name, x) for joint, x in zip(self.machine.independent_joints, self._usual, strict=True)]
        )
        found = JointCoordinates(self.machine, self.other.independent)(State({"q": q[None]}))[0][0]
        if not np.isfinite(found).all():
            at = ", ".join(f"{j.name}={x:g}" for j, x in zip(self.machine.independent_joints, q, strict=True))
            raise self.machine.error(f"loop {self._loops}", f"it does not close at {at}: start somewhere else")
        return dict(zip((joint.name for joint in self.other.independent_joints), found.tolist(), strict=True))

    def own(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return q, qd, qdd (3, N, n) of the machine at states (N, n) of `other`; NaN where a loop does not close."""
        return self._own(State({"q": q, "qd": qd, "qdd": qdd}))

    def forces(self, q: Array, torques: Array) -> Array:
        """Return S_m^T torques (n,) on the machine's coordinates at q (n,) (L3)."""
        found: Array = self._motors(State({"q": np.tile(q, (len(q), 1)), "qd": np.eye(len(q))}))[1] @ torques
        return found

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
