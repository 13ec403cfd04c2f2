"""Generated numpy of a robot against Pinocchio's reading of the same URDF."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import ModuleType

import numpy as np

from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.formats.robots.joint_tree import Tree, tree_of
from symoro_elastic.formats.robots.modified_dh import SEAT
from symoro_elastic.formats.robots.urdf import describe
from symoro_elastic.machine.machine import Kind, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.traced import Traced, trace_models
from symoro_elastic.numerics.implementations import import_package
from symoro_elastic.symbolic.program import OperationCount
from tests.references.numbers_of_machine import Array
from tests.references.urdf_in_pinocchio import Robot, Values, random_motion


@dataclass(frozen=True)
class Errors:
    """Largest errors: torques relative to the largest of their state, frames in rad and in m by the robot's extent."""

    torques: float
    frames: float

    @property
    def worst(self) -> float:
        return max(self.torques, self.frames)


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
        return trace_models(self.machine, Scene(models=("inverse_dynamics", "geometric_model")))

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
    def row_of_joint(self) -> dict[str, int]:
        """Index of the row of each joint that moves."""
        rows = [j - 1 for j in self.machine.articulated]
        return dict(zip((joint.name for joint in self.tree.moving), rows, strict=True))

    @cached_property
    def row_of_leaf(self) -> dict[str, int]:
        """Index of the row of each link that a fixed joint carries and that carries nothing."""
        fixed = [(k, row) for k, row in enumerate(self.machine.joints) if row.kind is Kind.FIXED]
        rows = [k for k, row in fixed if not row.name.endswith(SEAT)]
        return dict(zip((joint.child for joint in self.tree.leaves), rows, strict=True))

    @cached_property
    def in_rows(self) -> dict[str, tuple[int | None, Array]]:
        """The row whose frame carries each link, None for frame 0, and the link's place in it: at position 0.

        A leaf has a row of its own, and is in it.
        """
        zero = dict.fromkeys(self.own, 0.0)
        ours, theirs = self.our_frames(zero), self.robot.frames(zero)
        found: dict[str, tuple[int | None, Array]] = {}
        for link in self.robot.links:
            joint = self.tree.carrying[link].joint
            leaf = link in self.row_of_leaf
            row = self.row_of_leaf[link] if leaf else self.row_of_joint[joint.name] if joint else None
            found[link] = row, np.eye(4) if leaf or row is None else np.linalg.inv(ours[row]) @ theirs[link]
        return found

    def our_frames(self, q: Values) -> Array:
        frames: Array = self.module.geometric_model([q[name] for name in self.own])
        return frames

    def our_torques(self, q: Values, qd: Values, qdd: Values) -> Array:
        state = ([x[name] for name in self.own] for x in (q, qd, qdd))
        torques: Array = self.module.inverse_dynamics(*state)[0]
        return torques

    def errors(self, states: int = 5, seed: int = 1) -> Errors:
        """The largest errors at random states."""
        rng = np.random.default_rng(seed)
        motions = [random_motion(self.robot, rng) for _ in range(states)]
        torques, frames = [0.0], [0.0]
        for motion in motions:
            wanted = np.array([*map(self.robot.torques(motion).get, self.own)])
            found = self.our_torques(motion.q, motion.qd, motion.qdd)
            torques.append(_relative(found - wanted, np.abs(wanted).max(initial=0.0)))
            ours, theirs = self.our_frames(motion.q), self.robot.frames(motion.q)
            extent = max(1.0, *(np.abs(T).max() for T in theirs.values()))
            for link, (row, place) in self.in_rows.items():
                if row is not None:
                    frames.append(float(np.abs(ours[row] @ place - theirs[link]).max()) / extent)
        return Errors(max(torques), max(frames))


class OfTable(ComparedRobot):
    """The same of the table alone, in Pinocchio, without generated code; no joint follows another."""

    def our_frames(self, q: Values) -> Array:
        from tests.references import pinocchio_model

        return pinocchio_model.frames(self.machine, [q[name] for name in self.own])

    def our_torques(self, q: Values, qd: Values, qdd: Values) -> Array:
        from tests.references import pinocchio_model

        position, velocity, acceleration = (np.array([x[name] for name in self.own]) for x in (q, qd, qdd))
        bias = pinocchio_model.bias_forces(self.machine, position, velocity)
        torques: Array = pinocchio_model.inertia_matrix(self.machine, position) @ acceleration + bias
        return torques


def _relative(difference: Array, scale: float) -> float:
    return float(np.abs(difference).max(initial=0.0) / scale) if scale else float(np.abs(difference).max(initial=0.0))
