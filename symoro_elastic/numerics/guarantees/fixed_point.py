"""Fixed point with proven scales: each number of a program is an integer of 32 bits in units of its own.

Scales: the computed value of node z is at most |z| + E_z (lemma 1), so that with `bits` behind the binary point,
(|z| + E_z) 2^bits <= 2^31 - 1, nothing overflows; the most bits that this allows are taken. Local errors, in units
U = 2^-bits of the result:

    sum            operands of more bits are rounded to the bits of the sum: U/2 for each of them
    product        U/2, once, from the product of 64 bits; none where no bits are lost
    power of two   none: the unit changes, not the integer
    sine, cosine   U = 2^-30 (`templates/c_fixed/sincos.c.j2`)
    numbers        of the text: what the nearest of 31 bits misses, exactly

Angles of which only sines and cosines are taken are parts of a turn, sums of them wrap around: no error. The angle of
any other sine is n K 2^-s in units of 2^-32 turns, K with 31 bits: about
|x| 2^-31 + 2^-32 pi.
These local errors go through lemmas 1 and 2 as roundings of other precisions do.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from symoro_elastic.codegen.fixed_point import (
    LONGEST_OF_PRODUCT,
    OF_CIRCLE,
    PI,
    TURN_BITS,
    FixedPoint,
    bits_of,
    number_of,
    power_of_two,
    quantized,
    turn_factor,
    turning,
)
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.machine.limits import Limits
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.traced import Traced
from symoro_elastic.numerics.guarantees.box import Box, box_of
from symoro_elastic.numerics.guarantees.certificate import (
    MOST_SUB_BOXES,
    Certificate,
    Subject,
    certificate_over,
    sub_boxes_of,
)
from symoro_elastic.numerics.guarantees.header import guaranteed
from symoro_elastic.numerics.guarantees.running_error import PASSED, UPWARDS, Bounds, Known, Rounding, range_of_node
from symoro_elastic.numerics.guarantees.sub_boxes import Parts
from symoro_elastic.symbolic.expression import Constant, Expression, Level, Operand
from symoro_elastic.symbolic.operations import (
    ADD,
    COS,
    DIVIDE,
    MAXIMUM,
    MINIMUM,
    MULTIPLY,
    NEGATE,
    SIGN,
    SIN,
    SUBTRACT,
    SYMBOL,
)

NAME = "fixed-point"
RESTS_ON = (
    "Proven for arguments that are whole numbers of their units, and right shifts of negative numbers that are "
    "arithmetic, which the compiler checks. Outside of the box numbers may overflow."
)
OF_SINE = 2.0**-OF_CIRCLE
"""Of a sine or cosine of an exact angle."""
POSSIBLE = (SYMBOL, ADD, SUBTRACT, MULTIPLY, NEGATE, SIN, COS, SIGN, MINIMUM, MAXIMUM)


class FixedRounding(Rounding):
    """Integers of 32 bits: numbers of the text have 31 bits."""

    def __init__(self) -> None:
        super().__init__(NAME, 2.0**-32, 2.0**-32, 0.0, math.inf)

    def error_of_constant(self, x: Constant) -> Array:
        """How far a number of the text is off."""
        return np.array(_off(Fraction(x)))


FIXED_ROUNDING = FixedRounding()


def _off(x: Fraction) -> float:
    """How far the nearest number of 31 bits is off, rounded upwards."""
    return float(abs(quantized(x).exact - x)) * UPWARDS


def impossible(function: Function) -> str:
    """Why a function has no fixed point; empty where it has."""
    steps = [node for node in function.program.nodes if node.level != Level.CONSTANT]
    if any(node.operation == DIVIDE for node in steps):
        return "divides by what moves"
    found = next((node.operation for node in steps if node.operation not in POSSIBLE), "")
    return f"takes {found} of what moves" if found else ""


@dataclass(frozen=True)
class FixedSubject(Subject):
    """A function in fixed point; `bits` are chosen by its bounds, unless they are given."""

    bits: Mapping[int, int] | None = field(default=None)

    def as_printed(self) -> Subject:
        """The same: sums of integers have no rounding, and each operation has a statement of its own."""
        return self

    def bounds(self, parts: Parts) -> Bounds:
        """Ranges and errors of all nodes over sub-boxes (lemma 1)."""
        return self.scaled(parts)[0]

    def scaled(self, parts: Parts) -> tuple[Bounds, dict[int, int]]:
        """Ranges and errors of all nodes over sub-boxes, and the bits of each node."""
        turns = turning(self.function.program)
        return scaled_bounds(self.nodes, parts, turns, self.bits, self.knowledge(parts))


def scaled_bounds(
    nodes: Iterable[Expression],
    box: Parts,
    turns: frozenset[int],
    given: Mapping[int, int] | None = None,
    known: Known | None = None,
) -> tuple[Bounds, dict[int, int]]:
    """Ranges and errors of nodes in order, and the bits of each: those given, else as many as fit in all sub-boxes."""
    shape = np.broadcast_shapes((1,), *(x.low.shape for x in box.values()))
    bounds = Bounds(FIXED_ROUNDING, shape, {}, {}, {})
    bits: dict[int, int] = {}
    with np.errstate(all="ignore"):
        for node in nodes:
            found = range_of_node(node, bounds, box)
            bounds.range[node.id] = known[node.id](found) if known and node.id in known else found
            _add(node, bounds, bits, turns, given)
    return bounds, bits


def _add(
    node: Expression, bounds: Bounds, bits: dict[int, int], turns: frozenset[int], given: Mapping[int, int] | None
) -> None:
    z = bounds.range[node.id]
    constant = number_of(node)
    if node.id in turns:
        local, passed = 0.0, np.array(0.0)
    elif constant is not None:
        bits[node.id] = quantized(constant).bits
        local, passed = _off(constant) + 2.0**-160, np.array(0.0)
    else:
        ranges, errors = [bounds.range_of(x) for x in _operands(node)], [bounds.error_of(x) for x in _operands(node)]
        passed = np.array(0.0) if node.operation == SYMBOL else PASSED[node.operation](z, ranges, errors)
        reach = _finite(float(np.max((z.magnitude + passed) * UPWARDS)))
        bits[node.id] = given[node.id] if given else _bits(node, reach, bits)
        local = _local(node, bits, turns, bounds)
    bounds.local[node.id] = np.full_like(z.low, local * UPWARDS)
    bounds.error[node.id] = (passed + local) * UPWARDS


def _operands(node: Expression) -> tuple[Operand, ...]:
    return () if node.operation == SYMBOL else node.operands


def _finite(reach: float) -> float:
    if not math.isfinite(reach):
        raise OverflowError("a number of the program has no bound")
    return reach


def _bits(node: Expression, reach: float, bits: Mapping[int, int]) -> int:
    """The bits of a node whose value is computed within `reach`, but for its own rounding."""
    found = [_bits_of(x, bits) for x in _operands(node)]
    if node.operation in (SIN, COS, SIGN):
        return OF_CIRCLE
    if node.operation == NEGATE:
        return found[0]
    if node.operation == MULTIPLY:
        exponent = power_of_two(node.operands[1])
        if exponent is not None:
            return found[0] - exponent
        return max(min(_fitting(reach, 1), sum(found)), sum(found) - LONGEST_OF_PRODUCT)
    if node.operation in (ADD, SUBTRACT, MINIMUM, MAXIMUM):
        return min(_fitting(reach, 2), *found)
    return _fitting(reach, 0)


def _fitting(reach: float, halves: int) -> int:
    """The most bits with which `reach` and some halves of a unit fit."""
    bits = bits_of(Fraction(reach))
    while (Fraction(reach) + Fraction(halves, 2) * Fraction(2) ** -bits) * Fraction(2) ** bits > 2**31 - 1:
        bits -= 1
    return bits


def _bits_of(x: Operand, bits: Mapping[int, int]) -> int:
    number = number_of(x)
    if number is not None:
        return quantized(number).bits
    return bits.get(x.id, OF_CIRCLE) if isinstance(x, Expression) else OF_CIRCLE


def _local(node: Expression, bits: Mapping[int, int], turns: frozenset[int], bounds: Bounds) -> float:
    """The error that one operation adds."""
    own, found = bits[node.id], [_bits_of(x, bits) for x in _operands(node)]
    half = math.ldexp(0.5, -own)
    if node.operation in (ADD, SUBTRACT, MINIMUM, MAXIMUM):
        return half * sum(_is_rounded(x, each, own) for x, each in zip(node.operands, found, strict=True))
    if node.operation == MULTIPLY and power_of_two(node.operands[1]) is None:
        return half * (sum(found) > own)
    if node.operation in (SIN, COS):
        (x,) = node.needs
        return OF_SINE if x.id in turns else OF_SINE + _of_turns(float(np.max(bounds.computed(x).magnitude)), found[0])
    return 0.0


def _of_turns(angle: float, bits: int) -> float:
    """The error of an angle of at most this magnitude that is made a part of a turn, rad."""
    factor, exact = turn_factor(bits), Fraction(2) ** (TURN_BITS - bits) / (2 * PI)
    return (angle * float(abs(factor.exact / exact - 1)) + math.pi * 2.0**-TURN_BITS) * UPWARDS


def _is_rounded(x: Operand, bits: int, own: int) -> bool:
    """Whether an addend loses bits; of numbers that are written with the bits of the sum, only if they do."""
    number = number_of(x)
    return bits > own if number is None else (number * Fraction(2) ** own).denominator != 1


def in_fixed_point(
    function: Function, box: Box, machine: str, most_sub_boxes: int, progress: Progress = no_progress
) -> tuple[Certificate, FixedPoint]:
    """What a function guarantees in fixed point over its box, and the scales with which it does.

    Raises `OverflowError` where a number has no bound.
    """
    subject = FixedSubject(function, box, FIXED_ROUNDING)
    parts = sub_boxes_of(subject, most_sub_boxes, progress)
    _, bits = subject.scaled(parts)
    found = certificate_over(replace(subject, bits=bits), machine, parts)
    return found, FixedPoint(bits, turning(function.program))


Total: TypeAlias = tuple[Certificate, str]
"""The certificate of a function, errors beside those of fixed point among them, and its first sentence."""
NO_TOTALS: Mapping[str, Total] = MappingProxyType({})


def refuse_impossible(machine: Machine, function: Function) -> None:
    """Raise `InputError` for a function that has no fixed point."""
    if why := impossible(function):
        what = f"{function.name} {why}: choose a model that only adds and multiplies, as bias_forces does"
        raise machine.error("--target c-fixed", what)


def with_scales(
    asked: Traced,
    limits: Limits,
    most_sub_boxes: int = MOST_SUB_BOXES,
    progress: Progress = no_progress,
    totals: Mapping[str, Total] = NO_TOTALS,
) -> Package:
    """The package of programs in fixed point, with scales and guarantees; raises `InputError` for what has none.

    What is said of functions in `totals` is that, in place of what is found of their program.
    """
    package, machine = asked.package, asked.machine
    made = []
    for function in package.functions:
        refuse_impossible(machine, function)
        box = box_of(machine, limits, function.program.inputs, function.program.used)
        try:
            one, scales = in_fixed_point(function, box, machine.name, most_sub_boxes, progress)
        except OverflowError as error:
            raise machine.error("--target c-fixed", f"{function.name}: {error}") from None
        found, first = totals.get(function.name, (one, ""))
        said = guaranteed(package, function, found, first, rests_on=RESTS_ON)
        made.append(replace(function, fixed=scales, guaranteed={NAME: said}))
    return replace(package, functions=tuple(made))
