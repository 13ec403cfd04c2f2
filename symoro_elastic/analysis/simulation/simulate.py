"""Motions simulated with predicted step sizes; the error is measured by halving the step."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.control.cascade import FirstOrder
from symoro_elastic.analysis.simulation.compiled_steps import (
    NOTHING_TO_INTEGRATE,
    CompiledSteps,
    Trajectory,
    refuse_lost_loops,
    refuse_sampled,
    refuse_still,
    refuse_turned,
    ways_of,
)
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
from symoro_elastic.analysis.simulation.prediction.step_error import (
    PLACES,
    StepErrors,
    damped_above,
    fewest_steps,
    largest_stable_step,
    poles,
)
from symoro_elastic.analysis.simulation.reference_motion import SAMPLES, Motion, Reference
from symoro_elastic.analysis.simulation.sampled_drives import Sampling
from symoro_elastic.analysis.simulation.sampled_steps import compiled_steps, is_sampled
from symoro_elastic.analysis.simulation.simulated import EXACT, Simulation, energy_balance
from symoro_elastic.codegen.integration.tableaus import (
    METHODS,
    W3,
    Method,
    Midpoint,
    Rosenbrock,
    Tableau,
    share_of_halving,
)
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import temporary_folder
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.machine.described import between_samples
from symoro_elastic.machine.frames import COORDINATES
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import names_to_fold
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.drives.drive_states import state_names
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.models.steps.closed_dynamics import closed_dynamics
from symoro_elastic.models.steps.implicit_steps import Motors, base_models, implicit_system
from symoro_elastic.models.steps.time_steps import (
    WITHOUT_STATES,
    dependent_motors,
    motor_coordinates,
    passed_torques,
    refuse_machines,
)
from symoro_elastic.numerics.motion.signals import MOTOR_TORQUE
from symoro_elastic.quantities.time_steps import TimeStep
from symoro_elastic.symbolic.program import Program

DIVISION, SINE = 5, 15
"""Products that cost about as much as a division, and as a sine and a cosine."""

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
    """Settings of a simulation: outputs and tolerances by name, optional method and step, a period for steps."""

    outputs: tuple[str, ...] = ()
    tolerance: Mapping[str, float] | None = None
    method: str | None = None
    step: float | None = None
    period: float | None = None


class Simulating:
    """A motion of a machine, simulated by sufficiently many steps."""

    def __init__(
        self, reference: Reference, request: Request, linear: tuple[LinearPath, tuple[int, ...]] | None = None
    ) -> None:
        """Prepare a motion; `linear` is the linear model of a machine with more springs, and their entries in q."""
        self.reference, self.request, self._linear = reference, request, linear
        self.machine: Machine = reference.machine
        self._steps: dict[str, tuple[int, Mapping[str, float]]] = {}
        self.names = request.outputs or tuple(request.tolerance or ()) or self._free_joints

    @property
    def _free_joints(self) -> tuple[str, ...]:
        """Default outputs: pose of a freely moving base, and positions of joints without a prescribed motion."""
        exact = () if self.reference.servo else self.reference.motors
        joints = (f"{joint.name}.q" for joint in self.machine.independent_joints if joint.name not in exact)
        return (*COORDINATES[: self.machine.degrees_of_base], *joints)

    @cached_property
    def observer(self) -> Observer:
        """Observer of the outputs; omitted springs have no signals. Raises `InputError`."""
        return Observer(self.machine, self.reference, self.names)

    @property
    def is_predicted(self) -> bool:
        """Whether a linear model exists along the motion.

        Not where the base moves freely, joints depend on others, springs have backlash or there are states z, nor for
        long motions.
        """
        return self._path is not None

    @property
    def linear(self) -> tuple[LinearPath, tuple[int, ...]]:
        """The linear model along the motion, and its omitted springs."""
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
        """Tolerances by output: requested ones, else a thousandth of the largest deviation from the reference."""
        return dict(self.request.tolerance or self.usual(Deviations(self.linear[0]).outputs))

    def usual(self, deviation: Array) -> dict[str, float]:
        """Return a thousandth of the largest deviations (N, names) of the outputs."""
        largest = np.abs(deviation).max(axis=0)
        return {name: max(USUAL * float(x), LEAST) for name, x in zip(self.names, largest, strict=True)}

    def deviation(self, motion: Motion, outputs: Array) -> Array:
        """Return outputs (N, names) minus those of the reference; torques minus the holding torque at the start."""
        along = self.observer.outputs(self.reference.motion(motion.t))
        return np.asarray(outputs - np.where(np.isnan(along), outputs[:1], along))

    @cached_property
    def step_errors(self) -> StepErrors:
        """Errors of methods on the linear model."""
        return StepErrors(*self.linear)

    @cached_property
    def poles(self) -> ComplexArray:
        """Poles along the motion, rad/s, of a machine without closed loops."""
        return poles(*(self._path or (linear_path(self.reference, (), PLACES), ())))

    def steps_of(self, method: Method) -> tuple[int, Mapping[str, float]]:
        """Return the number of steps of a method that suffices by prediction, and the predicted errors."""
        if method.name not in self._steps:
            self._steps[method.name] = enough_steps(self, method, self.tolerance)
        return self._steps[method.name]

    def stable_steps(self, method: Method) -> int:
        """Return the fewest stable steps of an explicit method."""
        return math.ceil(self.reference.duration / self.largest_step(method)) if isinstance(method, Tableau) else 1

    def largest_step(self, method: Method) -> float:
        """Return the largest stable step of an explicit method along the motion, s; infinite for others.

        Without a linear model, it is that for the lags of drives alone.
        """
        if not isinstance(method, Tableau):
            return math.inf
        if not (self._linear or self._is_tree):
            paths = (drive.path for drive in self.reference.drives)
            lags = [x.time for path in paths for x in path if isinstance(x, FirstOrder)]
            return largest_stable_step(method, np.array([-1 / x for x in lags], dtype=complex)) if lags else math.inf
        return largest_stable_step(method, self.poles)

    def in_periods(self, steps: int) -> int:
        """Return at least `steps` steps, with an integer number in each period."""
        periods = self.intervals
        if self.request.period is not None:
            periods = math.lcm(periods, max(1, round(self.reference.duration / self.request.period)))
        return periods * -(-steps // periods)

    @cached_property
    def intervals(self) -> int:
        """Hold intervals of sampled drives in the motion, which contain integer numbers of steps; else 1."""
        return len([*Sampling(self.reference).intervals]) if is_sampled(self.reference) else 1

    @cached_property
    def cost(self) -> StepCost:
        """Operation counts of steps."""
        machine = self.reference.loaded
        return StepCost(between_samples(machine) if is_sampled(self.reference) else machine, ways_of(self.reference))

    def cheapest(self) -> str:
        """Return the method that reaches the tolerances with the fewest operations."""
        return min(self.candidates(), key=lambda name: self.steps_of(METHODS[name])[0] * self.cost.of(METHODS[name]))

    def candidates(self) -> list[str]:
        """Return the available methods: drives have states, which only some methods support."""
        return [name for name in CANDIDATES if not (self.reference.drives and name in WITHOUT_STATES)]

    def error(self, key: str, what: str) -> InputError:
        """Return the error to raise about one key or option."""
        place = key if key.startswith("--") else f"wanted, {key}"
        return InputError(self.reference.prescribed.source or self.machine.label, place, what)

    def refuse_unstable(self, method: Method, step: float) -> None:
        """Raise `InputError` for steps at which an explicit method is unstable."""
        largest = self.largest_step(method)
        if step > largest:
            period = self.request.period
            give = part_of(period, largest) if period else f"at most {rounded_down(largest)}"
            what = f"{step:g} s is beyond the limit of {method.name} here: give {give} s, or w3, w2"
            raise self.error("--step", what)

    def refuse_many(self, steps: float) -> None:
        """Raise `InputError` for more steps than the limit."""
        if steps > MOST_STEPS:
            hours = steps * SLOW / 3600
            size = f"{steps:.3g} steps, some {hours:.3g} h of work: {MOST_STEPS:.0e} is the limit, so give"
            least, period = self.reference.duration / MOST_STEPS, self.request.period
            if period and period < least:
                what = f"{size} at most {rounded_down(MOST_STEPS * period)} s with a period of {period:g} s"
                raise self.reference.prescribed.error("duration", what)
            give = part_from(period, least) if period else f"at least {least:.3g}"
            raise self.error("--step", f"{size} {give} s")


def enough_steps(
    simulating: Simulating, method: Method, tolerance: Mapping[str, float], share: float = SHARE
) -> tuple[int, Mapping[str, float]]:
    """Return the steps of a method whose predicted errors are at most a fraction of the tolerances, and these errors.

    The errors are NaN if stability alone requires too many steps.
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
    """Return a motion simulated by compiled even steps, refined until its measured errors meet the tolerances.

    Method and step are predicted where they are not given. Raises `InputError`, `CompilerMissing`, `CompilationFailed`.
    """
    simulating = Simulating(reference, request)
    name = _method(simulating, announce)
    steps, predicted = _steps(simulating, METHODS[name])
    announce("compile")
    with temporary_folder() as folder:
        compiled = compiled_steps(reference, [name], Path(folder))
        announce("simulate")
        return _refine(simulating, compiled, name, steps, predicted, progress)


