"""Motors that move with other motors alone, as two on one rigid beam: what they do together is determined, and shared.

Their variables depend on those of the others, x_m(u), and their torques act by S_m = dx_m/du: S_m^T tau (L3).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.independent_joints import moved_by


def followers(machine: Machine) -> dict[int, tuple[int, ...]]:
    """Return the motors that move with others, each with these, by number; raises `InputError` for other ones.

    The motors of the machine are independent as far as can be (`with_independent_motors`).
    """
    found = {j: tuple(moved_by(machine, j)) for j in machine.motors if j in machine.dependent}
    for j, moving in found.items():
        free = [machine.joint(k).name for k in moving if k not in machine.motors]
        if free:
            what = f"its motor cannot be held by itself, for {', '.join(free)} moves it too: choose other joints "
            raise machine.error(f"joint {machine.joint(j).name}", what + "(dependent = [...])")
    return found


def share_torques(S_m: Array, forces: Array, shares: Array) -> Array:
    """Return torques (m,) with S_m^T tau = forces (n,), in the least sum of tau^2 / share (L31)."""
    gram = S_m.T @ (shares[:, None] * S_m)
    torques: Array = shares * (S_m @ np.linalg.lstsq(gram, forces, rcond=None)[0])
    return torques


def shares(machine: Machine, values: Mapping[str, float]) -> Array:
    """Return the share of each motor (m,), 1 where the file gives none."""
    given = [joint.sharing for joint in machine.motor_joints]
    return np.array([1.0 if x.is_zero else x.value(values) for x in given])


def line_on_undetermined(machine: Machine, joined: Mapping[int, tuple[int, ...]]) -> list[str]:
    """Return a line on motors whose torques nothing determines one by one, and that no file shares out."""
    if not all(joint.sharing.is_zero for joint in machine.motor_joints):
        return []
    names = [machine.joint(j).name for j in sorted({*joined, *(k for moving in joined.values() for k in moving)})]
    what = "move each other, so only what their torques do together is determined: they are those of the least sum of "
    return [f"{', '.join(names)} {what}squares; sharing in [motors] weights them"] if names else []
