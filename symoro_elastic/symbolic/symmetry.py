"""Congruent nodes of a graph: the same operations on congruent symbols, signs and constants aside.

A renaming maps congruent symbols onto each other, as those of a left leg to those of a right one. Congruent nodes side
by side are the lanes of a vector. No renaming gives wrong numbers: lanes are nodes with the same operation on lanes of
the same vectors. A renaming that is not a symmetry has few lanes.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import NamedTuple, TypeAlias, TypeVar

from symoro_elastic.symbolic import operations as op
from symoro_elastic.symbolic.expression import Expression, Level, Operand

WIDTHS = (2, 4)
"""Numbers of lanes of vectors: doubles in a register."""
DEEPEST = 4
"""Maximum number of operations on vectors whose lanes are also needed as numbers: these are computed twice."""
SUMS, FACTORS = (op.ADD, op.SUBTRACT), (op.MULTIPLY, op.DIVIDE, op.NEGATE)
T = TypeVar("T", bound=Operand)
Shape: TypeAlias = "tuple[str | int, ...]"
"""An operation, those of sums aside, and the numbers of its operands, -1 for a constant."""


@dataclass(frozen=True, eq=False)
class Vector:
    """Congruent nodes. Lane k is nodes[k] times signs[k], 1 or -1; the first sign is 1.

    It is the operation of the first node on `operands`: vectors, numbers that are the same in all lanes, or constants
    by lane. In a sum the second one counts times `flips`, where these differ. Without operands numbers are put side by
    side: symbols, values of functions, and numbers that are computed in different ways.
    """

    nodes: tuple[Expression, ...]
    operands: tuple[Vector | Operand | tuple[Operand, ...], ...]
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
    """Lanes of vectors, in one pass over the nodes; other nodes are the same number in all lanes."""

    def __init__(self, nodes: Sequence[Expression], cycles: Iterable[Sequence[str]]) -> None:
        self.lanes: dict[int, Lane] = {}
        self._independent: set[int] = set()
        """Numbers that depend on no lane."""
        self._vectors: dict[tuple[int, ...], Vector] = {}
        self._by_shape: dict[Shape, list[Expression]] = defaultdict(list)
        self._users: dict[Shape, list[Expression]] = defaultdict(list)
        for node in nodes:
            self._by_shape[_shape(node.operation, node.operands)].append(node)
            for place, x in enumerate(node.operands if len(node.needs) > 1 else ()):
                self._users[_use(node, place, x)].append(node)
        symbols = {node.operands[0]: node for node in nodes if node.operation == op.SYMBOL}
        for cycle in cycles:
            if len(cycle) in WIDTHS and symbols.keys() >= {*cycle}:
                self._add(_side_by_side(tuple(map(symbols.__getitem__, cycle))))
        for node in nodes:
            if node.id not in self.lanes:
                self._find_lane(node)

    def _add(self, vector: Vector) -> None:
        self.lanes |= {node.id: Lane(vector, k) for k, node in enumerate(vector.nodes)}

    def _find_lane(self, node: Expression) -> None:
        """Add the vector of a node whose operands are lanes, all at the same position, or numbers."""
        lanes = [self.lanes[x.id] for x in node.needs if x.id in self.lanes]
        places = {(lane.vector.width, lane.number) for lane in lanes}
        if all(x.id in self._independent for x in node.needs):
            self._independent.add(node.id)
        elif len(places) == 1:
            ((width, first),) = places
            nodes = [self._congruent(node, k - first) for k in range(width)]
            if len({x.id for x in nodes if x}) == width:
                self._add(self._vector(tuple(x for x in nodes if x)))

    def _congruent(self, node: Expression, turn: int) -> Expression | None:
        """The free node congruent to `node` moved by `turn` lanes, preferably with equal constants; None if none is."""
        if not turn:
            return node
        candidates = [x for x in self._by_shape.get(self._shape_of_image(node, turn), ()) if x.id not in self.lanes]
        alike = (node.operation, _constants(node))
        return min(
            candidates or self._similar(node, turn), key=lambda x: (x.operation, _constants(x)) != alike, default=None
        )

    def _similar(self, node: Expression, turn: int) -> list[Expression]:
        """Free nodes that combine the lane of `node` moved by `turn` with a number of the same kind as in `node`."""
        moving = [k for k, x in enumerate(node.needs) if x.id in self.lanes]
        if len(node.needs) < 2 or len(moving) > 1 or node.needs[1 - moving[0]].id not in self._independent:
            return []
        (k,), kind = moving, _kind(node.needs[1 - moving[0]])
        users = self._users.get(_use(node, k, self._image(node.needs[k], turn)), ())
        free = [x for x in users if x.id not in self.lanes]
        return [x for x in free if any(y.id in self._independent and _kind(y) == kind for y in x.needs)]

    def _shape_of_image(self, node: Expression, turn: int) -> Shape:
        """The shape of a node whose operands are moved by `turn` lanes."""
        return _shape(node.operation, [self._image(x, turn) for x in node.operands])

    def _image(self, x: T, turn: int) -> T | Expression:
        """An operand moved by `turn` lanes; unchanged if it is in no lane."""
        lane = self.lanes.get(x.id) if isinstance(x, Expression) else None
        return lane.vector.nodes[(lane.number + turn) % lane.vector.width] if lane else x

    def _vector(self, nodes: tuple[Expression, ...], depth: int = 0) -> Vector:
        """The vector of congruent nodes, or of numbers that are computed in the same way."""
        key = tuple(node.id for node in nodes)
        if key not in self._vectors:
            self._vectors[key] = self._vector_of(nodes, depth)
        return self._vectors[key]

    def _vector_of(self, nodes: tuple[Expression, ...], depth: int) -> Vector:
        if nodes[0].operation not in (*SUMS, *FACTORS) or len({_kind(node) for node in nodes}) > 1 or depth > DEEPEST:
            return _side_by_side(nodes)
        orders = [self._order(nodes[0], node, k) for k, node in enumerate(nodes)]
        columns = [
            tuple(node.operands[order[place]] for node, order in zip(nodes, orders, strict=True)) for place in orders[0]
        ]
        operands = tuple(self._operand(column, depth) for column in columns)
        signs = [x.signs if isinstance(x, Vector) else (1,) * len(nodes) for x in operands]
        if nodes[0].operation not in SUMS:
            return Vector(nodes, operands, tuple(map(prod, zip(*signs, strict=True))))
        minus = [-1 if node.operation == op.SUBTRACT else 1 for node in nodes]
        total = tuple(x * y if order[0] else x for x, y, order in zip(signs[0], minus, orders, strict=True))
        flips = tuple(minus[0] * x * y * z for x, y, z in zip(*signs, minus, strict=True))
        return Vector(nodes, operands, total, flips if -1 in flips else ())

    def _order(self, first: Expression, node: Expression, k: int) -> tuple[int, ...]:
        """Indices of the operands of lane k, in the order of the operands of the first lane."""
        if first.operation not in (*SUMS, op.MULTIPLY) or _constants(first):
            return tuple(range(len(node.operands)))
        (a, b), (x, y) = (self._image(operand, k) for operand in first.needs), node.needs
        is_reversed = a is y or b is x or (a is not x and b is not y and _kind(a) != _kind(x))
        return (1, 0) if is_reversed else (0, 1)

    def _operand(self, column: tuple[Operand, ...], depth: int) -> Vector | Operand | tuple[Operand, ...]:
        """An operand of a vector, from its `column` over the lanes: a common value, a vector, or a tuple of values."""
        nodes = [x for x in column if isinstance(x, Expression) and x.level > Level.CONSTANT]
        if len(nodes) < len(column):
            return column[0] if all(x is column[0] or x == column[0] for x in column) else column
        if all(x is nodes[0] for x in nodes):
            return nodes[0]
        lane = self.lanes.get(nodes[0].id)
        if lane and lane.vector.nodes == column:
            return lane.vector
        return self._vector(tuple(nodes), depth + 1)


def _side_by_side(nodes: tuple[Expression, ...]) -> Vector:
    return Vector(nodes, (), (1,) * len(nodes))


def _constants(node: Expression) -> list[Operand]:
    """The constant operands of a node."""
    return [x for x in node.operands if not isinstance(x, Expression) or x.level == Level.CONSTANT]


def _kind(node: Expression) -> Shape:
    """The operation of a node, additions and subtractions being one, and which operands are constants."""
    return (_shape(node.operation, ())[0], *(x in _constants(node) for x in node.operands))


def _use(node: Expression, place: int, x: Operand) -> Shape:
    """The shape of a use of an operand; its position counts only in operations that are not symmetric."""
    is_symmetric = node.operation in (*SUMS, op.MULTIPLY)
    return (_shape(node.operation, ())[0], -1 if is_symmetric else place, x.id if isinstance(x, Expression) else -1)


def _shape(operation: str, operands: Iterable[Operand]) -> Shape:
    numbers = [x.id if isinstance(x, Expression) and x.level > Level.CONSTANT else -1 for x in operands]
    if operation in SUMS:
        return ("sum", *sorted(numbers))
    return (operation, *(sorted(numbers) if operation == op.MULTIPLY else numbers))
