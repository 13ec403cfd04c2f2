"""Expressions prepared to be evaluated many times: operations in order, with the places of their operands."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Generic

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import Arithmetic, Number
from symoro_elastic.symbolic.expression import Expression, reachable
from symoro_elastic.symbolic.operations import SYMBOL

Step = tuple[Callable[..., Any], int, int]
"""An operation and the places of its operands, -1 where it has one only."""


class Tape(Generic[Number]):
    """The operations that roots need, in an arithmetic; values equal those of `evaluate` to the last bit."""

    def __init__(self, roots: Iterable[Scalar], arithmetic: Arithmetic[Number]) -> None:
        roots, number, operations = list(roots), arithmetic.number, arithmetic.operations
        nodes = reachable(roots)
        symbols = [node for node in nodes if node.operation == SYMBOL]
        constant_nodes = [node for node in nodes if not node.operands]
        computed = [node for node in nodes if node.operands and node.operation != SYMBOL]
        constants = [x for node in computed for x in node.operands if type(x) is not Expression]
        constants += [x for x in roots if type(x) is not Expression]
        self._symbols = [str(node.operands[0]) for node in symbols]
        self._numbers = [*(operations[node.operation]() for node in constant_nodes), *map(number, constants)]
        numbered = [*symbols, *constant_nodes, *(None for _ in constants), *computed]
        places = {node.id: place for place, node in enumerate(numbered) if node is not None}
        of_constants = iter(range(len(symbols) + len(constant_nodes), len(numbered)))

        def place(x: Any) -> int:
            return places[x.id] if type(x) is Expression else next(of_constants)

        self._steps: list[Step] = []
        for node in computed:
            first, *others = map(place, node.operands)
            self._steps.append((operations[node.operation], first, *(others or [-1])))  # type: ignore[arg-type]
        self._roots = [place(x) for x in roots]

    def values(self, symbols: Mapping[str, Number]) -> list[Number]:
        """Return the values of the roots for these values of symbols."""
        values = [*map(symbols.__getitem__, self._symbols), *self._numbers]
        append = values.append
        for operation, first, second in self._steps:
            append(operation(values[first]) if second < 0 else operation(values[first], values[second]))
        return [values[place] for place in self._roots]
