"""Inverse dynamics and placements of MuJoCo, for machines read from MJCF.

What MuJoCo adds and no machine has is switched off: contacts, limits, tendons, fluid, gravity compensation. Dry
friction is a constraint there: it is added to MuJoCo's forces by its law.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import mujoco
import numpy as np

from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.formats.files import load_text
from symoro_elastic.formats.robots.converting import MJCF
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import free_name
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.valid_names import with_valid_names
from symoro_elastic.models.packaging import reserved_words, trace_models
from symoro_elastic.numerics.verification.implementations import import_package
from symoro_elastic.quantities.frames import JOINT, LINK, SITE

mujoco.set_mju_user_warning(lambda _: None)  # else it writes a file into the working folder
Array = np.ndarray[Any, np.dtype[np.float64]]
OFF = ("CONTACT", "LIMIT", "FRICTIONLOSS", "EQUALITY", "ACTUATION")
TENDONS = ("stiffness", "damping", "frictionloss", "armature")
MODELS = ("inverse_dynamics", "direct_dynamics", "geometric_model", "jacobian")


@dataclass(frozen=True)
class Errors:
    """Largest differences relative to the largest force, to the size of the robot, and to the largest acceleration.

    Frames are those of bodies, joints and sites, with the Jacobians of bodies and sites.
    """

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
    compared: set[tuple[str, str]] = field(default_factory=set)

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
        models = MODELS if machine.independent else MODELS[:-1]
        with tempfile.TemporaryDirectory() as folder:
            generated = import_package(render_numpy(trace_models(machine, Scene(models=models)).package), Path(folder))
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
    def has_balls(self) -> bool:
        """Whether a joint of MuJoCo is three rows of the machine."""
        return bool((self.model.jnt_type == mujoco.mjtJoint.mjJNT_BALL).any())

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
        """Of bodies, anchors of joints, and sites, by their names in the file."""
        base = np.eye(4)
        if self.machine.floating:
            base[:3, :3], base[:3, 3] = state["R0"].reshape(3, 3), (0.3, -0.2, 0.5)
        placed = base @ self.generated.geometric_model(state["q"])
        columns = self.generated.jacobian(state["q"]) if self.machine.independent else np.zeros((len(placed), 6, 0))
        size = max(np.abs(data.xanchor - base[:3, 3]).max(), np.abs(data.xpos - base[:3, 3]).max()) or 1.0
        found = [0.0]
        for what, name, T, jacobian in self._named(data):
            k = next((k for text in (f"{what} {name}", name) if (k := self._number(text)) is not None), None)
            if k is None:
                continue
            found.append(np.abs(placed[k, :3, 3] - T[:3, 3]).max() / size)
            if what != JOINT:
                found.append(np.abs(placed[k, :3, :3] - T[:3, :3]).max())
                J = np.concatenate([base[:3, :3] @ columns[k, :3], base[:3, :3] @ columns[k, 3:]])
                found.append(np.abs(J - self._of_coordinates(jacobian)).max(initial=0.0) / size)
                self.compared.add((what, name))
        return float(max(found))

    def _named(self, data: Any) -> Iterator[tuple[str, str, Array, Array]]:
        """Bodies, sites and joints with a name: placements in the world, and Jacobians by MuJoCo's velocities."""
        slid = data.xaxis * [self._slide(data, j) for j in range(self.model.njnt)]
        parts = (
            (LINK, "nbody", "body", data.xpos, data.xmat, mujoco.mj_jacBody),
            (SITE, "nsite", "site", data.site_xpos, data.site_xmat, mujoco.mj_jacSite),
            (JOINT, "njnt", "joint", data.xanchor + slid, None, None),
        )
        for what, count, kind, origins, axes, jacobian in parts:
            for name, k in self._names(count, kind).items():
                T, J = np.eye(4), np.zeros((6, self.model.nv))
                T[:3, 3] = origins[k]
                if jacobian:
                    T[:3, :3] = axes[k].reshape(3, 3)
                    jacobian(self.model, data, J[:3], J[3:], k)
                if name:
                    yield what, name, T, J

    def _slide(self, data: Any, j: int) -> list[float]:
        """How far a slide is from its reference, m, by which MuJoCo does not move its anchor."""
        at = self.model.jnt_qposadr[j]
        slides = self.model.jnt_type[j] == mujoco.mjtJoint.mjJNT_SLIDE
        return [data.qpos[at] - self.model.qpos0[at] if slides else 0.0]

    def _number(self, name: str) -> int | None:
        names = self.generated.FRAMES
        what, _, own = name.rpartition(" ")
        known = (x for x in (name, f"{what} {free_name(own)}".strip()) if x in names)
        return next(map(names.index, known), None)

    def _of_coordinates(self, jacobian: Array) -> Array:
        """The columns of the machine's coordinates, joints that follow others with theirs."""
        v = [int(self._joint(j).dofadr[0]) for j in self.machine.independent]
        found: Array = jacobian[:, v]
        return found

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
