"""Motions simulated by integrators with steps of their own; their error is measured by a smaller tolerance."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from symoro_elastic.model_ladder.resolution import refuse_unresolved
from symoro_elastic.model_ladder.simulate import Request, Simulating
from symoro_elastic.model_ladder.spring_errors import relative
from symoro_elastic.models.time_steps import refuse_machines_without_steps
from symoro_elastic.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.simulation.adaptive import Adapted, CompiledMotion, integrated, method_for
from symoro_elastic.simulation.adaptive_on_base import compiled_motion
from symoro_elastic.simulation.compiled_steps import refuse_lost_loops, refuse_turned
from symoro_elastic.simulation.energy_balance import energy_balance
from symoro_elastic.simulation.events import level_of
from symoro_elastic.simulation.reference import Reference
from symoro_elastic.simulation.simulated import Simulation

PRECISIONS = (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)
"""Relative tolerances of a step: the error at each is measured by the next one."""


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
            runs.append(integrated(system, method, precision, levels, stop, progress))
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