def _method(simulating: Simulating, announce: Announce) -> str:
    """Return the requested method, or the cheapest by prediction. Raises `InputError` if none suffices."""
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
    """Raise `InputError` unless the motion is a multiple of the period and the period a multiple of the step."""
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
    """Return the initial number of steps, requested or predicted, and its predicted errors."""
    step, duration = simulating.request.step, simulating.reference.duration
    if step is None:
        first = simulating.in_periods(max(FIRST, in_detail(simulating.reference)))
        steps, predicted = simulating.steps_of(method) if simulating.is_predicted else (first, {})
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


def _refine(
    simulating: Simulating,
    compiled: CompiledSteps,
    name: str,
    steps: int,
    predicted: Mapping[str, float],
    progress: Progress,
) -> Simulation:
    """Return the motion with the requested steps, or refined until the measured errors meet the tolerances."""
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
    """Simulation runs of a motion by one method, with different numbers of steps."""

    def __init__(self, simulating: Simulating, compiled: CompiledSteps, name: str, progress: Progress) -> None:
        self.simulating, self.compiled, self.method, self.progress = simulating, compiled, METHODS[name], progress
        self._found: dict[int, tuple[Trajectory, Motion, Array]] = {}

    def run(self, steps: int) -> tuple[Trajectory, Motion, Array]:
        """Return trajectory, motion and outputs of a run; infinite if it diverges."""
        if steps not in self._found:
            trajectory = self.compiled.run(self.simulating.reference, self.method.name, steps, self.progress)
            with np.errstate(all="ignore"):
                motion = self.simulating.observer.motion(trajectory)
                self._found[steps] = trajectory, motion, self.simulating.observer.outputs(motion)
        return self._found[steps]

    def errors(self, steps: int) -> dict[str, float]:
        """Return the errors of outputs, extrapolated from the differences to a run at half the step."""
        (coarse, _, rough), (fine, _, smooth) = self.run(steps), self.run(2 * steps)
        if not np.isfinite(fine.q).all():
            refuse_lost_loops(self.simulating.reference, fine)
        errors = errors_by_halving(self.method, (coarse, rough), (fine, smooth))
        return dict(zip(self.simulating.names, errors.tolist(), strict=True))

    def tolerance(self, steps: int) -> dict[str, float]:
        """Return the tolerances; by default from the outputs of the run itself."""
        simulating = self.simulating
        if simulating.request.tolerance or simulating.is_predicted:
            return simulating.tolerance
        _, motion, outputs = self.run(2 * steps)
        with np.errstate(all="ignore"):
            tolerances = simulating.usual(simulating.deviation(motion, outputs))
        return {name: x if math.isfinite(x) else LEAST for name, x in tolerances.items()}

    def simulation(
        self, steps: int, errors: Mapping[str, float], tolerance: Mapping[str, float], predicted: Mapping[str, float]
    ) -> Simulation:
        """Return the motion with this number of steps and its errors; raises `InputError` if it diverges."""
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
    """Return the errors (names,) of outputs (N, names), from a run at half the step; infinite if it diverges.

    They are compared where both were kept: of many steps only some are.
    """
    (run, rough), (halved, smooth) = coarse, fine
    _, here, there = np.intersect1d(run.recorded * 2, halved.recorded, return_indices=True)
    with np.errstate(invalid="ignore"):
        apart = np.abs(smooth[there] - rough[here]).max(axis=0)
    return np.asarray(np.where(np.isfinite(apart), share_of_halving(method) * apart, np.inf))


