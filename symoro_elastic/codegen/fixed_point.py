"""Fixed point: integers of 32 bits for the numbers of a program, in individual units that are powers of two.

A number z is held as a whole number n, z = n 2^-bits, |n| < 2^31. Angles that only sines and cosines are taken of are
parts of a turn, of 2^-32 each: integers that wrap around reduce them exactly.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from symoro_elastic.symbolic.expression import Expression, Level, Operand
from symoro_elastic.symbolic.operations import ADD, COS, MULTIPLY, NEGATE, SIN, SUBTRACT, SYMBOL
from symoro_elastic.symbolic.program import Program

LARGEST = 2**31 - 1
MOST_BITS = 90
"""Maximum number of bits, for numbers that are nearly zero."""
LONGEST_SHIFT, LONGEST_OF_PRODUCT = 31, 62
"""Longest shifts of a number and of a product: longer ones leave less than half a unit."""
OF_CIRCLE = 30
"""Bits of sines, cosines and signs, which may be 1."""
TURN_BITS = 32
"""Bits of an angle, which is an integer of 2^-32 turns."""
DIGITS = 60
PI = Fraction("3.14159265358979323846264338327950288419716939937510582097494459")
TURN = 2 * PI / 2**TURN_BITS
"""The unit of an angle that is a part of a turn, rad."""


class Quantized(NamedTuple):
    """A fixed-point number in generated text: `value` times 2^-`bits`."""

    value: int
    bits: int

    @property
    def exact(self) -> Fraction:
        """The exact value as a fraction."""
        return Fraction(self.value) * Fraction(2) ** -self.bits


@dataclass(frozen=True)
class FixedPoint:
    """The `bits` after the binary point, by number of the node; nodes in `turns` are fractions of a turn.

    `only_limited` are the bits of arguments that only the box depends on, by name; None of a part of a turn.
    """

    bits: Mapping[int, int]
    turns: frozenset[int]
    only_limited: Mapping[str, int | None] = field(default_factory=dict)


def bits_of(magnitude: Fraction) -> int:
    """Largest number of bits after the binary point with which numbers of this magnitude fit into an integer."""
    if not magnitude:
        return MOST_BITS
    bits = 31 - (magnitude.numerator.bit_length() - magnitude.denominator.bit_length())
    while magnitude * Fraction(2) ** bits > LARGEST:
        bits -= 1
    return min(bits, MOST_BITS)


def quantize(x: Fraction, most: int = MOST_BITS) -> Quantized:
    """A number rounded to nearest, with as many bits as fit, but not more than `most`."""
    bits = min(bits_of(abs(x)), most)
    return Quantized(round(x * Fraction(2) ** bits), bits)


def number_of(x: Operand) -> Fraction | None:
    """The value of a constant, or of an expression of numbers to 60 digits; None for variables."""
    if not isinstance(x, Expression):
        return Fraction(x)
    if x.level != Level.CONSTANT:
        return None
    return Fraction(str(evaluate([x], {}, multiprecision(DIGITS))(x)))


def power_of_two(x: Operand) -> int | None:
    """The exponent of a constant that is plus or minus a power of two; None for other operands."""
    if isinstance(x, Expression) or not x:
        return None
    over, under = map(int, abs(Fraction(x)).as_integer_ratio())
    if over & (over - 1) or under & (under - 1):
        return None
    return over.bit_length() - under.bit_length()


def turn_factor(bits: int) -> Quantized:
    """Factor from angles in units of 2^-`bits` rad to units of 2^-32 turns; raises `OverflowError` for huge angles."""
    factor = Fraction(2) ** (TURN_BITS - bits) / (2 * PI)
    rounded = quantize(factor, LONGEST_OF_PRODUCT)
    if rounded.bits < 1:
        raise OverflowError("an angle may be beyond 2^30 rad")
    return rounded


def whole_units(low: float, high: float, unit: Fraction) -> tuple[int, int]:
    """The first and last integer multiple of a unit in a range; the last is below the first if there is none."""
    return math.ceil(Fraction(low) / unit), math.floor(Fraction(high) / unit)


def is_any_angle(low: float, high: float) -> bool:
    """Whether a range of angles, rad, covers a full turn."""
    first, last = whole_units(low, high, TURN)
    return last - first >= (1 << TURN_BITS) - 1


def turning(program: Program) -> frozenset[int]:
    """Numbers of the nodes that occur only in sines and cosines, directly or through sums and multiples.

    They may be off by whole turns. Multiples are by whole numbers.
    """
    state = [node for node in program.nodes if node.level == Level.STATE]
    values = {x.id for output in program.outputs for x in output.entries if isinstance(x, Expression)}
    while True:
        turns: set[int] = set()
        for node in state:
            if node.id not in values and _keeps_turns(node, turns):
                turns.add(node.id)
        remaining = [node for node in state if node.operation not in (SIN, COS) and node.id not in turns]
        more = values.union(*({x.id for x in node.needs} for node in remaining))
        if more == values:
            return frozenset(turns)
        values = more


def _keeps_turns(node: Expression, found: set[int]) -> bool:
    if node.operation == SYMBOL:
        return True
    if node.operation == MULTIPLY:
        return node.operands[0].id in found and isinstance(node.operands[1], int)
    inside = all(isinstance(x, Expression) and x.id in found for x in node.operands)
    return inside and node.operation in (ADD, SUBTRACT, NEGATE)


def symbols_of(program: Program) -> dict[str, Expression]:
    """The variables that a program uses, by name."""
    return {node.operands[0]: node for node in program.nodes if node.operation == SYMBOL}
