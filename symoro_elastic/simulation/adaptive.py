"""Motions by integrators of scipy with steps of their own: the generated right side and its derivatives, compiled.

    y' = [v; qdd(q, v, t)],    dy'/dy = [0 I; -M^-1 K, -M^-1 D]

M, D, K are those of the model `linearization`, with the gains of servos; y holds the joints that do not follow exactly.
Radau where the machine is stiff over the motion, DOP853 elsewhere. Methods of multiple steps are not used: those of
order above 2 grow where springs have little damping.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.codegen.compile import CompiledPackage, compile_library
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.motor_coordinates import MOTOR_COORDINATES, dependent_motors, motor_coordinates
from symoro_elastic.numerics.closed_positions import Followed
from symoro_elastic.numerics.loop_passages import refuse_lost
from symoro_elastic.numerics.values import given_values
from symoro_elastic.packages import for_vibrations
from symoro_elastic.progress import Progress, no_progress
from symoro_elastic.simulation.compiled_steps import Trajectory, law_of_servos, refuse_still, servo_torques
from symoro_elastic.simulation.events import Crossing, Level, Watch
from symoro_elastic.simulation.moving_base import BaseStates
from symoro_elastic.simulation.reference import Reference
from symoro_elastic.traced import traced

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
        assembled = ("assemble",) if machine.loops and Bound(machine).takes_dependent else ()
        models = (self.dynamics, *self.linear_models, *assembled)
        package = _package(reference.loaded, Scene(models=models, fold=ALL))
        self._compiled = CompiledPackage(package, compile_library(render_c(package), folder, flags=FLAGS))
        self._arguments = {f.name: {argument.name for argument in f.arguments} for f in package.functions}
        self.motors = list(machine.motor_entries)
        driven = self.motors if reference.servo is None else []
        self.free = [k for k in range(len(machine.moving)) if k not in driven]
        self._q_dep = None
        if package.takes_dependent:
            self._q_dep = Followed(machine, given_values(machine)).at(reference.start.q[None])[0]

    @property
    def start(self) -> Array:
        """y (2 f,) at the start."""
        state = self.reference.start
        return np.concatenate([state.q[self.free], state.qd[self.free]])

    def placed(self, t: Array, y: Array) -> tuple[Array, Array]:
        """Return q, qd (N, n) of all joints at times (N,) and y (N, 2 f)."""
        if self.reference.servo is not None:
            q, qd = np.split(y, 2, axis=1)
            return q, qd
        q, qd, _ = self.reference.states(t)
        q[:, self.free], qd[:, self.free] = np.split(y, 2, axis=1)
        return q, qd

    def rate(self, t: float, y: Array) -> Array:
        """Return y' (2 f,)."""
        q, qd = self.placed(np.array([t]), y[None])
        return np.concatenate([qd[0, self.free], self._accelerations(t, q, qd)[0, self.free]])

    def jacobian(self, t: float, y: Array) -> Array:
        """Return dy'/dy (2 f, 2 f).

        Of a servo on a dependent joint kd dS_m/dt is left out, by which the rate of the motor changes with positions.
        """
        q, qd = self.placed(np.array([t]), y[None])
        given = {"tau": self._torques(t, q, qd)} if "tau" in self._arguments["linearization"] else {}
        found = self._call("linearization", t, q=q, qd=qd, qdd=self._accelerations(t, q, qd), **given)
        M, D, K = (found[name][0] for name in ("M", "D", "K"))
        if self.reference.servo is not None:
            S_m = self._slopes(t, q)
            K, D = (matrix + S_m.T * x @ S_m for matrix, x in zip((K, D), self.reference.servo, strict=True))
        rows, f = np.ix_(self.free, self.free), len(self.free)
        J = np.zeros((2 * f, 2 * f))
        J[:f, f:] = np.eye(f)
        J[f:] = -np.linalg.solve(M[rows], np.hstack([K[rows], D[rows]]))
        return J

    def dependent(self, q: Array) -> Array | None:
        """Return q_dep (N, d) at positions (N, n), each from the one before; None where there are none."""
        if self._q_dep is None:
            return None
        self._q_dep = Followed(self.reference.machine, given_values(self.reference.machine)).at(q[:1])[0]
        return np.array([self._assembled(row[None])[0] for row in q])

    def base(self, y: Array) -> BaseStates:
        """Return the states of a floating base at y (N, 2 f); empty where the base is fixed."""
        return {}

    def _given(self, t: float, q: Array, qd: Array) -> dict[str, Array]:
        """Return what is known of the motors: accelerations, or torques (1, m)."""
        at = np.array([t])
        if self.reference.servo is None:
            return {"qdd_motor": self.reference.at(at)[2]}
        return {"tau": self._torques(t, q, qd)}

    def _accelerations(self, t: float, q: Array, qd: Array) -> Array:
        """Return qdd (1, n)."""
        return self._call(self.dynamics, t, q=q, qd=qd, **self._given(t, q, qd))["qdd"]

    def _torques(self, t: float, q: Array, qd: Array) -> Array:
        """Return the torques (1, m) of servos."""
        if MOTOR_COORDINATES not in self._arguments:
            return servo_torques(self.reference, np.array([t]), q, qd)
        of_motors = self._call(MOTOR_COORDINATES, t, q=q, qd=qd)
        return law_of_servos(self.reference, np.array([t]), of_motors["q_motor"], of_motors["qd_motor"])

    def _slopes(self, t: float, q: Array) -> Array:
        """Return S_m (m, n) at a position (1, n): the rates of motors by those of the coordinates."""
        n = q.shape[1]
        if MOTOR_COORDINATES not in self._arguments:
            return np.eye(n)[self.motors]
        rates = [self._call(MOTOR_COORDINATES, t, q=q, qd=row[None])["qd_motor"][0] for row in np.eye(n)]
        return np.stack(rates, axis=1)

    def _call(self, function: str, t: float, **arrays: Array) -> dict[str, Array]:
        if "f_ext" in self._arguments[function]:
            arrays["f_ext"], _ = self.reference.wrenches(np.array([t]))
        if "q_dep" in self._arguments[function]:
            arrays["q_dep"] = self._assembled(arrays["q"])
        return self._compiled.call(function, **arrays)

    def _assembled(self, q: Array) -> Array:
        """Return q_dep (1, d) at a position, from the last one."""
        assert self._q_dep is not None
        found = self._compiled.call("assemble", q=q, q_dep=self._q_dep[None])["q_dep"]
        self._q_dep = found[0]
        return found


