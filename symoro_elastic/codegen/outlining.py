"""Blocks of a long program that do the same work on other variables, so that a function can do it.

Blocks are found by merging statements that follow each other wherever the same pair, with the same variables in common,
occurs again: first within the work of a joint, then across joints.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Hashable, Sequence
from itertools import pairwise
from typing import NamedTuple

from symoro_elastic.symbolic.program import Section

LONGEST_BLOCKS = (150, 50)
"""Maximum number of statements of a block: long blocks need few calls, but repeat less often."""
FEWEST_PAIRS = 3
"""Times that a pair occurs where it becomes one work."""
NEVER = (0, 0)
APART = -1
"""Placeholder of the kind of a pair that is not merged."""
OPERAND = re.compile(r"((?:sine|cosine)\[\d+\]|[A-Za-z_]\w*)")


class Block(NamedTuple):
    """Consecutive statements from `first`: kind of computation, variables read from earlier ones, and defined.

    Blocks of the same kind compute the same of variables with equal positions in `read` and `defined`.
    """

    kind: int
    first: int
    size: int
    read: tuple[str, ...]
    defined: tuple[str, ...]


class _Kinds:
    """Numbers of kinds of work, one for equal work: of a statement, or of two kinds in turn that share variables."""

    def __init__(self) -> None:
        self._numbers: dict[Hashable, int] = {}

    def of(self, work: Hashable) -> int:
        return self._numbers.setdefault(work, len(self._numbers))


def blocks(
    statements: Sequence[tuple[str, str]],
    sections: Sequence[Section],
    operands: Collection[str],
    longest: Sequence[int] = LONGEST_BLOCKS,
) -> list[list[Block]]:
    """Return the statements (name, right side) grouped to blocks, the longest that are repeated.

    `operands` are the names of numbers; others, such as those of functions, belong to the work. There is a
    list of blocks for each of the limits in `longest`.
    """
    kinds = _Kinds()
    works = [_work(k, name, text, operands, kinds) for k, (name, text) in enumerate(statements)]
    read = [tuple(work.places)[:-1] for work in works]
    pairs = _Pairs(kinds, sections, min(longest))
    row = _Row(works, pairs)
    while not pairs.met_limit and row.merge():  # as long as no limit is met, works of all limits are the same
        pass
    merged_works = (_merge(row.works, sections, kinds, limit) for limit in longest)
    return [[_block(work, statements, read) for work in merged] for merged in merged_works]


def _merge(works: Sequence[_Work], sections: Sequence[Section], kinds: _Kinds, longest: int) -> Sequence[_Work]:
    """Sequences of at most `longest` statements, merged within sections, then across sections."""
    for of_one_section in (True, False):
        row = _Row(works, _Pairs(kinds, sections if of_one_section else None, longest))
        while row.merge():
            pass
        works = row.works
    return works


def _block(work: _Work, statements: Sequence[tuple[str, str]], read: Sequence[Sequence[str]]) -> Block:
    """The block of a statement sequence; `read` are the operands of all statements."""
    own = range(work.first, work.first + work.size)
    defined = dict.fromkeys([statements[k][0] for k in own])
    before = dict.fromkeys([name for k in own for name in read[k] if name not in defined])
    return Block(work.kind, work.first, work.size, tuple(before), tuple(defined))


class _Work(NamedTuple):
    """A sequence of statements from `first` on, its kind, and the indices of the variables in it.

    Variables of works of the same kind correspond by their places, which are less than `room`.
    """

    kind: int
    first: int
    size: int
    places: dict[str, int]
    room: int


def _work(first: int, name: str, text: str, operands: Collection[str], kinds: _Kinds) -> _Work:
    """The sequence of one statement; `operands` in its right side are numbered, its own variable comes last."""
    pieces = OPERAND.split(text)
    places: dict[str, int] = {}
    for k, word in enumerate(pieces[1::2]):
        if word in operands:
            pieces[2 * k + 1] = places.setdefault(word, len(places))
    kind = kinds.of(tuple(pieces))
    places[name] = len(places)
    return _Work(kind, first, 1, places, len(places))


class _Pairs:
    """Kinds of pairs of adjacent sequences, by their own kinds and common variables."""

    def __init__(self, kinds: _Kinds, sections: Sequence[Section] | None, longest: int) -> None:
        """Prepare the pairs; with `sections`, only sequences of the same section are merged."""
        self._kinds, self._sections, self._longest, self.met_limit = kinds, sections, longest, False

    def of(self, a: _Work, b: _Work) -> int:
        """The kind of two adjacent sequences; `APART` if they must not be merged."""
        if self._sections is not None and self._sections[a.first] != self._sections[b.first]:
            return APART
        if a.size + b.size > self._longest:
            self.met_limit = True
            return APART
        in_a, in_b = a.places, b.places
        shared = sorted([(in_a[name], in_b[name]) for name in in_a.keys() & in_b.keys()])
        return self._kinds.of((a.kind, b.kind, *shared))


class _Row:
    """Sequences in order, and the kinds of adjacent pairs: `kinds[k]` is that of sequences k and k + 1."""

    def __init__(self, works: Sequence[_Work], pairs: _Pairs) -> None:
        self._pairs = pairs
        self.works = list(works)
        self._kinds = [pairs.of(a, b) for a, b in pairwise(works)]

    def merge(self) -> bool:
        """Merge frequent pairs, each sequence with the neighbour of the more frequent pair; return if any merged."""
        kinds, works, before = self._kinds, self.works, len(self.works)
        times = Counter(kinds)
        often = {kind: (n, -order) for order, (kind, n) in enumerate(times.items()) if n >= FEWEST_PAIRS}
        often.pop(APART, None)
        ranks = [often.get(kind, NEVER) for kind in kinds] + [NEVER, NEVER]
        self.works, self._kinds, k, was_merged = [], [], 0, False
        while k < before:
            merges = ranks[k] > NEVER and ranks[k] >= ranks[k + 1]
            work = _both(works[k], works[k + 1], kinds[k]) if merges else works[k]
            if self.works:
                is_new = merges or was_merged
                self._kinds.append(self._pairs.of(self.works[-1], work) if is_new else kinds[k - 1])
            self.works.append(work)
            k, was_merged = k + 1 + merges, merges
        return len(self.works) < before


def _both(a: _Work, b: _Work, kind: int) -> _Work:
    places = {name: a.room + place for name, place in b.places.items()} | a.places
    return _Work(kind, a.first, a.size + b.size, places, a.room + b.room)
