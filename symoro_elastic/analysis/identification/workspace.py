"""A box of the workspace in which frames stay along an exciting motion."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symoro_elastic.analysis.identification.fourier_motion import rise
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError, placed
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.implementations import numpy_model
from symoro_elastic.numerics.motion.signals import OUTPUT, FrameSignal, outputs

PLACE, MODEL = "--workspace", "geometric_model"


class Box:
    """Ranges (m) of positions of frames or points by signal, `tool.x`, axes of frame 0."""

    def __init__(self, machine: Machine, ranges: Mapping[str, tuple[float, float]]) -> None:
        """Raises `InputError` for signals that are no positions, and ranges without room."""
        self._ends = np.array([*ranges.values()], dtype=float).reshape(-1, 2)
        frames, self._rows = FrameNames(machine), []
        names: list[str] = []
        with placed({OUTPUT: PLACE}):
            signals = outputs(machine, ranges)
        for (name, (low, high)), signal in zip(ranges.items(), signals, strict=True):
            if not isinstance(signal, FrameSignal) or signal.order or signal.component > 2 or not signal.number:
                what = f"{name} is not a position of a frame: name one of x, y, z, such as tool.x"
                raise InputError("symoro-elastic", PLACE, what)
            if not low < high:
                raise InputError("symoro-elastic", PLACE, f"{name}: no room between {low:g} and {high:g}")
            frame = frames.in_base(signal.number, signal.at)
            names += [frame] if frame not in names else []
            self._rows.append((names.index(frame), signal.component))
        self._placed = getattr(numpy_model(machine, (MODEL,), {MODEL: tuple(names)}), MODEL)

    def positions(self, q: Array) -> Array:
        """Return the positions (N, ranges), m, at positions q (N, n) of all joints."""
        T = self._placed(q)
        return np.stack([T[:, frame, k, 3] for frame, k in self._rows], axis=1)

    def excess(self, q: Array) -> float:
        """Return by how much samples q (N, n) of a period, and the curve between them, leave a range.

        As a share of its half width; negative inside, infinite where loops do not close.
        """
        x = self.positions(q)
        low, high = self._ends.T
        worst = float(((np.abs(x - (low + high) / 2) + rise(x)) / ((high - low) / 2)).max()) - 1
        return worst if np.isfinite(worst) else np.inf
