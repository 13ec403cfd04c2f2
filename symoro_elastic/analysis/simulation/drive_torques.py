"""Drives along motions: inputs of their laws, positions that they control, in numbers and for steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from symoro_elastic.analysis.simulation.observed import Observer
from symoro_elastic.analysis.simulation.reference_motion import MeasuredLoad, Motion, Reference
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.described import DescribedMachine, drives_of, without_drives
from symoro_elastic.machine.drives import LoadPosition
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.motion.signals import FrameSignal, outputs


def inputs_of(reference: Reference, motion: Motion, controlled: Array, xd: Array) -> Array:
    """Return the inputs (N, m, 6) of all drives along a motion, with the positions (N, m) that are controlled."""
    fed = reference.fed_torques(motion.t)
    return np.stack([*reference.at(motion.t), controlled, xd, fed], axis=-1)


class ControlledPositions:
    """Positions that the drives of a reference control: of their motors, or of loads over their ratios."""

    def __init__(self, reference: Reference) -> None:
        self.reference = reference
        names = tuple(load.signal for load in reference.loads if load)
        self._observer = Observer(reference.machine, reference, names) if names else None
        self._loaded = [k for k, load in enumerate(reference.loads) if load]
        self._ratios = np.array([load.ratio for load in reference.loads if load])

    def __call__(self, motion: Motion, x: Array) -> Array:
        """Return the positions (N, m) that are controlled, x being those of the motors."""
        if self._observer is None:
            return x
        start = self.reference.start
        blocks = {"q": np.vstack([start.q, motion.q]), "qd": np.vstack([start.qd, motion.qd])}
        found = self._observer.outputs(Motion(blocks, np.append(0.0, motion.t)))
        at_start = self.reference.motors_at_start
        x = x.copy()
        x[:, self._loaded] = at_start[self._loaded] + (found[1:] - found[0]) / self._ratios
        return x


def with_loads(reference: Reference) -> Machine:
    """Return the machine of a reference for steps: with the positions that its drives measure at loads, if driven."""
    machine = reference.loaded if reference.drives else without_drives(reference.loaded)
    known = tuple(load.signal for load in reference.loads if load)
    if not known:
        return machine
    start = Motion({"q": reference.start.q[None], "qd": reference.start.qd[None]}, np.zeros(1))
    values = iter(Observer(reference.machine, reference, known).outputs(start)[0].tolist())
    found = {
        name: _load_position(reference.machine, load, next(values), float(x))
        for name, load, x in zip(reference.motors, reference.loads, reference.motors_at_start, strict=True)
        if load
    }
    return replace(DescribedMachine.of(machine), drives=replace(drives_of(machine), loads=found))


def _load_position(machine: Machine, load: MeasuredLoad, start: float, motor: float) -> LoadPosition:
    (signal,) = outputs(machine, [load.signal])
    axis, at = (signal.component, signal.at) if isinstance(signal, FrameSignal) else (None, None)
    return LoadPosition(signal.number, axis, at, start, load.ratio, motor)
