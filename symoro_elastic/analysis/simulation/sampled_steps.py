"""Even steps of motions with sampled drives: an integer number in each hold interval.

The controllers' own code is called at the start of each period. Between samples a drive is its current loop, under the
held torque: a step of `_drives` with zero gains. Each interval has the same number of steps; a dead time that ends
within a period divides it into two intervals.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.control.cascade import Hold
from symoro_elastic.analysis.simulation.compiled_steps import (
    MOST_RECORDED,
    CompiledSteps,
    Trajectory,
    inputs_of_steps,
    refuse_still,
)
from symoro_elastic.analysis.simulation.driven import ControlledPositions, with_loads
from symoro_elastic.analysis.simulation.moving_base import rows
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.analysis.simulation.sampled_drives import Sampling
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.machine.described import between_samples
from symoro_elastic.models.bound.state import split_into
from symoro_elastic.models.steps.time_steps import WITHOUT_STATES


def is_sampled(reference: Reference) -> bool:
    """Return whether the drives of a motion are sampled."""
    return any(isinstance(x, Hold) for drive in reference.drives for x in drive.path)


def compiled_steps(reference: Reference, methods: Sequence[str], folder: Path) -> CompiledSteps:
    """Return compiled steps of some methods for a reference, with sampled or with continuous drives.

    Raises `InputError`, `CompilerMissing`, `CompilationFailed`.
    """
    lacking = [name for name in methods if reference.drives and name in WITHOUT_STATES]
    if lacking:
        raise reference.prescribed.error("method", f"{lacking[0]} is not offered with drives: use w3")
    if is_sampled(reference):
        return SampledSteps(reference, methods, folder)
    return CompiledSteps(with_loads(reference), methods, folder)


class SampledSteps(CompiledSteps):
    """Compiled time steps of some methods for the motors of a reference under sampled drives."""

    def __init__(
        self, reference: Reference, methods: Sequence[str], folder: Path, precision: Precision = DOUBLE
    ) -> None:
        """Compile the steps; raises `InputError`, `CompilerMissing`, `CompilationFailed`."""
        super().__init__(between_samples(reference.loaded), methods, folder, precision)
        self.sampling, self._measured = Sampling(reference), ControlledPositions(reference)

    def run(self, reference: Reference, method: str, steps: int, progress: Progress = no_progress) -> Trajectory:
        """Return the motion simulated in `steps` steps, equally many in each interval of constant drive torques."""
        refuse_still(reference)
        sampling, run = self.sampling.copy_at_start(), self.runs[f"{self.name}_step_{method}_drives"]
        intervals = [*sampling.intervals]
        per_interval, every = steps // len(intervals), -(-steps // MOST_RECORDED)
        state = {name: block.copy() for name, block in self.at_start(reference).items() if name in run.written}
        records, numbers, times, passed = [np.concatenate([*state.values()])[None]], [0], [0.0], 0.0
        for number, (begins, ends) in enumerate(intervals):
            sampling.hold(number, begins, lambda: self._read(reference, state))
            h = (ends - begins) / per_interval
            starts = begins + h * np.arange(per_interval, dtype=float)
            inputs = inputs_of_steps(reference, method, starts, h, sampling.held.torques[-1])
            record = np.empty((per_interval, sum(run.written.values())))
            passed += self.take(run, [inputs[name] for name in run.read], h, state, record)
            done = number * per_interval
            last = [k for k in range(per_interval) if (done + k + 1) % every == 0 or done + k + 1 == steps]
            records.append(record[last])
            numbers += [done + k + 1 for k in last]
            times += [ends if k + 1 == per_interval else begins + (k + 1) * h for k in last]
            progress(done + per_interval, steps)
        t = np.array(times)
        states = {**rows(reference.base, len(t)), **split_into(state, np.concatenate(records))}
        moved = self.with_loads(reference, self.with_torques(reference, Motion(states, t), sampling.held.at(t)))
        longest = max(ends - begins for begins, ends in intervals) / per_interval
        return Trajectory(moved.blocks, t, method, longest, steps, passed / steps, np.array(numbers))

    def _read(self, reference: Reference, state: dict[str, Array]) -> tuple[Array, Array]:
        """Return controlled positions and velocities (m,) at the present state."""
        blocks = {name: block[None] for name, block in state.items() if name != "z"}
        motion = Motion(blocks, np.zeros(1))
        x, (xd,) = reference.of_motors(motion)
        return self._measured(motion, x)[0], xd
