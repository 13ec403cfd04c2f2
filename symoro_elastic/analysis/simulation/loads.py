"""Torques through joints with load-dependent friction, along motions: solved with that friction, by substitution."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from symoro_elastic.analysis.simulation.reference_motion import Motion
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bound.state import State
from symoro_elastic.models.steps.time_steps import PASSED, PASSED_TORQUES, TERMS

SUBSTITUTIONS, EXTRAPOLATED, SETTLED = 1000, 30, 1e-13
"""Of torques that friction rises with: at most, those with limits between them, relative change of the last one
by the sizes of their terms."""


def under_loads(
    machine: Machine, call: Callable[[str, State], dict[str, Array]], dynamics: str, state: Motion
) -> dict[str, Array]:
    """Return the results of a dynamic model, and the torques `load` through joints with load-dependent friction.

    `call` gives the results of a generated function at states. Raises `InputError` where loads do not settle.
    """
    if not machine.loaded:
        return call(dynamics, state)
    loads = [np.zeros((len(state.t), len(machine.loaded)))]
    for number in range(1, SUBSTITUTIONS):
        results = call(dynamics, state.with_blocks(load=loads[-1]))
        moved = {name: results[name] for name in ("tau", "qdd") if name in results}
        passed = call(PASSED_TORQUES, state.with_blocks(load=loads[-1], **moved))
        load = passed[PASSED]
        if not (np.abs(load - loads[-1]) > SETTLED * passed[TERMS].sum(axis=1, keepdims=True)).any():
            return results | {"load": load}
        loads = [*loads[-2:], load]
        if number % 3 == 2 and number < EXTRAPOLATED:
            x, y, z = loads
            bend = z - 2 * y + x  # Aitken's rule: the limit of geometric convergence
            is_bent = np.abs(bend) > 1e-9 * np.abs(z - y)
            loads = [z - np.divide((z - y) ** 2, bend, out=np.zeros_like(z), where=is_bent)]
    names = ", ".join(machine.joint(j).name for j in machine.loaded)
    raise machine.error(f"friction, {names}, load", "the torque through the joint does not settle: lower load")
