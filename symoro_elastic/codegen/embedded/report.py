"""The report of generated C: stack, code, operations and instructions of each function."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from symoro_elastic.codegen.c.printers import angles_of
from symoro_elastic.codegen.embedded.counted_loops import LoopBounds, loop_bounds
from symoro_elastic.codegen.embedded.disassembly import Code, Kind, functions
from symoro_elastic.codegen.embedded.flow import Flow, Unbounded, flow, most
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


@dataclass(frozen=True)
class FunctionReport:
    """A function that users call: its operations, where it is a model, and what it costs."""

    name: str
    operations: OperationCount | None
    cost: Cost


@dataclass(frozen=True, repr=False)
class CodeReport(Result):
    """The functions of one C file, as one compiler translates them for one processor."""

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
    made = compile_file(files, file, tools)
    costs = Costs(made, files[file], package)
    models = _models(package, precision)
    functions = []
    for name in dict.fromkeys(DEFINITION.findall(files[file])):
        model, count = models.get(name, ("", None))
        functions.append(FunctionReport(name, count, costs.of(name, model)))
    return CodeReport(file, tools.command, costs.format, functions, costs.sections)


def _models(package: Package, precision: Precision) -> dict[str, tuple[str, OperationCount]]:
    """The model that a function computes, and its operations: with what depends on parameters only, that, the rest."""
    found = {}
    for one in package.functions:
        name, each, once = precision.function(package.name, one.name), one.program.count, one.program.count_once
        found[name] = one.name, each + once
        found[f"{name}_prepare"] = one.name, once
        found[f"{name}_prepared"] = one.name, each
    return found


# What each function of generated C costs at most, with all that it calls in its file.
@dataclass(frozen=True)
class Cost:
    """Of one call at most: instructions and calls of library functions (None: not known), bytes of stack, code."""

    instructions: int | None
    calls: dict[str, int] | None
    stack: int | None
    code: int


class Costs:
    """The functions of a compiled file."""

    def __init__(self, compiled: Compiled, source: str, package: Package) -> None:
        """`source` is the text of the C; raises `UnknownProcessor`."""
        self.functions, self.format = functions(compiled.listing)
        self._source, self._listing = source, compiled.listing
        self._frames = self._stack_usage(compiled.stack)
        self._angles = {f.name: len(angles_of(f.program)) for f in package.functions}

    def of(self, name: str, model: str = "") -> Cost:
        """The cost of a function; `model` is the one that it computes, where it is one."""
        angles = self._angles.get(model, max(self._angles.values(), default=0))
        ways = _Calls(self.functions, loop_bounds(self._source, angles))
        libraries = sorted({one for each in ways.below(name) for one in ways.outside(each)})
        try:
            instructions = ways.most(name)
            calls = {one: ways.most(name, one) for one in libraries}
        except Unbounded:
            instructions, calls = None, None
        code = sum(self.functions[each].size for each in ways.below(name))
        return Cost(instructions, calls, self._deepest(ways, name), code)

    @cached_property
    def sections(self) -> dict[str, int]:
        """Bytes of code and constants, of variables."""
        sizes: Counter[str] = Counter()
        for name, size in SECTION.findall(self._listing):
            sizes[name.split(".")[1]] += int(size, 16)
        return {"code": sizes["text"], "constants": sizes["rodata"], "variables": sizes["data"] + sizes["bss"]}

    def _stack_usage(self, text: str) -> dict[str, int | None]:
        """Bytes that a function takes by name, those of its copies too; None where they depend on data."""
        found: dict[str, int | None] = {}
        for line in text.splitlines():
            matched = USAGE.fullmatch(line)
            if matched:
                size = int(matched[3]) + (0 if matched[1] else RETURN_ADDRESS.get(self.format, 0))
                name = matched[2].split(".")[0]
                known = found.get(name, 0)
                bounded = matched[4] in BOUNDED and known is not None
                found[name] = max(size, known or 0) if bounded else None
        return found

    def _deepest(self, ways: _Calls, name: str) -> int | None:
        """Bytes of stack of a function and of what it calls; libraries are not counted."""
        own = self._frames.get(name.split(".", maxsplit=1)[0])
        if any(one.kind is Kind.UNKNOWN for one in self.functions[name].instructions):
            return None
        called = [self._deepest(ways, each) for each in ways.inside(name)]
        return None if own is None or None in called else own + max((size for size in called if size), default=0)


class _Calls:
    """Ways through functions that call each other."""

    def __init__(self, functions: Mapping[str, Code], bounds: LoopBounds) -> None:
        self.functions, self.bounds = functions, bounds
        self._flows: dict[str, Flow] = {}
        self._found: dict[tuple[str, str], int] = {}

    def inside(self, name: str) -> list[str]:
        """Functions of the file that a function calls."""
        return [one for one in self._called(name) if one in self.functions]

    def outside(self, name: str) -> list[str]:
        """Functions of libraries that a function calls."""
        return [one for one in self._called(name) if one not in self.functions]

    def below(self, name: str) -> list[str]:
        """A function, and all of its file that it calls."""
        found, stack = {name: None}, [name]
        while stack:
            new = [one for one in self.inside(stack.pop()) if one not in found]
            found |= dict.fromkeys(new)
            stack += new
        return [*found]

    def most(self, name: str, library: str = "") -> int:
        """The most instructions of a call, or calls of a library function in it; raises `Unbounded`."""
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

    def _called(self, name: str) -> list[str]:
        return [*dict.fromkeys(one.callee for one in self.functions[name].instructions if one.callee)]
