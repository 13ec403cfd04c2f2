"""The nonlinear motion of a machine with springs left out, integrated to many digits: what predictions are held to.

Accelerations are those of [8] with A and H of Pinocchio, or of generated code for many machines at once. All sets of
springs that are left out are one system: they are compared at the same times, by the same steps.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import RequestedPart
from symoro_elastic.numerics.motion.signals import FrameSignal, inputs
from symoro_elastic.numerics.motion.signals import outputs as output_signals
from symoro_elastic.numerics.verification.implementations import numpy_model

Dynamics = Callable[[Array, Array], tuple[Array, Array]]
"""A (sets, n, n) and H (sets, n), friction included, at q and qd (sets, n)."""


def generated_dynamics(machine: Machine) -> Dynamics:
    model = numpy_model(machine, ("inertia_matrix", "bias_forces"))
    return lambda q, v: (model.inertia_matrix(q), model.bias_forces(q, v))


def pinocchio_dynamics(machine: Machine) -> Dynamics:
    """Springs, dampers and friction are not in it: the machine must have no friction."""
    import pinocchio as pin

    from tests.references.pinocchio_model import model_of

    model, order, _ = model_of(machine)
    data = model.createData()
    upper = np.minimum.outer(order, order), np.maximum.outer(order, order)
    rest = np.zeros(model.nv)

    def dynamics(q: Array, v: Array) -> tuple[Array, Array]:
        A, H = np.zeros((*q.shape, q.shape[1])), np.zeros_like(q)
        for k, (position, velocity) in enumerate(zip(q, v, strict=True)):
            placed, moved = np.zeros(model.nq), np.zeros(model.nv)
            placed[order], moved[order] = position, velocity
            pin.crba(model, data, placed)
            A[k] = data.M[upper]
            H[k] = pin.rnea(model, data, placed, moved, rest)[order]
        return A, H

    return dynamics


@dataclass
class Truth:
    """Motions q, v, a (N, sets, n) at times t (N,) with sets of springs left out, locked where they start."""

    reference: Reference
    sets: Sequence[Collection[int]]
    t: Array
    dynamics: Dynamics
    precision: float = 1e-11

    def __post_init__(self) -> None:
        nothing = np.zeros(0)
        self._asked = np.nan, (nothing, nothing, nothing)
        machine = self.reference.machine
        rows = machine.independent_joints
        values = {p.name: p.value.value() for p in machine.parameters if p.value is not None}
        laws = [(j.spring.stiffness, j.spring.neutral, j.spring.damping) for j in rows]
        self.k, self.neutral, self.damping = np.array([[x.value(values) for x in row] for row in laws]).T
        self.motors = list(machine.motor_entries)
        self.free = np.ones((len(self.sets), len(rows)))
        for row, left_out in zip(self.free, self.sets, strict=True):
            row[list(left_out)] = 0.0
            row[self.motors] = float(self.reference.servo is not None)
        frames = tuple(f"{asked} in base" for asked in self.reference.loaded.forces)
        self.jacobian = numpy_model(machine, ("jacobian",), {"jacobian": frames}).jacobian if frames else None
        self.q, self.v = self._integrated()
        self.a = np.stack([self.accelerations(*state) for state in zip(self.t, self.q, self.v, strict=True)])

    def torques(self, t: float, q: Array, v: Array) -> Array:
        """What acts on the joints besides A and H: motors under servos, springs and dampers, applied forces."""
        forces = -self.k * (q - self.neutral) - self.damping * v
        if self.reference.servo:
            y, yd, _ = self.wanted(t)
            kp, kd = self.reference.servo
            motors = self.motors
            law = kp * (y - q[:, motors]) + kd * (yd - v[:, motors])
            forces[:, motors] += self.reference.start.tau[motors] + law
        return forces + self.pushed(t, q)

    def wanted(self, t: float) -> tuple[Array, Array, Array]:
        """y, y', y'' (m,) of the motors."""
        if t != self._asked[0]:
            y, yd, ydd = (x[0] for x in self.reference.at(np.array([t])))
            self._asked = t, (y, yd, ydd)
        return self._asked[1]

    def pushed(self, t: float, q: Array) -> Array:
        if self.jacobian is None:
            return np.zeros_like(q)
        wrenches, _ = self.reference.wrenches(np.array([t]))
        return np.einsum("sfci,fc->si", self.jacobian(q), wrenches.reshape(-1, 6))

    def accelerations(self, t: float, q: Array, v: Array) -> Array:
        A, H = self.dynamics(q, v)
        given = np.zeros_like(q)
        if not self.reference.servo:
            given[:, self.motors] = self.wanted(t)[2]
        left = (self.torques(t, q, v) - H - np.einsum("sij,sj->si", A, given)) * self.free
        held = A * self.free[:, :, None] * self.free[:, None, :] + np.eye(q.shape[1]) * (1 - self.free)[:, :, None]
        return given + np.linalg.solve(held, left[..., None])[..., 0]

    def _integrated(self) -> tuple[Array, Array]:
        sets, n = self.free.shape
        start = np.concatenate([np.tile(self.reference.start.q, (sets, 1)), np.zeros((sets, n))], axis=1)

        def rate(t: float, y: Array) -> Array:
            q, v = self._placed(t, y.reshape(sets, 2 * n))
            return np.concatenate([v, self.accelerations(t, q, v)], axis=1).ravel()

        found = solve_ivp(
            rate, (0, self.t[-1]), start.ravel(), "DOP853", self.t, rtol=self.precision, atol=1e-3 * self.precision
        )
        assert found.success, found.message
        states = [self._placed(t, y.reshape(sets, 2 * n)) for t, y in zip(self.t, found.y.T, strict=True)]
        return np.stack([q for q, _ in states]), np.stack([v for _, v in states])

    def _placed(self, t: float, y: Array) -> tuple[Array, Array]:
        q, v = np.split(y.copy(), 2, axis=1)
        if not self.reference.servo:
            q[:, self.motors], v[:, self.motors] = self.wanted(t)[:2]
        return q, v

    def recovered(self) -> Array:
        """q (N, sets, n) with the deflections of left-out springs from the reactions on their joints."""
        q = self.q.copy()
        for k, t in enumerate(self.t):
            A, H = self.dynamics(self.q[k], self.v[k])
            reaction = np.einsum("sij,sj->si", A, self.a[k]) + H - self.pushed(t, self.q[k])
            springs = np.where(self.k, self.k, 1.0)
            left_out = (self.free[:, :] == 0) & (self.k != 0)
            q[k] = np.where(left_out, self.neutral - reaction / springs, q[k])
        return q

    def outputs(self, names: Sequence[str], q: Array) -> Array:
        """Positions of frames, of joints, and torques of motors (N, sets, outputs) at q (N, sets, n)."""
        machine = self.reference.machine
        found = [self._output(machine, name, q) for name in names]
        return np.stack(found, axis=-1)

    def _output(self, machine: Machine, name: str, q: Array) -> Array:
        if name.endswith(".tau"):
            (signal,) = inputs(machine, [name])
            return self.motor_torques()[..., machine.independent.index(signal.number)]
        (signal,) = output_signals(machine, [name])
        if not isinstance(signal, FrameSignal):
            return (q, self.v, self.a)[signal.order][..., machine.independent.index(signal.number)]
        assert signal.order == 0 and signal.component < 3
        frame = str(RequestedPart(machine.joints[signal.number - 1].name, signal.at))
        placed = numpy_model(machine, ("geometric_model",), {"geometric_model": (frame,)}).geometric_model(q)
        return placed[..., 0, signal.component, 3]

    def motor_torques(self) -> Array:
        found = np.zeros_like(self.q)
        for k, t in enumerate(self.t):
            A, H = self.dynamics(self.q[k], self.v[k])
            if self.reference.servo:
                found[k] = self.torques(t, self.q[k], self.v[k]) + self.k * (self.q[k] - self.neutral)
                found[k] += self.damping * self.v[k] - self.pushed(t, self.q[k])
            else:
                found[k] = np.einsum("sij,sj->si", A, self.a[k]) + H - self.pushed(t, self.q[k])
        return found

    def errors(self, names: Sequence[str]) -> tuple[Array, Array]:
        """The largest differences (sets, outputs) to the first set, springs locked and static."""
        locked, static = self.outputs(names, self.q), self.outputs(names, self.recovered())
        whole = locked[:, :1]
        return np.abs(whole - locked).max(axis=0), np.abs(whole - static).max(axis=0)
