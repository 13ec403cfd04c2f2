"""Lines of generated functions: arguments unpacked, statements by section."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from symoro_elastic.codegen.printers import Printer
from symoro_elastic.symbolic.program import Section, Statement, by_section

LINE = 110
Indices = Mapping[str, str]


@dataclass(frozen=True)
class Dialect:
    """Syntax of a language: assignments, comments, and names of functions."""

    declare: str
    end: str
    comment: Callable[[str], str]
    continued: Callable[[str, list[str]], str]
    functions: Mapping[str, str]


def c_continued(head: str, parts: list[str]) -> str:
    """A long statement, broken into lines, of a language in which a line may end anywhere."""
    return "\n        ".join([head + parts[0], *parts[1:]])


def _python_continued(head: str, parts: list[str]) -> str:
    return "\n        ".join([f"{head}(", *parts]) + "\n    )"


C = Dialect("const double ", ";", lambda text: f"/* {text} */", c_continued, {})
PYTHON = Dialect(
    "",
    "",
    lambda text: f"# {text}",
    _python_continued,
    {name: f"_f.{name}" for name in ("sin", "cos", "sqrt", "sign", "atan2", "minimum", "maximum")},
)


def positions_by_name(names: Iterable[str]) -> Indices:
    """Index of each name in a list, as text."""
    return {name: str(k) for k, name in enumerate(names)}


class Writer:
    """Prints statements of a program in a dialect."""

    def __init__(self, printer: Printer, dialect: Dialect, joints: Sequence[str]) -> None:
        self.printer, self.dialect, self.joints = printer, dialect, joints

    def unpack(
        self, arguments: Mapping[str, Indices], used: Iterable[str], read: Mapping[str, str] | None = None
    ) -> list[str]:
        """Lines that unpack the used entries of arrays; `read` is how entries of an array are read: `{array}[{k}]`."""
        return [*self.unpack_lines(arguments, used, read).values()]

    def unpack_lines(
        self, arguments: Mapping[str, Indices], used: Iterable[str], read: Mapping[str, str] | None = None
    ) -> dict[str, str]:
        """The lines of `unpack`, keyed by the names that they define."""
        used, read, dialect = set(used), read or {}, self.dialect
        return {
            symbol: f"    {dialect.declare}{symbol} = "
            f"{read.get(array, '{array}[{k}]').format(array=array, k=index)}{dialect.end}"
            for array, symbols in arguments.items()
            for symbol, index in symbols.items()
            if symbol in used
        }

    def statements(self, statements: Sequence[Statement]) -> list[str]:
        """Assignments below the headings of their sections."""
        lines: list[str] = []
        for section, group in by_section(statements):
            lines += ["", f"    {self.dialect.comment(self.heading(section))}"]
            lines += [self.assignment(statement) for statement in group]
        return lines

    def heading(self, section: Section) -> str:
        """Heading of a section, as text: recursion, joint and equations."""
        if section.joint is None:
            return section.title
        joint = f"joint {section.joint} ({self.joints[section.joint - 1]})" if section.joint else "base"
        return f"{section.title}, {joint} {section.equations}".rstrip() + "."

    def assignment(self, statement: Statement) -> str:
        """A statement, broken into lines where it is long."""
        head = f"    {self.dialect.declare}{statement.name} = "
        right = self.printer.right_side(statement) + self.dialect.end
        if len(head) + len(right) <= LINE:
            return head + right
        return self.dialect.continued(head, break_sum(right))


def break_sum(text: str) -> list[str]:
    """A long sum cut before its signs, at the outermost bracket level with short enough pieces."""
    parts, depth, start, last = [], 0, 0, 0
    for position, character in enumerate(text):
        depth += (character == "(") - (character == ")")
        if character in "+-" and text[position - 1] == " " and depth <= 1:
            if position - start > LINE - 20 and last > start:
                parts.append(text[start:last].rstrip())
                start = last
            last = position
    if len(text) - start > LINE - 10 and last > start:
        parts.append(text[start:last].rstrip())
        start = last
    return [*parts, text[start:]]
