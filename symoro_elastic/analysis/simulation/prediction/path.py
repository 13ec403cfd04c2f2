"""The linear model of a machine along a motion of its motors, springs at the equilibrium of the start.

    M(t) d'' + D(t) d' + K(t) d = R(t),    d(0) = d'(0) = 0,    dy = Cq(t) d + Cv(t) d' + Ca(t) d''

d is the small motion about the reference q_r, v_r, a_r. M, D, K are those of the model `linearization`; where motors
have servos, their gains are in D and K. R is what drives d: the forces on the machine less those that the reference
takes, R = tau_r - ID(q_r, v_r, a_r), those on frames among them. This is a step of Newton's method on the equations of
motion, so d is wrong by O(d^2). The next step is about q_r + d, v_r + d', a_r + d'': there M, D, K are taken, and R
holds M d'' + D d' + K d of the step before. What springs cost then is wrong by the square of the difference that they
make.

Motors without servo follow exactly: their rows are not equations then, but give their torques. Drives are rows more,
see `loops`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from inspect import signature
from typing import Any

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade
from symoro_elastic.analysis.simulation.compiled_steps import Trajectory
from symoro_elastic.analysis.simulation.prediction.loops import Loops, parts_of, refuse_drives, without_parts
from symoro_elastic.analysis.simulation.prediction.output_matrices import Outputs, Three, between, outputs_along
from symoro_elastic.analysis.simulation.prediction.small_motion import LinearMotion, SmallMotion, small_motion
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.analysis.vibration.following import refuse_sticking
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.joints import Friction, Joint, Kind
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.kinematics.geometric import DEFLECTIONS
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.numerics.motion.inertia import refuse_singular
from symoro_elastic.numerics.verification.implementations import numpy_model

SAMPLES = 800
"""Times along a motion."""
NEWTON_STEPS = 2
NEAR = 10.0
"""Largest deviation of a joint, rad or m, for which the linear model is used."""


@dataclass(frozen=True)
class LinearPath:
    """The linear model at times t (N,), evenly spaced from 0: M, D, K (N, n, n), R (N, n), outputs, the reference.

    `moved` are the entries of q that d has, `springs` those among them that can be left out. `stiffness` (n,) and
    `damping` (N, n) are those of springs, dampers, friction and servos on the joints: diagonal; `preload` (n,) are the
    forces of the springs at the start. Drives have coordinates after those of joints: `controlled` is what loops add to
    D and K, `parts` are the entries of what they can do without, `offsets` (N, outputs) are outputs by drives
    without a deviation, `machine` the model without drives. `of_loads` (N, n, n) is what friction that rises with load
    adds to M, which implicit steps do not have. SI units, radians.
    """

    reference: Reference
    joints: tuple[str, ...]
    t: Array
    M: Array
    D: Array
    K: Array
    R: Array
    outputs: Outputs
    moved: tuple[int, ...]
    springs: tuple[int, ...]
    stiffness: Array
    damping: Array
    preload: Array
    controlled: tuple[Array, Array] | None = None
    parts: tuple[int, ...] = ()
    offsets: Array | None = None
    of_loads: Array | None = None
    machine: LinearPath | None = field(default=None, repr=False)

    @property
    def candidates(self) -> tuple[int, ...]:
        """Entries that can be omitted: springs, then parts of drives."""
        return (*self.springs, *self.parts)

    def with_drives(self, drives: Sequence[Cascade]) -> LinearPath:
        """Return the model of this machine with these drives; itself without drives."""
        if not drives:
            return self
        n, loops = len(self.joints), Loops(self.reference, drives, self.t)
        more = len(loops.names)
        D, K = loops.matrices(n)
        ends = ((0, 0), (0, more), (0, more))
        M = np.pad(self.M, ends)
        M[:, range(n, n + more), range(n, n + more)] = 1.0
        outputs, offsets = loops.outputs(self.outputs, n)
        parts = parts_of(drives)
        return replace(
            self,
            joints=(*self.joints, *loops.names),
            M=M,
            D=np.pad(self.D, ends) + D,
            K=np.pad(self.K, ends) + K,
            R=np.pad(self.R, ends[:2]) + loops.forces(n),
            outputs=outputs,
            moved=(*self.moved, *range(n, n + more)),
            stiffness=np.pad(self.stiffness, (0, more)),
            damping=np.pad(self.damping, ends[:2]),
            preload=np.pad(self.preload, (0, more)),
            controlled=(D, K),
            parts=tuple(k for k, name in enumerate(loops.names, start=n) if name in parts),
            offsets=offsets,
            of_loads=None if self.of_loads is None else np.pad(self.of_loads, ends),
            machine=self,
        )

    def without_parts(self, left_out: Collection[str]) -> LinearPath:
        """Return the model in which the named parts of drives act without delay; itself if none are named."""
        if self.machine is None or not left_out:
            return self
        return self.machine.with_drives(without_parts(self.reference.drives, left_out))

    def following(self, left_out: Collection[str]) -> tuple[LinearPath, tuple[int, ...]]:
        """Return the model without the drive parts among `left_out`, and the entries in q of the springs among them."""
        parts = self.names(self.parts)
        springs = tuple(self.joints.index(name) for name in left_out if name not in parts)
        return self.without_parts([name for name in left_out if name in parts]), springs

    @property
    def h(self) -> float:
        """Time between samples, s."""
        return float(self.t[1] - self.t[0])

    def names(self, entries: Sequence[int]) -> tuple[str, ...]:
        """Return the joint names of entries of q."""
        return tuple(self.joints[k] for k in entries)

    def without(self, sets: Sequence[Collection[int]], forces: Array | None = None) -> SmallMotion:
        """Return d, d', d'' (N, sets, n) with the springs of each set fixed at zero; sets have equal sizes.

        `forces` (N, n) are those that drive it, R where none are given.
        """
        rows = np.array([[k for k in self.moved if k not in left_out] for left_out in sets], dtype=int)
        columns = rows[:, None, :]
        M, D, K = (x[:, rows[:, :, None], columns] for x in (self.M, self.D, self.K))
        motion = small_motion(LinearMotion(self.h, M, D, K, (self.R if forces is None else forces)[:, rows]))
        return SmallMotion(*(_spread(x, rows, len(self.joints)) for x in (motion.d, motion.dd, motion.ddd)))

    def driven_by(self, forces: Array, left_out: Collection[int]) -> SmallMotion:
        """Return d, d', d'' (N, sets, n) under several forces (N, sets, n), zero for the omitted springs."""
        rows = [k for k in self.moved if k not in left_out]
        M, D, K = (x[:, rows][:, None, :, rows] for x in (self.M, self.D, self.K))
        motion = small_motion(LinearMotion(self.h, M, D, K, forces[:, :, rows]))
        columns = np.broadcast_to(np.array(rows, dtype=int), (forces.shape[1], len(rows)))
        return SmallMotion(*(_spread(x, columns, len(self.joints)) for x in (motion.d, motion.dd, motion.ddd)))

    def recovering(self, static: Sequence[int]) -> LinearPath:
        """Return the model whose outputs include the quasi-static deflections of omitted springs E.

        They are those by the motion, d_E = -(M_E d'' + D_E d' + K_E d) / k_E, without R_E / k_E.
        """
        E = list(static)
        by = np.array([-x[:, E] / self.stiffness[E, None] for x in (self.K, self.D, self.M)])
        by[..., E] = 0.0
        return replace(self, outputs=self.outputs.of_following_springs(E, (by[0], by[1], by[2])))

    def states(self, t: Array) -> tuple[Array, Array, Array]:
        """Return q_r, v_r, a_r (N, n) of the reference at times (N,)."""
        more = len(self.joints) - self.reference.start.q.size
        q, v, a = (np.pad(x, ((0, 0), (0, more))) if more else x for x in self.reference.states(t))
        return q, v, a

    @property
    def every_second(self) -> LinearPath:
        """The model at every second time."""
        M, D, K, R = (x[::2] for x in (self.M, self.D, self.K, self.R))
        offsets, of_loads = (None if x is None else x[::2] for x in (self.offsets, self.of_loads))
        every_second = replace(self, t=self.t[::2], M=M, D=D, K=K, R=R, outputs=self.outputs.every_second)
        return replace(every_second, damping=self.damping[::2], offsets=offsets, of_loads=of_loads, machine=None)

    def finer(self, samples: int) -> LinearPath:
        """Return the model at `samples` evenly spaced times, by cubic interpolation."""
        t = np.linspace(0.0, self.t[-1], samples)
        M, D, K, R, damping = (between(self.t, x, t) for x in (self.M, self.D, self.K, self.R, self.damping))
        offsets, of_loads = (None if x is None else between(self.t, x, t) for x in (self.offsets, self.of_loads))
        path = replace(self, t=t, M=M, D=D, K=K, R=R, damping=damping, outputs=self.outputs.at(self.t, t))
        return replace(path, offsets=offsets, of_loads=of_loads, machine=None)


