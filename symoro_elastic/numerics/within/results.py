"""Results of a reduction: the reduced program, the terms that it omits, and its errors by entry."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from symoro_elastic.machine.within import Tolerance
from symoro_elastic.numerics.guarantees.dropped_terms import ChangedNodes
from symoro_elastic.numerics.within.tape import Change, Kind, Tape
from symoro_elastic.symbolic.expression import Expression, Operand
from symoro_elastic.symbolic.operations import ADD, DIVIDE, MULTIPLY, NEGATE, SUBTRACT, SYMBOL
from symoro_elastic.symbolic.program import OperationCount, Output, Program

Tolerances = Mapping[str, Tolerance | Sequence[Tolerance]]
"""By the name of an output: for all its entries, or entry by entry."""
Reserved = Mapping[str, Sequence[float]]
"""By the name of an output: the part of each entry's tolerance that other errors need, in its unit."""
NOTHING: Reserved = MappingProxyType({})
ErrorBound = Callable[[Program, Program, ChangedNodes], Mapping[str, Sequence[float]]]
"""From a program, the reduced one and its changes to bounds on the errors of all entries, by output, in their units."""
LONGEST = 60


@dataclass(frozen=True)
class LeftOut:
    """A change of the program, for a reader: its kind, the quantity that it is part of, and the omitted term."""

    kind: Kind
    quantity: str
    term: str
    constant: float | None = None


@dataclass(frozen=True)
class EntryError:
    """Errors of an entry of an output, in its unit.

    `largest` is its largest value at 20 000 states; `tolerance` what is allowed; `sampled` the largest error at states
    of the search, those of earlier climbs among them; `climbed` that reached by climbing from there; `unseen` that at
    states not searched; `confident` the bound on errors at as many more states, at least the largest computed error;
    `bounded` the bound on all states; None where not requested. An entry that `is_rounding` is zero but for rounding.
    """

    output: str
    index: int
    largest: float
    tolerance: float
    sampled: float
    climbed: float
    unseen: float
    confident: float | None = None
    bounded: float | None = None
    is_rounding: bool = False


@dataclass(frozen=True)
class Reduction:
    """A reduced program, the terms that it omits, and its errors.

    `outputs` are those of the program with the new `values` of its nodes, by number, for `Names.moved`; `reduced` is
    the program of them. `states` were drawn for `unseen` errors, with `seed`. `ended` is true where the user ended the
    search, `unproven` is the result because of which a program stays full. `shift` bounds shifts of natural
    frequencies, of their tolerance, where they have one.
    """

    program: Program = field(repr=False)
    reduced: Program = field(repr=False)
    outputs: tuple[Output, ...] = field(repr=False)
    values: Mapping[int, Operand] = field(repr=False)
    left_out: tuple[LeftOut, ...]
    errors: tuple[EntryError, ...]
    states: int
    seed: int
    ended: bool = False
    unproven: str = ""
    shift: float | None = None

    @property
    def before(self) -> OperationCount:
        """Operations of a call of the program."""
        return self.program.count

    @property
    def after(self) -> OperationCount:
        """Operations of a call of the reduced program."""
        return self.reduced.count


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
