"""Forces on the joints of a compiled MJCF model: springs, damping, friction, rotors and actuators."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from symoro_elastic.formats.robots.mjcf_bodies import Bodies, Freedom
from symoro_elastic.formats.robots.robot import LARGEST, JointType
from symoro_elastic.machine.limits import JointLimits, range_of
from symoro_elastic.machine.names import quote

ON_JOINTS = ("mjTRN_JOINT", "mjTRN_JOINTINPARENT")


@dataclass(frozen=True, eq=False)
class Forces:
    """What acts on the joints of a model."""

    bodies: Bodies

    def on(self, freedom: Freedom) -> dict[str, Any]:
        """The forces on a joint that turns or slides, as fields of its `LinkJoint`; raises `InputError`.

        Inertia and damping of actuators are as the joint feels them: times the square of the gear.
        """
        model, j = self.bodies.model, freedom.number
        if reason := next(self._faults(freedom), None):
            raise self.bodies.compiled.error(f"joint {quote(self.bodies.joint_names[j])}", reason)
        if self._is_ball(freedom):
            return {"driven": False}
        v, actuators = model.jnt_dofadr[j], self.actuators.get(j, [])
        gears = [(a, float(model.actuator_gear[a][0])) for a in actuators]
        stiffness = 0.0 if self.off("SPRING") else float(model.jnt_stiffness[j])
        damping = model.dof_damping[v] + sum(gear**2 * model.actuator_damping[a] for a, gear in gears)
        return {
            "stiffness": stiffness,
            "neutral": float(model.qpos_spring[model.jnt_qposadr[j]]) if stiffness else 0.0,
            "damping": 0.0 if self.off("DAMPER") else float(damping),
            "friction": 0.0 if self.off("FRICTIONLOSS") or self.off("CONSTRAINT") else float(model.dof_frictionloss[v]),
            "rotor_inertia": float(model.dof_armature[v] + sum(g**2 * model.actuator_armature[a] for a, g in gears)),
            "driven": bool(actuators) or (not model.nu and not stiffness),
        }

    def limits(self, freedom: Freedom) -> JointLimits:
        """The limits of a joint that turns or slides: its position, and the torque that its actuators give together."""
        if self._is_ball(freedom) or freedom.type is JointType.FLOATING:
            return JointLimits()
        model, j = self.bodies.model, freedom.number
        torques = [self._torques(a) for a in self.actuators.get(j, ())]
        low, high = sum((x for x, _ in torques), 0.0), sum((x for _, x in torques), 0.0)
        if model.jnt_actfrclimited[j]:
            least, most = map(float, model.jnt_actfrcrange[j])
            low, high = max(low, least), min(high, most)
        least, most = map(float, model.jnt_range[j])
        position = range_of(least, most, LARGEST) if model.jnt_limited[j] and not self.off("LIMIT") else None
        return JointLimits(position, torque=range_of(low, high, LARGEST) if torques else None)

    def _torques(self, a: int) -> tuple[float, float]:
        """The least and largest torque, or force, of an actuator on its joint; infinite where the file does not say."""
        model = self.bodies.model
        low, high = -math.inf, math.inf
        if model.actuator_forcelimited[a]:
            low, high = map(float, model.actuator_forcerange[a])
        if model.actuator_ctrllimited[a] and not self._has_law(a):
            gain = float(model.actuator_gainprm[a][0])
            least, most = sorted(gain * float(x) for x in model.actuator_ctrlrange[a])
            low, high = max(low, least), min(high, most)
        gear = float(model.actuator_gear[a][0])
        first, second = (gear * x if gear else 0.0 for x in (low, high))
        return min(first, second), max(first, second)

    def _has_law(self, a: int) -> bool:
        """Whether the force of an actuator is more than its control times a number."""
        model = self.bodies.model
        return bool(model.actuator_dyntype[a] or model.actuator_gaintype[a] or model.actuator_biastype[a])

    def off(self, name: str) -> bool:
        """Whether the options of the file disable something, by MuJoCo's name."""
        flag = getattr(self.bodies.compiled.mujoco.mjtDisableBit, f"mjDSBL_{name}")
        return bool(self.bodies.model.opt.disableflags & int(flag))

    @cached_property
    def actuators(self) -> dict[int, list[int]]:
        """Numbers of the actuators on each joint that turns or slides."""
        found: dict[int, list[int]] = {}
        for a in range(self.bodies.model.nu):
            if a not in self.elsewhere:
                found.setdefault(int(self.bodies.model.actuator_trnid[a][0]), []).append(a)
        return found

    @cached_property
    def elsewhere(self) -> tuple[int, ...]:
        """Numbers of the actuators that act on a tendon, a body, or on a joint of several freedoms."""
        return tuple(a for a in range(self.bodies.model.nu) if not self._is_on_joint(a))

    def is_more_than_torque(self, a: int) -> bool:
        """Whether the control of an actuator is not the torque, or force, on its joint."""
        model = self.bodies.model
        return self._has_law(a) or model.actuator_gainprm[a][0] != 1 or model.actuator_gear[a][0] != 1

    def _is_on_joint(self, a: int) -> bool:
        """Whether an actuator acts on a joint that turns or slides."""
        kind = self.bodies.compiled.mujoco.mjtTrn(self.bodies.model.actuator_trntype[a]).name
        simple = (JointType.REVOLUTE, JointType.PRISMATIC)
        return kind in ON_JOINTS and self.bodies.type_of(self.bodies.model.actuator_trnid[a][0]) in simple

    def _is_ball(self, freedom: Freedom) -> bool:
        return freedom.name != self.bodies.joint_names[freedom.number]

    def _faults(self, freedom: Freedom) -> Iterator[str]:
        """What is not a force of a machine, and the way out."""
        model, j = self.bodies.model, freedom.number
        v = model.jnt_dofadr[j]
        several = 6 if freedom.type is JointType.FLOATING else 3 if self._is_ball(freedom) else 0
        if model.jnt_stiffnesspoly[j].any():
            yield "its stiffness is a polynomial of the deflection: only linear springs are modelled, give one number"
        if model.dof_dampingpoly[v].any() or any(
            model.actuator_dampingpoly[a].any() for a in self.actuators.get(j, [])
        ):
            yield "its damping is a polynomial of the velocity: only linear damping is modelled, give one number"
        if model.jnt_plasticadr[j] >= 0:
            yield "its spring yields: only elastic springs are modelled, remove springyield"
        if not several:
            return
        kind = "free" if several == 6 else "ball"
        given = {
            "stiffness": model.jnt_stiffness[j],
            "damping": model.dof_damping[v : v + several].any(),
            "armature": model.dof_armature[v : v + several].any(),
            "frictionloss": model.dof_frictionloss[v : v + several].any(),
        }
        for key, value in given.items():
            if value:
                yield f"it is a {kind} joint with {key}, which is not modelled: write {key} = 0"
