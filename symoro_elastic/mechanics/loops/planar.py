"""Closed forms of planar loops, which have three unknown joints, the cut one among them, and of loops with one.

Three turns close a triangle (L12); two turns and a slide a triangle of which one side is a line (L16), (L17); a turn
and two slides linear equations. Angles are results as (cosine, sine): none is computed. Vectors of the plane are
complex numbers: components along x and y of a frame whose z is the normal.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from symoro_elastic.foundation.scalar import quotient
from symoro_elastic.mechanics.loops.circuit import CUT, Circuit, Passed, Segment
from symoro_elastic.mechanics.spatial import Axis, Scalar, Vector, is_zero

SquareRoot = Callable[[Scalar], Scalar]


class Complex(NamedTuple):
    """A vector of the plane."""

    x: Scalar
    y: Scalar

    def __mul__(self, other: Complex) -> Complex:  # type: ignore[override]
        return Complex(self.x * other.x - self.y * other.y, self.x * other.y + self.y * other.x)

    def __neg__(self) -> Complex:
        return Complex(-self.x, -self.y)

    def times(self, factor: Scalar) -> Complex:
        """The vector times a scalar."""
        return Complex(factor * self.x, factor * self.y)

    @property
    def conjugate(self) -> Complex:
        """The vector mirrored at the x axis."""
        return Complex(self.x, -self.y)

    @property
    def square(self) -> Scalar:
        """Square of the length."""
        return self.x * self.x + self.y * self.y

    @property
    def length(self) -> Scalar | None:
        """The component of a vector that has only one, its length but for the sign; None for others."""
        if is_zero(self.y):
            return self.x
        return self.y if is_zero(self.x) else None

    @property
    def inverse(self) -> Complex:
        """1 / conj(u) = u / |u|^2."""
        return self.over(self.square)

    def over(self, squared: Scalar) -> Complex:
        """The quotient 1 / conj(u), where the square of the length of u is known."""
        if is_zero(self.y):
            return Complex(quotient(1, self.x), 0)
        if is_zero(self.x):
            return Complex(0, quotient(1, self.y))
        return self.times(quotient(1, squared))


def dot(u: Complex, v: Complex) -> Scalar:
    """Scalar product."""
    return u.x * v.x + u.y * v.y


def area(u: Complex, v: Complex) -> Scalar:
    """Component of u x v along the normal."""
    return u.x * v.y - u.y * v.x


@dataclass(frozen=True)
class Closed:
    """Unknown joints of a loop: turns as cosine + i sine, shifts of slides, by number (0 is the cut joint).

    `sides` lead from the joint named to the next one; `roots` are square roots, zero where the loop is singular.
    """

    turns: Mapping[int, Complex]
    slides: Mapping[int, Scalar]
    sides: Mapping[int, Sequence[Scalar]] = field(default_factory=dict)
    roots: Mapping[int, Scalar] = field(default_factory=dict)


Signs = Mapping[int, int]
"""Sign of the root at each unknown joint: the branch of a loop."""


def close_circuit(loop: Circuit, root: SquareRoot, signs: Signs) -> Closed:
    """The unknown joints of a loop on one of its branches (L9)."""
    if len(loop.unknown) == 1:
        return _with_one_unknown(loop)
    turns = [k for k, joint in enumerate(loop.unknown) if joint.axis is Axis.REVOLUTE]
    if len(turns) == 3:
        return _triangle(loop, root, signs)
    if len(turns) == 2:
        return _with_slide(loop.from_joint(next(k for k in turns if (k + 1) % 3 in turns)), root, signs)
    return _with_two_slides(loop.from_joint(turns[0]))


def _triangle(loop: Circuit, root: SquareRoot, signs: Signs) -> Closed:
    """Angles of a triangle from its three sides, by the cosine law; h is twice the area (L12).

    At a joint between the sides a and b, opposite to c: conj(a) e^(i theta) b = (c^2 - a^2 - b^2) / 2 + i h.
    """
    sides = [_in_plane(segment.frame.origin) for segment in loop.segments]
    h = _twice_area(sides, root)
    turns = {}
    for k, joint in enumerate(loop.unknown):
        before, b, c = sides[k - 1], sides[k], sides[k - 2]
        a = _seen_from_end(loop.segments[k - 1], before).over(before.square)
        m = _half_difference(c.square, before.square, b.square)
        turns[joint.joint] = _of_joint(joint, Complex(m, signs[joint.joint] * h) * (a * b.inverse.conjugate))
    named = {joint.joint: side for joint, side in zip(loop.unknown, sides, strict=True)}
    return Closed(turns, {}, named, {CUT: h})


def _half_difference(c: Scalar, a: Scalar, b: Scalar) -> Scalar:
    """(c - a - b) / 2, equal sides taken together first."""
    return quotient((c - b) - a if is_zero(c - b) else (c - a) - b, 2)


def _twice_area(sides: list[Complex], root: SquareRoot) -> Scalar:
    """Twice the area of a triangle, from the lengths of two sides where these need no root."""
    plain = [(k, length) for k, side in enumerate(sides) if (length := side.length) is not None]
    if len(plain) < 2:
        aa, bb, cc = (side.square for side in sides)
        m = quotient(cc - aa - bb, 2)
        return root(aa * bb - m * m)
    (j, a), (k, b) = plain[:2]
    c, total, difference = sides[3 - j - k].square, a + b, a - b
    return root((total * total - c) * (c - difference * difference)) / 2


def _with_slide(loop: Circuit, root: SquareRoot, signs: Signs) -> Closed:
    """Solve for two turns and the slide along n: |w + s n| is the length of the side between the turns (L16), (L17)."""
    first, second, slide = loop.unknown
    side, to_slide, back = loop.segments
    n, way = _in_plane(to_slide.frame.rotation.T.z), to_slide + back
    start, p = _in_plane(way.frame.origin), _in_plane(side.frame.origin)
    across = area(n, start)
    c = signs[slide.joint] * root(p.square - across * across)
    w = n * Complex(c, across)
    at_second = -(_seen_from_end(side, p).inverse.conjugate * w).conjugate
    at_first = -(_seen_from_end(way, w) * p.inverse.conjugate)
    turns = {first.joint: _of_joint(first, at_first), second.joint: _of_joint(second, at_second)}
    slides = {slide.joint: slide.sense * (c - dot(n, start))}
    return Closed(turns, slides, {first.joint: p, second.joint: w}, {slide.joint: c})


def _with_two_slides(loop: Circuit) -> Closed:
    """Solve for a turn by all other turns of the loop, and for two slides: w + s1 n1 + s2 n2 = 0."""
    turn, first, second = loop.unknown
    first_side, second_side, third_side = loop.segments
    around = (first_side + second_side + third_side).frame
    n1, n2 = _in_plane(first_side.frame.rotation.T.z), _in_plane((first_side + second_side).frame.rotation.T.z)
    w, between = _in_plane(around.origin), area(n1, n2)
    slides = {first.joint: quotient(-first.sense * area(w, n2), between)}
    slides |= {second.joint: quotient(second.sense * area(w, n1), between)}
    angle = Complex(around.rotation.x.x, around.rotation.x.y)
    return Closed({turn.joint: _of_joint(turn, angle)}, slides, {turn.joint: w})


def _with_one_unknown(loop: Circuit) -> Closed:
    """Closed form of a single unknown turn or slide, which undoes all other joints of the loop, in space too."""
    (joint,), frame = loop.unknown, loop.segments[0].frame
    if joint.axis is Axis.PRISMATIC:
        return Closed({}, {joint.joint: -joint.sense * frame.origin.z})
    return Closed({joint.joint: _of_joint(joint, Complex(frame.rotation.x.x, frame.rotation.x.y))}, {})


def _in_plane(v: Vector) -> Complex:
    return Complex(v.x, v.y)


def _seen_from_end(segment: Segment, v: Complex) -> Complex:
    """Components at the end of a segment of a vector given at its beginning; a turned normal mirrors them."""
    columns = segment.frame.rotation.T
    return Complex(dot(_in_plane(columns.x), v), dot(_in_plane(columns.y), v))


def _of_joint(joint: Passed, turn: Complex) -> Complex:
    """The turn counted in the positive sense of the joint."""
    return turn if joint.sense > 0 else turn.conjugate
