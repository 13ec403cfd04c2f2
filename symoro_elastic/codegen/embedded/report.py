"""The report of generated C: stack, code, operations and instructions by function."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

from symoro_elastic.codegen.c.printers import angles_of
from symoro_elastic.codegen.embedded.disassembly import Code, Instruction, Kind, functions
from symoro_elastic.codegen.embedded.tool_chain import Compiled, ToolChain, compile_file
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import Precision
from symoro_elastic.foundation.results import Result
from symoro_elastic.symbolic.program import OperationCount

USAGE = re.compile(r"(?:.*[/\\])?[^:]*:\d+:(\d+:)?(\S+)\t(\d+)\t(\S+)")
SECTION = re.compile(r"\s*\d+ (\.\S+)\s+([0-9a-f]{8,})")
BOUNDED = ("static", "dynamic,bounded")
RETURN_ADDRESS = {"elf64-x86-64": 8}
"""Bytes that a call itself puts on the stack; Clang does not count them."""

DEFINITION = re.compile(r"^void (\w+)\(", re.MULTILINE)
ENDS = (Kind.RETURN, Kind.MAY_RETURN, Kind.JUMP, Kind.BRANCH, Kind.UNKNOWN)
Weight = Callable[[Instruction], int]
Edges = Mapping[int, Collection[int]]
FOR = re.compile(r"\s*for \(size_t (\w+) = [^;]+; \1 < ([^;]+); \1\+\+\)")
DOWN = re.compile(r"\s*for \(size_t (\w+) = (\w+); \1 > 0U; \1--\)")
WHILE = re.compile(r"\s*while \(large > 0U\)")
TERMS = "terms"
LONGEST_SERIES = 14
"""Terms of the polynomials of sines and cosines that are summed in a loop."""


@dataclass(frozen=True)
class FunctionReport:
    """A public function: its operations, if it is a model, and its costs."""

    name: str
    operations: OperationCount | None
    cost: Cost


@dataclass(frozen=True, repr=False)
class CodeReport(Result):
    """The functions of a C file, as a compiler translates them for a processor."""

    file: str
    command: str
    format: str
    functions: Sequence[FunctionReport]
    sections: dict[str, int]

    @property
    def headline(self) -> str:
        """The file, and the compiler."""
        return f"Report of {self.file}: {self.command}"


def code_report(package: Package, files: Mapping[str, str], precision: Precision, tools: ToolChain) -> CodeReport:
    """Return the report of the C of a package; raises `CompilerMissing`, `CompilationFailed`, `UnknownProcessor`."""
    file = f"{package.name}{precision.suffix}.c"
    compiled = compile_file(files, file, tools)
    costs = Costs(compiled, files[file], package)
    models = _models(package, precision)
    functions = []
    for name in dict.fromkeys(DEFINITION.findall(files[file])):
        model, count = models.get(name, ("", None))
        functions.append(FunctionReport(name, count, costs.of(name, model)))
    return CodeReport(file, tools.command, costs.format, functions, costs.sections)


def _models(package: Package, precision: Precision) -> dict[str, tuple[str, OperationCount]]:
    """Models by C function: the model's name, and operations of a call."""
    models = {}
    for function in package.functions:
        name, program = precision.function(package.name, function.name), function.program
        models[name] = function.name, program.count + program.count_once
        models[f"{name}_prepare"] = function.name, program.count_once
        models[f"{name}_prepared"] = function.name, program.count
    return models


# What each function of generated C costs at most, with all that it calls in its file.
@dataclass(frozen=True)
class Cost:
    """Maximum costs of a call: instructions and calls of library functions (None: unknown), bytes of stack, code."""

    instructions: int | None
    calls: dict[str, int] | None
    stack: int | None
    code: int


