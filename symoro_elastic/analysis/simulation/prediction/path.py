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
from functools import cached_property, partial
from inspect import signature
from typing import Any

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade
from symoro_elastic.analysis.simulation.prediction.loads import passed_loads
from symoro_elastic.analysis.simulation.prediction.loops import Loops, parts_of, refuse_drives, without_parts
from symoro_elastic.analysis.simulation.prediction.output_matrices import Outputs, Three, outputs_along
from symoro_elastic.analysis.simulation.prediction.samples import between
from symoro_elastic.analysis.simulation.prediction.small_motion import LinearMotion, SmallMotion, small_motion
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.analysis.vibration.following import refuse_sticking
from symoro_elastic.foundation.array_types import Array, BoolArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.mechanics.joint_laws import friction_slope
from symoro_elastic.models.static_deflections import DEFLECTIONS
from symoro_elastic.numerics.implementations import numpy_model
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.numerics.motion.inertia import refuse_singular

SAMPLES = 800
"""Times along a motion."""
NEWTON_STEPS = 2
NEAR = 10.0
"""Of a deviation of a joint, rad or m: beyond it the linear model tells nothing."""


@dataclass(frozen=True)
class LinearPath:
    """The linear model at times t (N,), evenly spaced from 0: M, D, K (N, n, n), R (N, n), outputs, the reference.

    `moved` are the entries of q that d has, `springs` those among them that can be left out. `stiffness` (n,) and
    `damping` (N, n) are those of springs, dampers, friction and servos on the joints: diagonal; `preload` (n,) are the
    forces of the springs at the start. Drives have coordinates after those of joints: `controlled` is what loops add to
    D and K, `parts` are the entries of what they can do without, `known` (N, outputs) is what outputs have of them
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
    known: Array | None = None
    of_loads: Array | None = None
    machine: LinearPath | None = field(default=None, repr=False)

    @property
    def candidates(self) -> tuple[int, ...]:
        """What can be left out: springs, then parts of drives."""
        return (*self.springs, *self.parts)

    def with_drives(self, drives: Sequence[Cascade]) -> LinearPath:
        """Return the model of this machine under drives; itself without any."""
        if not drives:
            return self
        n, loops = len(self.joints), Loops(self.reference, drives, self.t)
        more = len(loops.names)
        D, K = loops.matrices(n)
        ends = ((0, 0), (0, more), (0, more))
        M = np.pad(self.M, ends)
        M[:, range(n, n + more), range(n, n + more)] = 1.0
        outputs, known = loops.outputs(self.outputs, n)
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
            known=known,
            of_loads=None if self.of_loads is None else np.pad(self.of_loads, ends),
            machine=self,
        )

    def without_parts(self, left_out: Collection[str]) -> LinearPath:
        """Return the model in which some parts of drives, by name, follow at once; itself without any."""
        if self.machine is None or not left_out:
            return self
        return self.machine.with_drives(without_parts(self.reference.drives, left_out))

    def following(self, left_out: Collection[str]) -> tuple[LinearPath, tuple[int, ...]]:
        """Return the model without the parts of drives among these names, and the entries of the springs among them."""
        parts = self.names(self.parts)
        springs = tuple(self.joints.index(name) for name in left_out if name not in parts)
        return self.without_parts([name for name in left_out if name in parts]), springs

    @property
    def h(self) -> float:
        """Time between samples, s."""
        return float(self.t[1] - self.t[0])

    @cached_property
    def prescribed(self) -> tuple[int, ...]:
        """Entries of q that follow the reference exactly."""
        return tuple(k for k in range(len(self.joints)) if k not in self.moved)

    def names(self, entries: Sequence[int]) -> tuple[str, ...]:
        """Return the names of entries of q."""
        return tuple(self.joints[k] for k in entries)

    def without(self, sets: Sequence[Collection[int]], forces: Array | None = None) -> SmallMotion:
        """Return d, d', d'' (N, sets, n), zero for the springs that each set leaves out; sets are equally large.

        `forces` (N, n) are those that drive it, R where none are given.
        """
        rows = np.array([[k for k in self.moved if k not in left_out] for left_out in sets], dtype=int)
        columns = rows[:, None, :]
        M, D, K = (x[:, rows[:, :, None], columns] for x in (self.M, self.D, self.K))
        found = small_motion(LinearMotion(self.h, M, D, K, (self.R if forces is None else forces)[:, rows]))
        return SmallMotion(*(_spread(x, rows, len(self.joints)) for x in (found.d, found.dd, found.ddd)))

    def driven_by(self, forces: Array, left_out: Collection[int]) -> SmallMotion:
        """Return d, d', d'' (N, sets, n) under each of several forces (N, sets, n), zero for springs left out."""
        rows = [k for k in self.moved if k not in left_out]
        M, D, K = (x[:, rows][:, None, :, rows] for x in (self.M, self.D, self.K))
        found = small_motion(LinearMotion(self.h, M, D, K, forces[:, :, rows]))
        columns = np.broadcast_to(np.array(rows, dtype=int), (forces.shape[1], len(rows)))
        return SmallMotion(*(_spread(x, columns, len(self.joints)) for x in (found.d, found.dd, found.ddd)))

    def recovering(self, static: Sequence[int]) -> LinearPath:
        """Return the model whose outputs follow the deflections of static springs E, for motions that leave them out.

        They are those by the motion, d_E = -(M_E d'' + D_E d' + K_E d) / k_E, without R_E / k_E.
        """
        E = list(static)
        by = np.array([-x[:, E] / self.stiffness[E, None] for x in (self.K, self.D, self.M)])
        by[..., E] = 0.0
        return replace(self, outputs=self.outputs.of_following_springs(E, (by[0], by[1], by[2])))

    def states(self, t: Array) -> tuple[Array, Array, Array]:
        """Return q_r, v_r, a_r (N, n) at times (N,)."""
        more = len(self.joints) - self.reference.start.q.size
        q, v, a = (np.pad(x, ((0, 0), (0, more))) if more else x for x in self.reference.states(t))
        return q, v, a

    @property
    def every_second(self) -> LinearPath:
        """The model at every second time."""
        M, D, K, R = (x[::2] for x in (self.M, self.D, self.K, self.R))
        known, of_loads = (None if x is None else x[::2] for x in (self.known, self.of_loads))
        every_second = replace(self, t=self.t[::2], M=M, D=D, K=K, R=R, outputs=self.outputs.every_second)
        return replace(every_second, damping=self.damping[::2], known=known, of_loads=of_loads, machine=None)

    def finer(self, samples: int) -> LinearPath:
        """Return the model at other times, evenly spaced: cubic between those that are known."""
        t = np.linspace(0.0, self.t[-1], samples)
        M, D, K, R, damping = (between(self.t, x, t) for x in (self.M, self.D, self.K, self.R, self.damping))
        known, of_loads = (None if x is None else between(self.t, x, t) for x in (self.known, self.of_loads))
        found = replace(self, t=t, M=M, D=D, K=K, R=R, damping=damping, outputs=self.outputs.at(self.t, t))
        return replace(found, known=known, of_loads=of_loads, machine=None)


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
            found = along.about(near, ()).without([()])
        if not np.abs(found.d[..., : len(along.motion.names)]).max(initial=0.0) <= NEAR:
            break
        near = found
    path = along.about(near, outputs)
    if any(one.is_limited for one in reference.drives):
        moved = path.without([()])
        Loops(reference, reference.drives, path.t).refuse_beyond(reference, moved.d[:, 0], moved.dd[:, 0])
    return path


