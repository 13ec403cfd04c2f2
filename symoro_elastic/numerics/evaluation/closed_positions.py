"""Positions and motions of machines with couplings and loops: every loop closed, on the branch of its start."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.coordinates import product
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.state import DEPENDENT, State
from symoro_elastic.models.loops.branch_crossings import BranchCrossings
from symoro_elastic.models.loops.plan import lacks_closed_form, plan_of
from symoro_elastic.models.parameters.base_parameters import ZeroPosition
from symoro_elastic.numerics.evaluation.arrays import values_along
from symoro_elastic.numerics.evaluation.values import ParameterValues, given_values, parameter_values

ORDERS = ("q", "qd", "qdd")

AnyState = TypeVar("AnyState", bound=State)
MOST_SAMPLES = 2000
"""Most samples of a motion that are evaluated; the continuation cuts the longer steps between them."""
AHEAD = 3.0
"""Steps ahead of the last state of a motion at which its loops are tried."""
OPEN, SINGULAR = "it does not close any more", "it is singular: branches meet there"


def drawn_values(machine: Machine, seed: int = 0) -> ParameterValues:
    """Return values of all parameters, random where none is given; parameters of the geometry let the loops close."""
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
        return np.asarray(self._assembly.positions_at(self._start, q)[:, self._assembly.unknown])


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

        Loops without a closed form are assembled from their start where the state lacks their dependent variables.
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


def refuse_lost(machine: Machine, command: str, t: Array, state: State) -> None:
    """Raise `InputError` by loop and time where a motion at times t (N,) leaves the branch of its start.

    Where q itself ends (NaN), the loops are blamed only if they do not close a few steps at qd ahead.
    """
    if not machine.loops:
        return
    q, watched = state.q, BranchCrossings(plan_of(machine))
    finite = np.isfinite(q).all(axis=1)
    ends = len(t) if finite.all() else int(np.argmin(finite))
    if not watched.loops or not ends:
        return
    looked = np.unique(np.linspace(0, ends - 1, min(ends, MOST_SAMPLES)).round().astype(np.int64))
    with np.errstate(all="ignore"):
        (found,) = JointCoordinates(machine, machine.with_variable)(State(state.only(("q", DEPENDENT)))[looked])
    lost = watched.first_lost(found)
    if lost is not None:
        what = SINGULAR if np.isfinite(found[lost]).all() else OPEN
        when = _when(machine, float(t[looked[lost]]), q[looked[lost]])
        raise _error(machine, command, watched.nearest(found[max(lost - 1, 0)]), f"{when} {what}")
    if ends < len(t) and "qd" in state.blocks:
        ahead = AHEAD * float(t[ends] - t[ends - 1]) * state.qd[ends - 1]
        if not np.isfinite(ahead).all() or watched.ends_at(found[-1], q[ends - 1] + ahead):
            when = _when(machine, float(t[ends - 1]), q[ends - 1])
            raise _error(machine, command, watched.nearest(found[-1]), f"{when} {OPEN}")


def _when(machine: Machine, t: float, q: Array) -> str:
    at = ", ".join(f"{joint.name} = {x:.4g}" for joint, x in zip(machine.independent_joints, q, strict=True))
    return f"from {t:.4g} s on ({at})"


def _error(machine: Machine, command: str, nearest: Sequence[str], what: str) -> InputError:
    """Return the error that names the loops nearest to singular at a position before they are lost."""
    return machine.error(f"loop {', '.join(nearest)}", f"{command}: {what}: give a motion that keeps away from there")
