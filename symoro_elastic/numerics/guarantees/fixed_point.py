"""Fixed point with proven scales: each number of a program is an integer of 32 bits in units of its own.

Scales: the computed value of node z is at most |z| + E_z (lemma 1), so that with `bits` after the binary point,
(|z| + E_z) 2^bits <= 2^31 - 1, nothing overflows; the most bits that this allows are used. Local errors, in units
U = 2^-bits of the result:

    sum            operands of more bits are rounded to the bits of the sum: U/2 for each of them
    product        U/2, once, from the product of 64 bits; none where no bits are lost
    power of two   none: the unit changes, not the integer
    sine, cosine   U = 2^-30 (`templates/c_fixed/sincos.c.j2`)
    numbers        of the text: what the nearest of 31 bits misses, exactly

Angles that occur in sines and cosines only are fractions of a turn, whose sums wrap around: no error. The angle of
any other sine is n K 2^-s in units of 2^-32 turns, K with 31 bits: about
|x| 2^-31 + 2^-32 pi.
These local errors go through lemmas 1 and 2 as roundings of other precisions do.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from symoro_elastic.codegen.fixed_point import (
    LONGEST_OF_PRODUCT,
    OF_CIRCLE,
    PI,
    TURN,
    TURN_BITS,
    FixedPoint,
    bits_of,
    is_any_angle,
    number_of,
    power_of_two,
    quantize,
    symbols_of,
    turn_factor,
    turning,
    whole_units,
)
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.machine.limits import Limits, Range
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.packaging import Traced
from symoro_elastic.numerics.guarantees.box import Box, Parts, box_of
from symoro_elastic.numerics.guarantees.certificate import (
    MOST_SUB_BOXES,
    Certificate,
    Subject,
    certificate_over,
    sub_boxes_of,
)
from symoro_elastic.numerics.guarantees.header import guarantees_of
from symoro_elastic.numerics.guarantees.running_error import PASSED, UPWARDS, Bounds, Known, Rounding, range_of_node
from symoro_elastic.symbolic import operations as op
from symoro_elastic.symbolic.expression import Constant, Expression, Level, Operand
from symoro_elastic.symbolic.program import Program

NAME = "fixed-point"
RESTS_ON = (
    "Proven for arguments that are whole numbers of their units, and right shifts of negative numbers that are "
    "arithmetic, which the compiler checks. Outside of the box numbers may overflow."
)
OF_SINE = 2.0**-OF_CIRCLE
"""Error of the sine or cosine of an exact angle."""
POSSIBLE = (op.SYMBOL, op.ADD, op.SUBTRACT, op.MULTIPLY, op.NEGATE, op.SIN, op.COS, op.SIGN, op.MINIMUM, op.MAXIMUM)


class FixedRounding(Rounding):
    """Rounding of 32-bit integers; literal numbers have 31 bits."""

    def __init__(self) -> None:
        super().__init__(NAME, 2.0**-32, 2.0**-32, 0.0, math.inf)

    def error_of_constant(self, x: Constant) -> Array:
        """Error of a literal number."""
        return np.array(_off(Fraction(x)))


FIXED_ROUNDING = FixedRounding()


def _off(x: Fraction) -> float:
    """Distance to the nearest number of 31 bits, rounded upwards."""
    return float(abs(quantize(x).exact - x)) * UPWARDS


def impossible(function: Function) -> str:
    """Why a function has no fixed-point form; empty if it has one."""
    steps = [node for node in function.program.nodes if node.level != Level.CONSTANT]
    if any(node.operation == op.DIVIDE for node in steps):
        return "divides by what moves"
    operation = next((node.operation for node in steps if node.operation not in POSSIBLE), "")
    return f"takes {operation} of what moves" if operation else ""


@dataclass(frozen=True)
class FixedSubject(Subject):
    """A function in fixed point; `bits` follow from its bounds unless given."""

    bits: Mapping[int, int] | None = field(default=None)

    def as_printed(self) -> Subject:
        """The subject itself: sums of integers have no rounding, so their order does not matter."""
        return self

    def bounds(self, parts: Parts) -> Bounds:
        """Ranges and errors of all nodes over sub-boxes (lemma 1)."""
        return self.bounds_and_bits(parts)[0]

    def bounds_and_bits(self, parts: Parts) -> tuple[Bounds, dict[int, int]]:
        """Ranges and errors of all nodes over sub-boxes, and their bits."""
        turns = turning(self.function.program)
        return scaled_bounds(self.nodes, parts, turns, self.bits, self.knowledge(parts))


def scaled_bounds(
    nodes: Iterable[Expression],
    box: Parts,
    turns: frozenset[int],
    fixed_bits: Mapping[int, int] | None = None,
    narrowings: Known | None = None,
) -> tuple[Bounds, dict[int, int]]:
    """Ranges and errors of nodes in order, and their bits: `fixed_bits`, else as many as fit in all sub-boxes."""
    shape = np.broadcast_shapes((1,), *(x.low.shape for x in box.values()))
    bounds = Bounds(FIXED_ROUNDING, shape, {}, {}, {})
    bits: dict[int, int] = {}
    with np.errstate(all="ignore"):
        for node in nodes:
            values = range_of_node(node, bounds, box)
            bounds.range[node.id] = narrowings[node.id](values) if narrowings and node.id in narrowings else values
            _add(node, bounds, bits, turns, fixed_bits)
    return bounds, bits


def _add(
    node: Expression, bounds: Bounds, bits: dict[int, int], turns: frozenset[int], fixed_bits: Mapping[int, int] | None
) -> None:
    z = bounds.range[node.id]
    constant = number_of(node)
    if node.id in turns:
        local, propagated = 0.0, np.array(0.0)
    elif constant is not None:
        bits[node.id] = quantize(constant).bits
        local, propagated = _off(constant) + 2.0**-160, np.array(0.0)
    else:
        ranges, errors = [bounds.range_of(x) for x in _operands(node)], [bounds.error_of(x) for x in _operands(node)]
        propagated = np.array(0.0) if node.operation == op.SYMBOL else PASSED[node.operation](z, ranges, errors)
        reach = float(np.max((z.magnitude + propagated) * UPWARDS))
        if not math.isfinite(reach):
            raise OverflowError("a number of the program has no bound")
        bits[node.id] = fixed_bits[node.id] if fixed_bits else _bits(node, reach, bits)
        local = _local(node, bits, turns, bounds)
    bounds.local[node.id] = np.full_like(z.low, local * UPWARDS)
    bounds.error[node.id] = (propagated + local) * UPWARDS


def _operands(node: Expression) -> tuple[Operand, ...]:
    return () if node.operation == op.SYMBOL else node.operands


def _bits(node: Expression, reach: float, bits: Mapping[int, int]) -> int:
    """The bits of a node with a magnitude of at most `reach` before its own rounding."""
    widths = [_bits_of(x, bits) for x in _operands(node)]
    if node.operation in (op.SIN, op.COS, op.SIGN):
        return OF_CIRCLE
    if node.operation == op.NEGATE:
        return widths[0]
    if node.operation == op.MULTIPLY:
        exponent = power_of_two(node.operands[1])
        if exponent is not None:
            return widths[0] - exponent
        return max(min(_fitting(reach, 1), sum(widths)), sum(widths) - LONGEST_OF_PRODUCT)
    if node.operation in (op.ADD, op.SUBTRACT, op.MINIMUM, op.MAXIMUM):
        return min(_fitting(reach, 2), *widths)
    return _fitting(reach, 0)


def _fitting(reach: float, halves: int) -> int:
    """The most bits with which `reach` plus `halves` half units fits."""
    bits = bits_of(Fraction(reach))
    while (Fraction(reach) + Fraction(halves, 2) * Fraction(2) ** -bits) * Fraction(2) ** bits > 2**31 - 1:
        bits -= 1
    return bits


def _bits_of(x: Operand, bits: Mapping[int, int]) -> int:
    number = number_of(x)
    if number is not None:
        return quantize(number).bits
    return bits.get(x.id, OF_CIRCLE) if isinstance(x, Expression) else OF_CIRCLE


def _local(node: Expression, bits: Mapping[int, int], turns: frozenset[int], bounds: Bounds) -> float:
    """The rounding error of an operation."""
    own, widths = bits[node.id], [_bits_of(x, bits) for x in _operands(node)]
    half = math.ldexp(0.5, -own)
    if node.operation in (op.ADD, op.SUBTRACT, op.MINIMUM, op.MAXIMUM):
        return half * sum(_is_rounded(x, k, own) for x, k in zip(node.operands, widths, strict=True))
    if node.operation == op.MULTIPLY and power_of_two(node.operands[1]) is None:
        return half * (sum(widths) > own)
    if node.operation in (op.SIN, op.COS):
        (x,) = node.needs
        if x.id in turns:
            return OF_SINE
        angle, exact = float(np.max(bounds.computed(x).magnitude)), Fraction(2) ** (TURN_BITS - widths[0]) / (2 * PI)
        of_factor = angle * float(abs(turn_factor(widths[0]).exact / exact - 1))
        return OF_SINE + (of_factor + math.pi * 2.0**-TURN_BITS) * UPWARDS
    return 0.0


def _is_rounded(x: Operand, bits: int, own: int) -> bool:
    """Whether an addend loses bits; a literal number only if its value is not representable with the sum's bits."""
    number = number_of(x)
    return bits > own if number is None else (number * Fraction(2) ** own).denominator != 1


