"""Entries of results that are constants or equal to other entries: batches write them in rows of many states.

Symmetric or sparse matrices have many of them. A vector of states that is stored to every entry
touches as many cache lines as there are entries; a row is written in one go.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from symoro_elastic.codegen.c.lines import INDENT, statement, with_arguments
from symoro_elastic.symbolic.expression import Expression, Level, Operand
from symoro_elastic.symbolic.program import Output

FEWEST, FEWEST_OF_ALL = 64, 16
"""Numbers of entries above which rows are faster: of a result, and of a result that consists of them."""
FEWEST_RESULTS = 500
"""Entries of a result from which on a table is faster: fewer are faster in lines (29 joints, a tree: 1 to 4 %)."""


@dataclass(frozen=True)
class Rows:
    """Entries of a result that a batch fills row by row: copies of earlier entries (`equal`), and `numbers`."""

    result: str
    equal: tuple[tuple[int, int], ...]
    numbers: tuple[tuple[int, str], ...]

    @property
    def entries(self) -> frozenset[int]:
        """Indices of all entries that are filled row by row."""
        return frozenset(k for k, _ in (*self.equal, *self.numbers))

    def lines(self, type_: str) -> list[str]:
        """C lines that store copied entries and numbers of a result in its array of this type, for `count` states."""
        equal = ", ".join(f"{{{k},{of}}}" for k, of in self.equal)
        places = ", ".join(str(k) for k, _ in self.numbers)
        values = ", ".join(value for _, value in self.numbers)
        lines = []
        if self.equal:
            lines += [statement(f"{INDENT}static const unsigned equal[{len(self.equal)}][2] = ", f"{{{equal}}};")]
        if self.numbers:
            lines += [statement(f"{INDENT}static const unsigned place[{len(self.numbers)}] = ", f"{{{places}}};")]
            lines += [statement(f"{INDENT}static const {type_} number[{len(self.numbers)}] = ", f"{{{values}}};")]
        return [*lines, *self._loops()]

    def _loops(self) -> list[str]:
        array, inner = self.result, INDENT * 2
        lines = []
        if self.equal:
            copied = [f"{array} + equal[k][0]*states", f"{array} + equal[k][1]*states", f"count*sizeof *{array}"]
            lines += [f"{INDENT}for (size_t k = 0; k < {len(self.equal)}; k++) {{"]
            lines += [with_arguments(f"{inner}memcpy", copied, ");"), f"{INDENT}}}"]
        if self.numbers:
            lines += [f"{INDENT}for (size_t k = 0; k < {len(self.numbers)}; k++) {{"]
            lines += [f"{inner}for (size_t state = 0; state < count; state++) {{"]
            lines += [f"{inner}{INDENT}{array}[place[k]*states + state] = number[k];", f"{inner}}}", f"{INDENT}}}"]
        return lines


def repeated_rows(outputs: Sequence[Output], text: Callable[[Operand], str]) -> list[Rows]:
    """Return the results with enough repeated entries to fill them row by row; `text` prints an entry."""
    rows = [_of(output, text) for output in outputs]
    return [one for one, output in zip(rows, outputs, strict=True) if _is_worth_it(one, len(output.entries))]


def _is_worth_it(rows: Rows, entries: int) -> bool:
    """Whether filling these entries of a result row by row is faster than storing them with vectors."""
    return len(rows.entries) >= (FEWEST_OF_ALL if len(rows.entries) == entries else FEWEST)


def _of(output: Output, text: Callable[[Operand], str]) -> Rows:
    first: dict[str, int] = {}
    equal, numbers = [], []
    for k, x in enumerate(output.entries):
        value = text(x)
        if not isinstance(x, Expression) or x.level == Level.CONSTANT:
            numbers.append((k, value))
        elif first.setdefault(value, k) != k:
            equal.append((k, first[value]))
    return Rows(output.name, tuple(equal), tuple(numbers))


class Stored(NamedTuple):
    """An entry of a result and the text of its value."""

    result: str
    k: int
    value: str


Copies = Mapping[str, Sequence[tuple[int, int]]]
"""Entries that are variables of the spill array with their slots, by result."""


def copies(stored: Sequence[Stored], slots: Mapping[str, int]) -> Copies:
    """Return, by result, the entries to copy from the spill array by a table, if a result has enough of them."""
    slots_of: dict[str, list[tuple[int, int]]] = {}
    for result, k, value in stored:
        if value in slots:
            slots_of.setdefault(result, []).append((k, slots[value]))
    return {result: places for result, places in slots_of.items() if len(places) >= FEWEST_RESULTS}


def lines(stored: Sequence[Stored], copied: Copies, store: str, spill: str) -> list[str]:
    """C lines that store single entries, then copy `copied` ones by tables; `store` is the format of a store."""
    done = {(result, k) for result, places in copied.items() for k, _ in places}
    single = [entry for entry in stored if (entry.result, entry.k) not in done]
    code = [INDENT + store.format(array=entry.result, k=entry.k, value=entry.value) for entry in single]
    for result, places in copied.items():
        table = ", ".join(f"{{{k},{slot}}}" for k, slot in places)
        of_entry = store.format(array=result, k="place[k][0]", value=f"{spill}[place[k][1]]")
        code += [
            f"{INDENT}{{",
            statement(f"{INDENT * 2}static const unsigned place[{len(places)}][2] = ", f"{{{table}}};"),
            f"{INDENT * 2}for (size_t k = 0U; k < {len(places)}U; k++) {{",
            f"{INDENT * 3}{of_entry}",
            f"{INDENT * 2}}}",
            f"{INDENT}}}",
        ]
    return code
