"""Terms of a program that can be switched off: each operand of its sums is multiplied by a symbol of its own, one.

Whatever is derived from the results of such a program, by derivatives or by solving for something, depends on the same
symbols: where one of them becomes zero, its term is left out of all that is derived.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symoro_elastic.numerics.within.rebuild import rebuilt, with_values
from symoro_elastic.numerics.within.tape import SUMS, Change, Changes, Kind, Tape
from symoro_elastic.symbolic.arithmetic import EXACT
from symoro_elastic.symbolic.expression import Expression, Level, Operand
from symoro_elastic.symbolic.program import Output, Program

PREFIX = "kept_"


@dataclass(frozen=True)
class Switched:
    """The results of a program with switches, and the change that each switch stands for, by name."""

    program: Program
    tape: Tape
    entries: tuple[Operand, ...]
    changes: Mapping[str, Change]

    def without(self, names: Sequence[str]) -> tuple[Output, ...]:
        """Return the outputs of the program where these switches are zero, all others one."""
        return with_values(self.program, self.values_without(names))

    def values_without(self, names: Sequence[str]) -> dict[int, Operand]:
        """Return the values of all nodes of the program there, by number."""
        return rebuilt(self.tape, Changes.of(self.changes[name] for name in names))


def switched(program: Program, positions: Sequence[str] = ("q",)) -> Switched:
    """Return the results of a program with a switch for each operand of each sum that depends on the state."""
    tape, changes = Tape(program, positions), dict[str, Change]()
    values: dict[int, Operand] = {}
    for place, node in enumerate(tape.nodes):
        operands = [values.get(x.id, x) if isinstance(x, Expression) else x for x in node.operands]
        if tape.operations[place] in SUMS and node.level == Level.STATE:
            for k in (0, 1):
                name = f"{PREFIX}{len(changes)}"
                changes[name] = Change(Kind.DROP, place, k)
                operands[k] = node.graph.symbol(name, Level.PARAMETER) * operands[k]
        values[node.id] = _value(node, operands)
    entries = [x for output in program.outputs for x in output.entries]
    found = tuple(values.get(x.id, x) if isinstance(x, Expression) else x for x in entries)
    return Switched(program, tape, found, changes)


def _value(node: Expression, operands: Sequence[Operand]) -> Operand:
    """A node of new operands."""
    if all(new is old for new, old in zip(operands, node.operands, strict=True)):
        return node
    operation = EXACT.get(node.operation)
    made: Operand = operation(*operands) if operation else node.graph.node(node.operation, *operands)
    return made
