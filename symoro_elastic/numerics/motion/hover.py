"""A base held in balance by thrusts: forces and moments in axes of the frames that they turn with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.frames import FrameNames
from symoro_elastic.machine.free_base import with_base_coordinates
from symoro_elastic.machine.machine import Joint, Kind, Machine, Parameter, Vector3, Wrench
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.numerics.motion.balance import RESIDUAL, balance
from symoro_elastic.numerics.motion.equations_of_motion import LARGEST_INPUT, EquationsOfMotion, State
from symoro_elastic.numerics.motion.equilibrium import base_coordinates, starting_point
from symoro_elastic.numerics.motion.signals import WRENCH_INPUTS

Thrusts = Mapping[str, float | None]
"""By name, such as rotor1.fz, its size in N or N m; None where it is to be found."""
OPTION = "--thrust"
MOST_STEPS = 30


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
        number = frames.number(frame)
        if number is None or component not in WRENCH_INPUTS:
            what = f"{quote(name)} is not FRAME.{'|'.join(WRENCH_INPUTS)}{did_you_mean(frame, frames.own)}"
            raise machine.error(OPTION, what)
        joints[number - 1] = _with_thrust(machine, joints[number - 1], WRENCH_INPUTS[component], name)
    named = tuple(Parameter(thrust_parameter(name), Formula.parse(x or 0.0)) for name, x in thrusts.items())
    return replace(machine, joints=tuple(joints), parameters=(*machine.parameters, *named))


def _with_thrust(machine: Machine, joint: Joint, component: int, name: str) -> Joint:
    """Return the joint whose body is pushed; a wrench of the table is what the body exerts, so the sign changes."""
    cells = [*joint.wrench.force, *joint.wrench.moment]
    if not cells[component].is_zero:
        raise machine.error(OPTION, f"{name}: the table has a wrench there: leave out one of the two")
    parameter = thrust_parameter(name)
    cells[component] = Formula(f"-{parameter}", ("neg", ("name", parameter)))
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
    solutions. Raises `InputError` where they balance nothing, with what is left.
    """
    for name, x in thrusts.items():
        if x is not None and not abs(x) <= LARGEST_INPUT:
            raise InputError(motion.source, OPTION, f"{name}={x:g} is out of range: give up to {LARGEST_INPUT:g}")
    base = base_coordinates(motion)
    sought = [k for k, joint in enumerate(motion.joints) if joint.kind is not Kind.MOTOR and k not in base]
    unknown = [thrust_parameter(name) for name, x in thrusts.items() if x is None]
    q, zero = starting_point(motion, at), np.zeros(len(motion.joints))
    placed = not motion.indices_of(at, "--at").keys().isdisjoint(sought)
    for _ in range(MOST_STEPS):
        q = balance(motion, q, zero, sought, placed)
        if _is_balanced(motion, q, base) or not unknown:
            break
        _improve(motion, q, base, unknown)
    _refuse_unbalanced(motion, q, base)
    forces = motion.forces(q, zero, zero)
    tau = np.zeros_like(q)
    tau[motion.motors] = forces[motion.motors]
    left = float(np.max(np.abs(forces - tau), initial=0.0))
    return State(q, zero, zero, tau, motion.torques(q, tau), tuple(sorted((*sought, *base))), left)


def _improve(motion: EquationsOfMotion, q: Array, base: list[int], unknown: list[str]) -> None:
    """Change the thrusts by what the forces on the base need, which are linear in them."""
    zero = np.zeros_like(q)
    before = motion.forces(q, zero, zero)[base]
    columns = []
    for name in unknown:
        motion.parameters[name] += 1.0
        columns.append(motion.forces(q, zero, zero)[base] - before)
        motion.parameters[name] -= 1.0
    for name, x in zip(unknown, np.linalg.lstsq(np.array(columns).T, -before, rcond=None)[0], strict=True):
        motion.parameters[name] += float(x)


def _loads(motion: EquationsOfMotion, q: Array) -> tuple[Array, float]:
    """Return the forces at rest, and the largest of those that balance."""
    zero = np.zeros_like(q)
    forces = motion.forces(q, zero, zero)
    return forces, max(*map(abs, thrusts_of(motion).values()), float(np.abs(forces).max()), np.finfo(float).tiny)


def _is_balanced(motion: EquationsOfMotion, q: Array, base: list[int]) -> bool:
    forces, largest = _loads(motion, q)
    return bool(np.abs(forces[base]).max() <= RESIDUAL * largest)


def _refuse_unbalanced(motion: EquationsOfMotion, q: Array, base: list[int]) -> None:
    if _is_balanced(motion, q, base):
        return
    forces, largest = _loads(motion, q)
    left = [k for k in base if abs(forces[k]) > RESIDUAL * largest]
    loads = ", ".join(f"{motion.names[k]} ({abs(forces[k]):.4g} {motion.joints[k].force_unit})" for k in left)
    what = f"these thrusts do not balance {loads}: add a thrust, or leave out values (FRAME.fz) to have them computed"
    raise InputError(motion.source, OPTION, what)