def linear_path(
    reference: Reference, outputs: Sequence[str], samples: int = SAMPLES, newton_steps: int = NEWTON_STEPS
) -> LinearPath:
    """Return the linear model along a motion, with rows for outputs named as signals, `motor_x.tau` among them.

    The first step of Newton's method is about the reference, the next about the motion that the one before gave, where
    that is near. Raises `InputError` for machines and outputs that it cannot treat, and where torques are not finite.
    """
    refuse_drives(reference)
    along = _Along(reference, np.linspace(0.0, reference.duration, samples + 1))
    near: SmallMotion | None = None
    for _ in range(newton_steps - 1):
        with np.errstate(over="ignore", invalid="ignore"):
            deviation = along.about(near, ()).without([()])
        if not np.abs(deviation.d[..., : len(along.motion.names)]).max(initial=0.0) <= NEAR:
            break
        near = deviation
    path = along.about(near, outputs)
    if any(drive.is_limited for drive in reference.drives):
        moved = path.without([()])
        Loops(reference, reference.drives, path.t).refuse_beyond(reference, moved.d[:, 0], moved.dd[:, 0])
    return path


class _Along:
    """A machine at times t (N,) of a motion, to be linearized there."""

    def __init__(self, reference: Reference, t: Array) -> None:
        self.reference, self.t, self.machine = reference, t, reference.machine
        self.motion = EquationsOfMotion(self.machine)
        refuse_machine(self.motion, reference.start)
        self.motors = list(self.machine.motor_entries)
        recovered = (DEFLECTIONS,) if self.machine.static else ()
        self.model = numpy_model(reference.loaded, ("linearization", "inverse_dynamics", *recovered))
        self.wrenches, _ = reference.wrenches(t)
        self.states = reference.states(t)

    def about(self, deviation: SmallMotion | None, outputs: Sequence[str]) -> LinearPath:
        """Return the model about the reference, or about a deviation (N, 1, n); d is relative to the reference."""
        states, driven = self.states, np.zeros_like(self.states[0])
        if deviation is not None:
            d, dd, ddd = (x[:, 0, : len(self.motion.names)] for x in (deviation.d, deviation.dd, deviation.ddd))
            states = states[0] + d, states[1] + dd, states[2] + ddd
        M, D, K = self._results_of(self.model.linearization, *states)
        forces, inertia = self._forces_of_reference(M, states), M.copy()
        loads = passed_loads(self.motion, *states[:2])
        damping = {load.k: load.add(M, D, K, forces, states[2]) for load in loads}
        self._refuse_infinite(forces, M, D, K)
        if deviation is not None:
            terms = ((K, d), (D, dd), (M, ddd))
            driven = sum(np.einsum("tij,tj->ti", matrix, x) for matrix, x in terms)
        R = self.reference.start.tau - forces + driven
        torques = K[:, self.motors], D[:, self.motors], M[:, self.motors]
        deflections = partial(self._results_of, self.model.static_deflections) if self.machine.static else None
        rows = outputs_along(self.machine, self.reference.servo, outputs, states, torques, deflections)
        stiffness, slopes, preload = self.motion.joint_laws(self.reference.start.q, states[1])
        for k, slope in damping.items():
            slopes[:, k] += slope
        path = self._with_servos(M, D, K, R, rows, (stiffness, slopes, preload))
        return replace(path, of_loads=M - inertia if loads else None).with_drives(self.reference.drives)

    def _with_servos(self, M: Array, D: Array, K: Array, R: Array, outputs: Outputs, laws: Three) -> LinearPath:
        """Return the model with the gains of servos, or without the equations of prescribed motors."""
        reference, motors, names = self.reference, self.motors, self.motion.names
        stiffness, damping, preload = laws
        moved = list(range(len(names)))
        if reference.servo is None:
            moved = [k for k in moved if k not in motors]
        else:
            D = D.copy()
            for diagonal, matrix, gains in zip((stiffness, damping), (K, D), reference.servo, strict=True):
                diagonal[..., motors] += gains
                matrix[:, motors, motors] += gains
        springs = tuple(k for k in self.machine.elastic_entries if k in moved and stiffness[k])
        return LinearPath(
            reference, tuple(names), self.t, M, D, K, R, outputs, tuple(moved), springs, stiffness, damping, preload
        )

    def _forces_of_reference(self, M: Array, states: Three) -> Array:
        """Return ID(q, v, a) (N, n), with springs and friction, minus generalized forces of wrenches on frames.

        The hybrid inverse model gives tau and a' with M a' + ... = tau at the same q, v; M (a - a') is what remains.
        """
        q, v, a = states
        tau, acceleration = self._results_of(self.model.inverse_dynamics, q, v, a[:, self.motors])
        forces: Array = (M @ (a - acceleration)[..., None])[..., 0]
        forces[:, self.motors] += tau
        return forces

    def _results_of(self, model: Callable[..., Any], *states: Array) -> Any:
        """Return the results of a generated function, with wrenches on frames and friction at zero load."""
        arguments = {"f_ext": self.wrenches, "load": np.zeros((len(self.t), len(self.machine.loaded)))}
        return model(*states, **{name: x for name, x in arguments.items() if name in signature(model).parameters})

    def _refuse_infinite(self, *arrays: Array) -> None:
        finite: BoolArray = np.all([np.isfinite(x.reshape(len(self.t), -1)).all(axis=1) for x in arrays], axis=0)
        if not finite.all():
            first = self.t[int(np.argmin(finite))]
            what = f"the torques of the reference are not numbers at {first:.4g} s: change the motion or its start"
            raise InputError(self.machine.label, "motion", what)