def in_fixed_point(
    function: Function, box: Box, machine: str, most_sub_boxes: int, progress: Progress = no_progress
) -> tuple[Certificate, FixedPoint]:
    """The certificate of a function in fixed point over its box, and its scales.

    Raises `OverflowError` where a number has no bound, or a range contains no integer unit (see `box_in_units`).
    """
    if empty := [name for name, x in box_in_units(function, box).ranges.items() if x != box.ranges[name]]:
        raise OverflowError(f"the range of {empty[0]} holds no whole unit where terms are left out: give a wider one")
    subject = FixedSubject(function, box, FIXED_ROUNDING)
    parts = sub_boxes_of(subject, most_sub_boxes, progress)
    _, bits = subject.bounds_and_bits(parts)
    certificate = certificate_over(replace(subject, bits=bits), machine, parts)
    return certificate, FixedPoint(bits, turning(function.program))


def box_in_units(function: Function, box: Box) -> Box:
    """The box with ranges that contain integer units of a function's arguments: others are moved to the nearest unit.

    A range of a full turn up to the rounding of its ends is that of any angle.
    """
    turns, nodes = turning(function.program), symbols_of(function.program)
    arguments = {name for argument in function.program.inputs for name in argument.symbols if name in nodes}
    ranges = {name: _in_units(x, nodes[name].id in turns) if name in arguments else x for name, x in box.ranges.items()}
    return Box(ranges, box.positions)


