"""Up to three joints that bring a point to a given place, all solutions.

A point w of the last moved frame must come to W in the frame before the first joint:
J1 C1 J2 C2 J3 w = W, with J a turn about z or a shift along z, C constant placements. Whatever two
joints do, the point stays on a surface that is a plane, a sphere or another quadric unless both
are revolute and their axes skew (a torus). The first joint must bring W onto this surface, one
equation for one unknown; the two others follow. Where the surface is of no use the chain is
taken from its other end: J3^-1 C2^-1 J2^-1 C1^-1 J1^-1 W = w.

Sources: Pieper (1968); Paul (1981); Khalil and Dombre (2002), chapter 4.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from symoro_elastic.mechanics.inverse_geometry.equation_types import (
    SMALL,
    Difference,
    Found,
    Functions,
    Miss,
    NoClosedForm,
    Pose,
    Quadric,
    along,
    distance,
    heron,
    is_along_z,
    only_where,
    plane,
    plane_cross,
    plane_dot,
    quadratic,
    real_root,
    shifted_by,
    type_2,
    type_3,
)
from symoro_elastic.mechanics.spatial import EZ, IDENTITY, ZERO, Axis, Matrix, Scalar, Vector, dot

Solution = tuple[Found, ...]


ON_A_SURFACE = "on a surface"


class Mover(NamedTuple):
    """A joint that moves: its number in the table, revolute or prismatic."""

    joint: int
    axis: Axis

    @property
    def turns(self) -> bool:
        """Whether the joint is revolute."""
        return self.axis is Axis.REVOLUTE


def reach(f: Functions, movers: Sequence[Mover], between: Sequence[Pose], w: Vector, W: Vector) -> list[Solution]:
    """Solutions of the joints that bring the point w to W; `between` are the placements between the joints.

    With less than three joints W must be within reach: not all its coordinates are looked at.
    """
    if not movers:
        return [()]
    if len(movers) == 1:
        return [(value,) for value in _with_one(f, movers[0], w, W)]
    if len(movers) == 2:
        return list(_with_two(f, movers, between[0], w, W))
    try:
        return list(_with_three(f, movers, between, w, W))
    except NoClosedForm as error:
        first = error
    try:
        back = [pose.inverse() for pose in reversed(between)]
        return [from_other_end(s) for s in _with_three(f, movers[::-1], back, W, w)]
    except NoClosedForm as second:
        raise _neither(movers, first, second) from None


def _neither(movers: Sequence[Mover], first: NoClosedForm, second: NoClosedForm) -> NoClosedForm:
    """The error for three joints that can be separated neither from the base nor from the end."""
    if ON_A_SURFACE in (first.condition, second.condition):
        reason = f"{names_in_words(movers)} move the point that they have to place on a surface, not in space"
        return NoClosedForm(numbers_of(movers), reason)
    if first.reason == second.reason:
        return NoClosedForm(first.joints, first.reason)
    reasons = f"{second.reason}, and {first.reason}"
    return NoClosedForm(numbers_of(movers), f"{reasons}: it takes an equation of degree four to place a point")


def from_other_end(solution: Solution) -> Solution:
    """The values of the same joints, in the order of the chain from its other end."""
    return tuple(value.from_other_end() for value in reversed(solution))


def numbers_of(movers: Sequence[Mover]) -> tuple[int, ...]:
    """Numbers of joints, in the order of the table."""
    return tuple(sorted(mover.joint for mover in movers))


def names_in_words(movers: Sequence[Mover]) -> str:
    """Joints in words."""
    numbers = [str(number) for number in numbers_of(movers)]
    return f"joints {', '.join(numbers[:-1])} and {numbers[-1]}" if len(numbers) > 1 else f"joint {numbers[0]}"


def _with_one(f: Functions, mover: Mover, w: Vector, W: Vector) -> list[Found]:
    if not mover.turns:
        return [shifted_by(mover.joint, W[2] - w[2])]
    if is_along_z(f, w):
        raise _idle(mover)
    return [type_3(f, mover.joint, w, W)]


def _idle(mover: Mover) -> NoClosedForm:
    reason = f"joint {mover.joint} does not move the point that the joints before the last axes have to place"
    return NoClosedForm((mover.joint,), reason)


def _same_direction(pair: Sequence[Mover]) -> NoClosedForm:
    return NoClosedForm(numbers_of(pair), f"{names_in_words(pair)} slide along the same direction")


def _with_three(
    f: Functions, movers: Sequence[Mover], between: Sequence[Pose], w: Vector, W: Vector
) -> Iterator[Solution]:
    first, *others = movers
    surface = _surface(f, others, between[1], w).seen_from(between[0])
    for value in onto_surface(f, first, surface, W):
        G = between[0].point_back(value.point_back(W))
        for pair in _with_two(f, others, between[1], w, G):
            yield (value, *pair)


# One joint onto a surface


def onto_surface(f: Functions, mover: Mover, surface: Quadric, W: Vector) -> list[Found]:
    """Motions J for which J^-1 W is on a surface. Raises `NoClosedForm` where the degree is four."""
    return (_turn_onto if mover.turns else _shift_onto)(f, mover, surface, W)


def _turn_onto(f: Functions, mover: Mover, surface: Quadric, W: Vector) -> list[Found]:
    """Angles of a revolute joint J for which J^-1 W is on a surface with circular or straight sections normal to z."""
    S, b, k = surface
    if is_along_z(f, W):
        raise _idle(mover)
    if not (f.is_zero(S[0][0] - S[1][1]) and f.is_zero(S[0][1])):
        reason = f"the equation for joint {mover.joint} is of degree four"
        raise NoClosedForm((mover.joint,), reason)
    beta = Vector(S.x.z * W.z + b.x, S.y.z * W.z + b.y, 0)
    if is_along_z(f, beta):
        raise _undetermined(mover)
    terms = Vector(S[0][0] * plane_dot(W, W), (S[2][2] * W[2] + 2 * b[2]) * W[2], k)
    x, y, z = 2 * plane_dot(beta, W), 2 * plane_cross(beta, W), -(terms[0] + terms[1] + terms[2])
    scale = 4 * plane_dot(beta, beta) * dot(W, W) + dot(terms, terms)
    return type_2(f, mover.joint, x, y, z, Difference(x * x + y * y, z, scale).root(f))


def _shift_onto(f: Functions, mover: Mover, surface: Quadric, W: Vector) -> list[Found]:
    """Lengths of a prismatic joint J for which J^-1 W is on a surface: a r^2 + 2 h r + c = 0, or 2 h r + c = 0."""
    a, h, c = surface.S[2][2], -(dot(surface.S[2], W) + surface.b[2]), surface.value(W)
    if not f.is_zero(a):
        return quadratic(f, mover.joint, a, h, real_root(f, h * h - a * c, h * h + a * a * dot(W, W)))
    if f.is_zero(h):
        raise _undetermined(mover)
    if all(f.is_zero(x) for x in surface.S[2]):
        return [shifted_by(mover.joint, -c / (2 * h))]
    size = dot(surface.S[2], surface.S[2]) * dot(W, W) + surface.b[2] * surface.b[2]
    h = h / only_where(f, h * h - SMALL * size)
    return [shifted_by(mover.joint, -c / (2 * h), h * f.sign(h))]


def _undetermined(mover: Mover) -> NoClosedForm:
    return NoClosedForm((mover.joint,), f"joint {mover.joint} does not matter to the others", None, ON_A_SURFACE)


# The surface that two joints can reach


def _surface(f: Functions, pair: Sequence[Mover], C: Pose, w: Vector) -> Quadric:
    """Surface of all points J1 C J2 w that two joints reach, in the frame before J1."""
    first, second = pair
    if first.turns and second.turns:
        return _surface_of_turns(f, pair, C, w)
    if first.turns:
        return _surface_of_turn_and_shift(f, C.point(w), C.rotation.T[2])
    if second.turns:
        return _surface_of_shift_and_turn(f, C, w)
    normal = Vector(-C.rotation.y.z, C.rotation.x.z, 0)
    if is_along_z(f, normal):
        raise _same_direction(pair)
    return plane(normal, dot(normal, C.point(w)))


def _surface_of_turns(f: Functions, pair: Sequence[Mover], C: Pose, w: Vector) -> Quadric:
    """Surface that two revolute joints reach: a plane for parallel axes, a sphere about the point where axes meet."""
    if is_along_z(f, C.rotation.T[2]):
        return plane(EZ, C.point(w)[2])
    here, there = meeting(f, pair, C)
    arm = w - along(there)
    return Quadric(IDENTITY, along(-here), here * here - dot(arm, arm))


def _surface_of_turn_and_shift(f: Functions, c: Vector, u: Vector) -> Quadric:
    """Surface of the line c + r u turned about z: the plane z = c3, or a hyperboloid, a cone, a cylinder."""
    if f.is_zero(u[2]):
        return plane(EZ, c[2])
    round_ = u[2] * u[2]
    S = Matrix(Vector(round_, 0, 0), Vector(0, round_, 0), Vector(0, 0, -plane_dot(u, u)))
    surface = Quadric(S, along(-u[2] * plane_dot(c, u)), -round_ * plane_dot(c, c))
    return surface.seen_from(Pose(IDENTITY, along(c[2])))


def _surface_of_shift_and_turn(f: Functions, C: Pose, w: Vector) -> Quadric:
    """Surface of the circle of w about z2 shifted along z1: its plane if z1 lies in it, else an oblique cylinder."""
    u = C.rotation[2]
    normal = C.rotation.T[2]
    if f.is_zero(u[2]):
        return plane(normal, dot(normal, C.point(along(w[2]))))
    p, q = -u[2] * u[0], -u[2] * u[1]
    round_ = u[2] * u[2]
    S = Matrix(Vector(round_, 0, p), Vector(0, round_, q), Vector(p, q, plane_dot(u, u)))
    surface = Quadric(S, ZERO, -round_ * plane_dot(w, w))
    return surface.seen_from(Pose(C.rotation, C.point(along(w[2]))))


def meeting(f: Functions, pair: Sequence[Mover], C: Pose) -> tuple[Scalar, Scalar]:
    """Where two axes meet: z in the frame of the first, z in the frame of the second. Raises `NoClosedForm`."""
    a, p = C.rotation.T[2], C.origin
    axes = f"the axes of {names_in_words(pair)}"
    if is_along_z(f, a):
        raise NoClosedForm(numbers_of(pair), f"{axes} are parallel", Miss(max(numbers_of(pair)), "parallel"))
    if not f.is_zero(plane_cross(p, a)):
        raise NoClosedForm(numbers_of(pair), f"{axes} do not meet", Miss(max(numbers_of(pair)), "apart"))
    there = -p[1] / a[1] if f.is_zero(a[0]) else -p[0] / a[0]
    return p[2] + there * a[2], there


# Two joints


def _with_two(f: Functions, pair: Sequence[Mover], C: Pose, w: Vector, G: Vector) -> Iterator[Solution]:
    """Solve J1 C J2 w = G for both joints, where G is on the surface that they reach."""
    first, second = pair
    if first.turns and second.turns:
        yield from _turns(f, pair, C, w, G)
    elif first.turns:
        yield from _turn_and_shift(f, pair, C, w, G)
    elif second.turns:
        if is_along_z(f, w):
            raise _idle(second)
        for solution in _turn_and_shift(f, pair[::-1], C.inverse(), G, w):
            yield from_other_end(solution)
    else:
        v, g = C.rotation.T[2], G - C.point(w)
        if is_along_z(f, v):
            raise _same_direction(pair)
        r = plane_dot(g, v) / plane_dot(v, v)
        yield shifted_by(first.joint, g[2] - r * v[2]), shifted_by(second.joint, r)


def _turns(f: Functions, pair: Sequence[Mover], C: Pose, w: Vector, G: Vector) -> Iterator[Solution]:
    first, second = pair
    if is_along_z(f, w):
        raise _idle(second)
    parallel = is_along_z(f, C.rotation.T[2])
    for value in (_elbow if parallel else _shoulder)(f, pair, C, w, G):
        yield type_3(f, first.joint, C.point(value.point(w)), G), value


def _elbow(f: Functions, pair: Sequence[Mover], C: Pose, w: Vector, G: Vector) -> list[Found]:
    """Angles q2 for parallel axes: |p + Rot(z, q2) w| = |G| in the plane (type 8), p the first axis in frame 2."""
    x, y, _ = Pose(C.rotation, ZERO).point_back(C.origin)
    p = Vector(x, y, 0)
    if is_along_z(f, p):
        raise NoClosedForm(numbers_of(pair), f"the axes of {names_in_words(pair)} coincide")
    area = heron(f, distance(f, p), distance(f, w), distance(f, G))
    constant = plane_dot(G, G) - plane_dot(p, p) - plane_dot(w, w)
    return type_2(f, pair[1].joint, 2 * plane_dot(p, w), 2 * plane_cross(w, p), constant, area)


def _shoulder(f: Functions, pair: Sequence[Mover], C: Pose, w: Vector, G: Vector) -> list[Found]:
    """Angles q2 for axes that meet: a.Rot(z, q2) w = G3, a the first axis in frame 2, origins where axes meet.

    D^2 = |a x z|^2 |w x z|^2 - (G3 - a3 w3)^2 = |a x z|^2 |G x z|^2 - (w3 - a3 G3)^2: the first is exact
    where w is near the second axis, the second where G is near the first; their mean is in both places.
    """
    here, there = meeting(f, pair, C)
    w, G, a = w - along(there), G - along(here), C.rotation[2]
    z, other = G[2] - a[2] * w[2], w[2] - a[2] * G[2]
    near_w, near_G = plane_dot(w, w), plane_dot(G, G)
    oblique, scale = plane_dot(a, a), near_w + w[2] * w[2]
    by_w, by_G = Difference(oblique * near_w, z, scale), Difference(oblique * near_G, other, scale)
    if f.is_fixed(near_w):
        root = by_G.root(f)
    elif f.is_fixed(near_G):
        root = by_w.root(f)
    else:
        mean = (near_G * by_w.value + near_w * by_G.value) / (near_G + near_w)
        root = real_root(f, mean, by_G.size, scale)
    return type_2(f, pair[1].joint, plane_dot(a, w), plane_cross(w, a), z, root)


def _turn_and_shift(f: Functions, pair: Sequence[Mover], C: Pose, w: Vector, G: Vector) -> Iterator[Solution]:
    """Solve Rot(z, q1) (c + r u) = G for the angle q1 and the length r."""
    first, second = pair
    c, u = C.point(w), C.rotation.T[2]
    for r in _lengths(f, second, c, u, G):
        yield type_3(f, first.joint, c + r.variable * u, G), r


def _lengths(f: Functions, mover: Mover, c: Vector, u: Vector, G: Vector) -> list[Found]:
    """Lengths r of a slide, from r u3 = G3 - c3 or, where u3 = 0, from |c + r u| = |G| in the plane."""
    if is_along_z(f, u):
        if is_along_z(f, c):
            raise NoClosedForm((mover.joint,), f"joint {mover.joint} slides along the axis of its neighbour")
        return [shifted_by(mover.joint, (G[2] - c[2]) / u[2])]
    radius = distance(f, G)
    if not f.is_zero(u[2]):
        return [shifted_by(mover.joint, (G[2] - c[2]) / u[2], radius * f.sign(radius))]
    length = plane_dot(u, u)
    root = Difference(length * plane_dot(G, G), plane_cross(c, u), length * plane_dot(c, c)).root(f)
    return quadratic(f, mover.joint, length, plane_dot(c, u), root)
