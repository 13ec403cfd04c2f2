"""The report of generated C: stack, code, operations and instructions of each function, as a table and as data."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import Precision
from symoro_elastic.embedded.costs import Cost, Costs
from symoro_elastic.embedded.tool_chain import ToolChain, compiled
from symoro_elastic.models.tables import count_json, operations
from symoro_elastic.results import Part, Result, Titled
from symoro_elastic.symbolic.program import OperationCount

DEFINITION = re.compile(r"^void (\w+)\(", re.MULTILINE)
NOTES = (
    "instructions, library calls: the most on any way through the code, huge angles (1e6 rad, single: 1024) included",
    "stack, code: with those of all functions of the file that it calls, without those of libraries",
)


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

    def parts(self) -> list[Part]:
        """Return the table, what the file takes in all, and what the figures mean."""
        from rich.table import Table

        table = Table("function", "operations")
        for head in ("instructions, at most", "library calls, at most", "stack, bytes", "code, bytes"):
            table.add_column(head, justify="right")
        for one in self.functions:
            table.add_row(*_cells(one))
        sizes = ", ".join(f"{size} bytes of {name}" for name, size in self.sections.items())
        title = f"{self.file}: {self.command} ({self.format})"
        return [Titled(table, title), f"{self.file} takes {sizes}", *NOTES]

    def as_json(self) -> dict[str, Any]:
        """Return the figures of each function; null where something depends on data."""
        return {
            "command": self.command,
            "format": self.format,
            "sections": self.sections,
            "functions": {one.name: _figures(one) for one in self.functions},
        }

    def columns(self) -> dict[str, list[Any]]:
        """Return a row for each function."""
        rows = self.functions
        return {
            "function": [one.name for one in rows],
            "instructions": [one.cost.instructions for one in rows],
            "library_calls": [sum(one.cost.calls.values()) if one.cost.calls is not None else None for one in rows],
            "stack": [one.cost.stack for one in rows],
            "code": [one.cost.code for one in rows],
        }


def code_report(package: Package, files: Mapping[str, str], precision: Precision, tools: ToolChain) -> CodeReport:
    """Return the report of the C of a package; raises `CompilerMissing`, `CompilationFailed`, `UnknownProcessor`."""
    file = f"{package.name}{precision.suffix}.c"
    made = compiled(files, file, tools)
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


def _cells(one: FunctionReport) -> Iterator[str]:
    cost = one.cost
    yield one.name
    yield operations(one.operations) if one.operations else "-"
    yield _text(cost.instructions)
    yield "-" if cost.calls is None else ", ".join(f"{n} {name}" for name, n in _few(cost.calls).items()) or "0"
    yield _text(cost.stack)
    yield str(cost.code)


def _few(calls: Mapping[str, int]) -> dict[str, int]:
    """The calls by name; as one number where there are many names."""
    made = {name: n for name, n in calls.items() if n}
    return made if len(made) <= 3 else {f"of {len(made)} functions": sum(made.values())}


def _text(number: int | None) -> str:
    return "-" if number is None else str(number)


def _figures(one: FunctionReport) -> dict[str, Any]:
    return {
        "operations": count_json(one.operations) if one.operations else None,
        "instructions": one.cost.instructions,
        "library_calls": one.cost.calls,
        "stack": one.cost.stack,
        "code": one.cost.code,
    }
