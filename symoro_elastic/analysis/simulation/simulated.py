"""A simulated motion with its errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symoro_elastic.analysis.simulation.compiled_steps import Trajectory
from symoro_elastic.analysis.simulation.energy_balance import EnergyBalance
from symoro_elastic.analysis.simulation.events import Crossing
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.analysis.vibration.beyond_limits import Beyond, beyond_limits, of_joints
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.limits import TORQUE

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
        """Steps in a period of the controller; 0 without one."""
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
