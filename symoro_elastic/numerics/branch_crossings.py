"""Refusal of motions of machines that leave the branch on which their loops start."""

from __future__ import annotations

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.loops.branch_crossings import BranchCrossings
from symoro_elastic.models.loops.plan import plan_of
from symoro_elastic.models.state import DEPENDENT, State
from symoro_elastic.numerics.closed_positions import JointCoordinates

MOST_SAMPLES = 2000
"""Of a motion that are looked at; longer steps between them are cut by the continuation."""
AHEAD = 3.0
"""Steps ahead of the last state of a motion at which its loops are tried."""
OPEN, SINGULAR = "it does not close any more", "it is singular: branches meet there"


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
        raise _error(machine, command, watched, found[max(lost - 1, 0)], what, float(t[looked[lost]]), q[looked[lost]])
    if ends < len(t) and "qd" in state.blocks:
        ahead = AHEAD * float(t[ends] - t[ends - 1]) * state.qd[ends - 1]
        if not np.isfinite(ahead).all() or watched.ends_at(found[-1], q[ends - 1] + ahead):
            raise _error(machine, command, watched, found[-1], OPEN, float(t[ends - 1]), q[ends - 1])


def _error(
    machine: Machine, command: str, watched: BranchCrossings, before: Array, what: str, t: float, q: Array
) -> InputError:
    """Return the error that names the loop nearest to singular at a position before it is lost."""
    names = ", ".join(watched.nearest(before))
    at = ", ".join(f"{joint.name} = {x:.4g}" for joint, x in zip(machine.independent_joints, q, strict=True))
    when = f"{command}: from {t:.4g} s on ({at}) {what}: give a motion that keeps away from there"
    return machine.error(f"loop {names}", when)
