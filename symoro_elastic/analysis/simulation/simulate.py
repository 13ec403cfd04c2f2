"""Motions simulated with steps that are predicted to suffice; their error is measured by halving the step."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from symoro_elastic.analysis.control.cascade import FirstOrder
from symoro_elastic.analysis.simulation.compiled_steps import (
    CompiledSteps,
    Trajectory,
    refuse_lost_loops,
    refuse_sampled,
    refuse_still,
    refuse_turned,
    ways_of,
)
from symoro_elastic.analysis.simulation.energy_balance import energy_balance
from symoro_elastic.analysis.simulation.observed import Observer
from symoro_elastic.analysis.simulation.periods import WHOLE, is_whole, part_from, part_of, rounded_down
from symoro_elastic.analysis.simulation.prediction.path import LinearPath, linear_path
from symoro_elastic.analysis.simulation.prediction.resolution import (
    SLOW,
    in_detail,
    path_if_resolved,
    refuse_unresolved,
)
from symoro_elastic.analysis.simulation.prediction.spring_errors import Deviations, relative
from symoro_elastic.analysis.simulation.prediction.stability import PLACES, damped_above, largest_stable_step, poles
from symoro_elastic.analysis.simulation.prediction.step_error import StepErrors, fewest_steps
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.analysis.simulation.sampled_drives import Sampling
from symoro_elastic.analysis.simulation.sampled_steps import compiled_steps, is_sampled
from symoro_elastic.analysis.simulation.simulated import Simulation
from symoro_elastic.codegen.integration.methods import METHODS, Method, Midpoint, share_of_halving
from symoro_elastic.codegen.integration.rosenbrock import Rosenbrock
from symoro_elastic.codegen.integration.tableaus import Tableau
from symoro_elastic.codegen.integration.w_methods import W3
from symoro_elastic.foundation.array_types import AnyArray, Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.machine.described import between_samples
from symoro_elastic.machine.free_base import COORDINATES
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import names_to_fold
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.base_steps import base_models
from symoro_elastic.models.catalogue import trace
from symoro_elastic.models.drives.closed_dynamics import closed_dynamics
from symoro_elastic.models.drives.drive_states import state_names
from symoro_elastic.models.implicit_steps import Motors, implicit_system
from symoro_elastic.models.motor_coordinates import dependent_motors, motor_coordinates
from symoro_elastic.models.passed_torques import passed_torques
from symoro_elastic.models.time_steps import WITHOUT_STATES, refuse_machines
from symoro_elastic.quantities.time_steps import TimeStep
from symoro_elastic.symbolic.program import OperationCount, Program

DIVISION, SINE = 5, 15
"""Products that take about as long as a division, and as a sine and a cosine."""

SUBSTITUTIONS = 4
"""Of the loads that friction rises with, in a stage of a step: their mean."""
SHARE = 0.25
"""Of the tolerance that a step may take."""
USUAL = 1e-3
"""Of the largest deflection: the tolerance where none is given."""
LEAST = 1e-12
FIRST, REFINEMENTS = 200, 8
"""Steps that are tried where nothing is predicted, and how often they are made shorter."""
MARGIN, MOST_AT_ONCE = 1.1, 16.0
"""Steps more than the order of a method asks for, and times as many at most."""
MOST_STEPS, MOST_PREDICTED = 100_000_000, 20_000
CANDIDATES = (TimeStep.RK4, TimeStep.W2, TimeStep.W3, TimeStep.RODAS4)


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
        self.names = request.outputs or tuple(request.tolerance or ()) or _free_joints(reference)

    @cached_property
    def observer(self) -> Observer:
        """Outputs of motions; a machine with springs left out has no signals of these. Raises `InputError`."""
        return Observer(self.machine, self.reference, self.names)

    @property
    def is_predicted(self) -> bool:
        """Whether there is a linear model along the motion.

        Not where the base moves freely, joints depend on others, springs have backlash or there are states z, nor for
        long motions.
        """
        return self._path is not None

    @property
    def linear(self) -> tuple[LinearPath, tuple[int, ...]]:
        """The linear model along the motion, and the springs in it that are left out."""
        assert self._path is not None
        return self._path

    @property
    def _is_tree(self) -> bool:
        """Whether joints are independent, on a fixed base, springs straight, friction and motors without states.

        Friction that rises with load is not in the linear model either.
        """
        states = self.machine.bristles or self.machine.loaded or self.reference.drives
        straight = not self.machine.is_coupled and not self.machine.with_backlash
        return straight and not self.machine.degrees_of_base and not states

    @cached_property
    def _path(self) -> tuple[LinearPath, tuple[int, ...]] | None:
        if self._linear or not self._is_tree:
            return self._linear
        allowed = dict.fromkeys(self.names, 0.0) | dict(self.request.tolerance or {})
        path = path_if_resolved(self.reference, allowed)
        return None if path is None else (path, ())

    @cached_property
    def tolerance(self) -> dict[str, float]:
        """Tolerances by output: those that are given, else a thousandth of how far it is from the reference."""
        return dict(self.request.tolerance or self.usual(Deviations(self.linear[0]).outputs))

    def usual(self, deviation: Array) -> dict[str, float]:
        """Return a thousandth of the largest deviation (N, names) of each output."""
        largest = np.abs(deviation).max(axis=0)
        return {name: max(USUAL * float(x), LEAST) for name, x in zip(self.names, largest, strict=True)}

    def deviation(self, motion: Motion, outputs: Array) -> Array:
        """Return outputs (N, names) less those of the reference; torques less what holds the machine at the start."""
        along = self.observer.along_reference(motion.t)
        found: Array = outputs - np.where(np.isnan(along), outputs[:1], along)
        return found

    @cached_property
    def step_errors(self) -> StepErrors:
        """Errors of methods on the linear model."""
        return StepErrors(*self.linear)

    @cached_property
    def poles(self) -> ComplexArray:
        """Poles along the motion, rad/s; of a tree."""
        return poles(*(self._path or (linear_path(self.reference, (), PLACES), ())))

    def steps_of(self, method: Method) -> tuple[int, Mapping[str, float]]:
        """Return the steps that suffice for a method by prediction, and the errors predicted."""
        if method.name not in self._steps:
            self._steps[method.name] = enough_steps(self, method, self.tolerance)
        return self._steps[method.name]

    @cached_property
    def _steps(self) -> dict[str, tuple[int, Mapping[str, float]]]:
        return {}

    def stable_steps(self, method: Method) -> int:
        """Return the fewest steps that an explicit method bears."""
        return math.ceil(self.reference.duration / self.largest_step(method)) if isinstance(method, Tableau) else 1

    def largest_step(self, method: Method) -> float:
        """Return the largest step, s, with which an explicit method is stable along the motion; infinite for others.

        Where there is no linear model, it is that for the lags of drives alone.
        """
        if not isinstance(method, Tableau):
            return math.inf
        if not (self._linear or self._is_tree):
            paths = (one.path for one in self.reference.drives)
            lags = [x.time for path in paths for x in path if isinstance(x, FirstOrder)]
            return largest_stable_step(method, np.array([-1 / x for x in lags], dtype=complex)) if lags else math.inf
        return largest_stable_step(method, self.poles)

    def in_periods(self, steps: int) -> int:
        """Return at least as many steps, a whole number of them in each period."""
        periods = self.intervals
        if self.request.period is not None:
            periods = math.lcm(periods, max(1, round(self.reference.duration / self.request.period)))
        return periods * -(-steps // periods)

    @cached_property
    def intervals(self) -> int:
        """Intervals of the motion in which sampled drives hold their torques, which have whole steps; else 1."""
        return len([*Sampling(self.reference).intervals]) if is_sampled(self.reference) else 1

    @property
    def first_steps(self) -> int:
        """Steps that are tried first where none are predicted."""
        return self.in_periods(max(FIRST, in_detail(self.reference)))

    @cached_property
    def cost(self) -> StepCost:
        """Operations of steps."""
        machine = self.reference.loaded
        return StepCost(between_samples(machine) if is_sampled(self.reference) else machine, ways_of(self.reference))

    def cheapest(self) -> str:
        """Return the method whose steps suffice with the fewest operations."""
        return min(self.candidates(), key=lambda name: self.steps_of(METHODS[name])[0] * self.cost.of(METHODS[name]))

    def candidates(self) -> list[str]:
        """Return the methods to choose from: drives have states, which only some carry."""
        return [name for name in CANDIDATES if not (self.reference.drives and name in WITHOUT_STATES)]

    def error(self, key: str, what: str) -> InputError:
        """Return the error to raise about one key or option."""
        place = key if key.startswith("--") else f"wanted, {key}"
        return InputError(self.reference.prescribed.source or self.machine.label, place, what)

    def refuse_unstable(self, method: Method, step: float) -> None:
        """Raise `InputError` for steps that an explicit method does not bear."""
        largest = self.largest_step(method)
        if step > largest:
            period = self.request.period
            give = part_of(period, largest) if period else f"at most {rounded_down(largest)}"
            what = f"{step:g} s is beyond the limit of {method.name} here: give {give} s, or w3, w2"
            raise self.error("--step", what)

    def refuse_many(self, steps: float) -> None:
        """Raise `InputError` for more steps than are carried out."""
        if steps > MOST_STEPS:
            hours = steps * SLOW / 3600
            taken = f"{steps:.3g} steps, some {hours:.3g} h of work: {MOST_STEPS:.0e} is the limit, so give"
            least, period = self.reference.duration / MOST_STEPS, self.request.period
            if period and period < least:
                what = f"{taken} at most {rounded_down(MOST_STEPS * period)} s with a period of {period:g} s"
                raise self.reference.prescribed.error("duration", what)
            give = part_from(period, least) if period else f"at least {least:.3g}"
            raise self.error("--step", f"{taken} {give} s")


def enough_steps(
    simulating: Simulating, method: Method, tolerance: Mapping[str, float], share: float = SHARE
) -> tuple[int, Mapping[str, float]]:
    """Return the steps of a method whose predicted errors are at most a share of the tolerances, and these errors.

    The errors are NaN where stability alone takes too many steps to try them.
    """
    least = simulating.stable_steps(method)
    if least > MOST_PREDICTED:
        return simulating.in_periods(least), dict.fromkeys(tolerance, math.nan)
    choice = fewest_steps(simulating.step_errors, method, tolerance, share, least)
    steps = simulating.in_periods(choice.steps)
    if steps == choice.steps or not choice.is_tried:
        return steps, choice.errors
    return steps, simulating.step_errors.errors(method, steps)


def simulate(
    reference: Reference, request: Request, announce: Announce = announce_nothing, progress: Progress = no_progress
) -> Simulation:
    """Return a motion simulated by compiled steps of even size, refined until its measured errors are tolerable.

    Method and step are predicted where they are not given. Raises `InputError`, `CompilerMissing`, `CompilationFailed`.
    """
    simulating = Simulating(reference, request)
    name = _method(simulating, announce)
    steps, predicted = _steps(simulating, METHODS[name])
    announce("compile")
    with TemporaryDirectory() as folder:
        compiled = compiled_steps(reference, [name], Path(folder))
        announce("simulate")
        return _refined(simulating, compiled, name, steps, predicted, progress)


def _method(simulating: Simulating, announce: Announce) -> str:
    """Return the requested method, or the cheapest by prediction. Raises `InputError` where none serves."""
    request = simulating.request
    refuse_still(simulating.reference)
    refuse_sampled(simulating.reference)
    refuse_machines(simulating.machine, (request.method or W3.name,))
    refuse_period(simulating)
    if request.step is None:
        refuse_unresolved(simulating.reference)
    announce("predict")
    return request.method or (simulating.cheapest() if simulating.is_predicted and not request.step else W3.name)


def refuse_period(simulating: Simulating) -> None:
    """Raise `InputError` where the motion is not a whole number of periods, or a period no whole number of steps."""
    period, step, duration = simulating.request.period, simulating.request.step, simulating.reference.duration
    if period is None:
        return
    if not is_whole(duration / period):
        nearest = max(1, round(duration / period)) * period
        what = f"{period:g} s is not a whole part of the motion of {duration:g} s: make its duration {nearest:g} s"
        raise simulating.error("period", what)
    if step and 0 < step < math.inf and not is_whole(period / step):
        largest = min(step, simulating.largest_step(METHODS[simulating.request.method or W3.name]))
        give = part_of(period, largest)
        raise simulating.error("--step", f"{step:g} s is not a whole part of the period of {period:g} s: give {give} s")


def _steps(simulating: Simulating, method: Method) -> tuple[int, Mapping[str, float]]:
    """Return the first number of steps, and the errors predicted for it."""
    step, duration = simulating.request.step, simulating.reference.duration
    if step is None:
        steps, predicted = simulating.steps_of(method) if simulating.is_predicted else (simulating.first_steps, {})
        simulating.refuse_many(steps)
        return steps, predicted
    if not 0 < step < math.inf:
        raise simulating.error("--step", f"{step:g} s is not a time: give a positive number")
    simulating.refuse_many(duration / step)
    simulating.refuse_unstable(method, step)
    steps = math.ceil(duration / step * (1 - WHOLE))
    steps = simulating.in_periods(steps) if simulating.intervals > 1 else steps
    if not simulating.is_predicted or steps > MOST_PREDICTED:
        return steps, {}
    return steps, simulating.step_errors.errors(method, steps)


def _refined(
    simulating: Simulating,
    compiled: CompiledSteps,
    name: str,
    steps: int,
    predicted: Mapping[str, float],
    progress: Progress,
) -> Simulation:
    """Return the motion with steps that are given, or refined until the measured errors are tolerable."""
    runs = Runs(simulating, compiled, name, progress)
    for _ in range(REFINEMENTS):
        errors, tolerance = runs.errors(steps), runs.tolerance(steps)
        excess = relative(errors, tolerance)
        if simulating.request.step or excess <= 1:
            break
        factor = np.clip(MARGIN * excess ** (1 / METHODS[name].order), 2, MOST_AT_ONCE)
        steps, predicted = simulating.in_periods(math.ceil(steps * factor)), {}
        simulating.refuse_many(2 * steps)
    return runs.simulation(steps, errors, tolerance, predicted)


class Runs:
    """Motions by one method, with different numbers of steps."""

    def __init__(self, simulating: Simulating, compiled: CompiledSteps, name: str, progress: Progress) -> None:
        self.simulating, self.compiled, self.method, self.progress = simulating, compiled, METHODS[name], progress
        self._found: dict[int, tuple[Trajectory, Motion, Array]] = {}

    def run(self, steps: int) -> tuple[Trajectory, Motion, Array]:
        """Return states, motion and outputs; not finite where they grow out of range."""
        if steps not in self._found:
            trajectory = self.compiled.run(self.simulating.reference, self.method.name, steps, self.progress)
            with np.errstate(all="ignore"):
                motion = self.simulating.observer.motion(trajectory)
                self._found[steps] = trajectory, motion, self.simulating.observer.outputs(motion)
        return self._found[steps]

    def errors(self, steps: int) -> dict[str, float]:
        """Return the errors of outputs: the distance from those at half the step, extrapolated by the order."""
        (coarse, _, rough), (fine, _, smooth) = self.run(steps), self.run(2 * steps)
        if not np.isfinite(fine.q).all():
            refuse_lost_loops(self.simulating.reference, fine)
        errors = errors_by_halving(self.method, (coarse, rough), (fine, smooth))
        return dict(zip(self.simulating.names, errors.tolist(), strict=True))

    def tolerance(self, steps: int) -> dict[str, float]:
        """Return the tolerances; those of a run itself where nothing gives them before."""
        simulating = self.simulating
        if simulating.request.tolerance or simulating.is_predicted:
            return simulating.tolerance
        _, motion, outputs = self.run(2 * steps)
        with np.errstate(all="ignore"):
            found = simulating.usual(simulating.deviation(motion, outputs))
        return {name: x if math.isfinite(x) else LEAST for name, x in found.items()}

    def simulation(
        self, steps: int, errors: Mapping[str, float], tolerance: Mapping[str, float], predicted: Mapping[str, float]
    ) -> Simulation:
        """Return the motion of so many steps with its errors; raises `InputError` where it grows out of range."""
        simulating, (trajectory, motion, outputs) = self.simulating, self.run(steps)
        refuse_lost_loops(simulating.reference, trajectory)
        _refuse_infinite(simulating, trajectory)
        refuse_turned(simulating.reference, trajectory)
        return Simulation(
            simulating.reference,
            trajectory,
            motion,
            simulating.names,
            outputs,
            simulating.deviation(motion, outputs),
            errors,
            tolerance,
            predicted,
            simulating.cost.of(self.method),
            energy_balance(simulating.reference, motion),
            damped_above(self.method, trajectory.step),
            simulating.largest_step(self.method),
            simulating.request.period,
        )


def errors_by_halving(method: Method, coarse: tuple[Trajectory, Array], fine: tuple[Trajectory, Array]) -> Array:
    """Return the errors (names,) of outputs (N, names) of a run, from a run at half the step; infinite out of range.

    They are compared where both were kept: of many steps only some are.
    """
    (run, rough), (halved, smooth) = coarse, fine
    _, here, there = np.intersect1d(_numbers(run) * 2, _numbers(halved), return_indices=True)
    with np.errstate(invalid="ignore"):
        apart = np.abs(smooth[there] - rough[here]).max(axis=0)
    errors: Array = np.where(np.isfinite(apart), share_of_halving(method) * apart, np.inf)
    return errors


def _numbers(run: Trajectory) -> AnyArray:
    """Return the numbers of the steps that were kept."""
    if run.numbers is not None:
        return run.numbers
    return np.round(run.t / run.step).astype(np.int64)


def _refuse_infinite(simulating: Simulating, trajectory: Trajectory) -> None:
    states = np.concatenate([trajectory.q, trajectory.qd, *trajectory.base.values()], axis=1)
    finite = np.isfinite(states).all(axis=1)
    if not finite.all():
        first = trajectory.t[int(np.argmin(finite))]
        shorter = f"with steps of {trajectory.step:.3g} s: give shorter ones"
        raise simulating.error("--step", f"the motion leaves the valid range at {first:.4g} s {shorter}")


def _free_joints(reference: Reference) -> tuple[str, ...]:
    """Return the pose of a base that moves freely, and the positions of the joints that do not follow exactly."""
    exact = () if reference.servo else reference.motors
    joints = tuple(f"{joint.name}.q" for joint in reference.machine.independent_joints if joint.name not in exact)
    return (*COORDINATES[: reference.machine.degrees_of_base], *joints)


# Operations of a time step, counted in the programs that it calls.
def cost_in_products(count: OperationCount) -> int:
    """Return the operations of a program as so many products."""
    return count.mul + count.add + DIVISION * count.div + SINE * count.sincos


class StepCost:
    """Operations of steps of a machine whose motors are given in a way; all parameters are constants unless named."""

    def __init__(self, machine: Machine, motors: Motors, folded: Sequence[str] | None = None) -> None:
        self.machine, self.motors = machine, motors
        self._folded = names_to_fold(machine, Scene(fold=ALL)) if folded is None else tuple(folded)
        self._traced: dict[str, Program] = {}

    def of(self, method: Method) -> int:
        """Return the operations of a step, weighted: those of its right sides, systems and sums."""
        n = len(self.machine.independent) + self.machine.degrees_of_base
        entries = 2 * n + len(state_names(self.machine, self.motors is Motors.DRIVES))
        found = sum(times * cost_in_products(program.count) for times, program in self.programs(method))
        found += 2 * entries * _sums(method)
        return found + 2 * n**3 // 3 + len(method.m) * 6 * n**2 if isinstance(method, Rosenbrock) else found

    def programs(self, method: Method) -> Iterator[tuple[int, Program]]:
        """Yield the programs that a step calls, and how often."""
        stages = _stages(method)
        rates = stages * (SUBSTITUTIONS if self.machine.loaded else 1)
        if self.machine.loaded:
            yield rates, passed_torques(self.machine, self._folded).program
        if self.motors is Motors.DRIVES:
            yield rates, closed_dynamics(self.machine, self._folded).program
            yield from zip((stages + 1, stages), self._of_base, strict=False)
            yield from () if isinstance(method, Tableau) else zip((1, stages), self._system, strict=True)
            return
        yield rates, self._model("inverse_dynamics" if self.motors is Motors.DRIVEN else "direct_dynamics")
        if self.motors is Motors.SERVO and dependent_motors(self.machine):
            yield stages, self._of_motors
        yield from zip((stages + 1, stages), self._of_base, strict=False)
        if isinstance(method, Rosenbrock):
            yield 1, self._model("linearization")
        elif not isinstance(method, Tableau):
            yield from zip((1, stages), self._system, strict=True)

    @cached_property
    def _of_motors(self) -> Program:
        """Positions and velocities of motors that follow from loops, under servos."""
        return motor_coordinates(self.machine, self._folded).program

    @cached_property
    def _of_base(self) -> list[Program]:
        return [one.program for one in base_models(self.machine, self._folded)]

    def _model(self, name: str) -> Program:
        if name not in self._traced:
            self._traced[name] = trace(self.machine, name, folded=self._folded).program
        return self._traced[name]

    @cached_property
    def _system(self) -> list[Program]:
        return [one.program for one in implicit_system(self.machine, self.motors, self._folded)]


def _stages(method: Method) -> int:
    if isinstance(method, Midpoint):
        return method.iterations
    return len(method.m if isinstance(method, Rosenbrock) else method.b)


def _sums(method: Method) -> int:
    """Return the coefficients of a step that are not zero."""
    if isinstance(method, Midpoint):
        return 2 * method.iterations
    rows = [*(method.A if isinstance(method, Tableau) else method.a)]
    rows += [] if isinstance(method, Tableau) else [*(method.c if isinstance(method, Rosenbrock) else method.g)]
    return sum(1 for row in rows for x in row if x) + _stages(method)