class Costs:
    """Cost analysis of the functions of a compiled file."""

    def __init__(self, compiled: Compiled, source: str, package: Package) -> None:
        """Read the functions of a file; `source` is its C text; raises `UnknownProcessor`."""
        self.functions, self.format = functions(compiled.listing)
        self._source, self._listing = source, compiled.listing
        self._frames = self._stack_usage(compiled.stack)
        self._angles = {f.name: len(angles_of(f.program)) for f in package.functions}

    def of(self, name: str, model: str = "") -> Cost:
        """The cost of a function; `model` is the name of the model that it computes, if it computes one."""
        angles = self._angles.get(model, max(self._angles.values(), default=0))
        ways = _Calls(self.functions, loop_bounds(self._source, angles))
        libraries = sorted({library for caller in ways.below(name) for library in ways.outside(caller)})
        try:
            instructions = ways.most(name)
            calls = {library: ways.most(name, library) for library in libraries}
        except Unbounded:
            instructions, calls = None, None
        code = sum(self.functions[function].size for function in ways.below(name))
        return Cost(instructions, calls, self._deepest(ways, name), code)

    @cached_property
    def sections(self) -> dict[str, int]:
        """Bytes of code, of constants and of variables."""
        sizes: Counter[str] = Counter()
        for name, size in SECTION.findall(self._listing):
            sizes[name.split(".")[1]] += int(size, 16)
        return {"code": sizes["text"], "constants": sizes["rodata"], "variables": sizes["data"] + sizes["bss"]}

    def _stack_usage(self, text: str) -> dict[str, int | None]:
        """Bytes of stack by function, its clones included; None where they depend on data."""
        sizes: dict[str, int | None] = {}
        for line in text.splitlines():
            matched = USAGE.fullmatch(line)
            if matched:
                size = int(matched[3]) + (0 if matched[1] else RETURN_ADDRESS.get(self.format, 0))
                name = matched[2].split(".")[0]
                former = sizes.get(name, 0)
                bounded = matched[4] in BOUNDED and former is not None
                sizes[name] = max(size, former or 0) if bounded else None
        return sizes

    def _deepest(self, ways: _Calls, name: str) -> int | None:
        """Bytes of stack of a function and its callees, library functions excluded."""
        own = self._frames.get(name.split(".", maxsplit=1)[0])
        if any(instruction.kind is Kind.UNKNOWN for instruction in self.functions[name].instructions):
            return None
        called = [self._deepest(ways, callee) for callee in ways.inside(name)]
        return None if own is None or None in called else own + max((size for size in called if size), default=0)


class _Calls:
    """Call graph of the functions of a file, with maximum costs along its paths."""

    def __init__(self, functions: Mapping[str, Code], bounds: LoopBounds) -> None:
        self.functions, self.bounds = functions, bounds
        self._flows: dict[str, Flow] = {}
        self._found: dict[tuple[str, str], int] = {}

    def inside(self, name: str) -> list[str]:
        """Functions of the file that a function calls directly."""
        return [callee for callee in self._callees(name) if callee in self.functions]

    def outside(self, name: str) -> list[str]:
        """Library functions that a function calls directly."""
        return [callee for callee in self._callees(name) if callee not in self.functions]

    def below(self, name: str) -> list[str]:
        """A function and all functions of its file that it calls, directly or indirectly."""
        reached, stack = {name: None}, [name]
        while stack:
            new = [callee for callee in self.inside(stack.pop()) if callee not in reached]
            reached |= dict.fromkeys(new)
            stack += new
        return [*reached]

    def most(self, name: str, library: str = "") -> int:
        """Maximum number of instructions of a call, or of calls of a `library` function; raises `Unbounded`."""
        key = name, library
        if key not in self._found:
            if name not in self._flows:
                self._flows[name] = flow(self.functions[name])
            self._found[key] = most(
                self._flows[name],
                lambda one: (
                    (one.callee == library if library else 1)
                    + (self.most(one.callee, library) if one.callee in self.functions else 0)
                ),
                self.bounds,
                in_conditions=not library,
            )
        return self._found[key]

    def _callees(self, name: str) -> list[str]:
        return [*dict.fromkeys(x.callee for x in self.functions[name].instructions if x.callee)]


class Unbounded(Exception):
    """The bound of a loop or the target of a jump is unknown; the message is the line of the C file."""


@dataclass(frozen=True)
class Flow:
    """Control flow graph: basic blocks by the address of their first instruction, and successors of each."""

    blocks: dict[int, Sequence[Instruction]]
    after: dict[int, tuple[int, ...]]
    entry: int


def flow(code: Code) -> Flow:
    """Return the control flow graph of a function; raises `Unbounded` for a computed jump."""
    all_ = code.instructions
    following = {x.address: y.address for x, y in pairwise(all_)}
    starts = {all_[0].address} | {x.target for x in all_ if x.target >= 0}
    starts |= {following[x.address] for x in all_ if x.kind in ENDS and x.address in following}
    blocks: dict[int, list[Instruction]] = {}
    for instruction in all_:
        if instruction.address in starts:
            first = instruction.address
        blocks.setdefault(first, []).append(instruction)
    after = {first: _after(block[-1], following) for first, block in blocks.items()}
    return Flow({**blocks}, after, all_[0].address)