def _spread(x: Array, rows: Array, n: int) -> Array:
    """Return x (N, sets, r) of the coordinates rows (sets, r) among n, zero for the others."""
    spread = np.zeros((*x.shape[:-1], n))
    np.put_along_axis(spread, np.broadcast_to(rows, x.shape), x, axis=-1)
    return spread


def refuse_machine(motion: EquationsOfMotion, start: State) -> None:
    """Raise `InputError` for what no linear model has: loops, backlash, bristles, sticking, singular inertia."""
    refuse_coupled(motion.given)
    for j in motion.given.with_backlash:
        what = "the ladder requires linear springs: leave it out, or use simulate"
        raise motion.given.error(f"joint {motion.given.joint(j).name}, backlash", what)
    for j in motion.given.bristles:
        what = "where a motion stops, a bristle yields to one side only: no linear model has it"
        raise motion.given.error(f"friction, {motion.given.joint(j).name}", f"{what}, give creep in its place")
    refuse_sticking(motion)
    (M,) = motion.matrices("M", start.q, start.qd, start.qdd)
    refuse_singular(motion, M, range(len(start.q)), can_hold=False)


def refuse_coupled(machine: Machine) -> None:
    """Raise `InputError` for loops, and for dependent joints with a variable, friction or a motor."""
    if machine.loops:
        raise machine.error(f"loop {machine.loops[0].name}", "the ladder does not handle loops: use simulate")
    variables = {*machine.variables}
    for joint in machine.joints:
        followed = variables & joint.selected.names - {str(joint.variable)}
        own_laws = {
            "a variable": joint.variable is not None,
            "a motor": not joint.rotor_inertia.is_zero or joint.kind is Kind.MOTOR,
            "friction": joint.friction != Friction(),
        }
        own = next((what for what, is_own in own_laws.items() if is_own), "")
        if followed and own:
            what = f"it follows {', '.join(sorted(followed))}, and has {own}, which the ladder does not handle"
            raise machine.error(f"joint {joint.name}", f"{what}: use simulate")


