"""Torques that drives feed forward: of the inverse model along the set points, springs as they are at the start."""

from __future__ import annotations

from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import with_held_joints
from symoro_elastic.models.loops.plan import lacks_closed_form
from symoro_elastic.models.motor_coordinates import dependent_motors
from symoro_elastic.models.state import State
from symoro_elastic.numerics.implementations import numpy_model

PLACE = "drives, feed_forward, torque"


class InverseModelOfMotors:
    """Torques (N, m) of all motors along their set points, at a machine whose other joints stay at q (n,)."""

    def __init__(self, machine: Machine, q: Array) -> None:
        """Raises `InputError` for motors that follow others, and for joints that cannot be held."""
        if dependent_motors(machine):
            raise machine.error(PLACE, "motors follow from a loop: leave it out, or make them independent")
        if machine.bristles:
            raise machine.error(PLACE, "friction with states (bristle) is not in the inverse model of motors")
        joints, motors = machine.independent_joints, set(machine.motor_entries)
        held = {one.name: Formula.parse(x) for k, (one, x) in enumerate(zip(joints, q.tolist(), strict=True))
                if k not in motors}  # fmt: skip
        try:
            stiff = with_held_joints(machine, held, "locked")
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
        found, *_ = State({"q": q, "qd": qd, "qdd_motor": rdd}).results(self._model.inverse_dynamics)
        torques: Array = found
        return torques
