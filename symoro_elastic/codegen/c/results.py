"""Results of a call: entries stored one by one, or copied from the spill array by a table.

A long model hands on most of its results from one function to the last. A table of places takes the compiler no time
and, where entries are many, a call less of it than fetching an instruction for each load and store.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from symoro_elastic.codegen.c.lines import INDENT, statement

FEWEST = 500
"""Entries of a result from which on a table is faster: fewer are faster in lines (29 joints, a tree: 1 to 4 %)."""


class Stored(NamedTuple):
    """An entry of a result, and the value that it has."""

    result: str
    k: int
    value: str


Copies = Mapping[str, Sequence[tuple[int, int]]]
"""By result: its entries that are variables of the spill array, each with its slot there."""


def copies(stored: Sequence[Stored], slots: Mapping[str, int]) -> Copies:
    """Return what a table can copy, of the results for which it is worth it."""
    found: dict[str, list[tuple[int, int]]] = {}
    for result, k, value in stored:
        if value in slots:
            found.setdefault(result, []).append((k, slots[value]))
    return {result: places for result, places in found.items() if len(places) >= FEWEST}


def lines(stored: Sequence[Stored], copied: Copies, store: str, spill: str) -> list[str]:
    """C that stores what is not copied, then copies; `store` is how an entry is written."""
    done = {(result, k) for result, places in copied.items() for k, _ in places}
    single = [one for one in stored if (one.result, one.k) not in done]
    found = [INDENT + store.format(array=one.result, k=one.k, value=one.value) for one in single]
    for result, places in copied.items():
        table = ", ".join(f"{{{k},{slot}}}" for k, slot in places)
        of_entry = store.format(array=result, k="place[k][0]", value=f"{spill}[place[k][1]]")
        found += [
            f"{INDENT}{{",
            statement(f"{INDENT * 2}static const unsigned place[{len(places)}][2] = ", f"{{{table}}};"),
            f"{INDENT * 2}for (size_t k = 0U; k < {len(places)}U; k++) {{",
            f"{INDENT * 3}{of_entry}",
            f"{INDENT * 2}}}",
            f"{INDENT}}}",
        ]
    return found
