"""What changes leave out of a program, in the words of its statements."""

from __future__ import annotations

from collections.abc import Sequence

from symoro_elastic.numerics.within.results import LeftOut
from symoro_elastic.numerics.within.tape import Change, Kind, Tape
from symoro_elastic.symbolic.expression import Expression
from symoro_elastic.symbolic.operations import ADD, DIVIDE, MULTIPLY, NEGATE, SUBTRACT, SYMBOL
from symoro_elastic.symbolic.program import Program

LONGEST = 60


def left_out_of(program: Program, tape: Tape, changes: Sequence[Change]) -> tuple[LeftOut, ...]:
    """Return the changes, each with the statement that it is part of."""
    names = {statement.node.id: statement.name for statement in (*program.once, *program.statements)}
    homes = _homes(tape, names)
    return tuple(_left_out(tape, change, names, homes) for change in changes)


def _left_out(tape: Tape, change: Change, names: dict[int, str], homes: dict[int, str]) -> LeftOut:
    node = tape.nodes[change.place]
    quantity = homes.get(change.place, "")
    if change.kind is Kind.DROP:
        return LeftOut(change.kind, quantity, _term(node.operands[change.operand], names))
    frozen = change.kind is Kind.FREEZE
    return LeftOut(change.kind, quantity, _term(node, names), change.constant if frozen else None)


def _homes(tape: Tape, names: dict[int, str]) -> dict[int, str]:
    """For each place the first statement that computes it; empty for a result without a statement."""
    homes: dict[int, str] = {}
    for place in range(tape.count - 1, -1, -1):
        home = names.get(tape.nodes[place].id) or homes.get(place, "")
        homes[place] = home
        for x in tape.operands[place]:
            if x < tape.count:
                homes[x] = home
    return homes


def _term(x: Expression | object, names: dict[int, str]) -> str:
    """A term by the names of statements, shortened."""
    text = _written(x, names, 4)
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


def _written(x: Expression | object, names: dict[int, str], depth: int) -> str:
    if not isinstance(x, Expression):
        return f"{float(x):.6g}"  # type: ignore[arg-type]
    if x.id in names:
        return names[x.id]
    if x.operation == SYMBOL:
        return str(x.operands[0])
    if not depth:
        return "..."
    operands = [_written(o, names, depth - 1) for o in x.operands]
    if x.operation == NEGATE:
        return f"-{operands[0]}"
    if x.operation in (ADD, SUBTRACT):
        return f"({f' {x.operation} '.join(operands)})"
    if x.operation in (MULTIPLY, DIVIDE):
        return x.operation.join(operands)
    return f"{x.operation}({', '.join(operands)})"
