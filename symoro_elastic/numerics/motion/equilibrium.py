"""States to linearize about: the equilibrium under gravity and loads, or a state of the user.

A free base is in balance by thrusts: forces and moments in axes of the frames that they turn with.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.machine.frames import COORDINATES, FrameNames, row_under, with_base_coordinates
from symoro_elastic.machine.machine import Joint, Kind, Machine, Parameter, Vector3, Wrench
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.machine.static_springs import with_free_springs
from symoro_elastic.mechanics import spatial
from symoro_elastic.mechanics.spatial import roll_pitch_yaw, translation
from symoro_elastic.numerics.motion.balance import RESIDUAL, balance
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State, motion_of
from symoro_elastic.numerics.motion.inertia import refuse_singular
from symoro_elastic.numerics.motion.signals import WRENCH_INPUTS

SOFT = "gravity or a load is stronger than its spring at this position: keep it in the motion"
LEAST = 1e-9
"""Smallest eigenvalue of K_EE, in units of the springs' own stiffness, that is more than rounding."""
Thrusts = Mapping[str, float | None]
"""Sizes of thrusts by name, such as rotor1.fz, N or N m; None where the equilibrium determines the size."""
OPTION = "--thrust"
MOST_STEPS = 30


def equilibrium(
    motion: EquationsOfMotion,
    at: Mapping[str, float] | None = None,
    torques: Mapping[str, float] | None = None,
    carried: bool = False,
) -> State:
    """Return the state at rest where r(q, 0, 0) = tau [8], [9], with gravity, external wrenches and `torques`.

    Motors are held `at` their positions (rad or m, 0 by default) and tau is the torque that holds them; a motor in
    `torques` (N m or N) is free to move instead. For other joints `at` is where the search begins, else
    the neutral position of their spring. A base that is `carried` stays where it is; tau holds the force and the moment
    on it, whose directions are constant. Raises `InputError` that names the joints nothing supports.
    """
    base = base_coordinates(motion) if carried else []
    q, tau = starting_point(motion, at or {}), np.zeros(len(motion.joints))
    free = _free(motion, torques or {})
    tau[list(free)] = list(free.values())
    fixed = {k for k in motion.motors if k not in free}.union(base)
    sought = [k for k in range(len(motion.joints)) if k not in fixed]
    given_at = motion.indices_of(at or {}, "--at").keys()
    has_start = not given_at.isdisjoint(sought)
    q = _on_flanks(motion, q, tau, [k for k in sought if k not in given_at])
    q = balance(motion, q, tau, sought, has_start)
    zero, forces = np.zeros_like(q), motion.forces(q)
    residual = float(np.max(np.abs((forces - tau)[sought]), initial=0.0))
    tau[list(fixed)] = forces[list(fixed)]
    started = tuple(k for k in fixed if k not in given_at)
    return State(q, zero, zero, tau, motion.torques(q, tau), tuple(sought), residual, started)


def base_coordinates(motion: EquationsOfMotion) -> list[int]:
    """Return the indices in q of the coordinates of the base; raises `InputError` where the base is fixed."""
    base = [k for k, name in enumerate(motion.names) if name in COORDINATES]
    if not base:
        raise InputError(motion.source, "hover", "the base is fixed: only a floating base hovers")
    return base


def given_state(
    motion: EquationsOfMotion,
    at: Mapping[str, float] | None = None,
    rates: Mapping[str, float] | None = None,
    torques: Mapping[str, float] | None = None,
) -> State:
    """Return the state of a user's q, qd and torques: tau, and qdd from A qdd = tau - r(q, qd, 0) [8].

    They are 0 by default, q that of the start of a loop.
    Raises `InputError` for joints that do not exist, and where A is singular.
    """
    q, pushed = motion.position_of_loops(), np.zeros(len(motion.motor_names))
    for m, x in _by_index(motion, torques or {}).items():
        pushed[m] = x
    qd = np.zeros_like(q)
    for numbers, named, place in ((q, at or {}, "--at"), (qd, rates or {}, "--rate")):
        for k, x in motion.indices_of(named, place).items():
            numbers[k] = x
    motion.refuse_open(q)
    (A,) = motion.matrices("M", q, qd)
    refuse_singular(motion, A, range(len(q)), can_hold=False)
    tau = motion.motor_slopes(q).T @ pushed
    qdd: Array = np.array(np.linalg.solve(A, tau - motion.forces(q, qd)), dtype=float)
    given_at = motion.indices_of(at or {}, "--at").keys()
    return State(q, qd, qdd, tau, pushed, started=tuple(k for k in range(len(q)) if k not in given_at))


def starting_point(motion: EquationsOfMotion, at: Mapping[str, float]) -> Array:
    """Return the position where the search begins; raises `InputError` for joints that do not exist."""
    q = motion.neutral_positions()
    for k, x in motion.indices_of(at, "--at").items():
        q[k] = x
    return q


