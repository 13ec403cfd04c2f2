"""A box of the workspace in which frames stay along an exciting motion."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import NO_RANGE, InputError, among, reported_places
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.fitting.estimates import ROUNDING
from symoro_elastic.measured.logs.fourier_motion import rise
from symoro_elastic.numerics.linear.regressor import geometry_of, nominal_body
from symoro_elastic.numerics.motion.signals import OUTPUT, FrameSignal, outputs
from symoro_elastic.numerics.verification.implementations import numpy_model

OPTION = "--payload"
MOST_RANGES = 6  # of payloads, which have 64 corners
PLACE, MODEL = "--workspace", "geometric_model"


class Box:
    """Ranges (m) of positions of frames or points by signal, `tool.x`, axes of frame 0."""

    def __init__(self, machine: Machine, ranges: Mapping[str, tuple[float, float]]) -> None:
        """Raise `InputError` for signals other than positions, and for empty ranges."""
        self._ends = np.array([*ranges.values()], dtype=float).reshape(-1, 2)
        frames, self._rows = FrameNames(machine), []
        names: list[str] = []
        with reported_places({OUTPUT: PLACE}):
            signals = outputs(machine, ranges)
        for (name, (low, high)), signal in zip(ranges.items(), signals, strict=True):
            if not isinstance(signal, FrameSignal) or signal.order or signal.component > 2 or not signal.number:
                what = f"{name} is not a position of a frame: name one of x, y, z, such as tool.x"
                raise InputError("symoro-elastic", PLACE, what)
            if not low < high:
                raise InputError("symoro-elastic", PLACE, f"{name}={NO_RANGE.format(low, high)}")
            frame = frames.in_base(signal.number, signal.at)
            names += [frame] if frame not in names else []
            self._rows.append((names.index(frame), signal.component))
        self._placed = getattr(numpy_model(machine, (MODEL,), {MODEL: tuple(names)}), MODEL)

    def positions(self, q: Array) -> Array:
        """Return the positions (N, ranges), m, at positions q (N, n) of all joints."""
        T = self._placed(q)
        return np.stack([T[:, frame, k, 3] for frame, k in self._rows], axis=1)

    def excess(self, q: Array) -> float:
        """Return by how much a periodic motion with samples q (N, n) leaves a range, between samples too.

        As a share of its half width; negative inside, infinite where loops do not close.
        """
        x = self.positions(q)
        low, high = self._ends.T
        worst = float(((np.abs(x - (low + high) / 2) + rise(x)) / ((high - low) / 2)).max()) - 1
        return worst if np.isfinite(worst) else np.inf


def corners(
    machine: Machine, values: Mapping[str, float], payloads: Mapping[str, tuple[float, float]]
) -> list[dict[str, float]]:
    """Return values of parameters at the corners of ranges; torques in between are means of those at corners.

    Raises `InputError` for names of no parameter, empty ranges, and parameters in which torques are not
    linear: of the geometry, distances of centers of mass.
    """
    among(tuple(payloads), tuple(p.name for p in machine.parameters), OPTION)
    if len(payloads) > MOST_RANGES:
        raise InputError("symoro-elastic", OPTION, f"{len(payloads)} ranges, {MOST_RANGES} is the limit")
    for name, (low, high) in payloads.items():
        if not low < high:
            raise InputError("symoro-elastic", OPTION, f"{name}={NO_RANGE.format(low, high)}")
    all_values = {**parameter_values(machine), **values}
    for name, ends in payloads.items():
        _refuse_curved(machine, name, ends, all_values)
    corners_of_ranges = itertools.product(*payloads.values()) if payloads else []
    return [{**all_values, **dict(zip(payloads, ends, strict=True))} for ends in corners_of_ranges]


def _refuse_curved(machine: Machine, name: str, ends: tuple[float, float], values: Mapping[str, float]) -> None:
    """Raise `InputError` for a parameter on which the inertial parameters and loads do not depend linearly."""
    for j, joint in enumerate(machine.joints, start=1):
        place = f"joint {j} ({joint.name})"
        if any(name in formula.names for formula in geometry_of(joint)):
            raise InputError(
                "symoro-elastic", OPTION, f"{name}: {place} has it in its geometry: give a mass or an inertia"
            )
        bodies = [nominal_body(joint.body, {**values, name: x}) for x in (*ends, sum(ends) / 2)]
        for low, high, middle in zip(*(x.values() for x in bodies), strict=True):
            within = ROUNDING * (abs(low) + abs(high))
            if math.isfinite(middle) and not math.isclose(middle, (low + high) / 2, rel_tol=ROUNDING, abs_tol=within):
                what = f"{name}: the inertia of {place} is not linear in it, so ends of a range do not bound torques"
                raise InputError("symoro-elastic", OPTION, f"{what}: give a range of a mass")
