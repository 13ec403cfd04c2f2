"""Motions by integrators of scipy with steps of their own: the generated right side and its derivatives, compiled.

    y' = [v; qdd(q, v, t)],    dy'/dy = [0 I; -M^-1 K, -M^-1 D]

M, D, K are those of the model `linearization`, with the gains of servos; y holds the joints that do not follow exactly.
Radau where the machine is stiff over the motion, DOP853 elsewhere. Methods of multiple steps are not used: those of
order above 2 grow where springs have little damping.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.compiled_steps import (
    Trajectory,
    law_of_servos,
    refuse_lost_loops,
    refuse_still,
    refuse_turned,
    with_servo_torques,
)
from symoro_elastic.analysis.simulation.energy_balance import energy_balance
from symoro_elastic.analysis.simulation.events import Crossing, Level, Watch, level_of
from symoro_elastic.analysis.simulation.moving_base import quaternion, rotation_at, rotations, turning
from symoro_elastic.analysis.simulation.prediction.resolution import refuse_unresolved
from symoro_elastic.analysis.simulation.prediction.spring_errors import relative
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.analysis.simulation.simulate import Request, Simulating
from symoro_elastic.analysis.simulation.simulated import Simulation
from symoro_elastic.codegen.compile import CompiledPackage, compile_library
from symoro_elastic.codegen.package import EXTERNAL, Package
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.motor_coordinates import MOTOR_COORDINATES, dependent_motors, motor_coordinates
from symoro_elastic.models.state import State, closing_models
from symoro_elastic.models.time_steps import refuse_machines_without_steps
from symoro_elastic.models.traced import trace_models
from symoro_elastic.numerics.branch_crossings import refuse_lost

PRECISIONS = (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)
"""Relative tolerances of a step: the error at each is measured by the next one."""

DIFFERENCE = 1e-7
"""Of the state, for derivatives."""
FLAGS = ("-O1",)
"""Calls from Python take longer than what more would save."""
STIFF = 20_000.0
"""Largest pole times duration that DOP853 is taken for: a step passes about 6."""
ABSOLUTE = 1e-3
"""Absolute tolerance of positions (rad, m) and velocities, of the relative one."""
LONGEST = 100
"""Steps over a motion, at least."""
MOST_STEPS = 400_000
CHECKED = 500
"""Steps after which it is looked whether loops are still on their branch: steps get short where they are not."""
SAMPLES, SAMPLES_OF_STEP, MOST_SAMPLES = 1000, 4, 100_000


class CompiledMotion:
    """The right side of a motion and its derivatives."""

    linear_models: tuple[str, ...] = ("linearization",)

    def __init__(self, reference: Reference, folder: Path) -> None:
        """Raises `InputError`, `CompilerMissing`, `CompilationFailed`."""
        refuse_still(reference)
        self.reference, machine = reference, reference.machine
        self.dynamics = "inverse_dynamics" if reference.servo is None else "direct_dynamics"
        self.closing = closing_models(machine)
        models = (self.dynamics, *self.linear_models, *self.closing)
        package = _package(reference.loaded, Scene(models=models, fold=ALL))
        self._compiled = CompiledPackage(package, compile_library(render_c(package), folder, flags=FLAGS))
        self._arguments = {f.name: {argument.name for argument in f.arguments} for f in package.functions}
        self._external = {EXTERNAL} & self._arguments[self.dynamics]
        self.motors = list(machine.motor_entries)
        driven = self.motors if reference.servo is None else []
        self.free = [k for k in range(len(machine.independent)) if k not in driven]

    @property
    def start(self) -> Array:
        """y (2 f,) at the start."""
        state = self.reference.start
        return np.concatenate([state.q[self.free], state.qd[self.free]])

    def states_of_joints(self, t: Array, y: Array) -> tuple[Array, Array]:
        """Return q, qd (N, n) of all joints at times (N,) and y (N, 2 f)."""
        if self.reference.servo is not None:
            q, qd = np.split(y, 2, axis=1)
            return q, qd
        q, qd, _ = self.reference.states(t)
        q[:, self.free], qd[:, self.free] = np.split(y, 2, axis=1)
        return q, qd

    def states(self, t: Array, y: Array, near: State) -> Motion:
        """Return the states at times (N,) and y (N, 2 f); loops are closed in turn, from a state `near` the first."""
        q, qd = self.states_of_joints(t, y)
        wrenches = {name: self.reference.wrenches(t)[0] for name in self._external}
        motion = Motion({"q": q, "qd": qd, **wrenches, **self.base(y)}, t)
        for model in self.closing:
            closed = [near := State(self._compiled.call(model, q=x, q_dep=near.q_dep)) for x in q]
            motion = motion.with_blocks(q_dep=np.array([one.q_dep for one in closed]))
        return motion

    def base(self, y: Array) -> dict[str, Array]:
        """Return the blocks of a base that moves freely at y (N, 2 f); none here."""
        return {}

    def rate(self, t: float, y: Array, near: State) -> Array:
        """Return y' (2 f,), with loops closed from a state `near`."""
        motion = self.states(np.array([t]), y[None], near)
        qdd = self._accelerations(motion)["qdd"]
        return np.concatenate([motion.qd[0, self.free], qdd[0, self.free]])

    def jacobian(self, t: float, y: Array, near: State) -> Array:
        """Return dy'/dy (2 f, 2 f), with loops closed from a state `near`.

        Of a servo on a dependent joint kd dS_m/dt is left out, by which the rate of the motor changes with positions.
        """
        motion = self.states(np.array([t]), y[None], near)
        moved = motion.with_blocks(qdd=self._accelerations(motion)["qdd"], tau=self._torques(motion))
        found = self._call("linearization", moved)
        M, D, K = (found[name][0] for name in ("M", "D", "K"))
        if self.reference.servo is not None:
            S_m = self._slopes(motion)
            K, D = (matrix + S_m.T * x @ S_m for matrix, x in zip((K, D), self.reference.servo, strict=True))
        rows, f = np.ix_(self.free, self.free), len(self.free)
        J = np.zeros((2 * f, 2 * f))
        J[:f, f:] = np.eye(f)
        J[f:] = -np.linalg.solve(M[rows], np.hstack([K[rows], D[rows]]))
        return J

    def _accelerations(self, motion: Motion) -> dict[str, Array]:
        """Return qdd, and the acceleration of a base that moves freely, where motors do what the reference says."""
        if self.reference.servo is None:
            return self._call(self.dynamics, motion.with_blocks(qdd_motor=self.reference.at(motion.t)[2]))
        return self._call(self.dynamics, motion.with_blocks(tau=self._torques(motion)))

    def _torques(self, motion: Motion) -> Array:
        """Return the torques (N, m) of servos; NaN where motors follow exactly."""
        if MOTOR_COORDINATES not in self._arguments or self.reference.servo is None:
            return with_servo_torques(self.reference, motion).tau
        of_motors = self._call(MOTOR_COORDINATES, motion)
        return law_of_servos(self.reference, motion.t, of_motors["q_motor"], of_motors["qd_motor"])

    def _slopes(self, motion: Motion) -> Array:
        """Return S_m (m, n) at one position: the rates of motors by those of the coordinates."""
        unit = np.eye(motion.q.shape[1])
        if MOTOR_COORDINATES not in self._arguments:
            return unit[self.motors]
        rates = [self._call(MOTOR_COORDINATES, motion.with_blocks(qd=row[None]))["qd_motor"][0] for row in unit]
        return np.stack(rates, axis=1)

    def _call(self, function: str, state: State) -> dict[str, Array]:
        return self._compiled.call(function, **state.only(self._arguments[function]))