def _on_flanks(motion: EquationsOfMotion, q: Array, tau: Array, sought: list[int]) -> Array:
    """Return the position with springs that have backlash at the edges to which loads push them."""
    edges = np.zeros_like(q)
    for k in sought:
        edges[k] = motion.joints[k].spring.backlash.value(motion.parameters) / 2
    if not edges.any():
        return q
    motion.refuse_open(q)
    return q + edges * np.sign(tau - motion.forces(q))


def _free(motion: EquationsOfMotion, torques: Mapping[str, float]) -> dict[int, float]:
    """Return the torques of freely moving motors, by index in q; raises `InputError` for motors that share a torque."""
    free = {}
    for m, x in _by_index(motion, torques).items():
        j = motion.machine.motors[m]
        joined = [(one, *others) for one, others in motion.followers.items() if j in (one, *others)]
        if joined:
            names = ", ".join(sorted(motion.machine.joint(i).name for i in joined[0]))
            what = f"{names} move each other, so none is free by itself: leave it out, or give the state "
            raise InputError(motion.source, "--torque", what + "(--as-given)")
        free[motion.machine.independent.index(j)] = x
    return free


def _by_index(motion: EquationsOfMotion, torques: Mapping[str, float]) -> dict[int, float]:
    """Return torques by index of the motor; raises `InputError` for other joints, and numbers out of range."""
    numbered = {motion.motor(name, "--torque"): x for name, x in torques.items()}
    motion.refuse_large(torques, "--torque")
    return numbered


def refuse_soft_static(machine: Machine, at: Mapping[str, float], values: Mapping[str, float] | None = None) -> None:
    """Raise `InputError` for static springs that cannot balance gravity or a load: K_EE is not positive definite."""
    weakest = soft_static(machine, at, values)
    if weakest:
        raise machine.error(f"scene, static, {weakest}", SOFT)


def soft_static(machine: Machine, at: Mapping[str, float], values: Mapping[str, float] | None = None) -> str | None:
    """Return the weakest static joint unless K_EE of all of them is positive definite, neutral and at equilibrium.

    K = dr/dq [8] holds springs, gravity and loads, with motors `at` their positions, rad or m. `values` are those of
    parameters. Raises `InputError` where they are missing, and for joints that nothing supports.
    """
    if not machine.static:
        return None
    names = [joint.name for joint in machine.static_springs.values()]
    motion = motion_of(replace(with_free_springs(machine), static={}), values)
    entries = [motion.index(name, "scene, static") for name in names]
    weakest = _weakest(motion, starting_point(motion, at), entries)
    if weakest is None:
        weakest = _weakest(motion, equilibrium(motion, at).q, entries)
    return None if weakest is None else motion.names[weakest]


def _weakest(motion: EquationsOfMotion, q: Array, entries: Sequence[int]) -> int | None:
    """The joint that moves most in the softest direction of K_EE; None where K_EE is positive definite."""
    (K,) = motion.matrices("K", q)
    own = dict(zip(motion.springs, motion.spring_stiffnesses(q), strict=True))
    units = np.sqrt([own[motion.names[k]] for k in entries])
    K_EE = K[np.ix_(entries, entries)] / np.outer(units, units)
    sizes, directions = np.linalg.eigh((K_EE + K_EE.T) / 2)
    return None if sizes[0] > LEAST else entries[int(np.argmax(np.abs(directions[:, 0])))]


def thrust_parameter(name: str) -> str:
    """Return the name of the parameter that holds the size of a thrust."""
    return f"{name}.thrust"


def with_thrusts(machine: Machine, thrusts: Thrusts) -> Machine:
    """Return the machine with thrusts on its frames, as parameters. Raises `InputError` for unknown names."""
    if not thrusts:
        return machine
    machine = with_base_coordinates(machine)
    joints, frames = [*machine.joints], FrameNames(machine)
    for name in thrusts:
        frame, _, component = name.rpartition(".")
        number = frames.number(frame) or 0
        row = row_under(machine, number)
        if not row or component not in WRENCH_INPUTS:
            what = f"{quote(name)} is not FRAME.{'|'.join(WRENCH_INPUTS)}{did_you_mean(frame, frames.own)}"
            raise machine.error(OPTION, what)
        wrench = machine.joint(row).wrench
        if not all(cell.is_zero for cell in (*wrench.force, *wrench.moment)):
            raise machine.error(OPTION, f"{name}: the table has a wrench there: remove one of the two")
        joints[row - 1] = _with_thrust(joints[row - 1], _unit_wrench(machine, number, component), name)
    named = tuple(Parameter(thrust_parameter(name), Formula.parse(x or 0.0)) for name, x in thrusts.items())
    return replace(machine, joints=tuple(joints), parameters=(*machine.parameters, *named))


