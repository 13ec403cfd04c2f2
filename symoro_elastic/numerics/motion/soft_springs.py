"""Springs that gravity or a load bends further than they bend back: they cannot be left out of a motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.static_springs import with_free_springs
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium, starting_point

SOFT = "gravity or a load is stronger than its spring at this position: keep it in the motion"
LEAST = 1e-9
"""Of the smallest eigenvalue of K_EE with the springs' own stiffness as unit: below, it is rounding."""


def refuse_soft_static(machine: Machine, at: Mapping[str, float], values: Mapping[str, float] | None = None) -> None:
    """Raise `InputError` for a static spring of a machine that gravity or a load bends further than it bends back."""
    weakest = soft_static(machine, at, values)
    if weakest:
        raise machine.error(f"scene, static, {weakest}", SOFT)


def soft_static(machine: Machine, at: Mapping[str, float], values: Mapping[str, float] | None = None) -> str | None:
    """Return the weakest static joint unless K_EE of all of them is positive definite, neutral and at equilibrium.

    K = dr/dq [8] holds springs, gravity and loads, with motors `at` their positions, rad or m. `values` are those of
    parameters. Raises `InputError` where they are missing, and for joints that nothing supports.
    """
    if not machine.static:
        return None
    names = [joint.name for joint in machine.static.values()]
    motion = motion_of(replace(with_free_springs(machine), static={}), values)
    entries = [motion.index(name, "scene, static") for name in names]
    weakest = _weakest(motion, starting_point(motion, at), entries)
    if weakest is None:
        weakest = _weakest(motion, equilibrium(motion, at).q, entries)
    return None if weakest is None else motion.names[weakest]


def _weakest(motion: EquationsOfMotion, q: Array, entries: Sequence[int]) -> int | None:
    """The joint that moves most where K_EE has an eigenvalue that is not positive; None where all are."""
    at_rest = np.zeros_like(q)
    (K,) = motion.matrices("K", q, at_rest, at_rest)
    own = dict(zip(motion.springs, motion.spring_stiffnesses(q), strict=True))
    units = np.sqrt([own[motion.names[k]] for k in entries])
    K_EE = K[np.ix_(entries, entries)] / np.outer(units, units)
    sizes, directions = np.linalg.eigh((K_EE + K_EE.T) / 2)
    return None if sizes[0] > LEAST else entries[int(np.argmax(np.abs(directions[:, 0])))]
