"""The report of generated C as a table, as data for JSON, and as rows of a data frame."""

from __future__ import annotations

from collections.abc import Sequence

from symoro_elastic.codegen.embedded.report import CodeReport, FunctionReport
from symoro_elastic.codegen.package_context import count_json, operations
from symoro_elastic.foundation.results import Field, Part, declare, parts_of, table_of

NOTES = (
    "instructions, library calls: the maximum over all paths, huge angles (1e6 rad, single: 1024) included",
    "stack, code: including all functions of the file that it calls, excluding libraries",
)
MOST_NAMED = 3
"""Functions of libraries that are named in a cell."""


def _operations(function: FunctionReport) -> str:
    return operations(function.operations) if function.operations else "-"


def _counts(function: FunctionReport) -> dict[str, int] | None:
    return count_json(function.operations) if function.operations else None


def _library_calls(function: FunctionReport) -> str:
    """Return the calls by name; as one number where there are many names, as a dash where they depend on data."""
    if function.cost.calls is None:
        return "-"
    calls = {name: n for name, n in function.cost.calls.items() if n}
    if len(calls) > MOST_NAMED:
        calls = {f"of {len(calls)} functions": sum(calls.values())}
    return ", ".join(f"{n} {name}" for name, n in calls.items()) or "0"


def _sum_of_calls(function: FunctionReport) -> int | None:
    return None if function.cost.calls is None else sum(function.cost.calls.values())


declare(
    FunctionReport,
    Field("name", head="function", column="function", json=False),
    Field("operations", _counts, "operations", text=_operations),
    Field("instructions", "cost.instructions", "instructions, at most", column="instructions"),
    Field("library_calls", "cost.calls", "library calls, at most", text=_library_calls),
    Field("library_calls", _sum_of_calls, column="library_calls", json=False),
    Field("stack", "cost.stack", "stack", "bytes", column="stack"),
    Field("code", "cost.code", "code", "bytes", column="code"),
)
declare(
    CodeReport,
    *map(Field, ("command", "format", "sections")),
    Field("functions", lambda report: {function.name: function for function in report.functions}, rows=FunctionReport),
)


@parts_of.register
def _(report: CodeReport) -> Sequence[Part]:
    """Return the table of functions, the size of the file, and notes on the numbers."""
    sizes = ", ".join(f"{size} bytes of {name}" for name, size in report.sections.items())
    title = f"{report.file}: {report.command} ({report.format})"
    return [table_of(FunctionReport, report.functions, title), f"{report.file} takes {sizes}", *NOTES]
