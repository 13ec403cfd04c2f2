"""Positions and motions of machines with couplings and loops: every loop closed, on the branch of its start."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.coordinates import product
from symoro_elastic.models.base_parameters import ZeroPosition
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.loops.plan import lacks_closed_form, plan_of
from symoro_elastic.models.state import DEPENDENT, State
from symoro_elastic.numerics.arrays import values_along
from symoro_elastic.numerics.values import ParameterValues, given_values, parameter_values

ORDERS = ("q", "qd", "qdd")

AnyState = TypeVar("AnyState", bound=State)


def drawn_values(machine: Machine, seed: int = 0) -> ParameterValues:
    """Return values of all parameters, drawn where none is given; those of the geometry are such that loops close."""
    values = parameter_values(machine, seed)
    if not machine.loops:
        return values
    closed, geometry = plan_of(machine).assembly.values, ZeroPosition(machine).geometry
    return values | {name: closed[name] for name in geometry}


class Followed:
    """Dependent variables without closed form, followed from the start of the loops by continuation."""

    def __init__(self, machine: Machine, values: Mapping[str, float]) -> None:
        plan = plan_of(machine)
        self._start, self._assembly = plan.positions[0], plan.assembly.at_values({**plan.assembly.values, **values})

    def at(self, q: Array) -> Array:
        """Return q_dep (samples, d) at q (samples, n); NaN where the branch of the start does not lead there."""
        found: Array = self._assembly.positions_at(self._start, q)[:, self._assembly.unknown]
        return found


def with_dependent(machine: Machine, state: AnyState, values: Mapping[str, float] | None = None) -> AnyState:
    """Return the state with all blocks of its position: loops without a closed form are followed from their start.

    Positions that the state has are kept. Values of parameters are those of the file where none are given.
    """
    if DEPENDENT in state.blocks or not lacks_closed_form(machine):
        return state
    followed = Followed(machine, given_values(machine) if values is None else values)
    return state.with_blocks(**{DEPENDENT: followed.at(state.q)})


class JointCoordinates:
    """Positions, rates and accelerations of the coordinates of some joints of a machine, by number (L1), (L2)."""

    def __init__(self, machine: Machine, joints: Sequence[int]) -> None:
        self.machine, self.joints = machine, tuple(joints)

    def __call__(self, state: State) -> Array:
        """Return x, xd and, with qdd, xdd (orders, N, joints) at states; NaN where a loop does not close.

        Loops without a closed form are assembled from their start on where the state does not tell how they close.
        """
        entries, orders = self._bound.arguments(), len(state.only(ORDERS))
        symbols: dict[str, Any] = dict(self._values)
        for name, block in with_dependent(self.machine, state, self._values).only((*ORDERS, DEPENDENT)).items():
            symbols |= zip(entries[name], block.T, strict=True)
        return np.stack([values_along(roots, symbols, len(state)).T for roots in self._expressions[:orders]])

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
