"""The right-hand side of a motion, and its derivatives, compiled, with or without a freely moving base.

    y' = [v; qdd(q, v, t)],    dy'/dy = [0 I; -M^-1 K, -M^-1 D]

M, D, K are those of the model `linearization`, with the gains of servos; y holds the joints that do not follow exactly.
States of friction follow them. Friction that rises with the torque through a joint is found with that torque, by
substitution. Derivatives then are differences, as the linear model has none of both.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Self

import numpy as np

from symoro_elastic.analysis.simulation.compiled_steps import (
    law_of_servos,
    refuse_still,
    under_loads,
    with_servo_torques,
)
from symoro_elastic.analysis.simulation.moving_base import quaternion, rotation_at, rotations, turning
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.codegen.compile import CompiledPackage, compile_library
from symoro_elastic.codegen.package import EXTERNAL, Package
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.bound.state import State, closing_models
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.models.steps.time_steps import (
    MOTOR_COORDINATES,
    dependent_motors,
    motor_coordinates,
    passed_torques,
)

DIFFERENCE = 1e-7
"""Of the state, for derivatives."""
FLAGS = ("-O1",)
"""More would save less than calls from Python cost."""


class CompiledMotion:
    """The right-hand side of a motion and its derivatives."""

    linear_models: tuple[str, ...] = ("linearization",)
    explicit = "DOP853"
    """The method for motions that are not stiff."""

    def __init__(self, reference: Reference, folder: Path) -> None:
        """Compile the motion; raises `InputError`, `CompilerMissing`, `CompilationFailed`."""
        refuse_still(reference)
        self.reference, machine = reference, reference.machine
        self.dynamics = "inverse_dynamics" if reference.servo is None else "direct_dynamics"
        self.closing = closing_models(machine)
        models = (self.dynamics, *self.linear_models, *self.closing)
        package = _package(reference.loaded, Scene(models=models, fold=ALL))
        self._compiled = CompiledPackage(package, compile_library(render_c(package), folder, flags=FLAGS))
        self._arguments = {f.name: {argument.name for argument in f.arguments} for f in package.functions}
        self._external = {EXTERNAL} & self._arguments[self.dynamics]
        self.motors = list(machine.motor_entries)
        driven = self.motors if reference.servo is None else []
        self.free = [k for k in range(len(machine.independent)) if k not in driven]
        self.largest_bent = np.array(machine.largest_deflections)
        self.has_linear_model = not machine.bristles and not machine.loaded

    @property
    def of_motion(self) -> int:
        """Number of entries of y before the states of friction."""
        return 2 * len(self.free)

    @property
    def bristles(self) -> slice:
        """The entries of y that are deflections of bristles."""
        return slice(self.of_motion, self.of_motion + len(self.largest_bent))

    @property
    def start(self) -> Array:
        """The state y at the start, with undeflected bristles."""
        state = self.reference.start
        return np.concatenate([state.q[self.free], state.qd[self.free], 0 * self.largest_bent])

    @property
    def sizes(self) -> Array:
        """Scales of the entries of y for relative errors."""
        return np.concatenate([np.ones(self.of_motion), self.largest_bent])

    @property
    def intervals(self) -> Iterable[tuple[float, float]]:
        """Time intervals with a smooth right-hand side."""
        return [(0.0, self.reference.duration)]

    def copy_at_start(self) -> Self:
        """Return the motion from its start."""
        return self

    def begin(self, number: int, t: float, y: Array) -> None:
        """Start interval `number` at time t with state y."""

    def states_of_joints(self, t: Array, y: Array) -> tuple[Array, Array]:
        """Return q, qd (N, n) of all joints at times (N,) and y."""
        f = len(self.free)
        if self.reference.servo is not None:
            return y[:, :f], y[:, f : 2 * f]
        q, qd, _ = self.reference.states(t)
        q[:, self.free], qd[:, self.free] = y[:, :f], y[:, f : 2 * f]
        return q, qd

    def states(self, t: Array, y: Array, near: State) -> Motion:
        """Return the states at times (N,) and y; loops are closed successively, from a state `near` the first."""
        q, qd = self.states_of_joints(t, y)
        wrenches = {name: self.reference.wrenches(t)[0] for name in self._external}
        bent = {"z": y[:, self.bristles]} if len(self.largest_bent) else {}
        motion = Motion({"q": q, "qd": qd, **bent, **wrenches, **self.base(y)}, t)
        for model in self.closing:
            closed = [near := State(self._compiled.call(model, q=x, q_dep=near.q_dep)) for x in q]
            motion = motion.with_blocks(q_dep=np.array([state.q_dep for state in closed]))
        return motion

    def base(self, y: Array) -> dict[str, Array]:
        """Return the blocks of a freely moving base at y; empty here."""
        return {}

    def rate(self, t: float, y: Array, near: State) -> Array:
        """Return the time derivative y', with loops closed iteratively from a state `near`."""
        motion = self.states(np.array([t]), y[None], near)
        rates = self.accelerations(motion, y[None])
        return np.concatenate([motion.qd[0, self.free], rates["qdd"][0, self.free], *rates.get("zd", ())])

    def jacobian(self, t: float, y: Array, near: State) -> Array:
        """Return the Jacobian dy'/dy, with loops closed iteratively from a state `near`.

        Of a servo on a dependent joint kd dS_m/dt is left out, by which the rate of the motor changes with positions.
        """
        if not self.has_linear_model:
            return self.differences(t, y, near)
        motion = self.states(np.array([t]), y[None], near)
        M, D, K = self.matrices(motion, y[None])
        if self.reference.servo is not None:
            S_m = self.slopes(motion)
            K, D = (matrix + S_m.T * x @ S_m for matrix, x in zip((K, D), self.reference.servo, strict=True))
        rows, f = np.ix_(self.free, self.free), len(self.free)
        J = np.zeros((2 * f, 2 * f))
        J[:f, f:] = np.eye(f)
        J[f:] = -np.linalg.solve(M[rows], np.hstack([K[rows], D[rows]]))
        return J

    def differences(self, t: float, y: Array, near: State) -> Array:
        """Return the Jacobian dy'/dy by central differences."""
        steps = DIFFERENCE * np.maximum(self.sizes, np.abs(y))
        columns = [
            (self.rate(t, y + h * e, near) - self.rate(t, y - h * e, near)) / (2 * h)
            for h, e in zip(steps, np.eye(len(y)), strict=True)
        ]
        return np.stack(columns, axis=1)

    def matrices(self, motion: Motion, y: Array) -> tuple[Array, Array, Array]:
        """Return M, D, K (n, n) of the machine at one state."""
        moved = motion.with_blocks(qdd=self.accelerations(motion, y)["qdd"], tau=self.torques(motion, y))
        matrices = self.call("linearization", moved)
        return matrices["M"][0], matrices["D"][0], matrices["K"][0]

    def accelerations(self, motion: Motion, y: Array) -> dict[str, Array]:
        """Return qdd, and the acceleration of a freely moving base, with motors as in the reference."""
        if self.reference.servo is None:
            return self.under_loads(motion.with_blocks(qdd_motor=self.reference.at(motion.t)[2]))
        return self.under_loads(motion.with_blocks(tau=self.torques(motion, y)))

    def under_loads(self, motion: Motion) -> dict[str, Array]:
        """Return the results of the dynamic model, and the torques `load` through joints with load-dependent friction.

        Raises `InputError` where these do not settle.
        """
        return under_loads(self.reference.machine, self.call, self.dynamics, motion)

    def torques(self, motion: Motion, y: Array) -> Array:
        """Return the torques (N, m) of servos at y; NaN for exactly prescribed motors."""
        if self.reference.servo is None:
            return with_servo_torques(self.reference, motion).tau
        return law_of_servos(self.reference, motion.t, *self.of_motors(motion))

    def of_motors(self, motion: Motion) -> tuple[Array, Array]:
        """Return positions and rates (N, m) of the motors."""
        if MOTOR_COORDINATES not in self._arguments:
            return self.reference.of_motors(motion)
        coordinates = self.call(MOTOR_COORDINATES, motion)
        return coordinates["q_motor"], coordinates["qd_motor"]

    def slopes(self, motion: Motion) -> Array:
        """Return S_m (m, n) at one position, d(motor velocities)/d(coordinate velocities)."""
        unit = np.eye(motion.q.shape[1])
        if MOTOR_COORDINATES not in self._arguments:
            return unit[self.motors]
        rates = [self.call(MOTOR_COORDINATES, motion.with_blocks(qd=row[None]))["qd_motor"][0] for row in unit]
        return np.stack(rates, axis=1)

    def call(self, function: str, state: State) -> dict[str, Array]:
        """Return the results of a generated function at states."""
        return self._compiled.call(function, **state.only(self._arguments[function]))


