"""Positions of machines with couplings and loops, many at once: every loop closed, on the branch of its start."""

from __future__ import annotations

from collections.abc import Mapping

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.base_parameters import ZeroPosition
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.loops.plan import plan_of
from symoro_elastic.numerics.values import ParameterValues, parameter_values


def drawn_values(machine: Machine, seed: int = 0) -> ParameterValues:
    """Return values of all parameters, drawn where none is given; those of the geometry are such that loops close."""
    values = parameter_values(machine, seed)
    if not machine.loops:
        return values
    closed, geometry = plan_of(machine, Bound).assembly.values, ZeroPosition(machine).geometry
    return values | {name: closed[name] for name in geometry}


class Followed:
    """Dependent variables without closed form, followed from the start of the loops by continuation."""

    def __init__(self, machine: Machine, values: Mapping[str, float]) -> None:
        plan = plan_of(machine, Bound)
        self._start, self._assembly = plan.positions[0], plan.assembly.at_values({**plan.assembly.values, **values})

    def at(self, q: Array) -> Array:
        """Return q_dep (samples, d) at q (samples, n); NaN where the branch of the start does not lead there."""
        found: Array = self._assembly.followed(self._start, q)[:, self._assembly.unknown]
        return found
