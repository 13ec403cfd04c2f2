"""A program as a JavaScript function: the same statements on the browser's numbers, which are doubles."""

from __future__ import annotations

import re
from dataclasses import replace

from symoro_elastic.codegen.body import Dialect, Writer, c_continued
from symoro_elastic.codegen.printers import Printer
from symoro_elastic.symbolic.program import Program, Statement, rename_variables

JAVASCRIPT = Dialect(
    "const ",
    ";",
    lambda text: f"// {text}",
    c_continued,
    {name: f"Math.{name}" for name in ("sin", "cos", "sqrt", "sign", "atan2")}
    | {"minimum": "Math.min", "maximum": "Math.max"},
)

IN_USE = frozenset(("Math", "q", "q_dep", "do", "if", "in", "of", "let", "new", "try", "var", "for"))


def javascript_function(name: str, program: Program) -> str:
    """Return `function name(q, ...) { ... }`: arrays in, an object of flat arrays out, last index fastest.

    No parameter may be left in the program. Names of a user are not printed: an entry of an array is `q[3]`.
    """
    entries = {symbol: f"{x.name}[{k}]" for x in program.inputs for k, symbol in enumerate(x.symbols)}
    missing = program.used - entries.keys()
    if missing:
        raise ValueError(f"parameters without value: {', '.join(sorted(missing))}")
    program = _with_identifiers(rename_variables(program, entries))
    printer = Printer(program, functions=JAVASCRIPT.functions)
    writer = Writer(printer, JAVASCRIPT, ())
    lines = [writer.assignment(statement) for statement in (*program.once, *program.statements)]
    results = [f"        {x.name}: [{', '.join(map(printer.value, x.entries))}]," for x in program.outputs]
    head = f"function {name}({', '.join(x.name for x in program.inputs)}) {{"
    return "\n".join([head, *lines, "    return {", *results, "    };", "}"])


def _with_identifiers(program: Program) -> Program:
    """The program with variables whose names are identifiers, each another one: coordinates of a base have dots."""
    used = {*IN_USE}

    def of(statements: tuple[Statement, ...]) -> tuple[Statement, ...]:
        renamed = []
        for statement in statements:
            name = re.sub(r"[^A-Za-z0-9_]", "_", statement.name)
            while name in used:
                name += "_"
            used.add(name)
            renamed.append(statement._replace(name=name))
        return tuple(renamed)

    return replace(program, once=of(program.once), statements=of(program.statements))