def _unit_wrench(machine: Machine, number: int, component: str) -> list[float]:
    """Return the wrench (6,) on the body of a row, about its origin, in its axes, of a unit thrust on a frame."""
    unit = [float(k == WRENCH_INPUTS[component]) for k in range(6)]
    if number <= len(machine.joints):
        return unit
    frame, values = machine.frames[number - len(machine.joints) - 1], parameter_values(machine)
    try:
        at, rpy = ([cell.value(values) for cell in cells] for cells in (frame.at, frame.rpy))
    except FormulaError as error:
        raise machine.error(OPTION, f"{frame.name}: {error}") from None
    roll, pitch, yaw = ((math.cos(angle), math.sin(angle)) for angle in rpy)
    placement = roll_pitch_yaw(roll, pitch, yaw).after(translation(spatial.Vector(*at)))
    wrench = placement.T * spatial.Wrench(spatial.Vector(*unit[:3]), spatial.Vector(*unit[3:]))
    return [float(x) for part in wrench for x in part]  # type: ignore[arg-type]


def _with_thrust(joint: Joint, wrench: list[float], name: str) -> Joint:
    """Return the joint with a thrust on its body; table wrenches act from the body outward, so the sign changes."""
    parameter = thrust_parameter(name)
    cells = [*joint.wrench.force, *joint.wrench.moment]
    for k, x in enumerate(wrench):
        if x:
            tree = ("*", ("number", Fraction(-x)), ("name", parameter))
            cells[k] = Formula(f"{cells[k]} - {x!r}*{parameter}", ("+", cells[k].tree, tree))
    force, moment = (_vector(cells[k : k + 3]) for k in (0, 3))
    return replace(joint, wrench=Wrench(force, moment))


def _vector(cells: list[Formula]) -> Vector3:
    return cells[0], cells[1], cells[2]


def thrusts_of(motion: EquationsOfMotion) -> dict[str, float]:
    """Return the sizes of the thrusts on a machine, N or N m."""
    end = thrust_parameter("")
    return {name.removesuffix(end): x for name, x in motion.parameters.items() if name.endswith(end)}


def hover(motion: EquationsOfMotion, at: Mapping[str, float], thrusts: Thrusts) -> State:
    """Return the state at rest in which thrusts carry the base, with the motors held `at` their positions.

    The base stays where it is; sizes of thrusts that are None are found, the smallest ones where there are several
    solutions. Raises `InputError` where they balance nothing, with the unbalanced forces.
    """
    motion.refuse_large({name: x for name, x in thrusts.items() if x is not None}, OPTION)
    base = base_coordinates(motion)
    sought = [k for k, joint in enumerate(motion.joints) if joint.kind is not Kind.MOTOR and k not in base]
    unknown = [thrust_parameter(name) for name, x in thrusts.items() if x is None]
    q, zero = starting_point(motion, at), np.zeros(len(motion.joints))
    has_start = not motion.indices_of(at, "--at").keys().isdisjoint(sought)
    for _ in range(MOST_STEPS):
        q = balance(motion, q, zero, sought, has_start)
        if not _unbalanced(motion, q, base) or not unknown:
            break
        _improve(motion, q, base, unknown)
    if unbalanced := _unbalanced(motion, q, base):
        loads = ", ".join(f"{motion.names[k]} ({x:.4g} {motion.joints[k].force_unit})" for k, x in unbalanced.items())
        ways_out = "add a thrust, or leave out values (FRAME.fz) to have them computed"
        raise InputError(motion.source, OPTION, f"these thrusts do not balance {loads}: {ways_out}")
    forces, tau = motion.forces(q), np.zeros_like(q)
    tau[motion.motors] = forces[motion.motors]
    residual = float(np.max(np.abs(forces - tau), initial=0.0))
    return State(q, zero, zero, tau, motion.torques(q, tau), tuple(sorted((*sought, *base))), residual)


def _improve(motion: EquationsOfMotion, q: Array, base: list[int], unknown: list[str]) -> None:
    """Change the thrusts so that the base is balanced; forces are linear in the thrusts."""
    before = motion.forces(q)[base]
    columns = []
    for name in unknown:
        motion.parameters[name] += 1.0
        columns.append(motion.forces(q)[base] - before)
        motion.parameters[name] -= 1.0
    for name, x in zip(unknown, np.linalg.lstsq(np.array(columns).T, -before, rcond=None)[0], strict=True):
        motion.parameters[name] += float(x)


def _unbalanced(motion: EquationsOfMotion, q: Array, base: list[int]) -> dict[int, float]:
    """Return the forces at rest on coordinates of the base, by index in q, beyond rounding of the largest load."""
    forces = np.abs(motion.forces(q)).tolist()
    largest = max(*map(abs, thrusts_of(motion).values()), *forces, np.finfo(float).tiny)
    return {k: forces[k] for k in base if not forces[k] <= RESIDUAL * largest}
