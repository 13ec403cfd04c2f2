"""Motions on a floating base by integrators of scipy: the base is part of the state.

y = [q; P0; Q0; v; V0], with the joints that do not follow exactly. The quaternion turns by Q' = Q (0, w) / 2, which
keeps its length, and is divided by it wherever it is used. Radau takes derivatives from differences.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.simulation.adaptive import CompiledMotion
from symoro_elastic.simulation.moving_base import BaseStates, quaternion, rotation_at, rotations, turning
from symoro_elastic.simulation.reference import Reference

DIFFERENCE = 1e-7
"""Of the state, for derivatives."""


class CompiledMotionOnBase(CompiledMotion):
    """The right side of a motion of a machine on a floating base."""

    linear_models = ()

    def __init__(self, reference: Reference, folder: Path) -> None:
        """Raises `InputError`, `CompilerMissing`, `CompilationFailed`."""
        super().__init__(reference, folder)
        self.orientation = next(iter(reference.base.keys() & {"Q0", "R0"}))

    @property
    def start(self) -> Array:
        """y at the start."""
        state, base = self.reference.start, self.reference.base
        Q0 = base["Q0"] if "Q0" in base else quaternion(base["R0"].reshape(3, 3))
        return np.concatenate([state.q[self.free], base["P0"], Q0, state.qd[self.free], base["V0"]])

    def placed(self, t: Array, y: Array) -> tuple[Array, Array]:
        """Return q, qd (N, n) of all joints at times (N,) and y (N, 2 f + 13)."""
        f = len(self.free)
        own = y[:, :f], y[:, f + 7 : 2 * f + 7]
        if f == len(self.reference.start.q):
            return own
        q, qd, _ = self.reference.states(t)
        q[:, self.free], qd[:, self.free] = own
        return q, qd

    def base(self, y: Array) -> BaseStates:
        """Return the states of the base at y (N, 2 f + 13), and the wrench on it."""
        P0, Q0 = np.split(y[:, len(self.free) : len(self.free) + 7], [3], axis=1)
        Q0 = Q0 / np.linalg.norm(Q0, axis=1, keepdims=True)
        turned = Q0 if self.orientation == "Q0" else rotations(Q0).reshape(-1, 9)
        wrench = np.tile(self.reference.base["f0"], (len(y), 1))
        return {self.orientation: turned, "P0": P0, "V0": y[:, -6:], "f0": wrench}

    def rate(self, t: float, y: Array) -> Array:
        """Return y'."""
        q, qd = self.placed(np.array([t]), y[None])
        base = self.base(y[None])
        of_base = {name: x for name, x in base.items() if name in self._arguments[self.dynamics]}
        found = self._call(self.dynamics, q=q, qd=qd, **self._given(t, q, qd), **of_base)
        f, (v, w), (a, wd) = len(self.free), np.split(base["V0"][0], 2), np.split(found["V0d"][0], 2)
        speed, turned = rotation_at(base)[0] @ v, turning(y[f + 3 : f + 7], w)
        return np.concatenate([qd[0, self.free], speed, turned, found["qdd"][0, self.free], a - np.cross(w, v), wd])

    def jacobian(self, t: float, y: Array) -> Array:
        """Return dy'/dy by central differences."""
        steps = DIFFERENCE * np.maximum(1.0, np.abs(y))
        columns = [
            (self.rate(t, y + h * e) - self.rate(t, y - h * e)) / (2 * h)
            for h, e in zip(steps, np.eye(len(y)), strict=True)
        ]
        return np.stack(columns, axis=1)


def compiled_motion(reference: Reference, folder: Path) -> CompiledMotion:
    """Return the right side of a motion, on a fixed or a floating base.

    Raises `InputError`, `CompilerMissing`, `CompilationFailed`.
    """
    return (CompiledMotionOnBase if reference.base else CompiledMotion)(reference, folder)
