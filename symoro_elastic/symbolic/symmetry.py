"""Congruent nodes of a graph: the same operations on congruent symbols, signs and constants aside.

Symbols are congruent that a renaming maps onto each other, as that of the joints of a left leg to those of a right one.
Nodes are congruent that do the same with them; side by side they are the lanes of a vector. No renaming gives wrong
numbers: whatever it is, lanes are nodes with the same operation on lanes of the same vectors. One that is no symmetry
has few of them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import NamedTuple, TypeAlias

from symoro_elastic.symbolic import operations as op
from symoro_elastic.symbolic.expression import Expression, Level, Operand

WIDTHS = (2, 4)
"""Numbers of lanes of vectors: those of the registers of processors, for doubles."""
SUMS, FACTORS = (op.ADD, op.SUBTRACT), (op.MULTIPLY, op.DIVIDE, op.NEGATE)
Shape: TypeAlias = "tuple[str | int, ...]"
"""An operation, those of sums aside, and the numbers of its operands, -1 for a constant."""


@dataclass(frozen=True, eq=False)
class Vector:
    """Congruent nodes. Lane k is nodes[k] times signs[k], 1 or -1; the first sign is 1.

    In a sum on vectors the second operand counts times `flips` of the lanes, where these differ.
    """

    nodes: tuple[Expression, ...]
    signs: tuple[int, ...]
    flips: tuple[int, ...] = ()

    @property
    def width(self) -> int:
        """Number of lanes."""
        return len(self.nodes)


class Lane(NamedTuple):
    """A lane of a vector, by its position."""

    vector: Vector
    number: int


def lanes_of(nodes: Sequence[Expression], cycles: Iterable[Sequence[str]]) -> Mapping[int, Lane]:
    """Return the lanes of vectors by the numbers of their nodes.

    `nodes` are all of a program, operands before their users; `cycles` are the names of congruent symbols, lane by
    lane, in which every lane is the image of the one before, and the first that of the last.
    """
    return _Congruence(nodes, cycles).lanes


class _Congruence:
    """Lanes, and the nodes that are their own images (`fixed`), in one pass over the nodes."""

    def __init__(self, nodes: Sequence[Expression], cycles: Iterable[Sequence[str]]) -> None:
        self.lanes: dict[int, Lane] = {}
        self._fixed: set[int] = set()
        self._by_shape: dict[Shape, list[Expression]] = defaultdict(list)
        for node in nodes:
            self._by_shape[_shape(node.operation, node.operands)].append(node)
        symbols = {node.operands[0]: node for node in nodes if node.operation == op.SYMBOL}
        renamed = {name for cycle in cycles for name in cycle}
        for cycle in cycles:
            if len(cycle) in WIDTHS and symbols.keys() >= {*cycle}:
                self._add(Vector(tuple(map(symbols.__getitem__, cycle)), (1,) * len(cycle)))
        for node in nodes:
            if node.level == Level.CONSTANT or (node.operation == op.SYMBOL and node.operands[0] not in renamed):
                self._fixed.add(node.id)
            elif node.operation != op.SYMBOL and node.id not in self.lanes:
                self._find_lane(node)

    def _add(self, vector: Vector) -> None:
        self.lanes |= {node.id: Lane(vector, k) for k, node in enumerate(vector.nodes)}

    def _find_lane(self, node: Expression) -> None:
        """Add the vector of a node whose operands have lanes or are fixed, or itself to those that are fixed."""
        moving = [x for x in node.needs if x.id not in self._fixed]
        if not moving:
            self._fixed.add(node.id)
        elif all(x.id in self.lanes for x in moving):
            places = {(self.lanes[x.id].vector.width, self.lanes[x.id].number) for x in moving}
            if len(places) > 1:
                if node in self._by_shape.get(self._image(node, 1), ()):
                    self._fixed.add(node.id)
                return
            ((width, first),) = places
            nodes = [self._congruent(node, k - first) for k in range(width)]
            if len({x.id for x in nodes if x}) == width:
                self._add(self._vector(tuple(x for x in nodes if x)))

    def _congruent(self, node: Expression, turn: int) -> Expression | None:
        """The node without a lane that is nearest to the image of a node, so many lanes further; None without any."""
        if not turn:
            return node
        candidates = [x for x in self._by_shape.get(self._image(node, turn), ()) if x.id not in self.lanes]
        relation, constants = self._relation(node, node.operands), _constants(node)
        operands = [self._turned(x, turn) for x in node.operands]
        return min(
            candidates,
            key=lambda x: (_constants(x) != constants, self._relation(x, operands) != relation),
            default=None,
        )

    def _relation(self, node: Expression, operands: Sequence[Operand]) -> int:
        """The sign of the second operand of a sum of lanes relative to the first, with the signs of their lanes."""
        return prod(self._coefficient(node, x) for x in operands) if _is_sum(node) else 1

    def _coefficient(self, node: Expression, x: Operand) -> int:
        """The sign of the lane of an operand in a sum."""
        minus = node.operation == op.SUBTRACT and node.operands[1] is x
        return -self._sign(x) if minus else self._sign(x)

    def _sign(self, x: Operand) -> int:
        lane = self.lanes.get(x.id) if isinstance(x, Expression) else None
        return lane.vector.signs[lane.number] if lane else 1

    def _vector(self, nodes: tuple[Expression, ...]) -> Vector:
        """The vector of congruent nodes."""
        operation, operands = nodes[0].operation, nodes[0].operands
        signs, flips = (1,) * len(nodes), ()
        if _is_sum(nodes[0]):
            first, second = (
                [self._coefficient(node, self._turned(x, k)) for k, node in enumerate(nodes)] for x in operands
            )
            signs = tuple(first[0] * sign for sign in first)
            flips = tuple(second[0] * x * y for x, y in zip(second, signs, strict=True))
        elif operation in (*SUMS, *FACTORS):
            signs = tuple(prod(map(self._sign, node.needs)) for node in nodes)
        return Vector(nodes, signs, flips if -1 in flips else ())

    def _image(self, node: Expression, turn: int) -> Shape:
        """The shape of the image of a node, so many lanes further."""
        return _shape(node.operation, [self._turned(x, turn) for x in node.operands])

    def _turned(self, x: Operand, turn: int) -> Operand:
        lane = self.lanes.get(x.id) if isinstance(x, Expression) else None
        return lane.vector.nodes[(lane.number + turn) % lane.vector.width] if lane else x


def _is_sum(node: Expression) -> bool:
    """Whether a node is the sum or the difference of two nodes."""
    return node.operation in SUMS and len(node.needs) > 1 and _constants(node) == []


def _constants(node: Expression) -> list[Operand]:
    """The constant operands of a node."""
    return [x for x in node.operands if not isinstance(x, Expression) or x.level == Level.CONSTANT]


def _shape(operation: str, operands: Iterable[Operand]) -> Shape:
    numbers = [x.id if isinstance(x, Expression) and x.level > Level.CONSTANT else -1 for x in operands]
    if operation in SUMS:
        return ("sum", *sorted(numbers))
    return (operation, *(sorted(numbers) if operation == op.MULTIPLY else numbers))