def _package(machine: Machine, scene: Scene) -> Package:
    """Return the models of a scene, with positions and rates of motors where these are on dependent joints."""
    found = traced(machine, scene)
    if not dependent_motors(machine):
        return found.package
    return replace(found, models=[*found.models, motor_coordinates(machine, found.folded)]).package


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
        y = self.dense(t).T
        q, qd = system.placed(t, y)
        dependent, base = system.dependent(q), system.base(y)
        tau, step = servo_torques(system.reference, t, q, qd, dependent), self.ends / self.steps
        return Trajectory(t, q, qd, tau, self.method, step, self.steps, self.seconds, dependent, base)


def method_for(system: CompiledMotion) -> str:
    """Return Radau where a pole at the start is fast over the motion, else DOP853."""
    poles = np.linalg.eigvals(system.jacobian(0.0, system.start))
    return "Radau" if np.abs(poles).max(initial=0.0) * system.reference.duration > STIFF else "DOP853"


def integrated(
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
    solver = _solver(system, method, precision)
    times, pieces, found = [0.0], list[Any](), list[Crossing]()
    while solver.status == "running":
        failure = solver.step()
        if failure or not np.isfinite(solver.y).all() or len(times) > MOST_STEPS:
            _refuse_lost_loops(system, times, pieces)
            what = f"the motion gets too fast to follow at {solver.t:.4g} s: shorten it, or change springs and dampers"
            raise reference.prescribed.error("duration", what)
        times.append(solver.t)
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
    if not last or not machine.loops or Bound(machine).takes_dependent:
        return
    t = np.array(times[-len(last) :])
    q, qd = system.placed(t, np.array([piece(end) for piece, end in zip(last, t, strict=True)]))
    gone, ahead = np.full((1, q.shape[1]), np.nan), t[-1] + system.reference.duration / LONGEST
    refuse_lost(machine, "simulate", np.append(t, ahead), np.vstack([q, gone]), np.vstack([qd, gone]))


def _states(system: CompiledMotion, dense: Any, t: Array) -> tuple[Array, Array]:
    return system.placed(t, dense(t).T)


def _solver(system: CompiledMotion, method: str, precision: float) -> Any:
    duration = system.reference.duration
    more = {"jac": system.jacobian} if method == "Radau" else {}
    return getattr(for_vibrations("scipy.integrate"), method)(
        system.rate,
        0.0,
        system.start,
        duration,
        rtol=precision,
        atol=ABSOLUTE * precision,
        max_step=duration / LONGEST,
        **more,
    )
