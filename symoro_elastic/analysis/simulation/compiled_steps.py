"""Generated time steps of a machine, compiled, and executed along a reference motion."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.moving_base import rows
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.codegen.c.steps import Run, render_runs, runs
from symoro_elastic.codegen.compile import CompiledPackage, compile_library, function_in, load_library
from symoro_elastic.codegen.integration.tableaus import METHODS, nodes_of
from symoro_elastic.codegen.local_names import with_own_results
from symoro_elastic.codegen.package import EXTERNAL
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.targets.c import render_c, source_text
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.machine.described import drives_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.bound.state import State, split_into
from symoro_elastic.models.drives.drive_states import states_at_rest
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.models.steps import closed_dynamics
from symoro_elastic.models.steps.implicit_steps import Motors
from symoro_elastic.models.steps.time_steps import PASSED, PASSED_TORQUES, TERMS, refuse_machines
from symoro_elastic.numerics.evaluation.closed_positions import refuse_lost
from symoro_elastic.numerics.motion.signals import FrameSignal, outputs

FLAGS = ("-O2",)
"""Wider vectors wait for numbers that were just stored, and cost more than they save here."""
CHUNK = 4096
"""Steps between two looks at the clock and at the interrupt key."""
MOST_RECORDED = 100_000
"""States that are kept of a motion."""
NOTHING_TO_INTEGRATE = "every joint is a motor that follows exactly, so nothing is integrated: give the motors servos"


@dataclass(frozen=True)
class Trajectory(Motion):
    """States along a motion: state variables of steps, and the torques.

    `step` is the time between steps and `seconds` what one took; a motion of many steps keeps some of them only.
    `numbers` are those of the steps that are kept where intervals differ in length, `step` is then the longest.
    """

    method: str
    step: float
    steps: int
    seconds: float
    numbers: AnyArray | None = None

    @property
    def recorded(self) -> AnyArray:
        """Numbers of the steps at which states are recorded."""
        return np.round(self.t / self.step).astype(np.int64) if self.numbers is None else self.numbers


class CompiledSteps:
    """Compiled time steps of some methods for the motors of a reference, driven by servos or prescribed.

    The machine is that of references, or `loaded` where forces act on frames. Numbers of the machine are
    folded; where a subclass leaves parameters, `p` holds their numbers at a run.
    """

    fold: str | tuple[str, ...] = ALL
    flags: tuple[str, ...] = FLAGS
    p: Array | None = None

    def __init__(self, machine: Machine, methods: Sequence[str], folder: Path, precision: Precision = DOUBLE) -> None:
        """Prepare the steps; states are in double precision, so `precision` is `DOUBLE` or `MIXED`.

        Raises `InputError`, `CompilerMissing`, `CompilationFailed`.
        """
        refuse_machines(machine, methods)
        self.machine = machine
        scene = Scene(models=("direct_dynamics",), steps=tuple(methods), fold=self.fold)
        self.package = trace_models(machine, scene).package
        text = source_text(with_own_results(self.package), precision)
        self.name = self.package.name + precision.suffix
        files = render_c(self.package, precision) | render_runs(self.name, text.steps)
        path = compile_library(files, folder, flags=self.flags)
        library = load_library(path)
        self.runs = {run.name: run for run in runs(text.steps)}
        self._entries = {name: _entry(library, run) for name, run in self.runs.items()}
        self._models = CompiledPackage(self.package, path, precision)

    def run(self, reference: Reference, method: str, steps: int, progress: Progress = no_progress) -> Trajectory:
        """Return the motion along a reference, simulated by equal steps; NaN or infinite if it diverges."""
        refuse_still(reference)
        refuse_sampled(reference)
        if reference.loaded.forces != self.machine.forces:
            raise reference.prescribed.error("forces", "these steps were generated for a machine under other forces")
        h = reference.duration / steps
        run = self.runs[f"{self.name}_step_{method}{ways_of(reference).suffix}"]
        state = {name: block.copy() for name, block in self.at_start(reference).items() if name in run.written}
        every = -(-steps // MOST_RECORDED)
        records, passed = [np.concatenate(list(state.values()))[None]], 0.0
        width = sum(run.written.values())
        for first in range(0, steps, CHUNK):
            count = min(CHUNK, steps - first)
            inputs = inputs_of_steps(reference, method, h * np.arange(first, first + count, dtype=float), h)
            record = np.empty((count, width))
            passed += self.take(run, [inputs[name] for name in run.read], h, state, record)
            last = [k for k in range(count) if (first + k + 1) % every == 0 or first + k + 1 == steps]
            records.append(record[last])
            progress(first + count, steps)
        numbers = [0, *(k for k in range(1, steps + 1) if k % every == 0 or k == steps)]
        t = np.array(numbers) * h
        states = {**rows(reference.base, len(t)), **split_into(state, np.concatenate(records))}
        moved = self.with_loads(reference, self.with_torques(reference, Motion(states, t)))
        return Trajectory(moved.blocks, t, method, h, steps, passed / steps)

    def take(self, run: Run, read: Sequence[Array], h: float, state: Mapping[str, Array], record: Array) -> float:
        """Advance `state` in place by a step for each row of the record; return the elapsed seconds."""
        began = time.perf_counter()
        self._call(run, len(record), read, h, [*state.values(), record])
        return time.perf_counter() - began

    def at_start(self, reference: Reference) -> dict[str, Array]:
        """Return the state at the start by block: drives in steady state, friction relaxed."""
        z = np.zeros(len(self.machine.bristles))
        if reference.drives:
            r, rd, _ = ([*x[0]] for x in reference.at(np.zeros(1)))
            z = np.concatenate([z, states_at_rest(self.machine, r, rd, [*reference.start.torques])])
        return {**reference.at_start.blocks, "z": z}

    def with_torques(self, reference: Reference, motion: Motion, added: Array | None = None) -> Motion:
        """Return the motion with torques of drives or servos; of the states z it keeps only those of friction.

        `added` (N, m) are the torques that drives are given, in place of those that are fed forward.
        """
        if not reference.drives:
            return with_servo_torques(reference, motion)
        tau = reference.fed_torques(motion.t) if added is None else added
        values = dict(zip(("r", "rd", "rdd"), reference.at(motion.t), strict=True))
        values |= {"tau": tau, "load": np.zeros((len(motion.t), len(self.machine.loaded)))}
        torques = self._results(reference, closed_dynamics.NAME, motion.with_blocks(**values))["tau_m"]
        friction = len(reference.machine.bristles)
        blocks = {**motion.blocks, "z": motion.z[:, :friction], "tau": torques}
        return replace(motion, blocks={name: x for name, x in blocks.items() if friction or name != "z"})

    def with_loads(self, reference: Reference, motion: Motion) -> Motion:
        """Return the motion with the torques through joints with load-dependent friction."""
        if not self.machine.loaded:
            return motion
        driven = ways_of(reference) is Motors.DRIVEN
        driving = motion.with_blocks(qdd_motor=reference.at(motion.t)[2]) if driven else motion
        model = "inverse_dynamics" if driven else "direct_dynamics"
        results = under_loads(self.machine, lambda name, state: self._results(reference, name, state), model, driving)
        return motion.with_blocks(load=results["load"])

    def _results(self, reference: Reference, function: str, state: State) -> dict[str, Array]:
        """Return the results of a generated function at states along a motion."""
        called = next(f for f in self.package.functions if f.name == function)
        assert isinstance(state, Motion)
        values = {**state.blocks, EXTERNAL: reference.wrenches(state.t)[0]}
        values |= {} if self.p is None else {"p": self.p}
        accepted = {argument.name for argument in called.arguments} | {"p"}
        return self._models.call(function, **{name: x for name, x in values.items() if name in accepted})

    def _call(self, run: Run, count: int, read: Sequence[Array], h: float, written: Sequence[Array]) -> None:
        arrays = [np.ascontiguousarray(array) for array in read]
        p = None if self.p is None else self.p.ctypes.data
        into = (array.ctypes.data for array in written)
        self._entries[run.name](count, *(array.ctypes.data for array in arrays), h, p, *into)


def ways_of(reference: Reference) -> Motors:
    """Return how the motors of a reference are driven: by torques, drives, servos, or prescribed motions."""
    if not reference.motors:
        return Motors.TORQUE
    if reference.drives:
        return Motors.DRIVES
    return Motors.DRIVEN if reference.servo is None else Motors.SERVO


def with_servo_torques(reference: Reference, motion: Motion) -> Motion:
    """Return the motion with torques of servos; NaN for exactly prescribed motors, whose torques are computed later."""
    if reference.servo is None:
        return motion.with_blocks(tau=np.full((len(motion.t), len(reference.motors)), np.nan))
    return motion.with_blocks(tau=law_of_servos(reference, motion.t, *reference.of_motors(motion)))


def law_of_servos(reference: Reference, t: Array, x: Array, xd: Array) -> Array:
    """Return the torques of servos (N, m) where motors are at x and move at xd (N, m)."""
    assert reference.servo is not None
    y, yd, _ = reference.at(t)
    kp, kd = reference.servo
    return np.asarray(reference.fed_torques(t) + kp * (y - x) + kd * (yd - xd))


def refuse_sampled(reference: Reference) -> None:
    """Raise `InputError` for continuous drives that measure rotations of frames, or frames on static springs."""
    machine, drives = reference.machine, drives_of(reference.machine).by_motor
    for motor, load in zip(reference.motors, reference.loads, strict=False):
        if load is None or drives[motor].period is not None:
            continue
        (signal,) = outputs(machine, [load.signal])
        if isinstance(signal, FrameSignal) and (signal.component > 2 or machine.static):
            of = "frames on static springs" if machine.static else "rotations of frames"
            what = f"even steps do not measure {of}: simulate with --adaptive"
            raise machine.error(f"drives, {motor}, measured", what)


def refuse_still(reference: Reference) -> None:
    """Raise `InputError` for a machine without equations to integrate, all of whose joints are prescribed or locked."""
    machine, prescribed = reference.machine, reference.prescribed
    if reference.base:
        return
    machine.refuse_without_motors("motors")
    if reference.servo is None and len(machine.motors) == len(machine.independent):
        raise prescribed.error("servo", NOTHING_TO_INTEGRATE)


def refuse_turned(reference: Reference, run: Trajectory) -> None:
    """Raise `InputError` for a motor on a dependent joint that turns by half a turn or more from its start.

    Its closed form determines angles up to a full turn, so its servo would receive another one there.
    """
    machine, (x, _) = reference.machine, reference.of_motors(run)
    for m, joint in enumerate(machine.motor_joints):
        jumps = np.abs(np.diff(x[:, m])) > np.pi
        if jumps.any() and joint.sigma == 0 and machine.motors[m] in machine.dependent:
            when = f"simulate: at {run.t[int(np.argmax(jumps))]:.4g} s it is half a turn away from its start"
            raise machine.error(f"joint {joint.name}", f"{when}: make it independent (dependent = [...])")


def refuse_lost_loops(reference: Reference, run: Trajectory) -> None:
    """Raise `InputError` by loop and time if a motion leaves the branch on which its loops start."""
    refuse_lost(reference.machine, "simulate", run.t, run)


def reference_motion(reference: Reference, steps: int) -> Trajectory:
    """Return the motion of a machine whose joints all follow the reference exactly."""
    t = np.linspace(0.0, reference.duration, steps + 1)
    q, qd, _ = (x[:, np.argsort(reference.machine.motor_entries)] for x in reference.at(t))
    blocks = {"q": q, "qd": qd, "tau": np.full_like(q, np.nan)}
    return Trajectory(blocks, t, "", reference.duration / steps, steps, 0.0)


def inputs_of_steps(
    reference: Reference, method: str, begins: Array, h: float, torques: Array | None = None
) -> dict[str, Array]:
    """Return the inputs of steps from motors and forces, a row for each node of each step.

    `torques` (m,) are torques that sampled drives hold, in place of those that are fed forward.
    """
    nodes = np.array(nodes_of(METHODS[method], driven=reference.servo is None), dtype=float)
    times = (begins[:, None] + h * nodes).ravel()
    y, yd, ydd = (x.reshape(len(begins), -1) for x in reference.at(times))
    forces = {"f_ext": reference.wrenches(times)[0].reshape(len(begins), -1), "f_extd": reference.wrenches(begins)[1]}
    forces |= {name: np.tile(block, (len(begins), len(nodes))) for name, block in reference.base.items()}
    if not reference.motors:
        return forces | {"tau": np.zeros((len(begins), 0))}
    if reference.servo is None:
        return forces | {"y": y, "yd": yd, "ydd": ydd, "yddd": reference.jerks(begins)}
    kp, kd = reference.servo
    if reference.drives:
        tau = reference.fed_torques(times) if torques is None else np.tile(torques, (len(times), 1))
        return forces | {"tau": tau.reshape(len(begins), -1), "r": y, "rd": yd, "rdd": ydd}
    _, rate, change = reference.at(begins)
    return forces | {
        "tau": reference.fed_torques(times).reshape(len(begins), -1),
        "r": y,
        "rd": yd,
        "kp": kp,
        "kd": kd,
        "taud": kp * rate + kd * change + _rate_of_feed(reference, begins, h),
    }


def _rate_of_feed(reference: Reference, t: Array, h: float) -> Array:
    """Return the rates of fed-forward torques, by central differences over a step; 0 for constant torques."""
    if reference.feed is None:
        return np.zeros_like(t)[:, None]
    ahead, behind = (reference.feed(np.clip(t + x, 0.0, reference.duration)) for x in (h / 2, -h / 2))
    return (ahead - behind) / h


def _entry(library: ctypes.CDLL, run: Run) -> Any:
    entry = function_in(library, f"{run.name}_run")
    read = [ctypes.c_void_p] * len(run.read)
    written = [ctypes.c_void_p] * (len(run.written) + 1)
    entry.argtypes, entry.restype = [ctypes.c_size_t, *read, ctypes.c_double, ctypes.c_void_p, *written], None
    return entry


# Torques through joints with load-dependent friction: solved with that friction, by substitution.
SUBSTITUTIONS, EXTRAPOLATED, SETTLED = 1000, 30, 1e-13
"""Of torques that friction rises with: at most, those with limits between them, relative change of the last one
by the sizes of their terms."""


def under_loads(
    machine: Machine, call: Callable[[str, State], dict[str, Array]], dynamics: str, state: Motion
) -> dict[str, Array]:
    """Return the results of a dynamic model, and the torques `load` through joints with load-dependent friction.

    `call` gives the results of a generated function at states. Raises `InputError` where loads do not settle.
    """
    if not machine.loaded:
        return call(dynamics, state)
    loads = [np.zeros((len(state.t), len(machine.loaded)))]
    for number in range(1, SUBSTITUTIONS):
        results = call(dynamics, state.with_blocks(load=loads[-1]))
        moved = {name: results[name] for name in ("tau", "qdd") if name in results}
        passed = call(PASSED_TORQUES, state.with_blocks(load=loads[-1], **moved))
        load = passed[PASSED]
        if not (np.abs(load - loads[-1]) > SETTLED * passed[TERMS].sum(axis=1, keepdims=True)).any():
            return results | {"load": load}
        loads = [*loads[-2:], load]
        if number % 3 == 2 and number < EXTRAPOLATED:
            x, y, z = loads
            bend = z - 2 * y + x  # Aitken's rule: the limit of geometric convergence
            is_bent = np.abs(bend) > 1e-9 * np.abs(z - y)
            loads = [z - np.divide((z - y) ** 2, bend, out=np.zeros_like(z), where=is_bent)]
    names = ", ".join(machine.joint(j).name for j in machine.loaded)
    raise machine.error(f"friction, {names}, load", "the torque through the joint does not settle: lower load")
