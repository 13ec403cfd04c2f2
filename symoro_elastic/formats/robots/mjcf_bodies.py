"""The bodies of a compiled MJCF model that are a robot, and the freedoms of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from symoro_elastic.formats.robots.mjcf_model import Compiled
from symoro_elastic.formats.robots.robot import JointType, Placement
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.names import distinct, quote

WORLD = "world"
TYPES = {"mjJNT_HINGE": JointType.REVOLUTE, "mjJNT_SLIDE": JointType.PRISMATIC, "mjJNT_FREE": JointType.FLOATING}


@dataclass(frozen=True, eq=False)
class Freedom:
    """One degree of freedom of a body, or the six of a floating body.

    `number` is that of the joint in MuJoCo; `axis` and `anchor` (3,) are in axes of the body, `reference` is the
    position, rad or m, at which the body stands as the file places it.
    """

    number: int
    name: str
    type: JointType
    axis: Array
    anchor: Array
    reference: float


@dataclass(frozen=True, eq=False)
class Bodies:
    """The bodies of a model by their numbers; 0 is the world.

    A free body is the base of a robot that floats, or an object next to a fixed robot. What stands still and
    carries nothing that moves is scenery.
    """

    compiled: Compiled

    @property
    def model(self) -> Any:
        """The compiled model of MuJoCo."""
        return self.compiled.model

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the bodies, that of the world first; one without a name gets its number."""
        names = [self.model.body(b).name for b in range(self.model.nbody)]
        return (WORLD, *(name or distinct(f"body{b}", names) for b, name in enumerate(names[1:], start=1)))

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints; one without a name gets that of its body."""
        names = [self.model.joint(j).name for j in range(self.model.njnt)]
        for j, name in enumerate(names):
            names[j] = name or distinct(f"{self.names[self.model.jnt_bodyid[j]]}_joint", names)
        return tuple(names)

    @cached_property
    def modelled(self) -> tuple[int, ...]:
        """Numbers of the bodies of the robot: each after the one that carries it."""
        roots = self._moving_roots - {*self.objects}
        at_rest = set(range(1, self.model.nbody)) - self._carrying
        still = {b for b in at_rest if self.model.body_weldid[b] == 0}
        return tuple(b for b in range(1, self.model.nbody) if self.model.body_rootid[b] in roots and b not in still)

    @cached_property
    def objects(self) -> tuple[int, ...]:
        """Numbers of the free bodies, such as objects, in addition to a robot that is fixed to the world."""
        free_roots = sorted(b for b in self._moving_roots if self.is_free(b))
        if len(free_roots) < len(self._moving_roots):
            return tuple(free_roots)
        if len(free_roots) > 1:
            listed = ", ".join(quote(self.names[b]) for b in free_roots[:5])
            raise self.compiled.error("bodies", f"{listed} float independently: leave one machine in the file")
        if not free_roots:
            raise self.compiled.error("bodies", "no joint: nothing moves")
        return ()

    def is_free(self, b: int) -> bool:
        """Whether a body floats."""
        first = self.model.body_jntadr[b]
        return bool(self.model.body_jntnum[b]) and self.type_of(first) is JointType.FLOATING

    def freedoms(self, b: int) -> tuple[Freedom, ...]:
        """The degrees of freedom of a body, in order from its parent outwards."""
        first = self.model.body_jntadr[b]
        return tuple(freedom for j in range(first, first + self.model.body_jntnum[b]) for freedom in self._freedoms(j))

    def on_link(self, b: int) -> Placement:
        """Placement of the frame of a body in the frame of its link."""
        freedoms = self.freedoms(b)
        return Placement(translation=-freedoms[-1].anchor) if freedoms else Placement()

    def seat(self, b: int) -> Placement:
        """Placement of a body's frame in its parent's frame, as stated in the file."""
        return Placement(self.rotation(self.model.body_quat[b]), self.model.body_pos[b].copy())

    def place(self, b: int) -> tuple[str, Placement] | None:
        """Link that a body belongs to, and the placement of the body's frame in it; None for omitted bodies.

        Scenery is on the world.
        """
        if b in self.modelled:
            return self.names[b], self.on_link(b)
        placement = Placement()
        while b:
            if self.model.body_weldid[b] != 0 or self.model.body_mocapid[b] >= 0:
                return None
            placement = self.seat(b) * placement
            b = self.model.body_parentid[b]
        return WORLD, placement

    def rotation(self, quaternion: Array) -> Array:
        """The rotation matrix (3, 3) of a unit quaternion, its scalar part first."""
        matrix = np.zeros(9)
        self.compiled.mujoco.mju_quat2Mat(matrix, quaternion)
        return matrix.reshape(3, 3)

    def about(self, axis: Array, angle: float) -> Array:
        """The rotation matrix (3, 3) about a unit axis."""
        quaternion = np.zeros(4)
        self.compiled.mujoco.mju_axisAngle2Quat(quaternion, axis, angle)
        return self.rotation(quaternion)

    @cached_property
    def _moving_roots(self) -> set[int]:
        """Numbers of the bodies on the world with joints in their subtrees."""
        return {int(self.model.body_rootid[b]) for b in range(1, self.model.nbody) if self.model.body_jntnum[b]}

    @cached_property
    def _carrying(self) -> set[int]:
        """Numbers of the bodies with joints, and of their ancestors."""
        bodies: set[int] = set()
        for b in range(self.model.nbody - 1, 0, -1):
            if self.model.body_jntnum[b] or b in bodies:
                bodies |= {b, int(self.model.body_parentid[b])}
        return bodies

    def type_of(self, j: int) -> JointType | None:
        """The type of a joint; None for a ball joint."""
        return TYPES.get(self.compiled.mujoco.mjtJoint(self.model.jnt_type[j]).name)

    def _freedoms(self, j: int) -> Iterator[Freedom]:
        """The freedom of a joint, or the three of a ball joint: turns about x, y and z of the body."""
        name, kind = self.joint_names[j], self.type_of(j)
        anchor = self.model.jnt_pos[j].copy() if kind is not JointType.FLOATING else np.zeros(3)
        if kind is None:
            for axis, unit in zip("xyz", np.eye(3), strict=True):
                yield Freedom(j, distinct(f"{name}_{axis}", self.joint_names), JointType.REVOLUTE, unit, anchor, 0.0)
            return
        reference = 0.0 if kind is JointType.FLOATING else float(self.model.qpos0[self.model.jnt_qposadr[j]])
        yield Freedom(j, name, kind, self.model.jnt_axis[j].copy(), anchor, reference)
