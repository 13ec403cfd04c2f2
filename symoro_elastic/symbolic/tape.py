"""Expressions prepared to be evaluated many times: operations in order, with the places of their operands."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Generic

from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.arithmetic import Arithmetic, Number
from symoro_elastic.symbolic.expression import Expression, reachable
from symoro_elastic.symbolic.operations import SYMBOL


class Tape(Generic[Number]):
    """The operations that some roots need, in one arithmetic; the values are those of `evaluate`, to the last bit."""

    def __init__(self, roots: Iterable[Scalar], arithmetic: Arithmetic[Number]) -> None:
        roots = list(roots)
        nodes = reachable(roots)
        self._symbols = [node for node in nodes if node.operation == SYMBOL]
        computed = [node for node in nodes if node.operation != SYMBOL]
        constants = (x for node in computed for x in node.operands if type(x) is not Expression)
        self._numbers = [arithmetic.number(x) for x in (*constants, *(x for x in roots if type(x) is not Expression))]
        ahead = len(self._symbols)
        of_numbers = iter(range(ahead, ahead + len(self._numbers)))
        numbered = (*self._symbols, *([None] * len(self._numbers)), *computed)
        places = {node.id: place for place, node in enumerate(numbered) if node is not None}

        def place(x: Any) -> int:
            return places[x.id] if type(x) is Expression else next(of_numbers)

        operations = arithmetic.operations
        self._steps = [(operations[node.operation], tuple(map(place, node.operands))) for node in computed]
        self._roots = [place(x) for x in roots]

    def values(self, symbols: Mapping[str, Number]) -> list[Number]:
        """Return the value of each root, where symbols have these values."""
        values = [*(symbols[node.operands[0]] for node in self._symbols), *self._numbers]
        append = values.append
        for operation, places in self._steps:
            if len(places) == 2:
                append(operation(values[places[0]], values[places[1]]))
            else:
                append(operation(*[values[place] for place in places]))
        return [values[place] for place in self._roots]
