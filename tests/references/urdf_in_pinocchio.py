"""A URDF as Pinocchio reads it: torques and frames by the names in the file, for robots on a fixed base.

Pinocchio takes joints that mimic others for free ones; here they follow, by the elements of the file, and their torques
act on the joints that they follow. Friction of joints is added outside. Callers do `pytest.importorskip("pinocchio")`.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin  # type: ignore[import-untyped, unused-ignore]

from symoro_elastic.quantities.frames import JOINT, LINK
from tests.references.numbers_of_machine import Array

Values = dict[str, float]


@dataclass(frozen=True)
class Motion:
    """Positions, velocities and accelerations of the joints with variables of their own."""

    q: Values
    qd: Values
    qdd: Values


@dataclass(frozen=True, eq=False)
class Robot:
    """The robot in a URDF text."""

    text: str
    model: Any = field(init=False)
    data: Any = field(init=False)

    def __post_init__(self) -> None:
        model = pin.buildModelFromXML(self.text)
        object.__setattr__(self, "model", model)
        object.__setattr__(self, "data", model.createData())

    @cached_property
    def joints(self) -> list[str]:
        """Names of all joints that move."""
        return [str(name) for name in self.model.names][1:]

    @property
    def own(self) -> list[str]:
        """Names of those with a variable of their own."""
        return [name for name in self.joints if name not in self.followed]

    @cached_property
    def followed(self) -> dict[str, tuple[str, float, float]]:
        """The joint that a joint mimics, multiplier and offset."""
        found = {}
        for joint in ET.fromstring(self.text.strip().encode()).findall("joint"):
            mimic = joint.find("mimic")
            if mimic is not None and joint.get("type") != "fixed":
                numbers = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
                found[str(joint.get("name"))] = (str(mimic.get("joint")), *numbers)
        return found

    @cached_property
    def named(self) -> dict[tuple[str, str], int]:
        """Numbers of the frames of links and joints, by what they are of and its name in the file."""
        kinds = {pin.FrameType.BODY: LINK, pin.FrameType.JOINT: JOINT, pin.FrameType.FIXED_JOINT: JOINT}
        frames = [(kinds.get(frame.type, ""), str(frame.name)) for frame in self.model.frames]
        return {key: number for number, key in enumerate(frames) if key[0] and key[1] not in ("universe", "root_joint")}

    def torques(self, motion: Motion) -> Values:
        """Forces of the motors, friction overcome."""
        q = self._position(self._every(motion.q, offsets=True))
        qd, qdd = (self._vector(self._every(x)) for x in (motion.qd, motion.qdd))
        tau = pin.rnea(self.model, self.data, q, qd, qdd)
        tau = tau + self.model.damping * qd + self.model.upperDryFrictionLimit * np.sign(qd)
        found = {name: float(tau[self._entry(name).idx_v]) for name in self.joints}
        for name in self.joints:
            leader, factor, _ = self._leader(name)
            if leader != name:
                found[leader] += factor * found[name]
        return {name: found[name] for name in self.own}

    def frames(self, q: Values) -> dict[tuple[str, str], tuple[Array, Array]]:
        """Placements (4, 4) of all frames in that of the root link, and Jacobians (6, own) in axes of it."""
        pin.computeJointJacobians(self.model, self.data, self._position(self._every(q, offsets=True)))
        pin.updateFramePlacements(self.model, self.data)
        return {key: (self.data.oMf[k].homogeneous.copy(), self._jacobian(k)) for key, k in self.named.items()}

    def _jacobian(self, frame: int) -> Array:
        J = pin.getFrameJacobian(self.model, self.data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED).reshape(6, -1)
        found: Array = np.zeros((6, len(self.own)))
        for name in self.joints:
            leader, factor, _ = self._leader(name)
            found[:, self.own.index(leader)] += factor * J[:, self._entry(name).idx_v]
        return found

    def _leader(self, name: str) -> tuple[str, float, float]:
        """The joint that a joint follows in the end, itself without any, the factor and the offset."""
        factor, offset = 1.0, 0.0
        while name in self.followed:
            name, by, plus = self.followed[name]
            factor, offset = factor * by, factor * plus + offset
        return name, factor, offset

    def _every(self, own: Mapping[str, float], offsets: bool = False) -> Values:
        """Values of all joints from those of the joints with variables of their own."""
        leaders = {name: self._leader(name) for name in self.joints}
        return {name: factor * own[leader] + offset * offsets for name, (leader, factor, offset) in leaders.items()}

    def _entry(self, name: str) -> Any:
        return self.model.joints[self.model.getJointId(name)]

    def _position(self, values: Values) -> Array:
        vector: Array = pin.neutral(self.model)
        for name, x in values.items():
            joint = self._entry(name)
            vector[joint.idx_q : joint.idx_q + joint.nq] = [x] if joint.nq == 1 else [np.cos(x), np.sin(x)]
        return vector

    def _vector(self, values: Values) -> Array:
        vector: Array = np.zeros(self.model.nv)
        for name, x in values.items():
            vector[self._entry(name).idx_v] = x
        return vector


def random_motion(robot: Robot, rng: np.random.Generator) -> Motion:
    """Any position, and velocities and accelerations of the order of 1."""
    q, qd, qdd = rng.normal(size=(3, len(robot.own)))
    return Motion(*(dict(zip(robot.own, x, strict=True)) for x in (2.0 * q, qd, qdd)))
