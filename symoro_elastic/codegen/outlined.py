"""Long programs as calls: blocks that repeat become functions, whose arguments are places in arrays.

The variables that a block hands on to others lie side by side in the spill array. What two calls of a function read or
write is equally far apart in the arrays wherever it can share a pointer.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from symoro_elastic.codegen.outlining import Block
from symoro_elastic.codegen.partition import LONGEST_PART, Part, Step

SHORTEST_BLOCK = 10
SPILL = "spill"
NUMBERS = "number"


class Place(NamedTuple):
    """An entry of an array."""

    array: str
    at: int


@dataclass(frozen=True)
class Pointer:
    """An array argument of a function: start index in the array for each call, and the offsets of used entries.

    Entries have the names of the first call.
    """

    array: str
    starts: tuple[int, ...]
    entries: Mapping[str, int]


@dataclass(frozen=True)
class Outlined:
    """A function for repeated blocks, with the names of the first block; `numbers` are arguments of its calls."""

    blocks: tuple[Block, ...]
    read: tuple[Pointer, ...]
    written: Pointer
    numbers: tuple[tuple[str, ...], ...]


class Call(NamedTuple):
    """A call in an outline: the index of the function, and the index among its calls."""

    function: int
    number: int


@dataclass(frozen=True)
class Outline:
    """A program as calls and parts in order, the called functions, and the number of slots of the spill array."""

    pieces: tuple[Call | Part, ...]
    functions: tuple[Outlined, ...]
    slots: int

    @property
    def parts(self) -> list[Part]:
        """The parts of the program between calls."""
        return [piece for piece in self.pieces if isinstance(piece, Part)]

    @property
    def length(self) -> int:
        """Approximate number of lines: statements, passed variables, arguments of calls."""
        of_functions = sum(f.blocks[0].size + len(f.blocks[0].read) + len(f.written.entries) for f in self.functions)
        of_parts = sum(len(part.steps) + len(part.live_in) + len(part.live_out) for part in self.parts)
        return of_functions + of_parts + sum(len(f.blocks) * (len(f.read) + 1) for f in self.functions)


def outline(
    steps: Sequence[Step],
    blocks: Sequence[Block],
    places: Mapping[str, Place],
    numbers: Collection[str],
    needed_at_end: Iterable[str],
) -> Outline:
    """Return the program with functions for repeated blocks, their calls, and parts for the other statements.

    `places` are those of arguments, `numbers` the names of numbers, which differ from joint to joint.
    """
    at_end = frozenset(needed_at_end)
    groups = _groups(blocks, places, numbers)
    calls = {block.first: Call(f, k) for f, group in enumerate(groups) for k, block in enumerate(group)}
    stretches = list(_stretches(blocks, calls))
    slots = _slots(steps, stretches, groups, calls, at_end)
    everything = {**places, **{name: Place(SPILL, slot) for name, slot in slots.items()}}
    functions = tuple(_function(group, everything, numbers, slots) for group in groups)
    pieces = [
        calls[stretch.start] if stretch.start in calls else _part(steps[stretch.start : stretch.stop], slots)
        for stretch in stretches
    ]
    last = Part([], at_end, {name: slots[name] for name in sorted(at_end & slots.keys())}, {})
    return Outline((*pieces, last), functions, max(slots.values(), default=-1) + 1)


def _groups(blocks: Sequence[Block], places: Mapping[str, Place], numbers: Collection[str]) -> list[list[Block]]:
    """Groups of repeated blocks, of the same kind and reading from the same arrays."""

    def array(name: str) -> str:
        return NUMBERS if name in numbers else places[name].array if name in places else SPILL

    groups: dict[tuple[int, tuple[str, ...]], list[Block]] = defaultdict(list)
    for block in blocks:
        if block.size >= SHORTEST_BLOCK:
            groups[block.kind, tuple(map(array, block.read))].append(block)
    return [group for group in groups.values() if len(group) > 1]


def _stretches(blocks: Sequence[Block], calls: Mapping[int, Call]) -> Iterator[range]:
    """Ranges of the statements of each call, and of pieces of limited length between calls."""
    start = end = 0
    for block in blocks:
        first, last = block.first, block.first + block.size
        if end > start and (first in calls or last - start > LONGEST_PART):
            yield range(start, end)
            start = end
        end = last
        if first in calls:
            yield range(first, last)
            start = last
    if end > start:
        yield range(start, end)


def _slots(
    steps: Sequence[Step],
    stretches: Sequence[range],
    groups: Sequence[Sequence[Block]],
    calls: Mapping[int, Call],
    at_end: frozenset[str],
) -> dict[str, int]:
    """Slots of the variables that are passed on; all calls of a function pass on the same variables."""
    needed = {*at_end}
    for stretch in stretches:
        some = steps[stretch.start : stretch.stop]
        needed |= frozenset().union(*(step.uses for step in some)) - {step.statement.name for step in some}
    handed_on = [
        sorted({k for block in group for k, name in enumerate(block.defined) if name in needed}) for group in groups
    ]
    slots: dict[str, int] = {}
    for stretch in stretches:
        call = calls.get(stretch.start)
        if call:
            names = [groups[call.function][call.number].defined[k] for k in handed_on[call.function]]
        else:
            defined = [step.statement.name for step in steps[stretch.start : stretch.stop]]
            names = [name for name in defined if name in needed]
        slots |= {name: len(slots) + k for k, name in enumerate(names)}
    return slots


def _function(
    group: Sequence[Block], places: Mapping[str, Place], numbers: Collection[str], slots: Mapping[str, int]
) -> Outlined:
    first = group[0]
    of_numbers = [k for k, name in enumerate(first.read) if name in numbers]
    read = [*_read(group, places, numbers), *_of_numbers(first, of_numbers, len(group))]
    handed_on = [k for k, name in enumerate(first.defined) if name in slots]
    starts = [slots[block.defined[handed_on[0]]] for block in group]
    written = {first.defined[k]: n for n, k in enumerate(handed_on)}
    rows = tuple(tuple(block.read[k] for k in of_numbers) for block in group)
    return Outlined(tuple(group), tuple(read), Pointer(SPILL, tuple(starts), written), rows)


def _read(group: Sequence[Block], places: Mapping[str, Place], numbers: Collection[str]) -> Iterator[Pointer]:
    """Pointers for the operands of a group of blocks; operands at a fixed distance in all calls share a pointer."""
    pointers: dict[tuple[str, tuple[int, ...]], dict[str, int]] = defaultdict(dict)
    for k, name in enumerate(group[0].read):
        if name not in numbers:
            operands = [places[block.read[k]] for block in group]
            pointers[operands[0].array, tuple([place.at - operands[0].at for place in operands])][name] = operands[0].at
    for (array, distances), entries in pointers.items():
        start = min(entries.values())
        yield Pointer(array, tuple(start + x for x in distances), {name: at - start for name, at in entries.items()})


def _of_numbers(first: Block, positions: Sequence[int], calls: int) -> list[Pointer]:
    """The pointer to the numbers of a call, in a table with a row per call; empty without numbers."""
    count = len(positions)
    entries = {first.read[k]: n for n, k in enumerate(positions)}
    return [Pointer(NUMBERS, tuple(count * call for call in range(calls)), entries)] if count else []


def _part(steps: Sequence[Step], slots: Mapping[str, int]) -> Part:
    """The part with these steps between calls, with variables read from and written to the spill array."""
    uses = frozenset().union(*(step.uses for step in steps))
    defined = {step.statement.name for step in steps}
    live_in = {name: slots[name] for name in sorted(uses - defined) if name in slots}
    return Part(
        steps, uses, live_in, {s.statement.name: slots[s.statement.name] for s in steps if s.statement.name in slots}
    )
