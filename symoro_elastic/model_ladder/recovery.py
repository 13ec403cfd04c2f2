"""Deflections of static springs, recovered from the motion of the machine without them.

Gamma_E = (A a + H)_E at q, v, a of the joints that move, q_E where the motion starts, v_E = a_E = 0
q_E = neutral_E - Gamma_E / k_E
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.implementations import numpy_model
from symoro_elastic.numerics.values import given_values
from symoro_elastic.simulation.observed import Motion
from symoro_elastic.vibration.equations_of_motion import State


class Recovery:
    """Motions of a whole machine from those of the machine with some springs held where they start."""

    def __init__(self, machine: Machine, start: State, static: Sequence[str], held: Sequence[str] = ()) -> None:
        """`static` and `held` name the springs that are left out: those recovered, and those that stay at the start."""
        names = [joint.name for joint in machine.moving_joints]
        self.machine, self.start = machine, start
        self.static = [names.index(name) for name in static]
        self.moved = [k for k, name in enumerate(names) if name not in {*static, *held}]
        values = given_values(machine)
        springs = [machine.moving_joints[k].spring for k in self.static]
        self._neutral = np.array([spring.neutral.value(values) for spring in springs])
        self._stiffness = np.array([spring.stiffness.value(values) for spring in springs])
        self._models = numpy_model(machine, ("inertia_matrix", "bias_forces"))

    def whole(self, reduced: Motion) -> Motion:
        """Return the motion of the whole machine, static springs deflected."""
        q, qd, qdd = (self._spread(x) for x in (reduced.q, reduced.qd, reduced.qdd))
        q += np.where(np.isin(np.arange(q.shape[1]), self.moved), 0.0, self.start.q)
        if self.static:
            q[:, self.static] = self._neutral - self._reactions(q, qd, qdd) / self._stiffness
        return Motion(reduced.t, q, qd, qdd, reduced.tau)

    def _reactions(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return the forces (N, static) that the joints carry beside their springs."""
        A, H = self._models.inertia_matrix(q), self._models.bias_forces(q, qd)
        found: Array = (np.einsum("tij,tj->ti", A, qdd) + H)[:, self.static]
        return found

    def _spread(self, x: Array) -> Array:
        found = np.zeros((len(x), len(self.start.q)))
        found[:, self.moved] = x
        return found
