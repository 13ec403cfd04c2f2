"""Drift of energy in a simulated free motion without losses, by the format of the state.

A step changes a state by little, so a state in single precision loses most of a change to rounding, whatever the
accuracy of the accelerations. A compensated sum keeps the rounding; a state in double precision hardly loses any.
"""

from __future__ import annotations

import ctypes
import math
import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.codegen.compile import TYPES, compile_library, load_library
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, MIXED, SINGLE, Precision
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.codegen.templates import render
from symoro_elastic.foundation.array_types import AnyArray
from symoro_elastic.foundation.progress import Progress
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Base, Friction, Machine, Wrench
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.bound.state import State, closing_models, rows_carried, split_into
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.models.programs.catalogue import TracedModel, trace
from symoro_elastic.numerics.evaluation.arrays import EXTENDED, evaluate_arrays
from symoro_elastic.numerics.evaluation.assembled_states import start_of
from symoro_elastic.numerics.verification.states import States, moderate_states

STEPS, SAMPLES = 50_000, 50
LARGEST_TURN = 0.05
"""Largest step times the fastest rate of the machine, at first."""
HALVINGS = 12
NEGLIGIBLE_DRIFT = 1e-10
"""Drift in double precision, relative to the energy that moves, at which the step is small enough."""
DRIFT_FLAGS = ("-O2", "-ffp-contract=off")


@dataclass(frozen=True)
class StateFormat:
    """Precision of the right-hand side, and format of the state."""

    title: str
    precision: Precision
    compensated: bool = False


STATE_FORMATS = (
    StateFormat("all double", DOUBLE),
    StateFormat("single, state in double (mixed)", MIXED),
    StateFormat("single, compensated state", SINGLE, True),
    StateFormat("all single", SINGLE),
)


@dataclass(frozen=True)
class Drift:
    """Largest change of energy, J, after `steps` of `step` seconds; `energy` is kinetic and elastic."""

    title: str
    drift: float
    energy: float
    steps: int
    step: float


def drifts(machine: Machine, values: Mapping[str, float], folder: Path, progress: Progress) -> list[Drift]:
    """Return the drifts by format of the state, over the same free motion of a machine without losses.

    Raises `InputError` where no such motion can be computed, `CompilerMissing`, `CompilationFailed`.
    """
    motion = _Motion(conservative(machine), values, folder)
    step, energies = motion.small_step()
    results = []
    for done, form in enumerate(STATE_FORMATS, start=1):
        drift = motion.energies(form, step) if form is not STATE_FORMATS[0] else energies
        results.append(Drift(form.title, _drift(drift), motion.moving_energy, STEPS, step))
        progress(done, len(STATE_FORMATS))
    return results


def conservative(machine: Machine) -> Machine:
    """Return the machine without damping, friction and external wrenches, on a base at rest."""
    none = Formula.parse(0)
    joints = tuple(
        replace(x, spring=replace(x.spring, damping=none), friction=Friction(), wrench=Wrench()) for x in machine.joints
    )
    return replace(machine, joints=joints, base=Base(gravity=machine.base.gravity))


def _drift(energies: AnyArray) -> float:
    """Return the largest difference from the first energy."""
    largest = float(np.abs(energies - energies[0]).max())
    return largest if math.isfinite(largest) else math.inf