def _package(machine: Machine, scene: Scene) -> Package:
    """Return the models of a scene, with positions and rates of motors where these are on dependent joints."""
    found = trace_models(machine, scene)
    if not dependent_motors(machine):
        return found.package
    return replace(found, models=[*found.models, motor_coordinates(machine, found.folded)]).package


class CompiledMotionOnBase(CompiledMotion):
    """The right side of a motion with a base that moves freely, by derivatives from differences.

    y = [q; P0; Q0; v; V0]. The quaternion turns by Q' = Q (0, w) / 2, which keeps its length, and is divided by it
    wherever it is used.
    """

    linear_models = ()

    def __init__(self, reference: Reference, folder: Path) -> None:
        """Raises `InputError`, `CompilerMissing`, `CompilationFailed`."""
        super().__init__(reference, folder)
        self.orientation = next(iter(reference.base.keys() & {"Q0", "R0"}))

    @property
    def start(self) -> Array:
        """y at the start."""
        state, base = self.reference.start, self.reference.base
        Q0 = base["Q0"] if "Q0" in base else quaternion(base["R0"].reshape(3, 3))
        return np.concatenate([state.q[self.free], base["P0"], Q0, state.qd[self.free], base["V0"]])

    def states_of_joints(self, t: Array, y: Array) -> tuple[Array, Array]:
        """Return q, qd (N, n) of all joints at times (N,) and y (N, 2 f + 13)."""
        f = len(self.free)
        own = y[:, :f], y[:, f + 7 : 2 * f + 7]
        if f == len(self.reference.start.q):
            return own
        q, qd, _ = self.reference.states(t)
        q[:, self.free], qd[:, self.free] = own
        return q, qd

    def base(self, y: Array) -> dict[str, Array]:
        """Return the blocks of the base at y (N, 2 f + 13), and the wrench on it."""
        P0, Q0 = np.split(y[:, len(self.free) : len(self.free) + 7], [3], axis=1)
        Q0 = Q0 / np.linalg.norm(Q0, axis=1, keepdims=True)
        turned = Q0 if self.orientation == "Q0" else rotations(Q0).reshape(-1, 9)
        wrench = np.tile(self.reference.base["f0"], (len(y), 1))
        return {self.orientation: turned, "P0": P0, "V0": y[:, -6:], "f0": wrench}

    def rate(self, t: float, y: Array, near: State) -> Array:
        """Return y'."""
        motion = self.states(np.array([t]), y[None], near)
        found = self._accelerations(motion)
        f, (v, w), (a, wd) = len(self.free), np.split(motion.V0[0], 2), np.split(found["V0d"][0], 2)
        speed, turned = rotation_at(motion)[0] @ v, turning(y[f + 3 : f + 7], w)
        rates, qdd = motion.qd[0, self.free], found["qdd"][0, self.free]
        return np.concatenate([rates, speed, turned, qdd, a - np.cross(w, v), wd])

    def jacobian(self, t: float, y: Array, near: State) -> Array:
        """Return dy'/dy by central differences."""
        steps = DIFFERENCE * np.maximum(1.0, np.abs(y))
        columns = [
            (self.rate(t, y + h * e, near) - self.rate(t, y - h * e, near)) / (2 * h)
            for h, e in zip(steps, np.eye(len(y)), strict=True)
        ]
        return np.stack(columns, axis=1)


