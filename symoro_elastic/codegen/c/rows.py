"""Entries of results that hold a number, or what another entry holds: batches write them in rows of many states.

Matrices that are symmetric or sparse have more of them than of others. A vector of states that is stored to every entry
touches as many cache lines as there are entries; a row is written in one go.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from symoro_elastic.codegen.c.lines import INDENT, statement, with_arguments
from symoro_elastic.symbolic.expression import Expression, Level, Operand
from symoro_elastic.symbolic.program import Output

FEWEST, FEWEST_OF_ALL = 64, 16
"""Entries from which on rows are faster: fewer stay in the first cache; those that are all of a result."""


@dataclass(frozen=True)
class Rows:
    """Entries of one result: those that are `equal` to one before them, and the values of those that are `numbers`."""

    result: str
    equal: tuple[tuple[int, int], ...]
    numbers: tuple[tuple[int, str], ...]

    @property
    def entries(self) -> frozenset[int]:
        """All of them."""
        return frozenset(k for k, _ in (*self.equal, *self.numbers))

    def lines(self, type_: str) -> list[str]:
        """C that completes these entries of `count` states, in an array of this type."""
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
    """Return the rows of those results that have enough such entries; `text` prints an entry."""
    rows = [_of(output, text) for output in outputs]
    return [one for one, output in zip(rows, outputs, strict=True) if _is_worth_it(one, len(output.entries))]


def _is_worth_it(rows: Rows, entries: int) -> bool:
    """Whether rows are faster than vectors for these of the entries of a result."""
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