def _in_units(span: Range, turns: bool) -> Range:
    """A range that contains an integer unit: 2^-32 turn, or the finest power of two with which its ends fit."""
    if turns and not is_any_angle(span.low, span.high) and is_any_angle(*_around(span.low, span.high)):
        return Range(*_around(span.low, span.high))
    fine, unit = (TURN, TURN) if turns else (Fraction(2) ** -bits for bits in _bits_of_range(span))
    first, last = whole_units(span.low, span.high, fine)
    if first <= last:
        return span
    point = float(round((Fraction(span.low) + Fraction(span.high)) / 2 / unit) * unit)
    return Range(*_around(point, point)) if turns else Range(point, point)


def _bits_of_range(span: Range) -> tuple[int, int]:
    """The most bits with which the ends of a range fit, before and after rounding."""
    reach = max(abs(span.low), abs(span.high)) * UPWARDS
    return _fitting(reach, 0), _fitting(reach, 1)


def _around(low: float, high: float) -> tuple[float, float]:
    return float(np.nextafter(low, -np.inf)), float(np.nextafter(high, np.inf))


class Total(NamedTuple):
    """The certificate of a reduced function, including its errors against the full program, and a first sentence."""

    certificate: Certificate
    sentence: str
    full: Program

    def only_limited(self, used: Collection[str]) -> dict[str, int | None]:
        """The bits of arguments that only the full program uses, by name; None for fractions of a turn."""
        turns, box = turning(self.full), self.certificate.box.ranges
        unused = {name: x.id for name, x in symbols_of(self.full).items() if name in box and name not in used}
        return {name: None if number in turns else _bits_of_range(box[name])[0] for name, number in unused.items()}


NO_TOTALS: Mapping[str, Total] = MappingProxyType({})


def refuse_impossible(machine: Machine, function: Function) -> None:
    """Raise `InputError` for a function without fixed-point form."""
    if why := impossible(function):
        what = f"{function.name} {why}: choose a model that only adds and multiplies, as bias_forces does"
        raise machine.error("--target c-fixed", what)


def with_scales(
    traced: Traced,
    limits: Limits,
    most_sub_boxes: int = MOST_SUB_BOXES,
    progress: Progress = no_progress,
    totals: Mapping[str, Total] = NO_TOTALS,
) -> Package:
    """The package of programs in fixed point, with scales and guarantees; raises `InputError` for unsupported ones.

    Certificates and sentences in `totals` replace those of their functions.
    """
    package, machine = traced.package, traced.machine
    functions = []
    for function in package.functions:
        refuse_impossible(machine, function)
        used, total = function.program.used, totals.get(function.name)
        if total:
            box = total.certificate.box.of(name for name in total.certificate.box.ranges if name in used)
        else:
            box = box_in_units(function, box_of(machine, limits, function.program.inputs, used))
        try:
            certificate, scales = in_fixed_point(function, box, machine.name, most_sub_boxes, progress)
        except OverflowError as error:
            raise machine.error("--target c-fixed", f"{function.name}: {error}") from None
        if total:
            certificate, scales = total.certificate, replace(scales, only_limited=total.only_limited(used))
        statement = guarantees_of(package, function, certificate, total.sentence if total else "", rests_on=RESTS_ON)
        functions.append(replace(function, fixed=scales, guaranteed={NAME: statement}))
    return replace(package, functions=tuple(functions))