def compiled_motion(reference: Reference, folder: Path) -> CompiledMotion:
    """Return the right side of a motion, with the base where it moves freely.

    Raises `InputError`, `CompilerMissing`, `CompilationFailed`.
    """
    return (CompiledMotionOnBase if reference.base else CompiledMotion)(reference, folder)


@dataclass(frozen=True)
class Adapted:
    """A motion of adapted steps: y at any time by `dense`, until `ends`, and the crossings of levels."""

    method: str
    dense: Any
    ends: float
    steps: int
    seconds: float
    crossings: tuple[Crossing, ...]

    @property
    def samples(self) -> Array:
        """Even times (N,) that resolve the steps."""
        count = min(max(SAMPLES, SAMPLES_OF_STEP * self.steps), MOST_SAMPLES)
        return np.linspace(0.0, self.ends, count + 1)

    def trajectory(self, system: CompiledMotion, t: Array) -> Trajectory:
        """Return the states and torques at times (N,)."""
        motion = system.states(t, self.dense(t).T, system.reference.at_start)
        blocks, step = with_servo_torques(system.reference, motion).blocks, self.ends / self.steps
        return Trajectory(blocks, t, self.method, step, self.steps, self.seconds)


def method_for(system: CompiledMotion) -> str:
    """Return Radau where a pole at the start is fast over the motion, else DOP853."""
    poles = np.linalg.eigvals(system.jacobian(0.0, system.start, system.reference.at_start))
    return "Radau" if np.abs(poles).max(initial=0.0) * system.reference.duration > STIFF else "DOP853"


def integrate(
    system: CompiledMotion,
    method: str,
    precision: float,
    levels: Sequence[Level] = (),
    stop: bool = False,
    progress: Progress = no_progress,
) -> Adapted:
    """Return the motion at a relative tolerance of a step, up to the first crossing if it is to `stop` there.

    Raises `InputError` where steps get too small or many.
    """
    reference, watch = system.reference, Watch(levels)
    began, duration = time.perf_counter(), reference.duration
    right = _FromLastStep(system)
    solver = _solver(right, method, precision)
    times, pieces, found = [0.0], list[Any](), list[Crossing]()
    while solver.status == "running":
        failure = solver.step()
        if failure or not np.isfinite(solver.y).all() or len(times) > MOST_STEPS:
            _refuse_lost_loops(system, times, pieces)
            when = f"{solver.t:.4g} s"
            what = f"the motion becomes too fast to integrate at {when}: shorten it, or change springs and dampers"
            raise reference.prescribed.error("duration", what)
        times.append(solver.t)
        right.pass_to(solver.t, solver.y)
        pieces.append(dense := solver.dense_output())
        if levels:
            found += watch.crossings(partial(_states, system, dense), times[-2], times[-1])
        if len(pieces) % CHECKED == 0:
            _refuse_lost_loops(system, times, pieces)
        progress(int(1000 * solver.t / duration), 1000)
        if stop and found:
            break
    ends = found[0].t if stop and found else duration
    solution = for_vibrations("scipy.integrate").OdeSolution(times, pieces)
    passed = (time.perf_counter() - began) / len(pieces)
    return Adapted(method, solution, ends, len(pieces), passed, tuple(found[:1] if stop else found))


