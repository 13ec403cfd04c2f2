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
OPERAND = re.compile(r"(?:sine|cosine)\[\d+\]|[A-Za-z_]\w*")


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
    """Numbers of kinds of work."""

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
        merged = len(found) + 1
        while len(found) < merged:
            merged = len(found)
            found = _merged(found, kinds, _pairs(found, sections if of_one_section else None, longest))
    return found


def _single(first: int, name: str, text: str, operands: Collection[str], kinds: _Kinds) -> Block:
    """The block of one statement, whose right side names `operands`."""
    read: dict[str, int] = {}

    def place(found: re.Match[str]) -> str:
        return f"{{{read.setdefault(found[0], len(read))}}}" if found[0] in operands else found[0]

    kind = kinds.of(OPERAND.sub(place, text))
    return Block(kind, first, 1, tuple(read), (name,))


Pair = tuple[int, int, tuple[int, ...]]


def _pairs(found: Sequence[Block], sections: Sequence[Section] | None, longest: int) -> list[Pair | None]:
    """Each block with the next: their kinds and the variables in common; None where they stay apart."""
    return [
        _pair(a, b)
        if a.size + b.size <= longest and (sections is None or sections[a.first] == sections[b.first])
        else None
        for a, b in pairwise(found)
    ]


def _pair(a: Block, b: Block) -> Pair:
    places = {name: k for k, name in enumerate((*a.read, *a.defined))}
    return a.kind, b.kind, tuple([places.get(name, -1) for name in b.read])


def _merged(found: Sequence[Block], kinds: _Kinds, pairs: Sequence[Pair | None]) -> list[Block]:
    """Blocks with pairs merged that occur often, each with the neighbour with which it does more often, or first."""
    times = Counter(pair for pair in pairs if pair is not None)
    often = {pair: (n, -order) for order, (pair, n) in enumerate(times.items()) if n >= FEWEST_PAIRS}
    ranks = [often.get(pair, NEVER) if pair is not None else NEVER for pair in pairs] + [NEVER, NEVER]
    merged, k = [], 0
    while k < len(found):
        if ranks[k] > NEVER and ranks[k] >= ranks[k + 1]:
            merged.append(_both(found[k], found[k + 1], kinds.of(pairs[k])))
            k += 2
        else:
            merged.append(found[k])
            k += 1
    return merged


def _both(a: Block, b: Block, kind: int) -> Block:
    known = {*a.read, *a.defined}
    read = (*a.read, *(name for name in b.read if name not in known))
    return Block(kind, a.first, a.size + b.size, read, a.defined + b.defined)
