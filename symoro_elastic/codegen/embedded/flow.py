"""The most that a function executes: the longest way through its blocks, loops as often as their source says."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

from symoro_elastic.codegen.embedded.counted_loops import LoopBounds
from symoro_elastic.codegen.embedded.disassembly import Code, Instruction, Kind

ENDS = (Kind.RETURN, Kind.MAY_RETURN, Kind.JUMP, Kind.BRANCH, Kind.UNKNOWN)
Weight = Callable[[Instruction], int]
Edges = Mapping[int, Collection[int]]


class Unbounded(Exception):
    """Nothing says how often a loop runs, or where a jump goes; the message is the line of the C file."""


@dataclass(frozen=True)
class Flow:
    """The blocks of a function by the address of their first instruction, and the blocks that may follow each."""

    blocks: dict[int, Sequence[Instruction]]
    after: dict[int, tuple[int, ...]]
    entry: int


def flow(code: Code) -> Flow:
    """Return the blocks of a function; raises `Unbounded` for a computed jump."""
    all_ = code.instructions
    following = dict(zip((one.address for one in all_), (one.address for one in all_[1:]), strict=False))
    starts = {all_[0].address} | {one.target for one in all_ if one.target >= 0}
    starts |= {following[one.address] for one in all_ if one.kind in ENDS and one.address in following}
    blocks: dict[int, list[Instruction]] = {}
    for one in all_:
        if one.address in starts:
            first = one.address
        blocks.setdefault(first, []).append(one)
    after = {first: _after(block[-1], following) for first, block in blocks.items()}
    return Flow({**blocks}, after, all_[0].address)


def _after(last: Instruction, following: Mapping[int, int]) -> tuple[int, ...]:
    """The blocks that may follow an instruction that ends one."""
    if last.kind is Kind.UNKNOWN:
        raise Unbounded(str(last.line))
    further = [following[last.address]] if last.address in following else []
    if last.kind in (Kind.RETURN, Kind.JUMP):
        further = []
    return tuple(dict.fromkeys([*further, *([last.target] if last.target >= 0 else [])]))


def most(flow: Flow, weight: Weight, bounds: LoopBounds, in_conditions: bool = True) -> int:
    """Return the largest sum of weights on any way through a function; `bounds` tell how often loops run, by line.

    Weights of conditions, which are tested once more than a loop runs, count unless `in_conditions` is False: a call
    is in none. Raises `Unbounded`.
    """
    reached = _reached(flow.entry, flow.after)
    after = {node: [to for to in flow.after[node] if to in reached] for node in reached}
    weights = {node: sum(map(weight, flow.blocks[node])) for node in reached}
    lines = {node: {one.line for one in flow.blocks[node]} for node in reached}
    return max(_Ways(weights, lines, bounds, in_conditions).longest(flow.entry, after).values())


@dataclass(frozen=True)
class _Ways:
    """Longest ways in a graph whose nodes have weights, and lines of the C file."""

    weights: Mapping[int, int]
    lines: Mapping[int, Collection[int]]
    bounds: LoopBounds
    in_conditions: bool

    def longest(self, entry: int, after: Edges) -> dict[int, int]:
        """The largest sum from the entry to the end of each node; loops on the way run as often as they can."""
        longest: dict[int, int] = {entry: 0}
        for component in reversed(_components(entry, after)):
            first = max(longest.get(node, 0) for node in component)
            heads = {node for node in component if node in longest}
            if len(component) == 1 and component[0] not in after[component[0]]:
                longest[component[0]] = first + self.weights[component[0]]
            else:
                longest |= dict.fromkeys(component, first + self._loop(component, heads, after))
            for node in component:
                for to in set(after[node]) - {*component}:
                    longest[to] = max(longest.get(to, 0), longest[node])
        return longest

    def _loop(self, component: Sequence[int], heads: Collection[int], after: Edges) -> int:
        """What a loop costs; raises `Unbounded`."""
        inside = {node: [to for to in after[node] if to in component] for node in component}
        if len(heads) > 1:
            raise Unbounded(str(min(min(self.lines[node]) for node in component)))
        (head,) = heads
        once = self.longest(head, {node: [to for to in targets if to != head] for node, targets in inside.items()})
        latches = {node for node in component if head in inside[node]}
        leaving = {node for node in component if len(inside[node]) < len(after[node]) or not after[node]}
        times = self._times(component, inside, head)
        last = max((once[node] for node in leaving - latches), default=0)
        each = max(once[node] for node in latches)
        return times * each + last if self.in_conditions else times * max(each, last)

    def _times(self, component: Sequence[int], inside: Edges, head: int) -> int:
        """How often the loop runs at most: by its own line, else by the loops around its lines in the text."""
        cut = {node: [to for to in targets if to != head] for node, targets in inside.items()}
        parts = [part for part in _components(head, cut) if len(part) > 1 or part[0] in cut[part[0]]]
        within = {node for part in parts for node in part}
        inner = {line for node in within for line in self.lines[node]}
        lines = {line for node in component if node not in within for line in self.lines[node]}
        own = lines & self.bounds.of.keys()
        if own:
            return max(self.bounds.of[line] for line in own - inner or own)
        if lines <= self.bounds.around.keys():
            return max(self.bounds.around[line] for line in lines)
        raise Unbounded(str(min(lines)))


def _reached(entry: int, after: Edges) -> set[int]:
    found, stack = {entry}, [entry]
    while stack:
        new = set(after[stack.pop()]) - found
        found |= new
        stack += new
    return found


def _components(entry: int, after: Edges) -> list[list[int]]:
    """The strongly connected components that are reached from a node, each after those that follow it (Tarjan)."""
    index: dict[int, int] = {}
    low: dict[int, int] = {}
    path, on_path, found = [], set(), []
    work = [(entry, iter(after[entry]))]
    index[entry] = low[entry] = 0
    path.append(entry)
    on_path.add(entry)
    while work:
        node, targets = work[-1]
        to = next(targets, None)
        if to is None:
            work.pop()
            if work:
                low[work[-1][0]] = min(low[work[-1][0]], low[node])
            if low[node] == index[node]:
                component = path[path.index(node) :]
                del path[path.index(node) :]
                on_path -= {*component}
                found.append(component)
        elif to not in index:
            index[to] = low[to] = len(index)
            path.append(to)
            on_path.add(to)
            work.append((to, iter(after[to])))
        elif to in on_path:
            low[node] = min(low[node], index[to])
    return found
