"""Motions by adaptive integrators of scipy, from the compiled right-hand side and its derivatives.

Radau where the machine is stiff over the motion, DOP853 elsewhere. Methods of multiple steps are not used: those of
order above 2 grow where springs have little damping.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.control.cascade import Hold
from symoro_elastic.analysis.simulation.compiled_steps import Trajectory, refuse_lost_loops, refuse_turned
from symoro_elastic.analysis.simulation.driven import DrivenMotion
from symoro_elastic.analysis.simulation.prediction.resolution import refuse_unresolved
from symoro_elastic.analysis.simulation.prediction.spring_errors import relative
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.analysis.simulation.right_side import CompiledMotion, CompiledMotionOnBase
from symoro_elastic.analysis.simulation.sampled_drives import SampledMotion
from symoro_elastic.analysis.simulation.simulate import Request, Simulating
from symoro_elastic.analysis.simulation.simulated import Crossing, Level, Simulation, Watch, energy_balance, level_of
from symoro_elastic.analysis.vibration.following import TOO_FAST
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.output_files import temporary_folder
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.models.bound.state import State
from symoro_elastic.models.steps.time_steps import refuse_machines
from symoro_elastic.numerics.evaluation.closed_positions import refuse_lost

PRECISIONS = (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)
"""Relative tolerances of a step: the error at each is measured by the next one."""

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


def compiled_motion(reference: Reference, folder: Path) -> CompiledMotion:
    """Return the right-hand side of a motion with its kind of drives, with the base if it moves freely.

    Raises `InputError`, `CompilerMissing`, `CompilationFailed`.
    """
    if reference.drives:
        sampled = any(isinstance(x, Hold) for drive in reference.drives for x in drive.path)
        return (SampledMotion if sampled else DrivenMotion)(reference, folder)
    return (CompiledMotionOnBase if reference.base else CompiledMotion)(reference, folder)


@dataclass(frozen=True)
class Adapted:
    """A motion by adaptive steps: y of a `system` as a function of time (`dense`) up to `ends`, and level crossings."""

    system: CompiledMotion
    method: str
    dense: Any
    ends: float
    steps: int
    seconds: float
    crossings: tuple[Crossing, ...]

    @property
    def samples(self) -> Array:
        """Equidistant times (N,) that resolve the steps."""
        count = min(max(SAMPLES, SAMPLES_OF_STEP * self.steps), MOST_SAMPLES)
        return np.linspace(0.0, self.ends, count + 1)

    def trajectory(self, t: Array) -> Trajectory:
        """Return the states and torques at times (N,)."""
        y, system = self.dense(t).T, self.system
        motion = system.states(t, y, system.reference.at_start)
        if system.reference.machine.loaded:
            motion = motion.with_blocks(load=system.accelerations(motion, y)["load"])
        blocks, step = motion.with_blocks(tau=system.torques(motion, y)).blocks, self.ends / self.steps
        return Trajectory(blocks, t, self.method, step, self.steps, self.seconds)


def method_for(system: CompiledMotion) -> str:
    """Return Radau if a pole at the start, or a bristle, is fast over the motion, else the explicit method."""
    if len(system.largest_bent) and system.explicit == CompiledMotion.explicit:
        return "Radau"
    poles = np.linalg.eigvals(system.jacobian(0.0, system.start, system.reference.at_start))
    return "Radau" if np.abs(poles).max(initial=0.0) * system.reference.duration > STIFF else system.explicit


def integrate(
    system: CompiledMotion,
    method: str,
    precision: float,
    levels: Sequence[Level] = (),
    stop: bool = False,
    progress: Progress = no_progress,
) -> Adapted:
    """Return the motion at a relative tolerance of a step, until the first crossing with `stop`.

    Raises `InputError` where steps get too small or many.
    """
    system = system.copy_at_start()
    reference, watch = system.reference, Watch(levels)
    began, duration = time.perf_counter(), reference.duration
    right = _FromLastStep(system)
    steps = _steps(right, method, precision)
    times, pieces, crossings = [0.0], list[Any](), list[Crossing]()
    for solver, failure in steps:
        if failure or not np.isfinite(solver.y).all() or len(times) > MOST_STEPS:
            _refuse_lost_loops(system, times, pieces)
            raise reference.prescribed.error("duration", TOO_FAST.format(solver.t))
        times.append(solver.t)
        right.pass_to(solver.t, solver.y)
        pieces.append(dense := solver.dense_output())
        if levels:
            crossings += watch.crossings(partial(_states, system, dense), times[-2], times[-1])
        if len(pieces) % CHECKED == 0:
            _refuse_lost_loops(system, times, pieces)
        progress(int(1000 * solver.t / duration), 1000)
        if stop and crossings:
            break
    ends = crossings[0].t if stop and crossings else duration
    solution = for_vibrations("scipy.integrate").OdeSolution(times, pieces)
    passed = (time.perf_counter() - began) / len(pieces)
    return Adapted(system, method, solution, ends, len(pieces), passed, tuple(crossings[:1] if stop else crossings))


def _refuse_lost_loops(system: CompiledMotion, times: Sequence[float], pieces: Sequence[Any]) -> None:
    """Raise `InputError` by loop and time if loops leave their initial branch in the last steps or right after."""
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
    """The right-hand side of a motion, with loops closed iteratively from the state at the end of the last step."""

    def __init__(self, system: CompiledMotion) -> None:
        self.system = system
        self._near: State = system.reference.at_start

    def rate(self, t: float, y: Array) -> Array:
        """Return the time derivative y' of the state."""
        return self.system.rate(t, y, self._near)

    def jacobian(self, t: float, y: Array) -> Array:
        """Return the Jacobian dy'/dy of the right-hand side."""
        return self.system.jacobian(t, y, self._near)

    def pass_to(self, t: float, y: Array) -> None:
        """Store the end of a step as the start of the next loop closures."""
        self._near = self.system.states(np.array([t]), y[None], self._near)[0]