@dataclass(frozen=True)
class PassedLoad:
    """A joint with load-dependent friction along a motion: entry k, its forces, friction sense s and slope s' by v.

    `own` (N,) and `slope` (N,) are forces of its spring, damper and friction without load and their derivative by v,
    `share` mu, `rotor` Ia, `stiffness` that of its spring.
    """

    k: int
    own: Array
    slope: Array
    sense: Array
    rise: Array
    share: float
    rotor: float
    stiffness: float

    def load(self, forces: Array, a: Array) -> Array:
        """Return the transmitted torque lambda (N,) from `forces` without load friction, and accelerations (N, n)."""
        return np.asarray(forces[:, self.k] - self.own - self.rotor * a[:, self.k])

    def add(self, M: Array, D: Array, K: Array, forces: Array, a: Array) -> Array:
        """Add load friction to M, D, K (N, n, n) and `forces` (N, n) in place; return d(friction)/d(velocity) (N,)."""
        k, unit, load = self.k, np.eye(a.shape[1])[self.k], self.load(forces, a)
        at_load = self.share * np.sign(load) * self.sense
        rise: Array = self.share * np.abs(load) * self.rise
        forces[:, k] += self.share * np.abs(load) * self.sense
        for matrix, of_joint in ((M, self.rotor), (D, self.slope[:, None]), (K, self.stiffness)):
            matrix[:, k] += at_load[:, None] * (matrix[:, k] - of_joint * unit)
        D[:, k, k] += rise
        return rise


