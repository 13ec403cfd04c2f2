"""A simulated motion with its errors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from inspect import signature
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.compiled_steps import Trajectory
from symoro_elastic.analysis.simulation.observed import without_rates
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.analysis.vibration.beyond_limits import Beyond, beyond_limits, of_joints
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.limits import TORQUE
from symoro_elastic.machine.machine import Friction, Machine, Wrench
from symoro_elastic.numerics.motion.signals import JointSignal, entry_of, outputs
from symoro_elastic.numerics.verification.implementations import numpy_model

EXACT = "exact"
"""In the place of the method, where all motors follow exactly and nothing is integrated."""


@dataclass(frozen=True, repr=False)
class Simulation(Result):
    """A simulated motion: states with accelerations and torques, outputs (N, names), and their errors.

    `deviation` (N, names) are the outputs less those where motors follow exactly and springs stay; NaN for torques.
    `errors` are measured by halving the step, or by a smaller tolerance of an integrator with steps of its own;
    `tolerance` those that are allowed, by output; `predicted` those of the linear model, empty where none was made.
    `largest_step` is that of an explicit method, `followed` the frequency, Hz, above which vibrations are damped
    instead of followed. `operations` of a step are 0, and `crossings` found, where steps are adapted.
    """

    reference: Reference
    trajectory: Trajectory
    motion: Motion
    names: tuple[str, ...]
    outputs: Array
    deviation: Array
    errors: Mapping[str, float]
    tolerance: Mapping[str, float]
    predicted: Mapping[str, float]
    operations: int
    energy: EnergyBalance
    followed: float | None
    largest_step: float
    period: float | None = None
    crossings: tuple[Crossing, ...] = ()

    @property
    def is_within(self) -> bool:
        """Whether every measured error is within its tolerance."""
        return all(self.errors[name] <= limit for name, limit in self.tolerance.items())

    @property
    def is_exact(self) -> bool:
        """Whether all motors are exactly prescribed, without integration."""
        return self.trajectory.method == EXACT

    @property
    def beyond(self) -> tuple[Beyond, ...]:
        """Exceeded limits: of independent joints, of motors, and of motor torques."""
        machine, motion = self.reference.machine, self.motion
        y, yd = (dict(zip(self.reference.motors, x.T, strict=True)) for x in self.reference.of_motors(motion))
        by_quantity = dict(of_joints(machine.independent_joints, motion.q, motion.qd, motion.qdd))
        torques = dict(zip(self.reference.motors, motion.tau.T, strict=True))
        of_all = {"position": by_quantity["position"] | y, "velocity": by_quantity["velocity"] | yd, TORQUE: torques}
        return beyond_limits(machine, motion.t, by_quantity | of_all)

    @property
    def powers(self) -> Array:
        """Power (N, m) of the motors, W."""
        _, rates = self.reference.of_motors(self.motion)
        powers: Array = self.motion.tau * rates
        return powers

    @property
    def steps_of_period(self) -> int:
        """Number of steps in a period of the controller; 0 without a period."""
        return round(self.period / self.trajectory.step) if self.period else 0

    @property
    def headline(self) -> str:
        """Machine, motion, method and steps."""
        run = self.trajectory
        what = f"{self.motion.t[-1]:g} s by {run.steps} steps of {run.method}"
        if self.is_exact:
            what = f"{self.motion.t[-1]:g} s at {run.steps + 1} times, motors follow exactly"
        return f"Simulation of {self.reference.machine.name}: {self.reference.prescribed.place}, {what}"


class Simulations(Result, list[Simulation]):
    """The motions of a scene, simulated: a list with tables, plots and a data frame of all."""

    @property
    def headline(self) -> str:
        """Machine and motions."""
        name = self[0].reference.machine.name if self else "no machine"
        return f"Simulations of {name}: {', '.join(x.reference.prescribed.place for x in self) or 'none'}"


# Events of a motion: a joint reaches a position, or a velocity.
States = Callable[[Array], tuple[Array, Array]]
"""q, qd (N, n) at times (N,)."""
LOOKS = 9
"""Times within a step at which a level is looked for."""


@dataclass(frozen=True)
class Level:
    """A level of a joint's position or velocity: `signal` is its name, `k` the entry of q, `order` 0 or 1."""

    signal: str
    k: int
    order: int
    level: float

    def above(self, states: States, t: Array) -> Array:
        """Return the difference of the signal and its level at times (N,)."""
        return np.asarray(states(t)[self.order][:, self.k] - self.level)


@dataclass(frozen=True)
class Crossing:
    """A time, s, at which a signal crosses a level, upwards or downwards."""

    signal: str
    level: float
    t: float
    upwards: bool


def level_of(machine: Machine, signal: str, level: float) -> Level:
    """Return a level of a signal by its name; raises `InputError` for all but joint positions and velocities."""
    (source,) = outputs(machine, [signal])
    if not isinstance(source, JointSignal) or source.order > 1:
        name = machine.independent_joints[0].name
        what = f"{signal} is not a position or velocity of a joint: give {name}.q = X, or .qd"
        raise machine.error("--event", what)
    return Level(source.name, entry_of(machine, source), source.order, level)


class Watch:
    """Detector of level crossings in consecutive time intervals; touching a level is not a crossing."""

    def __init__(self, levels: Sequence[Level]) -> None:
        self.levels = levels
        self._last: dict[Level, tuple[float, float]] = {}

    def crossings(self, states: States, begins: float, ends: float) -> list[Crossing]:
        """Return the crossings between two times, in the order of time."""
        t = np.linspace(begins, ends, LOOKS)
        crossings = [crossing for level in self.levels for crossing in self._of(level, states, t)]
        return sorted(crossings, key=lambda crossing: crossing.t)

    def _of(self, level: Level, states: States, t: Array) -> Iterator[Crossing]:
        """Yield the crossings of a level between times; a signal at the level keeps its previous side."""
        for at, above in zip(t.tolist(), level.above(states, t).tolist(), strict=True):
            since, before = self._last.get(level, (at, above))
            if before * above < 0:
                search = for_vibrations("scipy.optimize").brentq
                t_crossing = search(lambda t: float(level.above(states, np.array([t]))[0]), since, at, xtol=1e-15)
                yield Crossing(level.signal, level.level, float(t_crossing), above > 0)
            if above:
                self._last[level] = at, above


# Energy balance: work of motors and forces, dissipation, stored energy, and the error.
FORMS = ("kinetic", "gravity", "elastic")
"""Forms of energy, in the order of the model `energy`."""


@dataclass(frozen=True)
class EnergyBalance:
    """Energies over a motion, J: work `put_in`, `dissipated` energy, and the increase of `stored` energy.

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
