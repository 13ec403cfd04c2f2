"""A robot as links and joints in placements at zero, as URDF and MJCF describe it.

The frame of a joint is that of its child link; the joint turns about its axis or moves along it, through the origin of
that frame. Units are SI, angles in radians. Arrays are of double precision, and as exact as the file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from enum import StrEnum
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import BodyShape
from symoro_elastic.machine.limits import JointLimits
from symoro_elastic.machine.names import quote

LARGEST = 1e50
"""Numbers beyond it are refused: what is made of their products would not be finite."""
EXPAND = "xacro, not URDF: expand it first, by `xacro FILE > robot.urdf`"
SPRING_OF_FOLLOWER = "it has a spring and follows another joint: move the spring to that joint"


class JointType(StrEnum):
    """Motion that a joint allows between its links."""

    REVOLUTE = "revolute"
    PRISMATIC = "prismatic"
    FIXED = "fixed"
    FLOATING = "floating"


@dataclass(frozen=True, eq=False)
class Placement:
    """Placement of a frame in another: `rotation` (3, 3), its columns the axes, and `translation` (3,), m."""

    rotation: Array = field(default_factory=lambda: np.eye(3))
    translation: Array = field(default_factory=lambda: np.zeros(3))

    def __mul__(self, other: Placement) -> Placement:
        """Return the composition: the placement of a frame that `other` places in the frame placed by this one."""
        return Placement(self.rotation @ other.rotation, self.rotation @ other.translation + self.translation)

    @property
    def matrix(self) -> Array:
        """The placement as a homogeneous matrix (4, 4)."""
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = self.rotation, self.translation
        return T

    @property
    def inverse(self) -> Placement:
        """Return the inverse placement, of the reference frame in the placed one."""
        return Placement(self.rotation.T, -self.rotation.T @ self.translation)


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid link: mass, kg; its center (3,), m, and inertia about it (3, 3), kg m2, in axes of the link's frame.

    `frame_only` says that the file gives no inertia; `shapes` are what it looks like, in its frame.
    """

    name: str
    mass: float = 0.0
    center: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))
    frame_only: bool = True
    shapes: tuple[BodyShape, ...] = ()


@dataclass(frozen=True)
class Mimicked:
    """Law of a following joint: multiplier times the other joint's position, plus offset.

    `powers` are the factors of the second and further powers of that position.
    """

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0
    powers: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class LinkJoint:
    """A joint between two links; `placement` is that of the child's frame in the parent's at position 0.

    `axis` (3,) is in the child's frame. `stiffness`, `neutral` position, `damping`, `friction` (dry) and
    `rotor_inertia` are those of the joint's coordinate, and so are `limits`. `driven` says that a motor is there,
    `ball` is the damping of the ball joint that this joint and the two before it make.
    """

    name: str
    type: JointType
    parent: str
    child: str
    placement: Placement = field(default_factory=Placement)
    axis: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))
    stiffness: float = 0.0
    neutral: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    rotor_inertia: float = 0.0
    driven: bool = True
    follows: Mimicked | None = None
    limits: JointLimits = JointLimits()
    ball: float = 0.0


class Holding(StrEnum):
    """What a connection makes coincide: origins, origins and z axes (a hinge), or complete frames."""

    POINT = "point"
    AXIS = "axis"
    FRAME = "frame"


@dataclass(frozen=True, eq=False)
class Connection:
    """Connection of two links by frames that coincide, which closes a loop.

    `on_first` and `on_second` place the frames that coincide in the links' frames, as far as `holding` says. `start`
    gives positions by joint at which they coincide, rad or m: they select the branch.
    """

    name: str
    first: str
    second: str
    on_first: Placement
    on_second: Placement
    holding: Holding = Holding.POINT
    start: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class PlacedFrame:
    """A frame of the file: its name, `what` has it (a link, a joint or a site), and its `placement` on a link."""

    name: str
    what: str
    link: str
    placement: Placement = field(default_factory=Placement)


@dataclass(frozen=True)
class Description:
    """A robot: links, joints from parents to children, and connections that close loops.

    `frames` are those that the file names: of links, of joints, which are those of their child links, and of sites.
    `gravity` is in the frame of the root link, m/s2. `remarks` say, a line each, what the file holds and the
    description does not.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[LinkJoint, ...]
    connections: tuple[Connection, ...] = ()
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    remarks: tuple[str, ...] = ()
    frames: tuple[PlacedFrame, ...] = ()


def refuse_out_of_range(description: Description, source: str) -> None:
    """Raise `InputError` that names the link or the joint for a number that is not finite, or beyond 1e50."""
    kinds: Mapping[str, tuple[Link | LinkJoint | Connection, ...]]
    kinds = {"joint": description.joints, "link": description.links, "connection": description.connections}
    for kind, parts in kinds.items():
        for part in parts:
            for key, number in _numbers(part):
                if not np.all(np.abs(number) < LARGEST):
                    what = f"{key} holds a number that is not finite, or beyond {LARGEST:g}"
                    raise InputError(source, f"{kind} {quote(part.name)}", what)


def _numbers(part: Any) -> Iterator[tuple[str, Array]]:
    """Yield the numbers of a link, a joint or a connection by the name of the field; models exclude shapes."""
    for key in fields(part):
        if key.name == "shapes":
            continue
        value = getattr(part, key.name)
        if isinstance(value, Placement | Mimicked):
            yield from ((key.name, number) for _, number in _numbers(value))
        elif isinstance(value, float | tuple | np.ndarray):
            yield key.name, np.asarray(value, dtype=float)
