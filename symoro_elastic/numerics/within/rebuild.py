"""The changed program as expressions: nodes made again in exact arithmetic, in their order.

Numbers stay exact fractions, so zeros and ones disappear and numbers fold as in a trace. A node whose operands did not
change stays the node it is, with its name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction

from symoro_elastic.numerics.within.tape import Changes, Tape
from symoro_elastic.symbolic.arithmetic import EXACT
from symoro_elastic.symbolic.expression import Expression, Operand
from symoro_elastic.symbolic.functions import arc_tangent, cosine_sine, maximum, minimum, sign, square_root
from symoro_elastic.symbolic.operations import ATAN2, COS, MAXIMUM, MINIMUM, SIGN, SIN, SQRT
from symoro_elastic.symbolic.program import Output, Program

OF_NUMBERS: dict[str, Callable[..., Operand]] = {
    SQRT: square_root,
    SIGN: sign,
    ATAN2: arc_tangent,
    MINIMUM: minimum,
    MAXIMUM: maximum,
}
"""Functions that are exact for some numbers."""


def rebuilt(tape: Tape, changes: Changes) -> dict[int, Operand]:
    """Return the new value of each node of the program, by its number."""
    values: dict[int, Operand] = {}
    for place, node in enumerate(tape.nodes):
        values[node.id] = _value(place, node, changes, values)
    return values


def with_values(program: Program, values: Mapping[int, Operand]) -> tuple[Output, ...]:
    """Return the outputs of a program with new values of its nodes."""
    return tuple(
        Output(output.name, output.shape, tuple(_new(x, values) for x in output.entries)) for output in program.outputs
    )


def _new(x: Operand, values: Mapping[int, Operand]) -> Operand:
    return values.get(x.id, x) if isinstance(x, Expression) else x


def _value(place: int, node: Expression, changes: Changes, values: Mapping[int, Operand]) -> Operand:
    if place in changes.frozen:
        return Fraction(changes.frozen[place])
    operands = [_new(x, values) for x in node.operands]
    if place in changes.straightened:
        return operands[0]
    dropped = [(place, k) in changes.dropped for k in (0, 1)]
    if any(dropped):
        first, second = (0 if gone else x for gone, x in zip(dropped, operands, strict=True))
        changed: Operand = EXACT[node.operation](first, second)
        return changed
    if all(new is old for new, old in zip(operands, node.operands, strict=True)):
        return node
    operation = EXACT.get(node.operation)
    made: Operand = operation(*operands) if operation else _function(node, operands)
    return made


def _function(node: Expression, operands: Sequence[Operand]) -> Operand:
    """A function of changed operands: exact for numbers, signs carried outwards."""
    graph, name, x = node.graph, node.operation, operands[0]
    if name in OF_NUMBERS:
        return OF_NUMBERS[name](graph, *operands)
    if name not in (SIN, COS):
        return graph.node(name, *operands)
    if not isinstance(x, Expression):
        return cosine_sine(graph, x)[name == SIN]
    found = graph.node(name, x.positive)
    return -found if x is not x.positive and name == SIN else found
