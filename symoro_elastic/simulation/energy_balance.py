"""Balance of energy of a simulated motion: what motors and forces put in, what friction takes, what is left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.implementations import numpy_model
from symoro_elastic.numerics.values import given_values
from symoro_elastic.packages import for_vibrations
from symoro_elastic.simulation.observed import Motion


@dataclass(frozen=True)
class EnergyBalance:
    """Energies over a motion, J: `put_in` by motors, `dissipated` by dampers and friction, `stored` more at the end.

    `largest` is the largest kinetic and elastic energy meanwhile; `left_over` is what steps and samples lose or make.
    """

    put_in: float
    dissipated: float
    stored: float
    largest: float

    @property
    def left_over(self) -> float:
        """Stored less what came in and went out."""
        return self.stored - self.put_in + self.dissipated


def energy_balance(machine: Machine, motion: Motion) -> EnergyBalance:
    """Return the balance of a motion, its powers integrated by Simpson's rule over the samples."""
    energy = numpy_model(machine, ("energy",)).energy(motion.q, motion.qd)
    total = energy.sum(axis=1)
    simpson = for_vibrations("scipy.integrate").simpson
    motors = list(machine.motor_entries)
    put_in = float(simpson((motion.tau * motion.qd[:, motors]).sum(axis=1), x=motion.t))
    dissipated = float(simpson(_losses(machine, motion), x=motion.t))
    moving = energy[:, 0] + energy[:, 2]
    return EnergyBalance(put_in, dissipated, float(total[-1] - total[0]), float(moving.max(initial=0.0)))


def _losses(machine: Machine, motion: Motion) -> Array:
    """Return the power (N,) that dampers and friction take, W."""
    values = given_values(machine)
    lost = np.zeros(len(motion.t))
    for k, joint in enumerate(machine.moving_joints):
        rate = motion.qd[:, k]
        viscous = joint.spring.damping.value(values) + joint.friction.viscous.value(values)
        lost += viscous * rate**2 + joint.friction.coulomb.value(values) * np.abs(rate)
    return lost
