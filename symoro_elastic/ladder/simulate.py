"""Motions simulated with steps that are predicted to suffice; their error is measured by halving the step."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from symoro_elastic.array_types import Array, ComplexArray
from symoro_elastic.errors import InputError
from symoro_elastic.integration.methods import METHODS, Method
from symoro_elastic.integration.rosenbrock import RODAS4
from symoro_elastic.integration.tableaus import Tableau
from symoro_elastic.ladder.path import LinearPath, linear_path
from symoro_elastic.ladder.spring_errors import Deviations
from symoro_elastic.ladder.stability import damped_above, largest_stable_step, poles
from symoro_elastic.ladder.step_error import StepErrors, fewest_steps
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.implicit_steps import Motors
from symoro_elastic.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.simulation.compiled_steps import CompiledSteps, Trajectory
from symoro_elastic.simulation.energy_balance import EnergyBalance, energy_balance
from symoro_elastic.simulation.observed import Motion, Observer
from symoro_elastic.simulation.reference import Reference
from symoro_elastic.simulation.step_cost import StepCost

SHARE = 0.25
"""Of the tolerance that a step may take."""
USUAL = 1e-3
"""Of the largest deflection: the tolerance where none is given."""
LEAST = 1e-12
REFINEMENTS = 6
MOST_STEPS, MOST_PREDICTED = 100_000_000, 20_000
CANDIDATES = ("rk4", "w2", "w3")
SLOW = 1e-6
"""Seconds that a step takes about, to say how long many of them would."""


@dataclass(frozen=True)
class Simulation:
    """A simulated motion: states with accelerations and torques, outputs (N, names), and what is known of its error.

    `errors` are measured by halving the step, `tolerance` those that are allowed, by output; `predicted` the steps
    and errors of the linear model, empty where none was made. `largest_step` is that of an explicit method, `followed`
    the frequency, Hz, above which vibrations are damped instead of followed.
    """

    reference: Reference
    trajectory: Trajectory
    motion: Motion
    names: tuple[str, ...]
    outputs: Array
    errors: Mapping[str, float]
    tolerance: Mapping[str, float]
    predicted: Mapping[str, float]
    operations: int
    energy: EnergyBalance
    followed: float | None
    largest_step: float

    @property
    def is_within(self) -> bool:
        """Whether every measured error is within its tolerance."""
        return all(self.errors[name] <= limit for name, limit in self.tolerance.items())


@dataclass(frozen=True)
class Request:
    """How to simulate: outputs and tolerances by name, method and step where they are given, a period for steps."""

    outputs: tuple[str, ...] = ()
    tolerance: Mapping[str, float] | None = None
    method: str | None = None
    step: float | None = None
    period: float | None = None


class Simulating:
    """One motion of a machine, simulated by steps that suffice."""

    def __init__(
        self, reference: Reference, request: Request, linear: tuple[LinearPath, tuple[int, ...]] | None = None
    ) -> None:
        """`linear` is the linear model of a machine with more springs, and the entries of q that are left out."""
        self.reference, self.request, self._linear = reference, request, linear
        self.machine: Machine = reference.machine
        joints = tuple(f"{joint.name}.q" for joint in self.machine.moving_joints)
        self.names = request.outputs or tuple(request.tolerance or ()) or joints
        self.observer = Observer(self.machine, reference, self.names)

    @property
    def path(self) -> LinearPath:
        """The linear model along the motion."""
        return self.linear[0]

    @cached_property
    def linear(self) -> tuple[LinearPath, tuple[int, ...]]:
        """The linear model along the motion, and the springs in it that are left out."""
        return self._linear or (linear_path(self.reference, self.names), ())

    @cached_property
    def tolerance(self) -> dict[str, float]:
        """Tolerances by output: those that are given, else a thousandth of how far it is from the reference."""
        if self.request.tolerance:
            return dict(self.request.tolerance)
        largest = np.abs(Deviations(self.path).outputs).max(axis=0)
        return {name: max(USUAL * float(x), LEAST) for name, x in zip(self.names, largest, strict=True)}

    @cached_property
    def step_errors(self) -> StepErrors:
        """Errors of methods on the linear model."""
        return StepErrors(*self.linear)

    @cached_property
    def poles(self) -> ComplexArray:
        """Poles along the motion, rad/s."""
        return poles(*self.linear)

    def steps_of(self, method: Method) -> tuple[int, Mapping[str, float]]:
        """Return the steps that suffice for a method by prediction, and the errors predicted."""
        return enough_steps(self, method, self.tolerance)

    def stable_steps(self, method: Method) -> int:
        """Return the fewest steps that an explicit method bears."""
        return math.ceil(self.reference.duration / self.largest_step(method)) if isinstance(method, Tableau) else 1

    def largest_step(self, method: Method) -> float:
        """Return the largest step, s, with which an explicit method is stable along the motion; infinite for others."""
        return largest_stable_step(method, self.poles) if isinstance(method, Tableau) else math.inf

    def in_periods(self, steps: int) -> int:
        """Return at least as many steps, a whole number of them in each period."""
        if self.request.period is None:
            return steps
        periods = max(1, round(self.reference.duration / self.request.period))
        return periods * -(-steps // periods)

    @cached_property
    def cost(self) -> StepCost:
        """Operations of steps."""
        return StepCost(self.machine, Motors.DRIVEN if self.reference.servo is None else Motors.SERVO)

    def cheapest(self) -> str:
        """Return the method whose steps suffice with the fewest operations."""
        return min(self.candidates(), key=lambda name: self.steps_of(METHODS[name])[0] * self.cost.of(METHODS[name]))

    def candidates(self) -> list[str]:
        """Return the methods to choose from: those with exact derivatives need servos."""
        return list(CANDIDATES if self.reference.servo is None else (*CANDIDATES, RODAS4.name))

    def refuse_unstable(self, method: Method, step: float) -> None:
        """Raise `InputError` for steps that an explicit method does not bear."""
        largest = self.largest_step(method)
        if step > largest:
            what = f"{step:g} s is beyond the limit of {method.name} here: give at most {largest:.3g} s, or w3, w2"
            raise InputError(self.machine.label, "--step", what)

    def refuse_many(self, steps: float) -> None:
        """Raise `InputError` for more steps than are carried out."""
        if steps > MOST_STEPS:
            hours = steps * SLOW / 3600
            what = (
                f"{steps:.3g} steps, some {hours:.2g} h of work: {MOST_STEPS:.0e} are the most, so give at least "
                f"{self.reference.duration / MOST_STEPS:.3g} s"
            )
            raise InputError(self.machine.label, "--step", what)


def enough_steps(
    simulating: Simulating, method: Method, tolerance: Mapping[str, float], share: float = SHARE
) -> tuple[int, Mapping[str, float]]:
    """Return the steps of a method whose predicted errors are at most a share of the tolerances, and these errors."""
    least = simulating.stable_steps(method)
    choice = fewest_steps(simulating.step_errors, method, tolerance, share, least)
    steps = simulating.in_periods(choice.steps)
    if steps == choice.steps or not choice.is_tried:
        return steps, choice.errors
    return steps, simulating.step_errors.errors(method, steps)


def simulate(
    reference: Reference,
    request: Request,
    announce: Announce = announce_nothing,
    progress: Progress = no_progress,
) -> Simulation:
    """Return a motion simulated by compiled steps of even size, refined until its measured errors are tolerable.

    Method and step are predicted where they are not given. Raises `InputError`, `CompilerMissing`, `CompilationFailed`.
    """
    simulating = Simulating(reference, request)
    announce("predict")
    name = request.method or simulating.cheapest()
    steps, predicted = _steps(simulating, METHODS[name])
    announce("compile")
    with TemporaryDirectory() as folder:
        compiled = CompiledSteps(reference.machine, [name], Path(folder))
        announce("simulate")
        return _refined(simulating, compiled, name, steps, predicted, progress)


def _steps(simulating: Simulating, method: Method) -> tuple[int, Mapping[str, float]]:
    """Return the first number of steps, and the errors predicted for it."""
    step, duration = simulating.request.step, simulating.reference.duration
    if step is None:
        steps, predicted = simulating.steps_of(method)
        simulating.refuse_many(steps)
        return steps, predicted
    if not 0 < step < math.inf:
        raise InputError(simulating.machine.label, "--step", f"{step:g} s is no time: give a positive number")
    simulating.refuse_many(duration / step)
    simulating.refuse_unstable(method, step)
    steps = max(1, round(duration / step))
    return steps, simulating.step_errors.errors(method, steps) if steps <= MOST_PREDICTED else {}


def _refined(
    simulating: Simulating,
    compiled: CompiledSteps,
    name: str,
    steps: int,
    predicted: Mapping[str, float],
    progress: Progress,
) -> Simulation:
    """Return the motion with a step that is halved until the measured errors are tolerable, or given."""
    reference, method = simulating.reference, METHODS[name]
    coarse = _run(simulating, compiled, name, steps, progress)
    for _ in range(REFINEMENTS):
        fine = _run(simulating, compiled, name, 2 * coarse[0].steps, progress)
        errors = _errors(simulating, method, coarse, fine)
        if simulating.request.step or all(errors[x] <= limit for x, limit in simulating.tolerance.items()):
            break
        coarse = fine
    trajectory, motion, outputs = coarse
    return Simulation(
        reference,
        trajectory,
        motion,
        simulating.names,
        outputs,
        errors,
        simulating.tolerance,
        predicted,
        simulating.cost.of(method),
        energy_balance(reference.machine, motion),
        damped_above(method, trajectory.step),
        simulating.largest_step(method),
    )


Run = tuple[Trajectory, Motion, Array]


def _run(simulating: Simulating, compiled: CompiledSteps, name: str, steps: int, progress: Progress) -> Run:
    trajectory = compiled.run(simulating.reference, name, steps, progress)
    _refuse_infinite(simulating, trajectory)
    motion = simulating.observer.motion(trajectory)
    return trajectory, motion, simulating.observer.outputs(motion)


def _refuse_infinite(simulating: Simulating, trajectory: Trajectory) -> None:
    finite = np.isfinite(trajectory.q).all(axis=1) & np.isfinite(trajectory.qd).all(axis=1)
    if not finite.all():
        first = trajectory.t[int(np.argmin(finite))]
        what = (
            f"the motion grows out of range at {first:.4g} s with steps of {trajectory.step:.3g} s: give shorter ones"
        )
        raise InputError(simulating.machine.label, "--step", what)


def _errors(simulating: Simulating, method: Method, coarse: Run, fine: Run) -> dict[str, float]:
    """Return the errors of the coarse run by output: its distance from the fine one, extrapolated by the order."""
    both = np.isin(np.round(fine[0].t / fine[0].step).astype(np.int64) % 2, 0)
    common = fine[2][both]
    there = min(len(common), len(coarse[2]))
    apart = np.abs(common[:there] - coarse[2][:there]).max(axis=0)
    factor = 2**method.order / (2**method.order - 1)
    return dict(zip(simulating.names, (factor * apart).tolist(), strict=True))