def with_passed_loads(reference: Reference, trajectory: Trajectory) -> Trajectory:
    """Return the motion of a machine with exactly prescribed motors only, with torques that load its friction."""
    machine, order = reference.loaded, np.argsort(reference.machine.motor_entries)
    if not machine.loaded:
        return trajectory
    qdd, (f_ext, _) = reference.at(trajectory.t)[2], reference.wrenches(trajectory.t)
    blocks = {"qdd_motor": qdd, "f_ext": f_ext, "load": np.zeros((len(trajectory.t), len(machine.loaded)))}
    model = numpy_model(machine, ("inverse_dynamics",)).inverse_dynamics
    tau, *_ = trajectory.with_blocks(**blocks).results(model)
    a, forces = (x[:, order] for x in (qdd, tau))
    loads = passed_loads(EquationsOfMotion(machine), trajectory.q, trajectory.qd)
    return trajectory.with_blocks(load=np.stack([load.load(forces, a) for load in loads], axis=1))


def passed_loads(motion: EquationsOfMotion, q: Array, v: Array) -> list[PassedLoad]:
    """Return the joints whose friction rises with load, at positions and velocities (N, n)."""
    rows, machine = motion.given.independent, motion.given
    return [_passed_load(motion, machine.joint(j), rows.index(j), q, v) for j in machine.loaded]


def _passed_load(motion: EquationsOfMotion, joint: Joint, k: int, q: Array, v: Array) -> PassedLoad:
    law, spring, v = joint.friction, joint.spring, v[:, k]
    cells = (law.viscous, law.coulomb, law.static, law.creep, law.stribeck, law.load, joint.reflected_inertia)
    viscous, coulomb, static, creep, stribeck, share, rotor = (x.value(motion.parameters) for x in cells)
    of_spring = (spring.stiffness, spring.damping, spring.neutral)
    stiffness, damping, neutral = (x.value(motion.parameters) * joint.has_spring for x in of_spring)
    speed = np.hypot(v, creep)
    sense, rise = v / speed, creep**2 / speed**3
    falls = (static - coulomb) / (1 + (v / stribeck) ** 2) if static else 0.0 * v
    steeper = -2 * v / stribeck**2 * falls / (1 + (v / stribeck) ** 2) if static else 0.0
    own = stiffness * (q[:, k] - neutral) + (damping + viscous) * v + (coulomb + falls) * sense
    slope = damping + viscous + (coulomb + falls) * rise + steeper * sense
    return PassedLoad(k, own, slope, sense, rise, share, rotor, stiffness)