def _refuse_infinite(simulating: Simulating, trajectory: Trajectory) -> None:
    states = np.concatenate([trajectory.q, trajectory.qd, *trajectory.base.values()], axis=1)
    finite = np.isfinite(states).all(axis=1)
    if not finite.all():
        first = trajectory.t[int(np.argmin(finite))]
        shorter = f"with steps of {trajectory.step:.3g} s: give shorter ones"
        raise simulating.error("--step", f"the motion leaves the valid range at {first:.4g} s {shorter}")


class StepCost:
    """Operation counts of steps of a machine for one kind of motor control; parameters not named are constants."""

    def __init__(self, machine: Machine, motors: Motors, folded: Sequence[str] | None = None) -> None:
        self.machine, self.motors = machine, motors
        self._folded = names_to_fold(machine, Scene(fold=ALL)) if folded is None else tuple(folded)
        self._traced: dict[str, Program] = {}

    def of(self, method: Method) -> int:
        """Return the weighted operations of a step: its right-hand sides, systems and sums."""
        n = len(self.machine.independent) + self.machine.degrees_of_base
        entries = 2 * n + len(state_names(self.machine, self.motors is Motors.DRIVES))
        counts = [(times, program.count) for times, program in self.programs(method)]
        count = sum(times * (x.mul + x.add + DIVISION * x.div + SINE * x.sincos) for times, x in counts)
        count += 2 * entries * _sums(method)
        return count + 2 * n**3 // 3 + len(method.m) * 6 * n**2 if isinstance(method, Rosenbrock) else count

    def programs(self, method: Method) -> Iterator[tuple[int, Program]]:
        """Yield the programs that a step calls, and how often."""
        stages = _stages(method)
        rates = stages * (SUBSTITUTIONS if self.machine.loaded else 1)
        if self.machine.loaded:
            yield rates, self._of_loads
        if self.motors is Motors.DRIVES:
            yield rates, self._of_motors
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
    def _of_loads(self) -> Program:
        return passed_torques(self.machine, self._folded).program

    @cached_property
    def _of_motors(self) -> Program:
        """The program of closed drive loops, or of positions and velocities of servo motors on dependent joints."""
        models = closed_dynamics if self.motors is Motors.DRIVES else motor_coordinates
        return models(self.machine, self._folded).program

    @cached_property
    def _of_base(self) -> list[Program]:
        return [base_model.program for base_model in base_models(self.machine, self._folded)]

    def _model(self, name: str) -> Program:
        if name not in self._traced:
            self._traced[name] = trace(self.machine, name, folded=self._folded).program
        return self._traced[name]

    @cached_property
    def _system(self) -> list[Program]:
        return [system.program for system in implicit_system(self.machine, self.motors, self._folded)]