class _Along:
    """A machine at times t (N,) of a motion."""

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
        """Return the model about the reference, or a deviation (N, 1, n) from it; d is from the reference in both."""
        states, driven = self.states, np.zeros_like(self.states[0])
        if deviation is not None:
            d, dd, ddd = (x[:, 0, : len(self.motion.names)] for x in (deviation.d, deviation.dd, deviation.ddd))
            states = states[0] + d, states[1] + dd, states[2] + ddd
        M, D, K = self._given_to(self.model.linearization, *states)
        taken, inertia = self._forces_taken(M, states), M.copy()
        loads = passed_loads(self.motion, *states[:2])
        damping = {one.k: one.add(M, D, K, taken, states[2]) for one in loads}
        self._refuse_infinite(taken, M, D, K)
        if deviation is not None:
            terms = ((K, d), (D, dd), (M, ddd))
            driven = sum(np.einsum("tij,tj->ti", matrix, x) for matrix, x in terms)
        R = self.reference.start.tau - taken + driven
        torques = K[:, self.motors], D[:, self.motors], M[:, self.motors]
        deflections = partial(self._given_to, self.model.static_deflections) if self.machine.static else None
        rows = outputs_along(self.machine, self.reference.servo, outputs, states, torques, deflections)
        stiffness, slopes, preload = _laws(self.motion, self.reference.start.q, states[1])
        for k, slope in damping.items():
            slopes[:, k] += slope
        found = self._served(M, D, K, R, rows, (stiffness, slopes, preload))
        return replace(found, of_loads=M - inertia if loads else None).with_drives(self.reference.drives)

    def _served(self, M: Array, D: Array, K: Array, R: Array, outputs: Outputs, laws: Three) -> LinearPath:
        """Return the model with the gains of servos, or without equations of motors."""
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

    def _forces_taken(self, M: Array, states: Three) -> Array:
        """Return ID(q, v, a) (N, n), springs and friction included, less what forces on frames do.

        The hybrid inverse model gives tau and a' with M a' + ... = tau at the same q, v; M (a - a') is what remains.
        """
        q, v, a = states
        tau, found = self._given_to(self.model.inverse_dynamics, q, v, a[:, self.motors])
        taken: Array = (M @ (a - found)[..., None])[..., 0]
        taken[:, self.motors] += tau
        return taken

    def _given_to(self, model: Callable[..., Any], *states: Array) -> Any:
        """Return the results of a generated function, under the forces on frames and without loads in friction."""
        given = {"f_ext": self.wrenches, "load": np.zeros((len(self.t), len(self.machine.loaded)))}
        return model(*states, **{name: x for name, x in given.items() if name in signature(model).parameters})

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


