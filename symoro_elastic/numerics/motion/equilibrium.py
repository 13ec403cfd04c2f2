"""States to linearize about: the equilibrium under gravity and loads, or a given state."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.free_base import COORDINATES
from symoro_elastic.numerics.motion.balance import balance
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.numerics.motion.inertia import refuse_singular


def equilibrium(
    motion: EquationsOfMotion,
    at: Mapping[str, float] | None = None,
    torques: Mapping[str, float] | None = None,
    carried: bool = False,
) -> State:
    """Return the state at rest where r(q, 0, 0) = tau [8], [9], with gravity, external wrenches and `torques`.

    Motors are held `at` their positions (rad or m, 0 by default) and tau is the torque that holds them; a motor in
    `torques` (N m or N) is free to move instead. For other joints `at` is where the search begins, else
    the neutral position of their spring. A base that is `carried` stays where it is; tau holds the force and the moment
    on it, whose directions are constant. Raises `InputError` that names the joints nothing supports.
    """
    base = base_coordinates(motion) if carried else []
    q, tau = starting_point(motion, at or {}), np.zeros(len(motion.joints))
    given = _free(motion, torques or {})
    tau[list(given)] = list(given.values())
    fixed = {k for k in motion.motors if k not in given}.union(base)
    sought = [k for k in range(len(motion.joints)) if k not in fixed]
    given_at = motion.indices_of(at or {}, "--at").keys()
    placed = not given_at.isdisjoint(sought)
    q = _on_flanks(motion, q, tau, [k for k in sought if k not in given_at])
    q = balance(motion, q, tau, sought, placed)
    zero = np.zeros_like(q)
    forces = motion.forces(q, zero, zero)
    left = float(np.max(np.abs((forces - tau)[sought]), initial=0.0))
    tau[list(fixed)] = forces[list(fixed)]
    return State(q, zero, zero, tau, motion.torques(q, tau), tuple(sought), left)


def base_coordinates(motion: EquationsOfMotion) -> list[int]:
    """Return the indices in q of the coordinates of the base; raises `InputError` where the base is fixed."""
    base = [k for k, name in enumerate(motion.names) if name in COORDINATES]
    if not base:
        raise InputError(motion.source, "hover", "the base is fixed: only a floating base hovers")
    return base


def given_state(
    motion: EquationsOfMotion,
    at: Mapping[str, float] | None = None,
    rates: Mapping[str, float] | None = None,
    torques: Mapping[str, float] | None = None,
) -> State:
    """Return a given state: q and qd, tau, and qdd from A qdd = tau - r(q, qd, 0) [8].

    They are 0 by default, q that of the start of a loop.
    Raises `InputError` for joints that do not exist, and where A is singular.
    """
    q, pushed = motion.position_of_loops(), np.zeros(len(motion.motor_names))
    for m, x in _numbered(motion, torques or {}).items():
        pushed[m] = x
    qd, zero = np.zeros_like(q), np.zeros_like(q)
    for numbers, named, place in ((q, at or {}, "--at"), (qd, rates or {}, "--rate")):
        for k, x in motion.indices_of(named, place).items():
            numbers[k] = x
    motion.refuse_open(q)
    (A,) = motion.matrices("M", q, qd, zero)
    refuse_singular(motion, A, range(len(q)), can_hold=False)
    tau = motion.motor_slopes(q).T @ pushed
    qdd: Array = np.array(np.linalg.solve(A, tau - motion.forces(q, qd, zero)), dtype=float)
    return State(q, qd, qdd, tau, pushed)


def starting_point(motion: EquationsOfMotion, at: Mapping[str, float]) -> Array:
    """Return the position where the search begins; raises `InputError` for joints that do not exist."""
    q = motion.neutral_positions()
    for k, x in motion.indices_of(at, "--at").items():
        q[k] = x
    return q


def _on_flanks(motion: EquationsOfMotion, q: Array, tau: Array, sought: list[int]) -> Array:
    """Return the position with springs that have backlash at the edges to which loads push them."""
    zero, edges = np.zeros_like(q), np.zeros_like(q)
    for k in sought:
        edges[k] = motion.joints[k].spring.backlash.value(motion.parameters) / 2
    if not edges.any():
        return q
    motion.refuse_open(q)
    return q + edges * np.sign(tau - motion.forces(q, zero, zero))


def _free(motion: EquationsOfMotion, torques: Mapping[str, float]) -> dict[int, float]:
    """Return the torques of motors that are free to move, by index in q; raises `InputError` for those that share."""
    free = {}
    for m, x in _numbered(motion, torques).items():
        j = motion.machine.motors[m]
        joined = [(one, *others) for one, others in motion.followers.items() if j in (one, *others)]
        if joined:
            names = ", ".join(sorted(motion.machine.joint(i).name for i in joined[0]))
            what = f"{names} move each other, so none is free by itself: leave it out, or give the state "
            raise InputError(motion.source, "--torque", what + "(--as-given)")
        free[motion.machine.independent.index(j)] = x
    return free


def _numbered(motion: EquationsOfMotion, torques: Mapping[str, float]) -> dict[int, float]:
    """Return torques by index of the motor; raises `InputError` for other joints, and numbers out of range."""
    numbered = {motion.motor(name, "--torque"): x for name, x in torques.items()}
    motion.refuse_large(torques, "--torque")
    return numbered
