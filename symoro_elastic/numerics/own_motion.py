"""Own variables of joints, dependent ones too, along motions of the independent joints."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.coordinates import product
from symoro_elastic.models.bind import Bound
from symoro_elastic.numerics.arrays import values_along
from symoro_elastic.numerics.closed_positions import Followed
from symoro_elastic.numerics.values import given_values
from symoro_elastic.scalar import Scalar


class OwnMotion:
    """Positions, rates and accelerations of the own variables of some joints of a machine, by number (L1), (L2)."""

    def __init__(self, machine: Machine, joints: Sequence[int]) -> None:
        self.machine, self.joints = machine, tuple(joints)

    def __call__(self, q: Array, qd: Array, qdd: Array | None = None, q_dep: Array | None = None) -> Array:
        """Return x, xd and, with qdd, xdd (orders, N, joints) at states (N, n); NaN where a loop does not close.

        Loops without a closed form are assembled from their start on where q_dep (N, d) is not given.
        """
        bound, motion = self._bound, [q, qd] if qdd is None else [q, qd, qdd]
        symbols: dict[str, Any] = dict(self._values)
        for by_joint, block in zip((bound.q, bound.qd, bound.qdd), motion, strict=False):
            symbols |= {x.operands[0]: column for x, column in zip(by_joint.values(), block.T, strict=True)}
        if bound.takes_dependent:
            found = Followed(self.machine, self._values).at(q) if q_dep is None else q_dep
            symbols |= zip(bound.arguments()["q_dep"], found.T, strict=True)
        return np.stack([values_along(roots, symbols, len(q)).T for roots in self._expressions[: len(motion)]])

    @cached_property
    def _bound(self) -> Bound:
        return Bound(self.machine)

    @cached_property
    def _values(self) -> dict[str, float]:
        return given_values(self.machine)

    @cached_property
    def _expressions(self) -> tuple[list[Scalar], ...]:
        bound, of = self._bound, self._bound.coordinates
        return (
            [bound.variables[j] for j in self.joints],
            [of.rates_x[j] for j in self.joints],
            [product(of.S_x[j], bound.qdd) + of.gam_x[j] for j in self.joints],
        )