class _Motion:
    """One free motion of a machine, computed in several ways."""

    def __init__(self, machine: Machine, values: Mapping[str, float], folder: Path) -> None:
        self.machine, self.values = machine, values
        self.energy = trace(machine, "energy")
        self.closing = [trace(machine, name) for name in closing_models(machine)]
        models = ("direct_dynamics", *closing_models(machine))
        self.package = trace_models(machine, Scene(models=models)).package
        self.p = np.array([values[parameter.name] for parameter in self.package.parameters], dtype=float)
        self.start = self._start()
        kinetic, _, elastic = self._values(self.energy, self.start)[0]
        self.moving_energy = float(kinetic + elastic)
        self._moves = _movers(self.package, folder, bool(self.closing))

    def _start(self) -> States:
        """A start state near the springs' neutral positions, exact in single precision; no motor acts."""
        state = moderate_states(self.machine, 2, values=dict(self.values))[1:2]
        single = {name: getattr(state, name).astype(np.float32).astype(float) for name in ("q", "qd")}
        return self._with_loops_closed(state.with_blocks(**single, tau=np.zeros_like(state.tau)))

    def _with_loops_closed(self, states: States) -> States:
        """The states with loops closed more accurately, if they have no closed form."""
        for model in self.closing:
            closed = State(evaluate_arrays(model, states, self.values, EXTENDED))
            states = states.with_blocks(**closed.only(states.blocks))
        return states

    def small_step(self) -> tuple[float, AnyArray]:
        """The step whose energy drift is caused by rounding alone, and the energies with it."""
        step = LARGEST_TURN / self._fastest_rate()
        for _ in range(HALVINGS):
            energies = self.energies(STATE_FORMATS[0], step)
            if _drift(energies) <= NEGLIGIBLE_DRIFT * abs(self.moving_energy):
                return step, energies
            step /= 2
        what = f"energy still drifts in double precision with steps of {step:.1g} s"
        raise self.machine.error("trade", what)

    def _fastest_rate(self) -> float:
        """The fastest rate of springs against inertias and of the motion itself, 1/s."""
        A = self._values(trace(self.machine, "inertia_matrix"), self.start)[0].astype(float)
        qdd = self._values(trace(self.machine, "direct_dynamics"), self.start)[0].astype(float)
        values = {**self.values, **start_of(self.machine).by_variable}
        stiffness = [self.machine.joint(j).spring.stiffness.value(values) for j in self.machine.independent]
        try:
            squares = np.linalg.eigvals(np.linalg.solve(A.reshape(len(qdd), -1), np.diag(stiffness)))
        except np.linalg.LinAlgError:
            squares = np.zeros(1)
        rate = float(np.sqrt(np.abs(squares).max(initial=0.0)) + np.abs(self.start.qd).max(initial=0.0))
        rate += float(np.sqrt(np.abs(qdd).max(initial=0.0)))
        if not math.isfinite(rate):
            raise self.machine.error("trade", "it has no finite accelerations")
        return max(rate, 1.0)

    def energies(self, form: StateFormat, step: float) -> AnyArray:
        """Energies at the start and at `SAMPLES` times of the motion, J, by steps in a format of the state."""
        move, dtype = self._moves[form.precision.name], TYPES[form.precision.state]
        carried = self.start[0].only(row.name for row in rows_carried(self.machine))
        x = np.concatenate([*carried.values()]).astype(dtype)
        lost, p = np.zeros_like(x), self.p.astype(dtype)
        states = [x.copy()]
        for _ in range(SAMPLES):
            move(STEPS // SAMPLES, step, form.compensated, p.ctypes.data, x.ctypes.data, lost.ctypes.data)
            states.append(x.copy())
        moved = split_into(carried, np.array(states, dtype=float))
        sampled = self.start[np.zeros(len(states), dtype=int)].with_blocks(**moved)
        return np.asarray(self._values(self.energy, self._with_loops_closed(sampled)).sum(axis=1))

    def _values(self, traced: TracedModel, states: States) -> AnyArray:
        (result,) = evaluate_arrays(traced, states, self.values, EXTENDED).values()
        return result


def _movers(package: Package, folder: Path, assembles: bool) -> dict[str, Any]:
    """The compiled functions that advance a state by many steps, by precision."""
    precisions = {form.precision.name: form.precision for form in STATE_FORMATS}
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        functions = pool.map(lambda x: _mover(package, x, folder / x.name, assembles), precisions.values())
        return dict(zip(precisions, functions, strict=True))


def _mover(package: Package, precision: Precision, folder: Path, assembles: bool) -> Any:
    name = package.name + precision.suffix
    motion = render(
        "c/motion.c.j2",
        name=name,
        macro=name.upper(),
        direct_dynamics=precision.function(package.name, "direct_dynamics"),
        assemble=precision.function(package.name, "assemble") if assembles else "",
        precision=precision,
    )
    files = render_c(package, precision) | {f"{name}_motion.c": motion}
    library = load_library(compile_library(files, folder, flags=DRIFT_FLAGS))
    move = library[f"{name}_move"]
    move.argtypes = [ctypes.c_size_t, ctypes.c_double, ctypes.c_int, *[ctypes.c_void_p] * 3]
    move.restype = None
    return move