def _steps(right: _FromLastStep, method: str, precision: float) -> Iterator[tuple[Any, Any]]:
    """Yield the solver after each step, and the reason if it fails; it restarts at every interval.

    Steps of a short interval are its halves, quarters ... for higher precisions, to differ and so measure errors.
    """
    system = right.system
    more = {"jac": right.jacobian} if method == "Radau" else {}
    longest, y, step = system.reference.duration / LONGEST, system.start, None
    pieces = 2 ** max(0, round(np.log10(PRECISIONS[0] / precision) / 2))
    for number, (begins, ends) in enumerate(system.intervals):
        system.begin(number, begins, y)
        solver = getattr(for_vibrations("scipy.integrate"), method)(
            *(right.rate, begins, y, ends),
            rtol=precision,
            atol=ABSOLUTE * precision * system.sizes,
            max_step=min(longest, (ends - begins) / pieces),
            first_step=None if step is None else min(step, ends - begins),
            **more,
        )
        while solver.status == "running":
            yield solver, solver.step()
            step = solver.step_size
        y = solver.y


def simulate_adaptively(
    reference: Reference,
    request: Request,
    events: Mapping[str, float],
    stop: bool = False,
    announce: Announce = announce_nothing,
    progress: Progress = no_progress,
) -> Simulation:
    """Return a motion by adaptive steps whose measured errors meet the tolerances, with level crossings.

    Raises `InputError`, `CompilerMissing`, `CompilationFailed`.
    """
    simulating = Simulating(reference, request)
    refuse_machines(reference.machine, ())
    refuse_unresolved(reference)
    levels = [level_of(reference.machine, name, level) for name, level in events.items()]
    announce("compile")
    with temporary_folder() as folder:
        system = compiled_motion(reference, Path(folder))
        method = method_for(system)
        runs = []
        for precision in PRECISIONS:
            announce(f"{method}, {precision:.0e}")
            runs.append(integrate(system, method, precision, levels, stop, progress))
            if len(runs) > 1:
                result = _compare(simulating, *runs[-2:])
                if relative(result.errors, result.tolerance) <= 1:
                    break
        return result


def _compare(simulating: Simulating, coarse: Adapted, fine: Adapted) -> Simulation:
    """Return the coarse motion, with its differences from the fine one as errors."""
    reference, observer = simulating.reference, simulating.observer
    t = coarse.samples
    trajectory = coarse.trajectory(t)
    refuse_lost_loops(reference, trajectory)
    refuse_turned(reference, trajectory)
    motion = observer.motion(trajectory)
    outputs = observer.outputs(motion)
    common = np.minimum(t, fine.ends)
    exact = observer.outputs(observer.motion(fine.trajectory(common)))
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
