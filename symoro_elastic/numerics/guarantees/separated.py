"""Variables that stand inside of sines and outside of them, as two variables each; signs, as variables.

A spring between a motor and a joint that turns has tau = k (q_m - q): the angle q stands outside of sines there, and
inside of them in all else, so the result is no trigonometric polynomial of q, and none of q alone.

**Lemma.** Let f(q) = F(q, q) with F(q, p) a trigonometric polynomial of q and a polynomial of p. What bounds |F| for
all q and p of the range of q bounds |f| there. An operation on q that is used both ways is two operations of F; its
error is counted for both, which is at least its share |a + b| |e| of the sum of errors.

F is written by copying what stands outside of sines, with p in place of q. In the same way dry friction, a multiple of
sign(v), is F(v, s) with s in [sign(low), sign(high)] in place of the sign, which has no rounding as v has none: where
arguments are rounded before their use (mixed precision), small ones may become zero, and the sign stays one.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from symoro_elastic.machine.limits import Range
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.symbolic.expression import Expression, Graph, Operand, reachable
from symoro_elastic.symbolic.operations import COS, SIGN, SIN, SYMBOL

OUTSIDE, OF_SIGN = " outside of sines", ", its sign"
"""Added to the name of a variable."""


def separated(roots: Sequence[Operand], box: Box, signs: bool = True) -> tuple[Sequence[Operand], Box]:
    """Return expressions with other variables outside of sines, where some stand on both sides; and their box.

    The expressions may be of one graph or of several. With `signs` those of variables are variables, too.
    """
    names = on_both_sides(roots, box)
    of_signs = {str(x.operands[0]) for x in _signs(roots)} & box.ranges.keys() if signs else set[str]()
    if not names and not of_signs:
        return roots, box
    ranges = {**box.ranges, **{name + OUTSIDE: box.ranges[name] for name in names}}
    ranges |= {name + OF_SIGN: _signs_in(box.ranges[name]) for name in of_signs}
    return [_copied(root, names, of_signs) for root in roots], replace(box, ranges=ranges)


def _signs(roots: Sequence[Operand]) -> list[Expression]:
    """The variables whose signs are taken."""
    nodes = (node for root in roots if type(root) is Expression for node in reachable([root]))
    return [x for node in nodes if node.operation == SIGN for x in node.needs if x.operation == SYMBOL]


def _signs_in(found: Range) -> Range:
    return Range(float(np.sign(found.low)), float(np.sign(found.high)))


def on_both_sides(roots: Sequence[Operand], box: Box) -> frozenset[str]:
    """Return the variables that stand inside of sines in some expressions, and outside of them in some."""
    sides = [_sides(root) for root in roots]
    inside, outside = (frozenset[str]().union(*names) for names in zip(*sides, strict=True))
    return inside & outside & {*box.open}


def _sides(root: Operand) -> tuple[frozenset[str], frozenset[str]]:
    """Return the variables that stand inside of sines and cosines, and those outside of them."""
    if type(root) is not Expression:
        return frozenset(), frozenset()
    nodes = reachable([root])
    inside, outside = set[int](), {root.id}
    for node in reversed(nodes):
        for x in node.needs:
            if node.id in outside and node.operation not in (SIN, COS):
                outside.add(x.id)
            if node.id in inside or node.operation in (SIN, COS):
                inside.add(x.id)
    symbols = [node for node in nodes if node.operation == SYMBOL]
    one, other = (frozenset(str(x.operands[0]) for x in symbols if x.id in side) for side in (inside, outside))
    return one, other


def _copied(root: Operand, names: Collection[str], of_signs: Collection[str]) -> Operand:
    """A copy of an expression in a graph of its own; each node has a copy for either side, where these differ."""
    if type(root) is not Expression:
        return root
    graph = Graph()
    inside: dict[int, Operand] = {}
    outside: dict[int, Operand] = {}
    for node in reachable([root]):
        if node.operation == SYMBOL:
            name = node.operands[0]
            inside[node.id] = graph.symbol(name, node.level)
            outside[node.id] = graph.symbol(name + OUTSIDE, node.level) if name in names else inside[node.id]
            continue
        if node.operation == SIGN and node.needs and (name := _name(node.needs[0])) in of_signs:
            inside[node.id] = outside[node.id] = graph.symbol(name + OF_SIGN, node.level)
            continue
        beyond = inside if node.operation in (SIN, COS) else outside
        inside[node.id] = graph.node(node.operation, *(_of(x, inside) for x in node.operands))
        outside[node.id] = graph.node(node.operation, *(_of(x, beyond) for x in node.operands))
    return outside[root.id]


def _name(x: Expression) -> str:
    return str(x.operands[0]) if x.operation == SYMBOL else ""


def _of(x: Operand, copies: Mapping[int, Operand]) -> Operand:
    return copies[x.id] if type(x) is Expression else x
