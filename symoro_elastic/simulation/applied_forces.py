"""Forces that act on frames during a motion, as forces on the independent joints: J^T w."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from inspect import signature

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.scene import BASE, Asked
from symoro_elastic.numerics.implementations import numpy_model
from symoro_elastic.simulation.reference import Reference


class AppliedForces:
    """The forces of a reference motion that has some."""

    def __init__(self, reference: Reference) -> None:
        self.reference = reference
        self.frames = tuple(str(replace(Asked.parse(name), seen_from=BASE)) for name in reference.frames)
        models = ("jacobian", "inertia_matrix")
        self._models = numpy_model(reference.machine, models, {"jacobian": self.frames})

    def on_joints(self, t: Array, q: Array, q_dep: Array | None = None) -> Array:
        """Return the forces (N, n) on the joints at times (N,) and positions (N, n)."""
        J = self._models.jacobian(*_positions(self._models.jacobian, q, q_dep))
        found: Array = np.einsum("tfci,tfc->ti", J, self.reference.forces_at(t))
        return found

    def answer(self, t: Array, q: Array, q_dep: Array | None = None) -> tuple[Array, Array]:
        """Return what the forces add to accelerations (N, n), and to the torques of motors (N, m) that follow exactly.

        A_oo qdd_o = (J^T w)_o for the joints o that move freely, tau = A_mo qdd_o - (J^T w)_m.
        """
        pushed, motors = self.on_joints(t, q, q_dep), list(self.reference.machine.motor_entries)
        A = self._models.inertia_matrix(*_positions(self._models.inertia_matrix, q, q_dep))
        driven = self.reference.servo is None
        free = [k for k in range(q.shape[1]) if not (driven and k in motors)]
        qdd = np.zeros_like(q)
        qdd[:, free] = np.linalg.solve(A[:, free][:, :, free], pushed[:, free, None])[..., 0]
        if not driven:
            return qdd, np.zeros((len(q), len(self.reference.motors)))
        return qdd, (A[:, motors] @ qdd[..., None])[..., 0] - pushed[:, motors]


def _positions(model: Callable[..., Array], q: Array, q_dep: Array | None) -> tuple[Array, ...]:
    """Return what a generated function takes of the positions."""
    return (q, q_dep) if "q_dep" in signature(model).parameters and q_dep is not None else (q,)
