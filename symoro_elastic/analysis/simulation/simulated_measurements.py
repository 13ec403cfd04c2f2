"""Simulated measurements: the direct model under a motor controller, and sensors with noise."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.time_series.measurements import Measurements
from symoro_elastic.codegen.integration.tableaus import RK4, step
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.machine.checks import require_fixed_base
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.loops.plan import lacks_closed_form
from symoro_elastic.numerics.evaluation.assembled_states import start_of
from symoro_elastic.numerics.verification.implementations import numpy_model

ReferenceMotion = Callable[[float], tuple[Array, Array, Array]]


@dataclass(frozen=True)
class Controller:
    """Controller of the motors along q_r, qd_r, qdd_r: tau = inertia qdd_r + kp (q_r - q) + kd (qd_r - qd), N m or N.

    Entries by motor: inertia in kg m2 (kg), kp in N m/rad (N/m), kd in N m s/rad (N s/m).
    """

    inertia: Array
    kp: Array
    kd: Array

    @classmethod
    def of_bandwidth(cls, inertia: Sequence[float], frequency: float, damping: float = 0.9) -> Controller:
        """Return gains that place the poles of motors of this inertia at a frequency in Hz."""
        moved, w = np.array(inertia, dtype=float), 2 * np.pi * frequency
        return cls(moved, moved * w**2, 2 * damping * moved * w)


@dataclass(frozen=True)
class Sensors:
    """Resolution of encoders by joint, standard deviation of their noise before rounding (rad or m), standard
    deviation of torque noise by motor (N m or N)."""

    resolution: Array
    jitter: Array
    torque_noise: Array


def simulate(
    machine: Machine,
    values: Mapping[str, float],
    reference: ReferenceMotion,
    controller: Controller,
    duration: float,
    sampling: float,
    substeps: int = 1,
    settle: float = 0.0,
    start: Array | None = None,
    progress: Progress = no_progress,
) -> Measurements:
    """Return motion and torques of a machine under control, sampled at `sampling` Hz for `duration` s.

    Integrated by RK4, `substeps` steps a sample; the first `settle` s are not recorded. `reference(t)` gives q, qd,
    qdd of the motors; `start` is the position at rest (0, or where loops start, unless given; motors on the
    reference). Raises `InputError` for bases that move freely, loops without closed form, motors that loops move.
    """
    _refuse(machine)
    model, motors = numpy_model(machine), list(machine.motor_entries)
    p = model.parameters(**values)
    n, h = len(machine.independent), 1 / (sampling * substeps)
    y = np.stack([start_of(machine).q if start is None else np.broadcast_to(start, n), np.zeros(n)])
    y[:, motors] = reference(0.0)[:2]

    def torque(t: float, q: Array, qd: Array) -> Array:
        wanted = reference(t)
        lag = controller.kp * (wanted[0] - q[motors]) + controller.kd * (wanted[1] - qd[motors])
        return controller.inertia * wanted[2] + lag

    def rate(t: float, y: Array) -> Array:
        return np.array([y[1], model.direct_dynamics(*y, torque(t, *y), p)])

    first, samples = round(settle * sampling), round((settle + duration) * sampling) + 1
    recorded = [np.zeros((samples, size)) for size in (n, n, len(motors))]
    for k in range(samples * substeps):
        t = k * h
        if k % substeps == 0:
            for block, x in zip(recorded, (*y, torque(t, *y)), strict=True):
                block[k // substeps] = x
            if k % (100 * substeps) == 0:
                progress(k // substeps, samples)
        y = step(RK4, rate, t, y, h)
    q, qd, tau = (block[first:] for block in recorded)
    return Measurements(np.arange(len(q)) / sampling, q, tau, qd=qd, source=f"simulated {machine.name}")


def _refuse(machine: Machine) -> None:
    require_fixed_base(machine, "simulation")
    if lacks_closed_form(machine):
        what = "its loops have no closed form, and loops are not assembled at each step here"
        raise machine.error("simulation", what)
    if set(machine.motors) & set(machine.dependent):
        raise machine.error("simulation", "motors moved by loops have no controller here: make them independent")


def measure(true: Measurements, sensors: Sensors, seed: int = 0) -> Measurements:
    """Return measurements of a true motion: positions in whole encoder steps, torques with white noise."""
    rng = np.random.default_rng(seed)
    resolution = sensors.resolution
    noisy = true.q + sensors.jitter * rng.standard_normal(true.q.shape)
    q = np.where(resolution > 0, np.round(noisy / np.where(resolution > 0, resolution, 1.0)) * resolution, noisy)
    tau = true.tau + sensors.torque_noise * rng.standard_normal(true.tau.shape)
    return Measurements(true.t, q, tau, source=true.source)
