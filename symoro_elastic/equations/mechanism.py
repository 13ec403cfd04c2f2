"""A mechanism as the equations see it: placements, axes and inertias, in any scalar."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

from symoro_elastic.equations.spatial import (
    ZERO,
    Pair,
    Placement,
    RigidInertia,
    Scalar,
    Screw,
    SpatialInertia,
    Vector,
    to_antecedent,
)


class Axis(Enum):
    """Spatial axis a_j of a joint [4]: along z, or none."""

    REVOLUTE = 0
    PRISMATIC = 1
    NONE = 2

    def screw(self, rate: Scalar) -> Pair:
        """rate a_j."""
        along = (0, 0, rate)
        return (along if self is Axis.PRISMATIC else ZERO, along if self is Axis.REVOLUTE else ZERO)

    def project(self, pair: Pair) -> Scalar:
        """a_j^T f of a wrench, or the component of a screw along the joint."""
        return pair[self is Axis.REVOLUTE][2]

    def with_along(self, pair: Pair, along: Scalar) -> Pair:
        """The same screw or wrench but for its component along the joint."""
        linear, angular = pair
        if self is Axis.REVOLUTE:
            return linear, (angular[0], angular[1], along)
        return (linear[0], linear[1], along), angular

    def column(self, inertia: SpatialInertia) -> Pair:
        """J a_j."""
        return inertia.angular_column() if self is Axis.REVOLUTE else inertia.linear_column()


@dataclass(frozen=True)
class Link:
    """Body j with the joint that carries it; `antecedent` 0 is the base."""

    antecedent: int
    axis: Axis
    placement: Placement
    body: RigidInertia = RigidInertia()
    rotor_inertia: Scalar = 0
    wrench: Pair = (ZERO, ZERO)

    @property
    def last_turn(self) -> Screw:
        """The turn by theta about z, last of the placement but for the shift along the same axis."""
        return self.placement[-1]._replace(shift=0)

    @property
    def unturned(self) -> Placement:
        """Placement of the frame that lacks the last turn: origin and axis z are those of frame j."""
        return (*self.placement[:-1], self.placement[-1]._replace(cosine=1, sine=0))

    def seen_unturned(self) -> Link:
        """The same body on the same joint, seen from the frame that lacks the last turn."""
        last = (self.last_turn,)
        wrench = to_antecedent(last, self.wrench[0]), to_antecedent(last, self.wrench[1])
        return replace(self, placement=self.unturned, body=self.body.to_antecedent(last), wrench=wrench)


@dataclass(frozen=True)
class Mechanism:
    """Links in table order and the motion of the base: V0 and V'0, gravity already subtracted.

    `body` is that of a base which is part of the machine; `None` for the ground.
    """

    links: tuple[Link, ...]
    velocity: Pair = (ZERO, ZERO)
    acceleration: Pair = (ZERO, ZERO)
    body: RigidInertia | None = None

    def numbered(self) -> enumerate[Link]:
        """(j, link j) from the base to the tips."""
        return enumerate(self.links, start=1)

    def map(self, convert: Callable[[Scalar], Scalar]) -> Mechanism:
        """The same mechanism in another arithmetic; the integers 0, 1, -1 of structure stay."""

        def scalar(x: Scalar) -> Scalar:
            return x if isinstance(x, int) and x in (0, 1, -1) else convert(x)

        def vector(v: Vector) -> Vector:
            return (scalar(v[0]), scalar(v[1]), scalar(v[2]))

        def pair(p: Pair) -> Pair:
            return vector(p[0]), vector(p[1])

        def rigid(body: RigidInertia) -> RigidInertia:
            return RigidInertia(scalar(body.mass), vector(body.moments), tuple(map(scalar, body.inertia)))

        links = tuple(
            Link(
                link.antecedent,
                link.axis,
                tuple(Screw(s.axis, *map(scalar, s[1:])) for s in link.placement),
                rigid(link.body),
                scalar(link.rotor_inertia),
                pair(link.wrench),
            )
            for link in self.links
        )
        base = None if self.body is None else rigid(self.body)
        return Mechanism(links, pair(self.velocity), pair(self.acceleration), base)


def without_loads(mechanism: Mechanism) -> Mechanism:
    """The mechanism on a base at rest, without gravity and external wrenches."""
    links = tuple(replace(link, wrench=(ZERO, ZERO)) for link in mechanism.links)
    return Mechanism(links, body=mechanism.body)
