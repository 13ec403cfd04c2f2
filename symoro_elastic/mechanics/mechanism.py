"""A mechanism as the equations see it: transforms, axes and inertias, in any scalar."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

from symoro_elastic.mechanics.flexible_inertia import Modes
from symoro_elastic.mechanics.spatial import (
    AT_REST,
    NO_WRENCH,
    AxialTransform,
    Axis,
    Matrix,
    RigidInertia,
    Rotation,
    Scalar,
    SpatialVector,
    Symmetric,
    Transform,
    Twist,
    Vector,
    Wrench,
    rotated_matrix,
)

S = TypeVar("S", bound=SpatialVector)


@dataclass(frozen=True)
class Parallel:
    """Constant rotation `turn` between the axes of a link and those of an earlier link that stays parallel to it."""

    number: int
    turn: AxialTransform

    def components(self, v: Vector) -> Vector:
        """Components along the axes of the link of a vector given in those of the parallel link."""
        return self.turn.rotate_back(v)

    def entries(self, U: Matrix) -> Matrix:
        """Entries of a matrix in the axes of the link, given in those of the parallel link."""
        return rotated_matrix(self.turn._replace(sine=-self.turn.sine), U)


@dataclass(frozen=True)
class Link:
    """Body j with the joint that carries it; `antecedent` 0 is the base.

    `transform` is jTi [5], `wrench` what the body exerts on its surroundings, about its origin, in its frame. With
    `modes` the body is flexible, and `body` is the rigid one in deformed shape.
    """

    antecedent: int
    axis: Axis
    transform: Transform
    body: RigidInertia = RigidInertia()
    rotor_inertia: Scalar = 0
    wrench: Wrench = NO_WRENCH
    parallel: Parallel | None = None
    modes: Modes | None = None

    @property
    def joint_rotation(self) -> Rotation:
        """Rotation by theta about z, from the frame before the joint's rotation to frame j."""
        return Rotation(self.transform.steps[-1].rotation)

    @property
    def before(self) -> Transform:
        """Transform from frame i to the frame before the joint's rotation, with origin and axis z of frame j."""
        *steps, last = self.transform.steps
        return Transform((*steps, last.translation))

    def in_frame_before(self) -> Link:
        """The same body on the same joint, described in the frame before the joint's rotation."""
        rotation = self.joint_rotation
        wrench = rotation.T * self.wrench
        body = self.body.to_antecedent(Transform((rotation.step,)))
        return replace(self, transform=self.before, body=body, wrench=wrench, parallel=None)


@dataclass(frozen=True)
class Mechanism:
    """Links in table order and the motion of the base: V0 and V'0, gravity already subtracted.

    `body` is that of a base which is part of the machine, and `wrench` what it exerts on its surroundings; `None` for
    the ground.
    """

    links: tuple[Link, ...]
    velocity: Twist = AT_REST
    acceleration: Twist = AT_REST
    body: RigidInertia | None = None
    wrench: Wrench = NO_WRENCH

    def link(self, j: int) -> Link:
        """Link j; links are numbered from 1."""
        return self.links[j - 1]

    def from_base(self) -> enumerate[Link]:
        """(j, link j) from the base to the tips."""
        return enumerate(self.links, start=1)

    def from_tips(self) -> Iterator[tuple[int, Link]]:
        """(j, link j) from the tips to the base."""
        return ((j, self.link(j)) for j in range(len(self.links), 0, -1))

    @property
    def modes(self) -> dict[int, Modes]:
        """Flexible bodies by the number of each of their modes."""
        return {j: link.modes for link in self.links if link.modes is not None for j in link.modes.numbers}

    @property
    def carriers(self) -> set[int]:
        """Numbers of the links that carry others, 0 for the base."""
        return {link.antecedent for link in self.links}

    def scalars(self) -> Iterator[Scalar]:
        """All scalars that `map` converts, in its order."""
        bodies = [] if self.body is None else [self.body]
        scalars = (
            *(x for link in self.links for x in _scalars_of_link(link)),
            *(x for body in bodies for x in _scalars_of_body(body)),
            *self.velocity.entries,
            *self.acceleration.entries,
            *self.wrench.entries,
        )
        return (x for x in scalars if not _is_structure(x))

    def map(self, convert: Callable[[Scalar], Scalar]) -> Mechanism:
        """The mechanism in another arithmetic; the integers 0, 1, -1 of structure are unchanged."""

        def scalar(x: Scalar) -> Scalar:
            return x if _is_structure(x) else convert(x)

        def vector(v: Vector) -> Vector:
            return Vector(*map(scalar, v))

        def rigid(body: RigidInertia) -> RigidInertia:
            return RigidInertia(scalar(body.mass), vector(body.moments), Symmetric(*map(scalar, body.inertia)))

        def spatial(V: S) -> S:
            return type(V)(vector(V.linear), vector(V.angular))

        def convert_link(link: Link) -> Link:
            steps = (AxialTransform(step.axis, *map(scalar, step[1:])) for step in link.transform.steps)
            return Link(
                link.antecedent,
                link.axis,
                Transform(tuple(steps)),
                rigid(link.body),
                scalar(link.rotor_inertia),
                spatial(link.wrench),
                modes=link.modes and link.modes.map(scalar),
            )

        links = tuple(map(convert_link, self.links))
        base = None if self.body is None else rigid(self.body)
        return Mechanism(links, spatial(self.velocity), spatial(self.acceleration), base, spatial(self.wrench))


def _is_structure(x: Scalar) -> bool:
    return isinstance(x, int) and x in (0, 1, -1)


def _scalars_of_link(link: Link) -> tuple[Scalar, ...]:
    steps = (x for step in link.transform.steps for x in step[1:])
    modes = link.modes.scalars() if link.modes else ()
    return *steps, *_scalars_of_body(link.body), link.rotor_inertia, *link.wrench.entries, *modes


def _scalars_of_body(body: RigidInertia) -> tuple[Scalar, ...]:
    return body.mass, *body.moments, *body.inertia


def without_loads(mechanism: Mechanism) -> Mechanism:
    """The mechanism on a base at rest, without gravity and external wrenches."""
    links = tuple(replace(link, wrench=NO_WRENCH) for link in mechanism.links)
    return Mechanism(links, body=mechanism.body)
