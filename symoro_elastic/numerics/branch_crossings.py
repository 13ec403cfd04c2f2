"""Refusal of motions of machines that leave the branch on which their loops start."""

from __future__ import annotations

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.loops.passages import Passages
from symoro_elastic.models.loops.plan import plan_of
from symoro_elastic.numerics.own_motion import OwnMotion

MOST_SAMPLES = 2000
"""Of a motion that are looked at; longer steps between them are cut by the continuation."""
AHEAD = 3.0
"""Steps ahead of the last state of a motion at which its loops are tried."""
OPEN, SINGULAR = "it closes no more", "it is singular: branches meet there"


def refuse_lost(
    machine: Machine, command: str, t: Array, q: Array, qd: Array | None = None, q_dep: Array | None = None
) -> None:
    """Raise `InputError` by loop and time where a motion q (N, n) at times t (N,) leaves the branch of its start.

    Where q itself ends (NaN), the loops are blamed only if they do not close a few steps at qd (N, n) ahead.
    """
    if not machine.loops:
        return
    watched = Passages(plan_of(machine, Bound))
    finite = np.isfinite(q).all(axis=1)
    ends = len(t) if finite.all() else int(np.argmin(finite))
    if not watched.loops or not ends:
        return
    looked = np.unique(np.linspace(0, ends - 1, min(ends, MOST_SAMPLES)).round().astype(np.int64))
    with np.errstate(all="ignore"):
        known = None if q_dep is None else q_dep[looked]
        found = OwnMotion(machine, machine.owners)(q[looked], np.zeros_like(q[looked]), q_dep=known)[0]
    lost = watched.lost(found)
    if lost is not None:
        what = SINGULAR if np.isfinite(found[lost]).all() else OPEN
        raise _error(machine, command, watched, found[max(lost - 1, 0)], what, float(t[looked[lost]]), q[looked[lost]])
    if ends < len(t) and qd is not None:
        ahead = AHEAD * float(t[ends] - t[ends - 1]) * qd[ends - 1]
        if not np.isfinite(ahead).all() or watched.ends_at(found[-1], q[ends - 1] + ahead):
            raise _error(machine, command, watched, found[-1], OPEN, float(t[ends - 1]), q[ends - 1])


def _error(
    machine: Machine, command: str, watched: Passages, before: Array, what: str, t: float, q: Array
) -> InputError:
    """Return the error that names the loop nearest to singular at a position before it is lost."""
    names = ", ".join(watched.nearest(before))
    at = ", ".join(f"{joint.name} = {x:.4g}" for joint, x in zip(machine.moving_joints, q, strict=True))
    when = f"{command}: from {t:.4g} s on ({at}) {what}: give a motion that keeps away from there"
    return machine.error(f"loop {names}", when)
