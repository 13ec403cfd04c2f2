"""Numbers loaded where they are first needed and stored where they are found.

Vectors of many states fill a register each, of which there are 16 or 32. Compilers leave loads and stores where they
stand: entries that are all loaded first, or stored last, are copied to the stack and back in the meantime.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from symoro_elastic.codegen.outlining import OPERAND
from symoro_elastic.codegen.partition import Step


class Around(NamedTuple):
    """Lines before and after statements, by the names of their variables."""

    before: Mapping[str, Sequence[str]]
    after: Mapping[str, Sequence[str]]


NOTHING = Around({}, {})


def near_use(
    steps: Sequence[Step], loads: Mapping[str, str], stores: Iterable[tuple[str, str]]
) -> tuple[Around, list[str]]:
    """Return lines around statements, and those at the end, for what no statement needs or finds.

    `loads` are lines by the name that they define, `stores` pairs of a value and the line that stores it, in which
    others may be computed.
    """
    found = {step.statement.name: k for k, step in enumerate(steps)}
    stored: dict[int, list[tuple[str, str]]] = defaultdict(list)
    for value, line in stores:
        own = [found[name] for name in OPERAND.findall(value) if name in found]
        stored[max(own, default=len(steps))].append((value, line))
    left = dict(loads)

    def first_used(names: Iterable[str]) -> list[str]:
        return [left.pop(name) for name in sorted(names) if name in left]

    def in_order(stores: Iterable[tuple[str, str]]) -> list[str]:
        return [text for value, line in stores for text in (*first_used(OPERAND.findall(value)), line)]

    before, after = {}, {}
    for k, step in enumerate(steps):
        before[step.statement.name] = first_used(step.uses)
        after[step.statement.name] = in_order(stored[k])
    return Around(before, after), in_order(stored[len(steps)])
