"""Motions of motors to try predictions on: smooth moves from rest to rest, wobbles, and forces on frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.vibration.course import COEFFICIENTS
from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.vibration.equilibrium import equilibrium

RISE = np.polynomial.Polynomial([0, 0, 0, 0, *COEFFICIENTS])


@dataclass(frozen=True)
class Push:
    """A force along one component of the wrench on a frame, smooth in over `lasts` s from `begins`."""

    frame: str
    component: int
    force: float
    begins: float
    lasts: float


@dataclass
class Moved:
    """A reference: each motor by so much in the first `lasts` s of `duration`, or a wobble of so much at some Hz."""

    machine: Machine
    duration: float
    moves: Mapping[str, tuple[float, float]]
    at_start: Mapping[str, float] = field(default_factory=dict)
    servo: tuple[Array, Array] | None = None
    pushes: Sequence[Push] = ()

    def __post_init__(self) -> None:
        self.start: State = equilibrium(EquationsOfMotion(self.machine), self.at_start)
        self.pushed = tuple(push.frame for push in self.pushes)

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        motors = [joint.name for joint in self.machine.motor_joints]
        y = np.zeros((3, len(t), len(motors)))
        y[0] = self.start.q[list(self.machine.motor_entries)]
        for name, (by, lasts) in self.moves.items():
            for order in range(3):
                y[order, :, motors.index(name)] += by * risen(t / lasts, order) / lasts**order
        return y[0], y[1], y[2]

    def forces_at(self, t: Array) -> Array:
        wrenches = np.zeros((len(t), len(self.pushes), 6))
        for k, push in enumerate(self.pushes):
            wrenches[:, k, push.component] = push.force * risen((t - push.begins) / push.lasts, 0)
        return wrenches


def risen(x: Array, order: int) -> Array:
    """35 x^4 - 84 x^5 + 70 x^6 - 20 x^7, or a derivative of it; at rest before 0 and after 1."""
    inside = RISE.deriv(order)(np.clip(x, 0, 1)) if order else RISE(np.clip(x, 0, 1))
    return inside if order == 0 else np.where((x > 0) & (x < 1), inside, 0.0)