def _package(machine: Machine, scene: Scene) -> Package:
    """Return the models of a scene, with those of motors on dependent joints and of load-dependent friction."""
    models = trace_models(machine, scene)
    more = [motor_coordinates(machine, models.folded)] if dependent_motors(machine) else []
    more += [passed_torques(machine, models.folded)] if machine.loaded else []
    return replace(models, models=[*models.models, *more]).package if more else models.package


class CompiledMotionOnBase(CompiledMotion):
    """The right-hand side of a motion with a freely moving base, with derivatives by differences.

    y = [q; P0; Q0; v; V0], then states of friction. The quaternion turns by Q' = Q (0, w) / 2, which keeps its length,
    and is divided by it wherever it is used.
    """

    linear_models = ()

    def __init__(self, reference: Reference, folder: Path) -> None:
        """Compile the motion; raises `InputError`, `CompilerMissing`, `CompilationFailed`."""
        super().__init__(reference, folder)
        self.orientation = next(iter(reference.base.keys() & {"Q0", "R0"}))

    @property
    def start(self) -> Array:
        """The state y at the start."""
        state, base = self.reference.start, self.reference.base
        Q0 = base["Q0"] if "Q0" in base else quaternion(base["R0"].reshape(3, 3))
        own = state.q[self.free], base["P0"], Q0, state.qd[self.free], base["V0"]
        return np.concatenate([*own, 0 * self.largest_bent])

    @property
    def of_motion(self) -> int:
        """Number of entries of y before the states of friction."""
        return super().of_motion + 13

    def states_of_joints(self, t: Array, y: Array) -> tuple[Array, Array]:
        """Return q, qd (N, n) of all joints at times (N,) and y."""
        P0_and_Q0 = np.arange(len(self.free), len(self.free) + 7)
        return super().states_of_joints(t, np.delete(y, P0_and_Q0, axis=1))

    def base(self, y: Array) -> dict[str, Array]:
        """Return the blocks of the base at y, and the wrench on it."""
        P0, Q0 = np.split(y[:, len(self.free) : len(self.free) + 7], [3], axis=1)
        Q0 = Q0 / np.linalg.norm(Q0, axis=1, keepdims=True)
        turned = Q0 if self.orientation == "Q0" else rotations(Q0).reshape(-1, 9)
        wrench = np.tile(self.reference.base["f0"], (len(y), 1))
        return {self.orientation: turned, "P0": P0, "V0": y[:, self.of_motion - 6 : self.of_motion], "f0": wrench}

    def rate(self, t: float, y: Array, near: State) -> Array:
        """Return the time derivative y' of the state."""
        motion = self.states(np.array([t]), y[None], near)
        rates_of_motion = self.accelerations(motion, y[None])
        f, (v, w), (a, wd) = len(self.free), np.split(motion.V0[0], 2), np.split(rates_of_motion["V0d"][0], 2)
        speed, turned = rotation_at(motion)[0] @ v, turning(y[f + 3 : f + 7], w)
        rates, qdd = motion.qd[0, self.free], rates_of_motion["qdd"][0, self.free]
        return np.concatenate([rates, speed, turned, qdd, a - np.cross(w, v), wd, *rates_of_motion.get("zd", ())])

    def jacobian(self, t: float, y: Array, near: State) -> Array:
        """Return the Jacobian dy'/dy by central differences."""
        return self.differences(t, y, near)