def _after(last: Instruction, following: Mapping[int, int]) -> tuple[int, ...]:
    """Addresses of the blocks that may follow the last instruction of a block."""
    if last.kind is Kind.UNKNOWN:
        raise Unbounded(str(last.line))
    further = [following[last.address]] if last.address in following else []
    if last.kind in (Kind.RETURN, Kind.JUMP):
        further = []
    return tuple(dict.fromkeys([*further, *([last.target] if last.target >= 0 else [])]))


def most(flow: Flow, weight: Weight, bounds: LoopBounds, in_conditions: bool = True) -> int:
    """Return the largest sum of weights on any path through a function; `bounds` limit the loops by line.

    Weights of conditions, which are tested once more than a loop runs, count unless `in_conditions` is False: a call
    is in none. Raises `Unbounded`.
    """
    reached = _reachable(flow.entry, flow.after)
    after = {node: [to for to in flow.after[node] if to in reached] for node in reached}
    weights = {node: sum(map(weight, flow.blocks[node])) for node in reached}
    lines = {node: {instruction.line for instruction in flow.blocks[node]} for node in reached}
    return max(_Ways(weights, lines, bounds, in_conditions).longest(flow.entry, after).values())


@dataclass(frozen=True)
class _Ways:
    """Longest paths in a control flow graph whose nodes have weights and lines of the C file."""

    weights: Mapping[int, int]
    lines: Mapping[int, Collection[int]]
    bounds: LoopBounds
    in_conditions: bool

    def longest(self, entry: int, after: Edges) -> dict[int, int]:
        """Largest sum of weights from the entry through each node; loops count with their maximum passes."""
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
        """Maximum cost of a loop, a strongly connected component; raises `Unbounded`."""
        inside = {node: [to for to in after[node] if to in component] for node in component}
        if len(heads) > 1:
            raise Unbounded(str(min(min(self.lines[node]) for node in component)))
        (head,) = heads
        once = self.longest(head, {node: [to for to in targets if to != head] for node, targets in inside.items()})
        latches = {node for node in component if head in inside[node]}
        leaving = {node for node in component if len(inside[node]) < len(after[node]) or not after[node]}
        times = self._times(component, inside, head)
        last = max((once[node] for node in leaving - latches), default=0)
        turn = max(once[node] for node in latches)
        return times * turn + last if self.in_conditions else times * max(turn, last)

    def _times(self, component: Sequence[int], inside: Edges, head: int) -> int:
        """Maximum number of passes of a loop: by its own line, else by the loops around its lines in the text."""
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


def _reachable(entry: int, after: Edges) -> set[int]:
    reached, stack = {entry}, [entry]
    while stack:
        new = set(after[stack.pop()]) - reached
        reached |= new
        stack += new
    return reached


def _components(entry: int, after: Edges) -> list[list[int]]:
    """The strongly connected components that are reached from a node, in reverse topological order (Tarjan)."""
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


@dataclass(frozen=True)
class LoopBounds:
    """Maximum passes of loops: by the line of a loop, and for each line the most of the loops around it; from 1."""

    of: Mapping[int, int]
    around: Mapping[int, int] = field(default_factory=dict)


def loop_bounds(source: str, angles: int) -> LoopBounds:
    """Return the bounds of loops by line, without those that the text does not determine.

    `angles` are those whose sines and cosines are found together: `count` in the functions that find them.
    """
    limits = {"count": angles, TERMS: LONGEST_SERIES}
    bounds: dict[int, int] = {}
    around: dict[int, int] = {}
    open_loops: list[tuple[str, int]] = []
    for number, line in enumerate(source.split("\n"), start=1):
        while open_loops and line == f"{open_loops[-1][0]}}}":
            open_loops.pop()
        if open_loops:
            around[number] = max(passes for _, passes in open_loops)
        passes = _passes(line, limits)
        if passes is not None:
            bounds[number] = passes
            open_loops.append((line[: len(line) - len(line.lstrip())], passes))
    return LoopBounds(bounds, around)


def _passes(line: str, known: dict[str, int]) -> int | None:
    """Maximum passes of the loop that begins in a line, which is stored in `known` for its variable."""
    if WHILE.match(line):
        return known["count"]
    match = FOR.match(line) or DOWN.match(line)
    passes = _product(match[2], known) if match else None
    if match and passes is not None:
        known[match[1]] = passes
    return passes


def _product(text: str, known: Mapping[str, int]) -> int | None:
    """The value of a product such as `2U*9U`, whose factors may be variables in `known`; None if unknown."""
    value = 1
    for factor in text.split("*"):
        digits = factor.strip().removesuffix("U")
        if not digits.isdigit() and digits not in known:
            return None
        value *= int(digits) if digits.isdigit() else known[digits]
    return value
