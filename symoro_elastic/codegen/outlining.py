"""Blocks of a long program that do the same work on other variables: each kind can be one function.

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

LONGEST_BLOCK = 150
FEWEST_PAIRS = 3
"""Statements of a block, and times that a pair occurs where it becomes one."""
NEVER = (0, 0)
APART = -1
"""In place of the kind of a pair that is not merged."""
OPERAND = re.compile(r"((?:sine|cosine)\[\d+\]|[A-Za-z_]\w*)")


class Block(NamedTuple):
    """Statements in a row from `first` on: the kind of their work, what they read from before them and define.

    Blocks of one kind compute the same of variables that correspond by their places in `read` and `defined`.
    """

    kind: int
    first: int
    size: int
    read: tuple[str, ...]
    defined: tuple[str, ...]


class _Kinds:
    """Numbers of kinds of work: statements, and pairs of kinds with the variables in common."""

    def __init__(self) -> None:
        self._numbers: dict[Hashable, int] = {}

    def of(self, work: Hashable) -> int:
        return self._numbers.setdefault(work, len(self._numbers))


def blocks(
    statements: Sequence[tuple[str, str]],
    sections: Sequence[Section],
    operands: Collection[str],
    longest: int = LONGEST_BLOCK,
) -> list[Block]:
    """Return the statements (name, right side) as blocks, as long as there are others of their kind.

    `operands` are the names that stand for numbers; others, such as those of functions, belong to the work.
    """
    kinds = _Kinds()
    found = [_single(k, name, text, operands, kinds) for k, (name, text) in enumerate(statements)]
    for of_one_section in (True, False):
        row = _Row(found, _Pairs(kinds, sections if of_one_section else None, longest))
        while row.merge():
            pass
        found = row.blocks
    return found


def _single(first: int, name: str, text: str, operands: Collection[str], kinds: _Kinds) -> Block:
    """The block of one statement, whose right side names `operands`."""
    pieces = OPERAND.split(text)
    names = pieces[1::2]
    read = {one: k for k, one in enumerate(dict.fromkeys([one for one in names if one in operands]))}
    kind = kinds.of((*pieces[::2], *[read.get(one, one) for one in names]))
    return Block(kind, first, 1, tuple(read), (name,))


class _Pairs:
    """Kinds of pairs of blocks: their own kinds and the variables in common."""

    def __init__(self, kinds: _Kinds, sections: Sequence[Section] | None, longest: int) -> None:
        """With `sections`, only blocks of one section are merged."""
        self._kinds, self._sections, self._longest = kinds, sections, longest

    def of(self, a: Block, b: Block) -> int:
        """The kind of a block and the next; `APART` where they stay apart."""
        if a.size + b.size > self._longest:
            return APART
        if self._sections is not None and self._sections[a.first] != self._sections[b.first]:
            return APART
        places = {name: k for k, name in enumerate(a.read + a.defined)}
        return self._kinds.of((a.kind, b.kind, *[places.get(name, -1) for name in b.read]))


class _Row:
    """Blocks in order, and the kinds of their pairs: `kinds[k]` is that of blocks k and k + 1."""

    def __init__(self, found: Sequence[Block], pairs: _Pairs) -> None:
        self._pairs = pairs
        self.blocks = list(found)
        self._kinds = [pairs.of(a, b) for a, b in pairwise(found)]

    def merge(self) -> bool:
        """Merge pairs that occur often, each block with the neighbour with which it does more often, or first."""
        kinds, blocks, before = self._kinds, self.blocks, len(self.blocks)
        times = Counter(kinds)
        often = {kind: (n, -order) for order, (kind, n) in enumerate(times.items()) if n >= FEWEST_PAIRS}
        often.pop(APART, None)
        ranks = [often.get(kind, NEVER) for kind in kinds] + [NEVER, NEVER]
        self.blocks, self._kinds, k, last_merged = [], [], 0, False
        while k < before:
            merges = ranks[k] > NEVER and ranks[k] >= ranks[k + 1]
            block = _both(blocks[k], blocks[k + 1], kinds[k]) if merges else blocks[k]
            if self.blocks:
                is_new = merges or last_merged
                self._kinds.append(self._pairs.of(self.blocks[-1], block) if is_new else kinds[k - 1])
            self.blocks.append(block)
            k, last_merged = k + 1 + merges, merges
        return len(self.blocks) < before


def _both(a: Block, b: Block, kind: int) -> Block:
    known = {*a.read, *a.defined}
    read = (*a.read, *[name for name in b.read if name not in known])
    return Block(kind, a.first, a.size + b.size, read, a.defined + b.defined)