def _stages(method: Method) -> int:
    if isinstance(method, Midpoint):
        return method.iterations
    return len(method.m if isinstance(method, Rosenbrock) else method.b)


def _sums(method: Method) -> int:
    """Return the number of nonzero coefficients of a method."""
    if isinstance(method, Midpoint):
        return 2 * method.iterations
    rows = [*(method.A if isinstance(method, Tableau) else method.a)]
    rows += [] if isinstance(method, Tableau) else [*(method.c if isinstance(method, Rosenbrock) else method.g)]
    return sum(1 for row in rows for x in row if x) + _stages(method)


def follows_exactly(reference: Reference) -> bool:
    """Return whether the motion of the motors determines that of all joints."""
    machine = reference.machine
    is_whole = bool(machine.motors) and len(machine.motors) == len(machine.independent)
    return is_whole and reference.servo is None and not reference.base


def follow(reference: Reference, request: Request) -> Simulation:
    """Return an exactly prescribed motion, with torques, outputs and energies; raises `InputError`.

    Its samples are those of --step, else enough to resolve all parts of the motion. Its errors are zero by definition.
    """
    if request.method is not None:
        source = reference.prescribed.source or reference.machine.label
        raise InputError(source, "--method", f"{NOTHING_TO_INTEGRATE}, or leave it out")
    steps = _sampled_steps(reference, request)
    names = request.outputs or tuple(request.tolerance or ())
    names = names or tuple(f"{motor}.{MOTOR_TORQUE}" for motor in reference.motors)
    t = np.linspace(0.0, reference.duration, steps + 1)
    observer = Observer(reference.machine, reference, names)
    blocks = reference.motion(t).blocks
    trajectory = Trajectory(blocks, t, EXACT, reference.duration / steps, steps, 0.0)
    motion = observer.motion(trajectory)
    outputs = observer.outputs(motion)
    return Simulation(
        reference, trajectory, motion, names, outputs, np.zeros_like(outputs), dict.fromkeys(names, 0.0),
        dict(request.tolerance or {}), {}, 0, energy_balance(reference, motion), None, math.inf,
    )  # fmt: skip


def _sampled_steps(reference: Reference, request: Request) -> int:
    """Return the number of output samples minus one."""
    if request.step is None:
        refuse_unresolved(reference)
        return max(SAMPLES - 1, in_detail(reference))
    simulating = Simulating(reference, request)
    if not 0 < request.step < math.inf:
        raise simulating.error("--step", f"{request.step:g} s is not a time: give a positive number")
    simulating.refuse_many(reference.duration / request.step)
    return math.ceil(reference.duration / request.step * (1 - WHOLE))
