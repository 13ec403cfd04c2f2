"""What single precision of the right side costs where states are in double: its roundings as forces."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.model_ladder.path import LinearPath

ROUNDINGS = 4.0
"""Roundings of a force in generated code, as they add up."""


def single_precision_errors(path: LinearPath, steps: int, left_out: Collection[int] = ()) -> dict[str, float]:
    """Return the errors of outputs, by name, where accelerations are rounded at every step of a motion.

    The forces of inertia and of springs are rounded to single precision; what is lost drives the same linear model.
    """
    path = path.finer(steps + 1)
    motion = path.without([left_out])
    accelerations = path.states(path.t)[2] + motion.ddd[:, 0]
    forces = np.einsum("tij,tj->ti", path.M, accelerations)
    springs = path.stiffness * motion.d[:, 0] + path.preload
    lost = ROUNDINGS * (_rounding(forces) + _rounding(springs))
    changes = path.outputs.of(path.without([left_out], lost))[:, 0]
    return dict(zip(path.outputs.names, np.abs(changes).max(axis=0).tolist(), strict=True))


def _rounding(x: Array) -> Array:
    """Return what rounding to single precision changes."""
    changed: Array = x.astype(np.float32).astype(float) - x
    return changed
