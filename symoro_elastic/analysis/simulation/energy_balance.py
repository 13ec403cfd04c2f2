"""Energy balance of a simulated motion: work of motors and forces, dissipation, stored energy, and the error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from inspect import signature
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.observed import without_rates
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Friction, Machine, Wrench
from symoro_elastic.numerics.verification.implementations import numpy_model

FORMS = ("kinetic", "gravity", "elastic")
"""Forms of energy, in the order of the model `energy`."""


@dataclass(frozen=True)
class EnergyBalance:
    """Energies over a motion, J: `put_in` by motors and forces, `dissipated` by dampers and friction, `stored` more.

    `energies` (N, 3) are kinetic energy, that of gravity and that of springs at each time. `largest` is the largest
    kinetic and elastic energy meanwhile; `left_over` is what steps and samples lose or make.
    """

    put_in: float
    dissipated: float
    stored: float
    largest: float
    energies: Array

    @property
    def left_over(self) -> float:
        """Error of the balance: stored energy minus work plus dissipation."""
        return self.stored - self.put_in + self.dissipated


def energy_balance(reference: Reference, motion: Motion) -> EnergyBalance:
    """Return the balance of a motion, its powers integrated by Simpson's rule over the samples."""
    machine = reference.machine
    (energy,) = motion.results(numpy_model(machine, ("energy",)).energy)
    total = energy.sum(axis=1)
    simpson = for_vibrations("scipy.integrate").simpson
    undamped = (replace(j, spring=replace(j.spring, damping=ZERO), friction=Friction()) for j in machine.joints)
    lossless = replace(machine, joints=tuple(undamped))
    put_in = float(simpson(_power(reference, motion), x=motion.t))
    dissipated = 0.0 - float(simpson(_power_of(machine, lossless, motion), x=motion.t))
    moving = energy[:, 0] + energy[:, 2]
    return EnergyBalance(put_in, dissipated, float(total[-1] - total[0]), float(moving.max(initial=0.0)), energy)


def _power(reference: Reference, motion: Motion) -> Array:
    """Return the power (N,) of motors and forces, W."""
    machine = reference.machine
    _, rates = reference.of_motors(motion)
    unloaded = replace(machine, joints=tuple(replace(j, wrench=Wrench()) for j in machine.joints))
    of_forces = _power_of(reference.loaded, unloaded, motion) + (motion.f0 * motion.V0).sum(axis=1)
    return np.asarray((motion.tau * rates).sum(axis=1) + of_forces)


def _power_of(machine: Machine, other: Machine, motion: Motion) -> Array:
    """Return the power (N,) of the forces that a machine has and `other` lacks, qd^T A (qdd - qdd_other)."""
    if machine == other:
        return np.zeros(len(motion.t))
    model = numpy_model(machine, ("inertia_matrix", "direct_dynamics"))
    more = _accelerations(model.direct_dynamics, motion)
    more = more - _accelerations(numpy_model(other, ("direct_dynamics",)).direct_dynamics, motion)
    rates, (A,) = np.concatenate([motion.V0, motion.qd], axis=1), motion.results(model.inertia_matrix)
    return np.asarray(np.einsum("ti,tij,tj->t", rates, A, more))


def _accelerations(model: Callable[..., Any], motion: Motion) -> Array:
    """Return the accelerations (N, n) of the coordinates, those of the base first if they are results."""
    results = motion.results(model)
    blocks = without_rates(motion, results) if "z" in signature(model).parameters else results
    return np.concatenate(blocks[::-1], axis=1)
