"""Dependent variables of loops that have no closed form: their values and derivatives at positions of a machine.

Values are followed from the start of the loops in small steps, so that they stay on their branch. Derivatives by an
independent variable or a parameter are W_d^-1 times that of the closing errors (L10), (L18).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.mechanics.loops.closing import closing_error
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.derivatives.derivative_columns import moved_with
from symoro_elastic.models.loops.assembly import Assembly, loop_branches
from symoro_elastic.models.loops.plan import plan_of
from symoro_elastic.symbolic.arithmetic import FLOATS, Arithmetic, evaluate
from symoro_elastic.symbolic.duals import Dual
from symoro_elastic.symbolic.expression import Expression, Level, reachable
from symoro_elastic.symbolic.operations import SYMBOL

T = TypeVar("T")

FARTHEST = 100.0
"""Rad or m that a position may be from the last one."""


class traced_once(cached_property[T]):  # noqa: N801  (used as a decorator)
    """A cached property that copies of its owner share, in the dictionary `traced` of the owner."""

    def __get__(self, instance: Any, owner: type[Any] | None = None) -> Any:
        """Return the value, computed on first use."""
        if instance is None:
            return self
        if self.attrname not in instance.traced:
            instance.traced[self.attrname] = self.func(instance)
        return instance.traced[self.attrname]


class AssembledLoops:
    """The dependent variables without closed form of a bound machine, at values of its parameters."""

    def __init__(self, bound: Bound, parameters: Mapping[str, float]) -> None:
        self.bound, self.parameters = bound, parameters
        self.joints = bound.assembled
        self.names = {j: str(bound.machine.joint(j).variable) for j in self.joints}
        self.traced: dict[str, Any] = {}

    def at_values(self, parameters: Mapping[str, float]) -> AssembledLoops:
        """Return these variables at other values of the parameters, followed from the start of the loops again."""
        loops = AssembledLoops(self.bound, parameters)
        loops.traced = self.traced
        return loops

    def add_to(self, symbols: dict[str, Any], q: Sequence[Any]) -> None:
        """Add the dependent variables to values of symbols, as duals where the independent ones `q` are duals."""
        if not self.joints:
            return
        values = self._values(np.array([x.value if x.__class__ is Dual else x for x in q], dtype=float))
        symbols |= values
        names = (symbol.operands[0] for symbol in self.bound.q.values())
        tangents = {name: x.tangent for name, x in zip(names, q, strict=True) if x.__class__ is Dual}
        if not tangents:
            return
        still = {name: x.value if x.__class__ is Dual else x for name, x in symbols.items()}
        slopes = self._evaluate(list(tangents), still, FLOATS)
        for name, x in values.items():
            symbols[name] = Dual(x, sum(slopes[by][name] * tangent for by, tangent in tangents.items()))

    def total(
        self, partial: Mapping[str, Any], symbols: Mapping[str, Any], arithmetic: Arithmetic[Any]
    ) -> dict[str, Any]:
        """Total derivatives by symbol from partial ones: dependent variables move along (L42)."""
        total = dict(partial)
        moved = {name: total.pop(name) for name in self.names.values() if name in total}
        for by, slopes in self._evaluate(list(self.slopes), symbols, arithmetic).items() if moved else ():
            for name, weight in moved.items():
                added = slopes[name] * weight
                total[by] = total[by] + added if by in total else added
        return total

    def _evaluate(self, by: Sequence[str], symbols: Mapping[str, Any], arithmetic: Arithmetic[Any]) -> dict[str, Any]:
        value = evaluate((x for name in by for x in self.slopes[name].values()), symbols, arithmetic)
        return {name: {d: value(x) for d, x in self.slopes[name].items()} for name in by}

    @traced_once
    def slopes(self) -> dict[str, dict[str, Scalar]]:
        """Derivatives of the variables, by the name of the denominator and then of the variable."""
        moved = {q: moved_with(self.bound, "q", j, q) for j, q in self.bound.q.items()}
        moved |= {p: moved_with(self.bound, "p", 0, p) for p in self._lengths()}
        return {
            by.operands[0]: {x.operands[0]: slope for x, slope in entries.items() if x is not by}
            for by, entries in moved.items()
        }

    def _lengths(self) -> list[Expression]:
        """Parameters that loops depend on."""
        branches = (loop_branches(self.bound, loop.loop) for loop in self.bound.loops)
        nodes = reachable(x for branch in branches for x in closing_error(branch).entries)
        return [x for x in nodes if x.operation == SYMBOL and x.level is Level.PARAMETER]

    def _values(self, q: np.ndarray[Any, Any]) -> dict[str, float]:
        """Return the variables at q (n,); NaN where the loops do not close, or too far away."""
        machine = self.bound.machine
        target = dict(zip(machine.independent, q.tolist(), strict=True))
        far = max((abs(x - self._position[j]) for j, x in target.items()), default=0.0)
        position = self._assembly.position_at(self._position, target) if far < FARTHEST else None
        if position is None:
            return dict.fromkeys(self.names.values(), np.nan)
        self._position = position
        return {name: position[j] for j, name in self.names.items()}

    @cached_property
    def _assembly(self) -> Assembly:
        assembly = plan_of(self.bound.machine).assembly
        return assembly.at_values({**assembly.values, **self.parameters})

    @cached_property
    def _position(self) -> dict[int, float]:
        start = plan_of(self.bound.machine).positions[0]
        return self._assembly.assembled_position(start, self.bound.machine.dependent)[0]