def _refuse_lost_loops(system: CompiledMotion, times: Sequence[float], pieces: Sequence[Any]) -> None:
    """Raise `InputError` by loop and time where the last steps leave the branch on which loops start, or end there."""
    machine, last = system.reference.machine, pieces[-CHECKED:]
    if not last or not machine.loops or system.closing:
        return
    t = np.array(times[-len(last) :])
    q, qd = system.states_of_joints(t, np.array([piece(end) for piece, end in zip(last, t, strict=True)]))
    gone, ahead = np.full((1, q.shape[1]), np.nan), t[-1] + system.reference.duration / LONGEST
    motion = State({"q": np.vstack([q, gone]), "qd": np.vstack([qd, gone])})
    refuse_lost(machine, "simulate", np.append(t, ahead), motion)


def _states(system: CompiledMotion, dense: Any, t: Array) -> tuple[Array, Array]:
    return system.states_of_joints(t, dense(t).T)


class _FromLastStep:
    """The right side of a motion, its loops closed from the end of the last step."""

    def __init__(self, system: CompiledMotion) -> None:
        self.system = system
        self._near: State = system.reference.at_start

    def rate(self, t: float, y: Array) -> Array:
        """Return y'."""
        return self.system.rate(t, y, self._near)

    def jacobian(self, t: float, y: Array) -> Array:
        """Return dy'/dy."""
        return self.system.jacobian(t, y, self._near)

    def pass_to(self, t: float, y: Array) -> None:
        """Take up a step that ends here."""
        self._near = self.system.states(np.array([t]), y[None], self._near)[0]


def _solver(right: _FromLastStep, method: str, precision: float) -> Any:
    system = right.system
    duration = system.reference.duration
    more = {"jac": right.jacobian} if method == "Radau" else {}
    return getattr(for_vibrations("scipy.integrate"), method)(
        right.rate,
        0.0,
        system.start,
        duration,
        rtol=precision,
        atol=ABSOLUTE * precision,
        max_step=duration / LONGEST,
        **more,
    )


def simulate_adaptively(
    reference: Reference,
    request: Request,
    events: Mapping[str, float],
    stop: bool = False,
    announce: Announce = announce_nothing,
    progress: Progress = no_progress,
) -> Simulation:
    """Return a motion by adapted steps whose measured errors are tolerable, with the crossings of levels by signal.

    Raises `InputError`, `CompilerMissing`, `CompilationFailed`.
    """
    simulating = Simulating(reference, request)
    refuse_machines_without_steps(reference.machine, ())
    refuse_unresolved(reference)
    levels = [level_of(reference.machine, name, level) for name, level in events.items()]
    announce("compile")
    with TemporaryDirectory() as folder:
        system = compiled_motion(reference, Path(folder))
        method = method_for(system)
        runs = []
        for precision in PRECISIONS:
            announce(f"{method}, {precision:.0e}")
            runs.append(integrate(system, method, precision, levels, stop, progress))
            if len(runs) > 1:
                found = _compared(simulating, system, *runs[-2:])
                if relative(found.errors, found.tolerance) <= 1:
                    break
        return found


def _compared(simulating: Simulating, system: CompiledMotion, coarse: Adapted, fine: Adapted) -> Simulation:
    """Return the coarse motion; its errors are its distance from the fine one."""
    reference, observer = simulating.reference, simulating.observer
    t = coarse.samples
    trajectory = coarse.trajectory(system, t)
    refuse_lost_loops(reference, trajectory)
    refuse_turned(reference, trajectory)
    motion = observer.motion(trajectory)
    outputs = observer.outputs(motion)
    common = np.minimum(t, fine.ends)
    exact = observer.outputs(observer.motion(fine.trajectory(system, common)))
    errors = dict(zip(simulating.names, np.abs(outputs - exact).max(axis=0).tolist(), strict=True))
    deviation = simulating.deviation(motion, outputs)
    return Simulation(
        reference,
        trajectory,
        motion,
        simulating.names,
        outputs,
        deviation,
        errors,
        dict(simulating.request.tolerance or simulating.usual(deviation)),
        {},
        0,
        energy_balance(reference, motion),
        None,
        np.inf,
        None,
        coarse.crossings,
    )
