"""Base inertial parameters of a tree: the combinations of inertial parameters on which torques depend.

The energy of body j is linear in its parameters. A combination of them whose energy depends neither
on q_j nor on qd_j is as well a combination of the parameters of the antecedent body: it leaves j.
Taken from the tips to the base, all that can leave does, and what stays is independent, for only
body j and those beyond it depend on q_j. So it is enough to know how frame j is carried by the
joints below it, and the rules of Gautier and Khalil (1990) are those of `leaving`; for trees, for
any gravity, for axes that meet, they follow from the same sentence.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TypeAlias

from symoro_elastic.equations.kinematics import path
from symoro_elastic.equations.mechanism import Link, Mechanism
from symoro_elastic.equations.regressor import INERTIA, MOMENTS, body_of, parameters_of
from symoro_elastic.equations.spatial import (
    AT_REST,
    AxialTransform,
    Axis,
    RigidInertia,
    Scalar,
    Transform,
    Twist,
    Vector,
    X,
    Z,
    cross,
    is_zero,
)

ROTOR = "IA"
Draw: TypeAlias = Callable[[], Scalar]
Settle: TypeAlias = Callable[[int, str, Scalar], Scalar]
LINEAR, ANGULAR = 0, 1
RATIO = "L"
TWIST = ("VX", "VY", "VZ", "WX", "WY", "WZ")


def as_is(_j: int, _name: str, x: Scalar) -> Scalar:
    """Leave a sum as it is."""
    return x


@dataclass(frozen=True)
class Ratio:
    """A coefficient that depends on the geometry: one component of a_k in frame j over another."""

    joint: int
    over: tuple[int, int]
    under: tuple[int, int]
    sign: int = 1

    def value(self, mechanism: Mechanism, j: int, settle: Settle) -> Scalar:
        """The coefficient, from a mechanism at its zero position."""
        screw = axis_at(mechanism, self.joint, j, settle)
        part, entry = self.over
        under, other = self.under
        divisor = screw[under][other]
        ratio = screw[part][entry] / (Fraction(divisor) if isinstance(divisor, int) else divisor)
        return settle(j, RATIO, self.sign * ratio)


@dataclass(frozen=True)
class Leaving:
    """A combination of the parameters of body j that leaves it: its first parameter is eliminated.

    `goes` tells whether it joins the parameters of the antecedent body; otherwise it has no effect.
    """

    combination: Mapping[str, int | Ratio]
    goes: bool = False

    @property
    def eliminated(self) -> str:
        """The parameter that is eliminated; its coefficient is 1."""
        return next(iter(self.combination))


@dataclass(frozen=True)
class Carried:
    """How frame j moves before joint j does: twists at random velocities of the joints below, and gravity.

    In frame j, at a random position. What holds here always holds.
    """

    twists: tuple[Twist, ...]
    gravity: Vector

    @cached_property
    def turning(self) -> bool:
        """The frame turns."""
        return any(any(w) for _, w in self.twists)

    @cached_property
    def shifting(self) -> bool:
        """Its origin moves."""
        return any(any(v) for v, _ in self.twists)

    @cached_property
    def parallel(self) -> bool:
        """It turns about z only, or not at all."""
        return not any(w[X] or w[1] for _, w in self.twists)

    @cached_property
    def perpendicular(self) -> bool:
        """It does not turn about z."""
        return not any(w[Z] for _, w in self.twists)

    @cached_property
    def one_direction(self) -> bool:
        """All turns are about one direction."""
        (_, first), (_, second) = self.twists
        return not any(cross(first, second))

    @cached_property
    def level(self) -> bool:
        """Its origin does not move along z."""
        return not any(v[Z] for v, _ in self.twists)

    @cached_property
    def on_axis(self) -> bool:
        """Its origin does not move across z."""
        return not any(v[X] or v[1] for v, _ in self.twists)

    @cached_property
    def about_a_point_of_axis(self) -> bool:
        """All motions are turns about one point of the axis z."""
        (v1, w1), (v2, w2) = self.twists
        imaginary = not any(v[X] * w[X] + v[1] * w[1] for v, w in self.twists)
        return self.level and imaginary and not (v1[X] * w2[1] - v2[X] * w1[1] or v1[1] * w2[X] - v2[1] * w1[X])

    @cached_property
    def weight_along_z(self) -> bool:
        """Gravity is parallel to z or zero."""
        return not (self.gravity[X] or self.gravity[1])


def carried(mechanism: Mechanism, draw: Draw, free_base: bool) -> dict[int, Carried]:
    """How each frame is carried, from a mechanism at its zero position in an exact field.

    `draw` gives random numbers of it. Gravity is the opposite of the base's acceleration. A base
    that is free moves in all directions.
    """

    def anything() -> Vector:
        return Vector(draw(), draw(), draw())

    fields = [anything() if free_base else -mechanism.acceleration.linear]
    twists: list[tuple[Twist, ...]] = [
        (Twist(anything(), anything()), Twist(anything(), anything())) if free_base else (AT_REST, AT_REST)
    ]
    found = {}
    for j, link in mechanism.from_base():
        before = tuple(link.transform * twist for twist in twists[link.antecedent])
        found[j] = Carried(before, link.transform.to_child(fields[link.antecedent]))
        moved = _displacement(link.axis, draw)
        fields.append(moved.to_child(found[j].gravity))
        twists.append(tuple(moved * twist + draw() * link.axis for twist in before))
    return found


def _displacement(axis: Axis, draw: Draw) -> Transform:
    """A random motion of the joint, its angle a rational point of the circle."""
    if axis is Axis.REVOLUTE:
        t = draw()
        return Transform((AxialTransform(Z, (1 - t * t) / (1 + t * t), (t + t) / (1 + t * t), 0),))
    return Transform((AxialTransform(Z, 1, 0, draw() if axis is Axis.PRISMATIC else 0),))


def leaving(mechanism: Mechanism, draw: Draw, free_base: bool, sizes: Mechanism) -> dict[int, list[Leaving]]:
    """What leaves each body, decided in an exact field; `sizes` is the same mechanism in floats."""
    rules = {Axis.REVOLUTE: _leaving_revolute, Axis.PRISMATIC: _leaving_prismatic, Axis.NONE: _leaving_fixed}
    how = carried(mechanism, draw, free_base)
    return {j: list(rules[link.axis](mechanism, sizes, j, link, how[j])) for j, link in mechanism.from_base()}


def _alone(names: Sequence[str], goes: bool = False) -> Iterator[Leaving]:
    return (Leaving({name: 1}, goes) for name in names)


def _leaving_revolute(mechanism: Mechanism, sizes: Mechanism, j: int, link: Link, how: Carried) -> Iterator[Leaving]:
    """YY with XX, MZ and M leave; more where the axes before are parallel, perpendicular or meet this one."""
    yield Leaving({"M": 1}, how.shifting)
    yield Leaving({"MZ": 1}, not how.parallel)
    if how.parallel:
        yield from _alone(("XX", "XY", "XZ", "YY", "YZ"))
    else:
        yield Leaving({"YY": 1, "XX": 1}, goes=True)
    if how.weight_along_z and how.parallel and how.on_axis:
        yield from _alone(("MX", "MY"))
    if how.weight_along_z and not how.parallel and how.about_a_point_of_axis:
        height = _height(mechanism, j)
        yield Leaving({"MX": 1, **({"XZ": height} if height else {})})
        yield Leaving({"MY": 1, **({"YZ": height} if height else {})})
    if how.perpendicular and not is_zero(link.rotor_inertia):
        yield Leaving({ROTOR: 1, "ZZ": -1})


def _leaving_prismatic(mechanism: Mechanism, sizes: Mechanism, j: int, link: Link, how: Carried) -> Iterator[Leaving]:
    """The inertia leaves; the first moments along the one direction of turning, or all; M with a rotor."""
    yield from _alone(INERTIA, how.turning)
    if how.parallel:
        yield from _alone(("MX", "MY"), how.turning)
        yield Leaving({"MZ": 1})
    elif how.one_direction:
        yield Leaving(_along(mechanism, sizes, j))
    if how.parallel and how.level and not how.gravity[Z] and not is_zero(link.rotor_inertia):
        yield Leaving({"M": 1, ROTOR: -1}, goes=True) if how.shifting else Leaving({ROTOR: 1, "M": -1})


def _leaving_fixed(mechanism: Mechanism, sizes: Mechanism, j: int, link: Link, how: Carried) -> Iterator[Leaving]:
    """Everything leaves."""
    yield from _alone((*INERTIA, *MOMENTS), how.turning)
    yield Leaving({"M": 1}, how.shifting)


def _height(mechanism: Mechanism, j: int) -> Ratio | None:
    """How far the origin of frame j lies beyond the point of its axis about which it is carried."""
    for k in reversed(_turning_joints(mechanism, j)):
        v, w = axis_at(mechanism, k, j)
        if w[1]:
            return Ratio(k, (LINEAR, X), (ANGULAR, 1)) if v[X] else None
        if w[X]:
            return Ratio(k, (LINEAR, 1), (ANGULAR, X), sign=-1) if v[1] else None
    raise AssertionError("no axis before this one is inclined to it")


def _along(mechanism: Mechanism, sizes: Mechanism, j: int) -> dict[str, int | Ratio]:
    """The first moment along the one direction about which frame j turns; its largest component is eliminated."""
    k = _turning_joints(mechanism, j)[0]
    (_, w), (_, size) = axis_at(mechanism, k, j), axis_at(sizes, k, j)
    entries = sorted((m for m in range(3) if w[m]), key=lambda m: -abs(round(_number(size[m]), 9)))
    first = entries[0]
    others = {MOMENTS[m]: Ratio(k, (ANGULAR, m), (ANGULAR, first)) for m in entries[1:]}
    return {MOMENTS[first]: 1, **others}


def _number(x: Scalar) -> float:
    """A scalar of a mechanism in floats."""
    if not isinstance(x, int | float | Fraction):
        raise TypeError(f"{x!r} is no number")
    return float(x)


def _turning_joints(mechanism: Mechanism, j: int) -> list[int]:
    """Revolute joints on the path from the base, joint j excepted."""
    return [k for k in path(mechanism, j)[:-1] if mechanism.link(k).axis is Axis.REVOLUTE]


def axis_at(mechanism: Mechanism, k: int, j: int, settle: Settle = as_is) -> Twist:
    """a_k taken at frame j; the joints between are at the position of the mechanism."""
    links = path(mechanism, j)
    a = 1 * mechanism.link(k).axis
    for number in links[links.index(k) + 1 :]:
        moved = mechanism.link(number).transform * a
        entries = [settle(number, name, x) for name, x in zip(TWIST, moved.entries, strict=True)]
        a = Twist(Vector(*entries[:3]), Vector(*entries[3:]))
    return a


def group(
    mechanism: Mechanism, found: Mapping[int, Sequence[Leaving]], settle: Settle = as_is
) -> dict[int, dict[str, Scalar]]:
    """The grouped parameters of every body, its rotor inertia IA among them; those eliminated are zero.

    From a mechanism at its zero position, in any scalar. `settle` sees each sum before it goes on.
    """
    bodies = [RigidInertia(), *(link.body for link in mechanism.links)]
    grouped: dict[int, dict[str, Scalar]] = {}
    for j, link in mechanism.from_tips():
        own = {**parameters_of(bodies[j]), ROTOR: link.rotor_inertia}
        own = {name: settle(j, name, x) for name, x in own.items()}
        gone: dict[str, Scalar] = {}
        for leaves in found[j]:
            share = own[leaves.eliminated]
            for name, coefficient in leaves.combination.items():
                factor = coefficient.value(mechanism, j, settle) if isinstance(coefficient, Ratio) else coefficient
                own[name] = 0 if name == leaves.eliminated else own[name] - share * factor
                if leaves.goes:
                    gone[name] = gone.get(name, 0) + share * factor
        grouped[j] = own
        bodies[link.antecedent] += _carried_over(gone, j, link, settle)
    return grouped


def _carried_over(gone: Mapping[str, Scalar], j: int, link: Link, settle: Settle) -> RigidInertia:
    """Parameters of body j in the frame of its antecedent, iLambda_j K_j, screw by screw."""
    body = body_of(gone)
    for step in reversed(link.transform.steps):
        body = body.to_antecedent(Transform((step,)))
        body = body_of({name: settle(j, name, x) for name, x in parameters_of(body).items()})
    return body
