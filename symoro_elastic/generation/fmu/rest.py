"""States of friction and drives where an FMU starts: at rest under the torques that hold the machine.

Rates zd and torques tau_m of the model `closed_dynamics` are solved for z, set points where motors stand and tau the
torques that hold them, so that what integrates holds nothing. The equations are linear but for limits.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.drives.closed_dynamics import closed_trace
from symoro_elastic.numerics.arrays import values_along
from symoro_elastic.symbolic.expression import operand

STEP = 1e-4
"""Of a state, for slopes: equations are linear, so rounding alone counts."""
ITERATIONS = 3
SOLVED = 1e-6
"""Of the torques: what is left of the equations where they have a solution."""


class AtRest:
    """Rates and torques of a machine at rest at q (n,), its motors at x (m,), by states z of its drives and torques."""

    def __init__(self, machine: Machine, q: Mapping[int, float], x: Array) -> None:
        bound = Bound(machine)
        trace = closed_trace(bound)
        self._inputs = {one.name: one.symbols for one in trace.inputs}
        self.friction, self.states = len(machine.bristles), len(self._inputs.get("z", ()))
        rates = trace.results["zd"].entries[self.friction :] if "zd" in trace.results else ()
        self._roots = [*map(operand, rates), *map(operand, trace.results["tau_m"].entries)]
        symbols = {p.name: p.value.value() for p in machine.parameters if p.value is not None}
        symbols |= dict.fromkeys((name for names in self._inputs.values() for name in names), 0.0)
        symbols |= {str(bound.q[j].operands[0]): value for j, value in q.items() if j in bound.q}
        symbols |= dict(zip(self._inputs["r"], x.tolist(), strict=True))
        self._symbols: dict[str, float] = symbols

    def solved(self, wanted: Array, fed: Array) -> tuple[Array, bool]:
        """Return z (states,) at which the torques are those wanted (m,), `fed` among them, and whether it is one.

        Of several solutions it is the smallest.
        """
        z, driven = np.zeros(self.states), self.states - self.friction
        goal = np.concatenate([np.zeros(driven), wanted])
        if not driven:
            return z, True
        rows, columns = np.ones(len(goal)), np.ones(driven)
        for _ in range(ITERATIONS):
            left = goal - self._values(z, fed)
            slopes = np.transpose(
                [(self._values(z + STEP * unit, fed) - self._values(z, fed)) / STEP for unit in np.eye(self.states)]
            )[:, self.friction :]
            rows = _over(np.abs(slopes).max(axis=1))
            columns = _over(np.abs(rows[:, None] * slopes).max(axis=0))
            scaled = rows[:, None] * slopes * columns
            z[self.friction :] += columns * np.linalg.lstsq(scaled, rows * left, rcond=1e-12)[0]
        off = rows * (goal - self._values(z, fed))
        return z, bool(np.abs(off).max() <= SOLVED * max(np.abs(wanted).max(), np.abs(rows * goal).max()))

    def _values(self, z: Array, fed: Array) -> Array:
        """Return zd of drives, then tau_m."""
        given = self._symbols | dict(zip(self._inputs.get("z", ()), z.tolist(), strict=True))
        given |= dict(zip(self._inputs["tau"], fed.tolist(), strict=True))
        return values_along(self._roots, given, 1)[:, 0]


def _over(x: Array) -> Array:
    """Return 1/x, 0 where x is."""
    found: Array = np.divide(1.0, x, out=np.zeros_like(x), where=x > 0)
    return found


def start_of_states(rest: AtRest, torques: Array, natural: Array) -> tuple[Array, Array, bool]:
    """Return z (states,) at the start, natural sizes of the states of drives, and whether the start is at rest.

    `torques` hold the machine, `natural` (m,) are of the size that motors give. A state has the size at which it gives
    such a torque; one that is zero then, that of the torque.
    """
    z, is_rest = rest.solved(torques, torques)
    none = np.zeros_like(natural)
    sizes = np.abs(rest.solved(natural, natural)[0])
    alone, is_found = rest.solved(natural, none)
    sizes = np.maximum(sizes, np.abs(alone)) if is_found else sizes
    return z, np.where(sizes > 1e-9 * natural.max(initial=0.0), sizes, natural.max(initial=1.0)), is_rest
