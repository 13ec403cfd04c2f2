"""Any displacement as the parameters of a row of the table [1].

T = Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r). Where the two axes are nearly
parallel b and r grow without bound: then one row moves and a second one turns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from symoro_elastic.formats.robots.axis_frames import NEARLY_PARALLEL, UNDECIDED
from symoro_elastic.formats.robots.robot import Placement
from symoro_elastic.machine.formula import SMALLEST, ZERO, Formula
from symoro_elastic.machine.joints import Joint

EPS = 2.0**-52
ROUNDING = 16 * EPS
"""Error of angles, rad, and of lengths relative to that of a robot, that double precision leaves."""
NO_CHANCE = 1e-3
"""Part of the last digit by which a number that is meant to be a short decimal may differ from it."""
QUARTER, TWELFTH = math.pi / 2, math.pi / 12


@dataclass(frozen=True)
class Tolerance:
    """What is taken for zero: angles near whole parts of a turn, rad, and lengths, m.

    `parts` is the angle, rad, of which angles are taken for multiples.
    """

    angle: float
    length: float
    parts: float = QUARTER

    @classmethod
    def rounding(cls, size: float) -> Tolerance:
        """That of arithmetic on a robot of this size, m."""
        return cls(ROUNDING, max(ROUNDING * size, SMALLEST))

    @classmethod
    def of(cls, tolerance: float, size: float) -> Tolerance:
        """That of a user, rad and m."""
        exact = cls.rounding(size)
        return cls(max(tolerance, exact.angle), max(tolerance, exact.length), TWELFTH)


@dataclass(frozen=True)
class Row:
    """Parameters of a row, rad and m."""

    gamma: float = 0.0
    b: float = 0.0
    alpha: float = 0.0
    d: float = 0.0
    theta: float = 0.0
    r: float = 0.0

    def put_into(self, joint: Joint, tolerance: Tolerance) -> Joint:
        """The joint with these parameters in its row, what is zero within the tolerance as zero."""
        return replace(
            joint,
            gamma=angle_cell(self.gamma, tolerance),
            b=length_cell(self.b, tolerance.length),
            alpha=angle_cell(self.alpha, tolerance),
            d=length_cell(self.d, tolerance.length),
            theta=angle_cell(self.theta, tolerance),
            r=length_cell(self.r, tolerance.length),
        )


def rows_of(T: Placement, tolerance: Tolerance) -> list[Row]:
    """The rows of a displacement: one, or two where z of both frames are nearly parallel and apart."""
    sine = math.hypot(*T.rotation[:2, 2])
    if sine <= tolerance.angle:
        return [_parallel(T, tolerance)]
    if sine >= NEARLY_PARALLEL:
        return [_general(T)]
    if math.hypot(*T.translation[:2]) > tolerance.length:
        return [_parallel(Placement(translation=T.translation), tolerance), _general(Placement(T.rotation))]
    return [_general(Placement(T.rotation, T.translation * [0.0, 0.0, 1.0]))]


def placement_of(joint: Joint) -> Placement:
    """The displacement of a row whose cells are numbers, its variable at 0."""
    keys = ("gamma", "b", "alpha", "d", "theta", "r")
    gamma, b, alpha, d, theta, r = (getattr(joint, key).value() for key in keys)
    return about_z(gamma, b) * about_x(alpha, d) * about_z(theta, r)


def angle_cell(angle: float, tolerance: Tolerance) -> Formula:
    """The formula of an angle, rad: a multiple of pi where it is within the tolerance of one, else a number."""
    parts = round(angle / tolerance.parts)
    if abs(angle - parts * tolerance.parts) > tolerance.angle:
        return number_cell(angle, tolerance.angle)
    half_turns = Fraction(round(parts * tolerance.parts / TWELFTH), 12)
    if half_turns == 0:
        return ZERO
    sign, above = "-" if -1 < half_turns < 0 else "", abs(half_turns.numerator)
    below = f"/{half_turns.denominator}" if half_turns.denominator > 1 else ""
    return Formula.parse(f"{sign}pi{below}" if above == 1 else f"{sign}{above}*pi{below}")


def length_cell(length: float, tolerance: float) -> Formula:
    """The formula of a length, or of any number that is taken for zero below a tolerance."""
    return ZERO if abs(length) <= tolerance else number_cell(length, tolerance)


def number_cell(x: float, tolerance: float = 0.0) -> Formula:
    """The formula of a number: 15 digits where rounding errors alone make more of them.

    A decimal of 6 or 9 digits stands for it where that is within the tolerance, and far nearer than by chance.
    """
    for digits in (6, 9, 15):
        short = f"{x:.{digits}g}"
        resolution = 10.0 ** (math.floor(math.log10(abs(x) or 1.0)) - digits + 1)
        if abs(float(short) - x) <= max(min(tolerance, NO_CHANCE * resolution), 4 * EPS * abs(x)):
            return Formula.parse(short)
    return Formula.parse(x)


def _general(T: Placement) -> Row:
    """The row of a displacement to an axis that is not parallel to z."""
    (x, y, z3), p = T.rotation[:, 2], T.translation
    sine = math.hypot(x, y)
    r = (p[0] * x + p[1] * y) / (sine * sine)
    return _row(T, math.atan2(x, -y), math.atan2(sine, z3), (x * p[1] - y * p[0]) / sine, float(p[2] - r * z3), r)


def _parallel(T: Placement, tolerance: Tolerance) -> Row:
    """The row of a displacement to an axis parallel to z, or against it."""
    x, y, z = map(float, T.translation)
    apart = math.hypot(x, y) > tolerance.length
    gamma, d = (math.atan2(y, x), math.hypot(x, y)) if apart else (0.0, 0.0)
    along = T.rotation[2, 2] > 0
    return _row(T, gamma, 0.0 if along else math.pi, d, 0.0, z if along else -z)


def _row(T: Placement, gamma: float, alpha: float, d: float, b: float, r: float) -> Row:
    """The row with gamma between -pi/2 and pi/2, and the theta that is left."""
    if not UNDECIDED - QUARTER < gamma <= QUARTER + UNDECIDED:
        gamma, alpha, d = math.remainder(gamma + math.pi, 2 * math.pi), -alpha, -d
    normal = np.array([math.cos(gamma), math.sin(gamma), 0.0])
    x, _, z = T.rotation.T
    return Row(gamma, b, alpha, d, math.atan2(np.cross(normal, x) @ z, normal @ x), r)


def about_z(angle: float, shift: float) -> Placement:
    """Rot(z, angle) Trans(z, shift)."""
    c, s = math.cos(angle), math.sin(angle)
    return Placement(np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), np.array([0.0, 0.0, shift]))


def about_x(angle: float, shift: float) -> Placement:
    """Rot(x, angle) Trans(x, shift)."""
    c, s = math.cos(angle), math.sin(angle)
    return Placement(np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]), np.array([shift, 0.0, 0.0]))
