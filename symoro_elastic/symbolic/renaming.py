"""Other names for the variables of a program."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from symoro_elastic.symbolic.expression import Expression, Operand, reachable
from symoro_elastic.symbolic.operations import SYMBOL
from symoro_elastic.symbolic.program import Program, Statement


def renamed(program: Program, names: Mapping[str, str]) -> Program:
    """Return the program with other names for some of its variables; expressions without them stay as they are."""
    statements = (*program.once, *program.statements)
    entries = [x for output in program.outputs for x in output.entries]
    copies = _copies([*(statement.node for statement in statements), *entries], names)

    def moved(x: Operand) -> Operand:
        return copies.get(x.id, x) if isinstance(x, Expression) else x

    def of(found: tuple[Statement, ...]) -> tuple[Statement, ...]:
        return tuple(one._replace(node=copies.get(one.node.id, one.node)) for one in found)

    return replace(
        program,
        inputs=tuple(replace(x, symbols=tuple(names.get(s, s) for s in x.symbols)) for x in program.inputs),
        outputs=tuple(replace(x, entries=tuple(map(moved, x.entries))) for x in program.outputs),
        once=of(program.once),
        statements=of(program.statements),
        used=frozenset(names.get(name, name) for name in program.used),
    )


def _copies(roots: list[Operand], names: Mapping[str, str]) -> dict[int, Expression]:
    """Copies, with the same numbers, of the nodes that depend on variables with another name."""
    copies: dict[int, Expression] = {}
    for node in reachable(roots):
        operands = tuple(copies.get(x.id, x) if isinstance(x, Expression) else x for x in node.operands)
        if node.operation == SYMBOL:
            operands = tuple(names.get(name, name) for name in node.operands)
        if any(new is not old for new, old in zip(operands, node.operands, strict=True)):
            copies[node.id] = Expression(node.graph, node.operation, operands, node.id, node.level)
    return copies