def _laws(motion: EquationsOfMotion, start: Array, v: Array) -> tuple[Array, Array, Array]:
    """Return stiffness (n,) of the joints themselves, their damping (N, n) at v (N, n), forces of springs at the start.

    The slope of dry friction that creeps is damping, too.
    """
    laws = [(joint.spring, joint.friction) for joint in motion.given.independent_joints]
    cells = [(s.stiffness, s.damping, s.neutral, f.viscous, f.coulomb, f.creep) for s, f in laws]
    numbers = np.array([[cell.value(motion.parameters) for cell in row] for row in cells], dtype=float)
    stiffness, damping, neutral, viscous, coulomb, creep = numbers.T
    speed = np.hypot(v, np.where(creep > 0, creep, 1.0))
    slope: Any = friction_slope(viscous, np.where(creep > 0, coulomb, 0.0), creep, speed)
    return stiffness.copy(), damping + slope, stiffness * (start - neutral)


def refuse_machine(motion: EquationsOfMotion, start: State) -> None:
    """Raise `InputError` for joints that depend on others, dry friction without a motor, and no inertia."""
    refuse_coupled(motion.given)
    for j in motion.given.with_backlash:
        what = "the ladder takes springs as straight: leave it out, or use simulate"
        raise motion.given.error(f"joint {motion.given.joint(j).name}, backlash", what)
    for j in motion.given.bristles:
        what = (
            "where a motion stops, a bristle yields to one side only: no linear model has it, give creep in its place"
        )
        raise motion.given.error(f"friction, {motion.given.joint(j).name}", what)
    refuse_sticking(motion)
    (M,) = motion.matrices("M", start.q, start.qd, start.qdd)
    refuse_singular(motion, M, range(len(start.q)), can_hold=False)


def refuse_coupled(machine: Machine) -> None:
    """Raise `InputError` where joints depend on the variables of others."""
    if not machine.is_coupled:
        return
    if machine.loops:
        raise machine.error(f"loop {machine.loops[0].name}", "the ladder does not handle loops: use simulate")
    variables = set(machine.variables)
    for joint in machine.joints:
        others = variables & set(joint.selected.names) - {str(joint.variable)}
        if others:
            what = (
                f"it follows {', '.join(sorted(others))}, and the ladder does not handle coupled joints: use simulate"
            )
            raise machine.error(f"joint {joint.name}", what)
