"""Inverse dynamics and placements of MuJoCo, for machines read from MJCF.

What MuJoCo adds and no machine has is switched off: contacts, limits, tendons, fluid, gravity compensation. Dry
friction is a constraint there: it is added to MuJoCo's forces by its law.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import mujoco
import numpy as np

from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.formats.files import load_text
from symoro_elastic.formats.robots.robot_formats import MJCF
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.valid_names import with_valid_names
from symoro_elastic.models.packaging import reserved_words
from symoro_elastic.models.traced import trace_models
from symoro_elastic.numerics.implementations import import_package

mujoco.set_mju_user_warning(lambda _: None)  # else it writes a file into the working folder
Array = np.ndarray[Any, np.dtype[np.float64]]
OFF = ("CONTACT", "LIMIT", "FRICTIONLOSS", "EQUALITY", "ACTUATION")
TENDONS = ("stiffness", "damping", "frictionloss", "armature")
MODELS = ("inverse_dynamics", "direct_dynamics", "geometric_model")


@dataclass(frozen=True)
class Errors:
    """Largest differences relative to the largest force, to the size of the robot, and to the largest acceleration."""

    forces: float
    frames: float
    accelerations: float


@dataclass(eq=False)
class Compared:
    """A machine beside MuJoCo's model of its MJCF."""

    machine: Machine
    names: tuple[str, ...]
    generated: ModuleType
    model: Any

    @classmethod
    def of_file(cls, path: Path) -> Compared:
        """Read a file both ways."""
        raw = MJCF.read(load_text(path), str(path))
        machine = with_valid_names(raw, reserved_words())
        return cls._of(machine, tuple(joint.name for joint in raw.joints), mujoco.MjModel.from_xml_path(str(path)))

    @classmethod
    def of_text(cls, machine: Machine, text: str) -> Compared:
        """A machine beside the MJCF text that it was written to."""
        names = tuple(joint.name for joint in machine.joints)
        return cls._of(machine, names, mujoco.MjModel.from_xml_string(text))

    @classmethod
    def _of(cls, machine: Machine, names: tuple[str, ...], model: Any) -> Compared:
        check(machine)
        with tempfile.TemporaryDirectory() as folder:
            generated = import_package(render_numpy(trace_models(machine, Scene(models=MODELS)).package), Path(folder))
        return cls(machine, names, generated, modelled_part(model))

    def errors(self, states: int, seed: int = 1) -> Errors:
        """Worst errors at random states."""
        found = [self._errors(np.random.default_rng([seed, k])) for k in range(states)]
        return Errors(*(max(x) for x in zip(*((e.forces, e.frames, e.accelerations) for e in found), strict=True)))

    def _errors(self, rng: np.random.Generator) -> Errors:
        state, data = self._state(rng), mujoco.MjData(self.model)
        tau, *given = self.generated.inverse_dynamics(**state)
        self._put(data, state, *given)
        mujoco.mj_inverse(self.model, data)
        forces, frames = self._of_forces(data, state, tau), self._of_frames(data, state)
        del state["qdd_motor"]
        moved = self.generated.direct_dynamics(tau=tau, **state)
        self._put(data, state, *(moved if self.machine.floating else [moved]))
        found = data.qacc.copy()
        data.qfrc_applied[:], rows = self._applied(state, tau)
        mujoco.mj_forward(self.model, data)
        away = np.abs(found - data.qacc)[rows].max() / np.abs(data.qacc[rows]).max()
        return Errors(forces, frames, float(away))

    def _state(self, rng: np.random.Generator) -> dict[str, Array]:
        """Random arguments of the inverse model; those of a floating base too."""
        independent, motors = len(self.machine.independent), len(self.machine.motors)
        state = {"q": rng.uniform(-1.5, 1.5, independent), "qd": rng.uniform(-2, 2, independent)}
        state["qdd_motor"] = rng.uniform(-5, 5, motors)
        if self.machine.floating:
            rotation, quaternion = np.zeros(9), rng.normal(size=4)
            mujoco.mju_quat2Mat(rotation, quaternion / np.linalg.norm(quaternion))
            state |= {"R0": rotation, "V0": rng.uniform(-2, 2, 6), "f0": rng.uniform(-20, 20, 6)}
        return state

    def _put(self, data: Any, state: dict[str, Array], qdd: Array, *V0d: Array) -> None:
        """Give MuJoCo the positions, velocities and accelerations of a state."""
        for k, j in enumerate(self.machine.independent):
            joint = self._joint(j)
            data.qpos[joint.qposadr], data.qvel[joint.dofadr] = state["q"][k], state["qd"][k]
            data.qacc[joint.dofadr] = qdd[k]
        if self.machine.floating:
            R0, at, v = state["R0"].reshape(3, 3), self._free.qposadr[0], self._free.dofadr[0]
            mujoco.mju_mat2Quat(data.qpos[at + 3 : at + 7], state["R0"])
            data.qpos[at : at + 3] = (0.3, -0.2, 0.5)
            data.qvel[v : v + 6] = [*(R0 @ state["V0"][:3]), *state["V0"][3:]]
            data.qacc[v : v + 6] = [*(R0 @ V0d[0][:3]), *V0d[0][3:]]

    def _joint(self, j: int) -> Any:
        """MuJoCo's joint of a row; one without a name is that of the body after which the row is called."""
        name = self.names[j - 1]
        if name in self._names("njnt", "joint"):
            return self.model.joint(name)
        body = name.removesuffix("_joint")
        number = self._names("nbody", "body").get(body) or int(body.removeprefix("body"))
        return self.model.joint(int(self.model.body_jntadr[number]))

    @property
    def _free(self) -> Any:
        (number,) = np.flatnonzero(self.model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
        return self.model.joint(number)

    def _of_forces(self, data: Any, state: dict[str, Array], tau: Array) -> float:
        wanted, rows = self._applied(state, tau)
        terms = [data.qfrc_inverse, data.qfrc_bias, data.qfrc_passive]
        return float(np.abs(data.qfrc_inverse - wanted)[rows].max() / max(np.abs(x[rows]).max() for x in terms))

    def _applied(self, state: dict[str, Array], tau: Array) -> tuple[Array, list[int]]:
        """Forces of motors, dry friction and the wrench on the base on MuJoCo's velocities, and which are ours."""
        applied, rows = np.zeros(self.model.nv), []
        by_motor = dict(zip(self.machine.motors, tau, strict=True))
        for k, j in enumerate(self.machine.independent):
            v = self._joint(j).dofadr[0]
            rows.append(int(v))
            applied[v] = by_motor.get(j, 0.0) - self.model.dof_frictionloss[v] * np.sign(state["qd"][k])
        if self.machine.floating:
            v = self._free.dofadr[0]
            rows += range(v, v + 6)
            applied[v : v + 6] = [*(state["R0"].reshape(3, 3) @ state["f0"][:3]), *state["f0"][3:]]
        return applied, rows

    def _of_frames(self, data: Any, state: dict[str, Array]) -> float:
        """Of axes and anchors of joints, and of bodies on fixed rows."""
        placed = self.generated.geometric_model(state["q"])
        base = np.eye(4)
        if self.machine.floating:
            base[:3, :3], base[:3, 3] = state["R0"].reshape(3, 3), (0.3, -0.2, 0.5)
        frames = dict(zip(self.generated.FRAMES, base @ placed, strict=True))
        size = np.abs(data.xanchor - base[:3, 3]).max() or 1.0
        joints, bodies = self._names("njnt", "joint"), self._names("nbody", "body")
        found = [0.0]
        for row, name in zip(self.machine.joints, self.names, strict=True):
            T = frames.get(row.name)
            if T is not None and row.sigma == 2 and name in bodies:
                b = bodies[name]
                found += [np.abs(T[:3, :3].ravel() - data.xmat[b]).max(), np.abs(T[:3, 3] - data.xpos[b]).max() / size]
            elif T is not None and name in joints:
                found.append(np.abs(T[:3, 2] - data.xaxis[joints[name]]).max())
                apart = np.cross(T[:3, 3] - data.xanchor[joints[name]], T[:3, 2])
                found.append(np.abs(apart).max() / size if row.sigma == 0 else 0.0)
        return float(max(found))

    def _names(self, count: str, kind: str) -> dict[str, int]:
        return {getattr(self.model, kind)(k).name: k for k in range(getattr(self.model, count))}


def modelled_part(model: Any) -> Any:
    """The same model without what no machine has."""
    for name in OFF:
        model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{name}"))
    for key in TENDONS:
        getattr(model, f"tendon_{key}")[:] = 0
    model.opt.density = model.opt.viscosity = 0
    model.body_gravcomp[:] = 0
    return model
