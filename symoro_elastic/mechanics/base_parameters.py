"""Base inertial parameters of a tree: the combinations of inertial parameters on which torques depend.

The energy of body j is linear in its parameters. A combination of them whose energy depends neither on q_j nor on qd_j
can be counted with the antecedent body as well: it is grouped there. Taken from the tips to the base, everything that
can be grouped is, and what remains is independent, for only body j and those beyond it depend on q_j. So the motion of
frame j with the joints below it decides: `grouping_rules` are those of Gautier and Khalil (1990), extended to trees,
any gravity and axes that meet.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TypeAlias

from symoro_elastic.mechanics.kinematics import path
from symoro_elastic.mechanics.mechanism import Link, Mechanism
from symoro_elastic.mechanics.regressor import INERTIA, MOMENTS, body_of, parameters_of
from symoro_elastic.mechanics.spatial import (
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
Simplify: TypeAlias = Callable[[int, str, Scalar], Scalar]
LINEAR, ANGULAR = 0, 1
RATIO = "L"
TWIST = ("VX", "VY", "VZ", "WX", "WY", "WZ")


def identity(_j: int, _name: str, x: Scalar) -> Scalar:
    """Return a sum unchanged."""
    return x


@dataclass(frozen=True)
class Ratio:
    """A coefficient that depends on the geometry: one component of a_k in frame j over another."""

    joint: int
    over: tuple[int, int]
    under: tuple[int, int]
    sign: int = 1

    def value(self, mechanism: Mechanism, j: int, simplify: Simplify) -> Scalar:
        """The coefficient, from a mechanism at its zero position."""
        axis = axis_at(mechanism, self.joint, j, simplify)
        part, entry = self.over
        under, other = self.under
        divisor = axis[under][other]
        ratio = axis[part][entry] / (Fraction(divisor) if isinstance(divisor, int) else divisor)
        return simplify(j, RATIO, self.sign * ratio)


@dataclass(frozen=True)
class GroupingRule:
    """A combination of the parameters of body j that is grouped: its first parameter is eliminated.

    Where `joins_antecedent`, it is added to the parameters of the antecedent body; otherwise it has no effect.
    """

    combination: Mapping[str, int | Ratio]
    joins_antecedent: bool = False

    @property
    def eliminated(self) -> str:
        """The parameter that is eliminated; its coefficient is 1."""
        return next(iter(self.combination))


Rules: TypeAlias = Iterator[GroupingRule]


@dataclass(frozen=True)
class CarriedMotion:
    """Motion of frame j without that of joint j: twists at random velocities of the joints below, and gravity.

    In frame j, at a random position. What holds here always holds.
    """

    twists: tuple[Twist, ...]
    gravity: Vector

    @cached_property
    def turning(self) -> bool:
        """Whether frame j rotates when the joints before joint j move."""
        return any(any(w) for _, w in self.twists)

    @cached_property
    def shifting(self) -> bool:
        """Whether the origin of frame j moves."""
        return any(any(v) for v, _ in self.twists)

    @cached_property
    def parallel(self) -> bool:
        """Whether the frame turns about z only, or not at all."""
        return not any(w[X] or w[1] for _, w in self.twists)

    @cached_property
    def perpendicular(self) -> bool:
        """Whether frame j has no angular velocity along its axis z."""
        return not any(w[Z] for _, w in self.twists)

    @cached_property
    def one_direction(self) -> bool:
        """Whether all rotations of frame j are about one direction."""
        (_, first), (_, second) = self.twists
        return not any(cross(first, second))

    @cached_property
    def level(self) -> bool:
        """Whether the origin of frame j never moves along z."""
        return not any(v[Z] for v, _ in self.twists)

    @cached_property
    def on_axis(self) -> bool:
        """Whether the origin of frame j never moves perpendicular to z."""
        return not any(v[X] or v[1] for v, _ in self.twists)

    @cached_property
    def about_a_point_of_axis(self) -> bool:
        """Whether all motions are turns about one point of the axis z."""
        (v1, w1), (v2, w2) = self.twists
        imaginary = not any(v[X] * w[X] + v[1] * w[1] for v, w in self.twists)
        return self.level and imaginary and not (v1[X] * w2[1] - v2[X] * w1[1] or v1[1] * w2[X] - v2[1] * w1[X])

    @cached_property
    def weight_along_z(self) -> bool:
        """Whether gravity is parallel to z of frame j, or zero."""
        return not (self.gravity[X] or self.gravity[1])


def carried_motions(mechanism: Mechanism, draw: Draw, free_base: bool) -> dict[int, CarriedMotion]:
    """Motion of each frame j due to the joints before it, by j; the mechanism given is at zero, in an exact field.

    `draw` gives random numbers of it. Gravity is the opposite of the base's acceleration. A base
    that is free moves in all directions.
    """

    def anything() -> Vector:
        return Vector(draw(), draw(), draw())

    fields = [anything() if free_base else -mechanism.acceleration.linear]
    twists: list[tuple[Twist, ...]] = [
        (Twist(anything(), anything()), Twist(anything(), anything())) if free_base else (AT_REST, AT_REST)
    ]
    motions = {}
    for j, link in mechanism.from_base():
        before = tuple(link.transform * twist for twist in twists[link.antecedent])
        motions[j] = CarriedMotion(before, link.transform.to_child(fields[link.antecedent]))
        moved = _displacement(link.axis, draw)
        fields.append(moved.to_child(motions[j].gravity))
        twists.append(tuple(moved * twist + draw() * link.axis for twist in before))
    return motions


def _displacement(axis: Axis, draw: Draw) -> Transform:
    """A random motion of the joint, its angle a rational point of the circle."""
    if axis is Axis.REVOLUTE:
        t = draw()
        return Transform((AxialTransform(Z, (1 - t * t) / (1 + t * t), (t + t) / (1 + t * t), 0),))
    return Transform((AxialTransform(Z, 1, 0, draw() if axis is Axis.PRISMATIC else 0),))


def grouping_rules(
    mechanism: Mechanism, draw: Draw, free_base: bool, sizes: Mechanism
) -> dict[int, list[GroupingRule]]:
    """Grouping rules by body, decided in an exact field; `sizes` is the mechanism in floats."""
    rules = {Axis.REVOLUTE: _rules_revolute, Axis.PRISMATIC: _rules_prismatic, Axis.NONE: _rules_fixed}
    motion = carried_motions(mechanism, draw, free_base)
    return {j: list(rules[link.axis](mechanism, sizes, j, link, motion[j])) for j, link in mechanism.from_base()}


def _alone(names: Sequence[str], joins_antecedent: bool = False) -> Rules:
    return (GroupingRule({name: 1}, joins_antecedent) for name in names)


def _rules_revolute(mechanism: Mechanism, sizes: Mechanism, j: int, link: Link, motion: CarriedMotion) -> Rules:
    """Rules of a body on a revolute joint: YY with XX, MZ and M; more where earlier axes are parallel or meet it."""
    yield GroupingRule({"M": 1}, motion.shifting)
    yield GroupingRule({"MZ": 1}, not motion.parallel)
    if motion.parallel:
        yield from _alone(("XX", "XY", "XZ", "YY", "YZ"))
    else:
        yield GroupingRule({"YY": 1, "XX": 1}, joins_antecedent=True)
    if motion.weight_along_z and motion.parallel and motion.on_axis:
        yield from _alone(("MX", "MY"))
    if motion.weight_along_z and not motion.parallel and motion.about_a_point_of_axis:
        height = _height(mechanism, j)
        yield GroupingRule({"MX": 1, **({"XZ": height} if height else {})})
        yield GroupingRule({"MY": 1, **({"YZ": height} if height else {})})
    if motion.perpendicular and not is_zero(link.rotor_inertia):
        yield GroupingRule({ROTOR: 1, "ZZ": -1})


def _rules_prismatic(mechanism: Mechanism, sizes: Mechanism, j: int, link: Link, motion: CarriedMotion) -> Rules:
    """Rules of a body on a prismatic joint: inertia, first moments along the rotation axis or all, M with a rotor."""
    yield from _alone(INERTIA, motion.turning)
    if motion.parallel:
        yield from _alone(("MX", "MY"), motion.turning)
        yield GroupingRule({"MZ": 1})
    elif motion.one_direction:
        yield GroupingRule(_along(mechanism, sizes, j))
    if motion.parallel and motion.level and not motion.gravity[Z] and not is_zero(link.rotor_inertia):
        yield (
            GroupingRule({"M": 1, ROTOR: -1}, joins_antecedent=True)
            if motion.shifting
            else GroupingRule({ROTOR: 1, "M": -1})
        )


def _rules_fixed(mechanism: Mechanism, sizes: Mechanism, j: int, link: Link, motion: CarriedMotion) -> Rules:
    """The rules of a fixed body: all ten parameters are grouped."""
    yield from _alone((*INERTIA, *MOMENTS), motion.turning)
    yield GroupingRule({"M": 1}, motion.shifting)


def _height(mechanism: Mechanism, j: int) -> Ratio | None:
    """Distance along z_j from the point about which earlier joints rotate frame j to its origin; None for zero."""
    for k in reversed(_turning_joints(mechanism, j)):
        v, w = axis_at(mechanism, k, j)
        if w[1]:
            return Ratio(k, (LINEAR, X), (ANGULAR, 1)) if v[X] else None
        if w[X]:
            return Ratio(k, (LINEAR, 1), (ANGULAR, X), sign=-1) if v[1] else None
    raise AssertionError("no axis before this one is inclined to it")


def _along(mechanism: Mechanism, sizes: Mechanism, j: int) -> dict[str, int | Ratio]:
    """Coefficients of the first moment along the one rotation axis of frame j; its largest component is eliminated."""
    k = _turning_joints(mechanism, j)[0]
    (_, w), (_, size) = axis_at(mechanism, k, j), axis_at(sizes, k, j)
    entries = sorted((m for m in range(3) if w[m]), key=lambda m: -abs(round(_number(size[m]), 9)))
    first = entries[0]
    ratios = {MOMENTS[m]: Ratio(k, (ANGULAR, m), (ANGULAR, first)) for m in entries[1:]}
    return {MOMENTS[first]: 1, **ratios}


def _number(x: Scalar) -> float:
    """A scalar of a mechanism in floats."""
    if not isinstance(x, int | float | Fraction):
        raise TypeError(f"{x!r} is not a number")
    return float(x)


def _turning_joints(mechanism: Mechanism, j: int) -> list[int]:
    """Revolute joints on the path from the base, joint j excepted."""
    return [k for k in path(mechanism, j)[:-1] if mechanism.link(k).axis is Axis.REVOLUTE]


def axis_at(mechanism: Mechanism, k: int, j: int, simplify: Simplify = identity) -> Twist:
    """Axis a_k in frame j, with the joints between at the position of the mechanism."""
    links = path(mechanism, j)
    a = 1 * mechanism.link(k).axis
    for number in links[links.index(k) + 1 :]:
        moved = mechanism.link(number).transform * a
        entries = [simplify(number, name, x) for name, x in zip(TWIST, moved.entries, strict=True)]
        a = Twist(Vector(*entries[:3]), Vector(*entries[3:]))
    return a


def group(
    mechanism: Mechanism, found: Mapping[int, Sequence[GroupingRule]], simplify: Simplify = identity
) -> dict[int, dict[str, Scalar]]:
    """The grouped parameters by body, including its rotor inertia IA; eliminated ones are zero.

    From a mechanism at its zero position, in any scalar. `simplify` is applied to each sum.
    """
    bodies = [RigidInertia(), *(link.body for link in mechanism.links)]
    grouped: dict[int, dict[str, Scalar]] = {}
    for j, link in mechanism.from_tips():
        own = {**parameters_of(bodies[j]), ROTOR: link.rotor_inertia}
        own = {name: simplify(j, name, x) for name, x in own.items()}
        gone: dict[str, Scalar] = {}
        for rule in found[j]:
            share = own[rule.eliminated]
            for name, coefficient in rule.combination.items():
                factor = coefficient.value(mechanism, j, simplify) if isinstance(coefficient, Ratio) else coefficient
                own[name] = 0 if name == rule.eliminated else own[name] - share * factor
                if rule.joins_antecedent:
                    gone[name] = gone.get(name, 0) + share * factor
        grouped[j] = own
        bodies[link.antecedent] += _carried_over(gone, j, link, simplify)
    return grouped


def _carried_over(gone: Mapping[str, Scalar], j: int, link: Link, simplify: Simplify) -> RigidInertia:
    """Inertial parameters of body j, transformed to the frame of its antecedent: iLambda_j K_j, step by step."""
    body = body_of(gone)
    for step in reversed(link.transform.steps):
        body = body.to_antecedent(Transform((step,)))
        body = body_of({name: simplify(j, name, x) for name, x in parameters_of(body).items()})
    return body
