"""Generated numpy of a robot against Pinocchio's reading of the same URDF."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import ModuleType

import numpy as np

from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.formats.robots.joint_tree import Tree, tree_of
from symoro_elastic.formats.robots.robot import Placement
from symoro_elastic.formats.robots.urdf import describe, rotation
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import free_name
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import Traced, trace_models
from symoro_elastic.numerics.verification.implementations import import_package, numpy_model
from symoro_elastic.quantities.frames import BASE
from symoro_elastic.symbolic.program import OperationCount
from tests.references.numbers_of_machine import Array
from tests.references.urdf_in_pinocchio import Robot, Values, random_motion


@dataclass(frozen=True)
class Errors:
    """Largest errors: torques relative to the largest of their state, frames in rad and in m by the robot's extent.

    Frames are those of all links and joints of the file, by their names, with the Jacobians.
    """

    torques: float
    frames: float
    jacobians: float = 0.0

    @property
    def worst(self) -> float:
        return max(self.torques, self.frames, self.jacobians)


@dataclass(frozen=True, eq=False)
class ComparedRobot:
    """A machine that is to be the robot of a URDF text, on a fixed base, all joints driven."""

    text: str
    machine: Machine
    robot: Robot = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "robot", Robot(self.text))

    @cached_property
    def tree(self) -> Tree:
        return tree_of(describe(self.text, "robot.urdf"), "robot.urdf")

    @cached_property
    def traced(self) -> Traced:
        return trace_models(self.machine, Scene(models=("inverse_dynamics", "geometric_model", "jacobian")))

    @cached_property
    def module(self) -> ModuleType:
        with tempfile.TemporaryDirectory() as folder:
            return import_package(render_numpy(self.traced.package), Path(folder))

    @property
    def operations(self) -> OperationCount:
        """Of the inverse model."""
        return self.traced.models[0].program.count

    @cached_property
    def own(self) -> list[str]:
        """Joints of the file with a variable, in the order of the rows."""
        return [joint.name for joint in self.tree.moving if joint.follows is None]

    @cached_property
    def frame_of(self) -> dict[tuple[str, str], int]:
        """Index among our frames of each link and joint of the file."""
        numbers = {name: k for k, name in enumerate(self.our_names)}
        return {key: numbers[_known(numbers, *key)] for key in self.robot.named}

    @property
    def our_names(self) -> list[str]:
        """Names of our frames, frame 0 last; of a row and a frame of one name the frame."""
        return [*self.module.FRAMES, BASE]

    def our_frames(self, q: Values) -> tuple[Array, Array | None]:
        """Placements of our frames, and their Jacobians where there are some."""
        position = [q[name] for name in self.own]
        T, J = self.module.geometric_model(position), self.module.jacobian(position)
        return np.concatenate([T, np.eye(4)[None]]), np.concatenate([J, np.zeros((1, 6, len(self.own)))])

    def our_torques(self, q: Values, qd: Values, qdd: Values) -> Array:
        state = ([x[name] for name in self.own] for x in (q, qd, qdd))
        torques: Array = self.module.inverse_dynamics(*state)[0]
        return torques

    def errors(self, states: int = 5, seed: int = 1) -> Errors:
        """The largest errors at random states."""
        rng = np.random.default_rng(seed)
        motions = [random_motion(self.robot, rng) for _ in range(states)]
        torques, frames, jacobians = [0.0], [0.0], [0.0]
        for motion in motions:
            wanted = np.array([*map(self.robot.torques(motion).get, self.own)])
            found = self.our_torques(motion.q, motion.qd, motion.qdd)
            torques.append(_relative(found - wanted, np.abs(wanted).max(initial=0.0)))
            (T, J), theirs = self.our_frames(motion.q), self.robot.frames(motion.q)
            extent = max(1.0, *(np.abs(placed).max() for placed, _ in theirs.values()))
            order = [self.own.index(name) for name in self.robot.own]
            for key, (placed, columns) in theirs.items():
                frames.append(float(np.abs(T[self.frame_of[key]] - placed).max()) / extent)
                if J is not None:
                    jacobians.append(float(np.abs(J[self.frame_of[key]][:, order] - columns).max(initial=0.0)) / extent)
        return Errors(max(torques), max(frames), max(jacobians))

    def acceleration_error(self, states: int = 5, seed: int = 1) -> float:
        """The largest error of direct dynamics from Pinocchio's torques, relative to the largest acceleration."""
        rng, model, errors = np.random.default_rng(seed), numpy_model(self.machine, ("direct_dynamics",)), [0.0]
        for motion in (random_motion(self.robot, rng) for _ in range(states)):
            torques = self.robot.torques(motion)
            q, qd, tau, qdd = ([x[name] for name in self.own] for x in (motion.q, motion.qd, torques, motion.qdd))
            errors.append(_relative(model.direct_dynamics(q, qd, tau) - qdd, np.abs(qdd).max(initial=0.0)))
        return max(errors)


def _known(names: Mapping[str, int], what: str, name: str) -> str:
    """The name of the frame of a link or a joint of the file, which may have been changed."""
    texts = (x for text in (name, free_name(name)) for x in (f"{what} {text}", text) if x in names)
    return next(texts)


class OfTable(ComparedRobot):
    """The same of the table alone, in Pinocchio, without generated code; no joint follows another."""

    @property
    def our_names(self) -> list[str]:
        return [*(joint.name for joint in self.machine.joints), *(frame.name for frame in self.machine.frames), BASE]

    def our_frames(self, q: Values) -> tuple[Array, None]:
        from tests.references import pinocchio_model

        T = [*pinocchio_model.frames(self.machine, [q[name] for name in self.own])]
        for frame in self.machine.frames:
            row = next((k for k, joint in enumerate(self.machine.joints) if joint.name == frame.on), None)
            at, rpy = ([x.value() for x in cells] for cells in (frame.at, frame.rpy))
            placed = Placement(rotation(*rpy), np.array(at)).matrix
            T.append(placed if row is None else T[row] @ placed)
        return np.array([*T, np.eye(4)]), None

    def our_torques(self, q: Values, qd: Values, qdd: Values) -> Array:
        from tests.references import pinocchio_model

        position, velocity, acceleration = (np.array([x[name] for name in self.own]) for x in (q, qd, qdd))
        bias = pinocchio_model.bias_forces(self.machine, position, velocity)
        torques: Array = pinocchio_model.inertia_matrix(self.machine, position) @ acceleration + bias
        return torques


def _relative(difference: Array, scale: float) -> float:
    return float(np.abs(difference).max(initial=0.0) / scale) if scale else float(np.abs(difference).max(initial=0.0))
