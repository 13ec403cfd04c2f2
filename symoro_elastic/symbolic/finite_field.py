"""Exact arithmetic modulo a large prime, angles included.

A quantity that is identically zero vanishes at every choice of its variables; one that is not
vanishes at random values with a probability of about 1e-15. Cosine and sine of an angle are the
coordinates of a point of the circle x^2 + y^2 = 1 over the field. That group is cyclic of order
PRIME + 1 = 11 TORSION ELL, so a multiple of pi with a denominator that divides TORSION / 2 and
any rational number of radians both have an exact image, sums of angles included.
"""

from __future__ import annotations

import random
from fractions import Fraction
from functools import cache
from numbers import Rational

from symoro_elastic.foundation.scalar import Scalar

PRIME = 4614990852022238441880510100949231999999
ELL = 2305843009213693967
FACTORS = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31)
TORSION = 2**10 * 3**5 * 5**6 * 7**2 * 11 * 13 * 17 * 19 * 23 * 29 * 31
ODD_PI = 1414213562373095049

Point = tuple[int, int]


class Residue:
    """A number modulo PRIME."""

    __slots__ = ("value",)

    def __init__(self, value: int | Fraction) -> None:
        self.value = (value if type(value) is int else _residue(Fraction(value))) % PRIME

    def __add__(self, other: Scalar) -> Residue:
        value = other.value if type(other) is Residue else _value(other)
        return NotImplemented if value is None else Residue(self.value + value)

    def __sub__(self, other: Scalar) -> Residue:
        value = other.value if type(other) is Residue else _value(other)
        return NotImplemented if value is None else Residue(self.value - value)

    def __rsub__(self, other: Scalar) -> Residue:
        value = _value(other)
        return NotImplemented if value is None else Residue(value - self.value)

    def __mul__(self, other: Scalar) -> Residue:
        value = other.value if type(other) is Residue else _value(other)
        return NotImplemented if value is None else Residue(self.value * value)

    def __truediv__(self, other: Scalar) -> Residue:
        value = _value(other)
        return NotImplemented if value is None else Residue(self.value * _inverse(value))

    def __rtruediv__(self, other: Scalar) -> Residue:
        value = _value(other)
        return NotImplemented if value is None else Residue(value * _inverse(self.value))

    def __neg__(self) -> Residue:
        return Residue(-self.value)

    def __bool__(self) -> bool:
        return self.value != 0

    __radd__ = __add__
    __rmul__ = __mul__


def _value(x: Scalar) -> int | None:
    """The integer of a residue or an exact number; None for anything else."""
    if type(x) is Residue:
        return x.value
    if type(x) is int:
        return x
    return _residue(Fraction(x)) if isinstance(x, Rational) else None


def _residue(x: Fraction) -> int:
    return x.numerator * pow(x.denominator, -1, PRIME)


def _inverse(value: int) -> int:
    if value % PRIME == 0:
        raise ZeroDivisionError("division by zero modulo the prime")
    return pow(value, -1, PRIME)


def circle_of_pi(multiple: Fraction) -> Point:
    """Image of (cos, sin) of `multiple` pi.

    Where the denominator does not fit, the angle must be less than pi/2, and up to pi/4 is taken for
    some radians: its complement and sums of small ones are exact, but 37 times pi/37 is not pi.
    """
    steps = multiple * TORSION / 2
    if steps.denominator == 1:
        return _power(_torsion_point(), steps.numerator % TORSION)
    if 4 * multiple <= 1:
        return circle_of_radians(multiple * ODD_PI)
    cosine, sine = circle_of_radians((Fraction(1, 2) - multiple) * ODD_PI)
    return sine, cosine


def circle_of_radians(radians: Fraction) -> Point:
    """Image of (cos, sin) of a number of radians."""
    exponent = radians.numerator * pow(radians.denominator, -1, ELL) % ELL
    result = (1, 0)
    for k, power in enumerate(_powers_of_free_point()):
        if exponent >> k & 1:
            result = _times(result, power)
    return result


def random_radians(source: random.Random) -> Fraction:
    """A random angle of a joint."""
    return Fraction(source.randrange(1, ELL))


def _times(p: Point, q: Point) -> Point:
    return (p[0] * q[0] - p[1] * q[1]) % PRIME, (p[0] * q[1] + p[1] * q[0]) % PRIME


def _power(point: Point, exponent: int) -> Point:
    result = (1, 0)
    while exponent:
        if exponent & 1:
            result = _times(result, point)
        point = _times(point, point)
        exponent >>= 1
    return result


def _circle_point(t: int) -> Point:
    scale = pow(1 + t * t, -1, PRIME)
    return (1 - t * t) * scale % PRIME, 2 * t * scale % PRIME


@cache
def _free_point() -> Point:
    """A point of order ELL on the circle modulo PRIME."""
    return _power(_circle_point(3), (PRIME + 1) // ELL)


@cache
def _powers_of_free_point() -> list[Point]:
    """The points P, 2 P, 4 P, 8 P ... of a point P of order ELL on the circle modulo PRIME."""
    powers = [_free_point()]
    while 1 << len(powers) < ELL:
        powers.append(_times(powers[-1], powers[-1]))
    return powers


@cache
def _torsion_point() -> Point:
    """A point of order TORSION on the circle modulo PRIME, the image of 2 pi / TORSION."""
    for t in range(2, 1000):
        point = _power(_circle_point(t), (PRIME + 1) // TORSION)
        if all(_power(point, TORSION // q) != (1, 0) for q in FACTORS):
            return point
    raise AssertionError("no generator found")
