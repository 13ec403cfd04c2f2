"""Random positions of machines with couplings and loops, many at once: every loop closed, away from singular ones."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.base_parameters import ZeroPosition
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.catalogue import trace
from symoro_elastic.models.loops.plan import plan_of
from symoro_elastic.numerics.arrays import values_along
from symoro_elastic.numerics.assembled_states import start_of
from symoro_elastic.numerics.values import ParameterValues, parameter_values

CLOSED, SETTLED = 1e-13, 1e-12
"""Gap of a loop, m and rad, that is rounding; change of a variable, which near singular positions is far larger."""
STEP = 0.2
"""Largest step towards a position whose dependent variables are followed, rad or m."""
SETTLING = 2
"""Further runs of `assemble` at the position itself."""


def drawn_values(machine: Machine, seed: int = 0) -> ParameterValues:
    """Return values of all parameters, drawn where none is given; those of the geometry are such that loops close."""
    values = parameter_values(machine, seed)
    if not machine.loops:
        return values
    closed, geometry = plan_of(machine, Bound).assembly.values, ZeroPosition(machine).geometry
    return values | {name: closed[name] for name in geometry}


class Followed:
    """Dependent variables without closed form, followed from the start of the loops along straight lines."""

    def __init__(self, machine: Machine, values: Mapping[str, float]) -> None:
        self._start, self._values = start_of(machine), values
        self._program = trace(machine, "assemble").program

    def at(self, q: Array) -> Array:
        """Return q_dep (samples, d) at q (samples, n); NaN where the loops do not close."""
        lengths = np.abs(q - self._start.q).max(axis=1, initial=0.0)
        steps = max(1, math.ceil(float(lengths.max(initial=0.0)) / STEP))
        q_dep = np.broadcast_to(self._start.q_dep, (len(q), len(self._start.q_dep)))
        for part in (*np.arange(1, steps + 1) / steps, *[1.0] * SETTLING):
            before = q_dep
            q_dep, gap = self._assembled(self._start.q + part * (q - self._start.q), before)
        closed = (gap < CLOSED) & (np.abs(q_dep - before).max(axis=1, initial=0.0) < SETTLED)
        return np.where(closed[:, None], q_dep, np.nan)

    def _assembled(self, q: Array, q_dep: Array) -> tuple[Array, Array]:
        symbols: dict[str, Any] = dict(self._values)
        for argument, block in zip(self._program.inputs, (q, q_dep), strict=True):
            symbols |= zip(argument.symbols, block.T, strict=True)
        found, gap = self._program.outputs
        *variables, error = values_along([*found.entries, *gap.entries], symbols, len(q))
        return np.stack(variables, axis=1), error
