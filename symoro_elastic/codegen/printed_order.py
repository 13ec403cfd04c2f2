"""A program whose sums are carried out in the order in which its text has them.

Text leaves out parentheses that sums do not need: x + (y + z) is written `x + y + z`, which compilers and interpreters
carry out from left to right, as (x + y) + z. It is the same number in exact arithmetic, but not as rounded: what is
proven of rounding is proven of this program. It follows the rules of `printers.py`: where both parts of a sum have the
same sign, the terms of the second follow those of the first; else the part with a minus is in parentheses.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeAlias

from symoro_elastic.codegen.printers import constant_values
from symoro_elastic.symbolic.expression import Expression, Level, Operand
from symoro_elastic.symbolic.operations import ADD, DIVIDE, MULTIPLY, NEGATE, SUBTRACT, SYMBOL
from symoro_elastic.symbolic.program import Program, Section, Statement, free_name, names_in

SUMS, RESULTS = (ADD, SUBTRACT), Section("Results")
Signed: TypeAlias = tuple[bool, Operand]
"""Whether there is a minus before it, and an expression without a sign or a constant that is not negative."""


class _Written(NamedTuple):
    """A printed expression as signed terms, and whether a minus precedes them all."""

    negative: bool
    terms: Sequence[Signed]


def in_printed_order(program: Program) -> tuple[Program, Mapping[int, Expression]]:
    """Return the program with additions in the order of its text, and the replaced nodes by number."""
    text = _Text(program)
    changed = text.changed

    def in_place(x: Operand) -> Operand:
        return in_place_of(x, changed)

    if not changed:
        return program, changed
    return replace(
        program,
        outputs=tuple(replace(x, entries=tuple(map(in_place, x.entries))) for x in program.outputs),
        once=tuple(s._replace(node=changed.get(s.node.id, s.node)) for s in program.once),
        statements=tuple(s._replace(node=changed.get(s.node.id, s.node)) for s in program.statements),
        quantities={name: in_place(x) for name, x in program.quantities.items()},
    ), changed


def with_named_sums(program: Program) -> Program:
    """Return the program with variables for nested sums, so that its text adds in the order of the graph."""
    names = names_in(program)
    named = {s.node.id for s in (*program.once, *program.statements)}
    statements: list[Statement] = []

    def add(roots: Iterable[Expression], name: str, section: Section) -> None:
        for node in _second_sums(roots, named):
            named.add(node.id)
            statements.append(Statement(free_name(f"{name}_sum", names), node, False, section))

    for s in program.statements:
        add([s.node], s.name, s.section)
        statements.append(s)
    for output in program.outputs:
        add([x for x in output.entries if isinstance(x, Expression) and x.id not in named], output.name, RESULTS)
    return replace(program, statements=tuple(statements))


def _second_sums(roots: Iterable[Expression], named: Collection[int]) -> list[Expression]:
    """Unnamed sums that are the second operand of other sums, operands first, in the graph below `roots`."""
    sums: dict[int, Expression] = {}
    stack = [*roots]
    while stack:
        node = stack.pop()
        needs = [x for x in node.needs if x.id not in named and x.level == Level.STATE]
        stack += needs
        if node.operation in SUMS:
            sums |= {x.id: x for x in needs if x is node.operands[1] and x.operation in SUMS}
    return [sums[number] for number in sorted(sums)]


def in_place_of(x: Operand, changed: Mapping[int, Expression]) -> Operand:
    """Return the replacement of an expression, with its sign."""
    if not isinstance(x, Expression) or x.positive.id not in changed:
        return x
    new = changed[x.positive.id]
    return -new if x.operation == NEGATE else new


class _Text:
    """Terms of all nodes of a program as printed; `changed` are nodes that the text evaluates differently."""

    def __init__(self, program: Program) -> None:
        self._variables = {s.node.id: s.negative for s in (*program.once, *program.statements)}
        self._constants: Mapping[int, float] = constant_values(program.constants)
        self._written: dict[int, _Written] = {}
        self.changed: dict[int, Expression] = {}
        for node in program.nodes:
            self._add(node)

    def _add(self, node: Expression) -> None:
        if node.operation == SYMBOL or node.level == Level.CONSTANT:
            negative = self._constants.get(node.id, 1.0) < 0
            self._written[node.id] = _Written(negative, [(negative, node)])
            return
        written = self._terms(node)
        negative, new = _together(written.terms)
        if node.operation != NEGATE:
            if negative != written.negative:
                new = -new
            if new is not node and isinstance(new, Expression):
                self.changed[node.id] = new
        if node.id in self._variables:
            negative = self._variables[node.id]
            minus, x = _sign_and_size(self.changed.get(node.id, node))
            written = _Written(negative, [(negative != minus, x)])
        self._written[node.id] = written

    def _of(self, x: Operand) -> _Written:
        if isinstance(x, Expression):
            return self._written[x.id]
        return _Written(x < 0, [(False, -x if x < 0 else x)])

    def _terms(self, node: Expression) -> _Written:
        """Terms of an operation as printed."""
        parts = [self._of(x) for x in node.operands]
        if node.operation == NEGATE:
            return _Written(not parts[0].negative, parts[0].terms)
        if node.operation in (ADD, SUBTRACT):
            return _sum(parts[0], parts[1], node.operation == SUBTRACT)
        grouped = [_together(part.terms) for part in parts]
        if node.operation in (MULTIPLY, DIVIDE):
            negative = parts[0].negative != parts[1].negative
            (one, x), (other, y) = grouped
            new = node if (x, y) == node.operands else _apply(node.operation, x, y)
            return _Written(negative, [(one != other, new)])
        operands = [-x if part.negative != minus else x for part, (minus, x) in zip(parts, grouped, strict=True)]
        same = all(x is y or x == y for x, y in zip(operands, node.operands, strict=True))
        return _Written(False, [(False, node if same else node.graph.node(node.operation, *operands))])


def _sum(first: _Written, second: _Written, subtracted: bool) -> _Written:
    minus_second = second.negative != subtracted
    if first.negative == minus_second:
        return _Written(first.negative, [*first.terms, *second.terms])
    plus, minus = (second, first) if first.negative else (first, second)
    sign, grouped = _together(minus.terms)
    return _Written(False, [*plus.terms, (not sign, grouped)])


def _together(terms: Sequence[Signed]) -> Signed:
    """Sum of terms from left to right, with its sign separate."""
    negative, x = terms[0]
    for minus, y in terms[1:]:
        if negative == minus:
            sign, x = _sign_and_size(_apply(ADD, x, y))
            negative ^= sign
        else:
            sign, x = _sign_and_size(_apply(SUBTRACT, x, y))
            negative ^= sign
    return negative, x


def _sign_and_size(x: Operand) -> Signed:
    if isinstance(x, Expression):
        return x.operation == NEGATE, x.positive
    return x < 0, -x if x < 0 else x


def _apply(operation: str, x: Operand, y: Operand) -> Operand:
    """The operation applied to operands in normal form, without merging equal terms."""
    if not isinstance(x, Expression):
        if not isinstance(y, Expression):
            raise TypeError("an operation on two numbers")
        if operation == DIVIDE:
            return y.graph.node(DIVIDE, x, y)
        flipped = _apply(operation, y, x)
        return -flipped if operation == SUBTRACT else flipped
    if not isinstance(y, Expression):
        if operation == SUBTRACT:
            return x.graph.node(ADD, x, -y)
        return x.graph.node(operation, x, y)
    if operation == DIVIDE or x.id < y.id:
        return x.graph.pair(operation, x, y)
    pair = x.graph.pair(operation, y, x)
    return -pair if operation == SUBTRACT else pair
