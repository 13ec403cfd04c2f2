"""A moving base in simulated motions: its start, the machine on a fixed base, frames in the world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import BaseStart, PrescribedMotion
from symoro_elastic.mechanics.base_body import rotation_of
from symoro_elastic.models.bound.state import State, orientation_of
from symoro_elastic.models.steps.time_steps import refuse_base
from symoro_elastic.numerics.evaluation.values import given_values


def start_of_base(machine: Machine, prescribed: PrescribedMotion) -> dict[str, Array]:
    """Return pose, velocity and wrench of the base at the start, a row each; empty for a fixed base.

    Raises `InputError` where the acceleration of the base is known, and for forces on frames.
    """
    if not machine.degrees_of_base:
        return {}
    refuse_base(machine)
    if prescribed.forces:
        raise prescribed.error("forces", "not offered on a floating base: give the wrench on it, in base")
    start = prescribed.base or BaseStart()
    name, turned = orientation_of(machine), np.array(start.orientation)
    Q0 = quaternion(turned.reshape(3, 3)) if turned.size == 9 else turned / np.linalg.norm(turned)
    blocks = {name: Q0 if name == "Q0" else rotations(Q0[None]).ravel()}
    blocks |= {"P0": np.array(start.position), "V0": np.array(start.velocity), "f0": np.array(start.wrench)}
    return {name: x.astype(float) for name, x in blocks.items()}


def held_machine(machine: Machine, start: Mapping[str, Array]) -> Machine:
    """Return the machine with its base fixed at the start: gravity in axes of the base."""
    if not start:
        return machine
    values = given_values(machine)
    gravity = rotation_at(State(start))[0].T @ np.array([x.value(values) for x in machine.base.gravity])
    x, y, z = (Formula.parse(repr(float(component))) for component in gravity)
    return replace(machine, floating=None, base=replace(machine.base, gravity=(x, y, z)))


def rows(start: Mapping[str, Array], count: int) -> dict[str, Array]:
    """Return the state of a base at rest at its start, repeated `count` times."""
    still = {name: np.tile(x, (count, 1)) for name, x in start.items()}
    return still | {name: np.zeros((count, 6)) for name in ("V0", "V0d") if start}


def rotation_at(state: State) -> Array:
    """Return rotations (N, 3, 3) from axes of the base to those of the world."""
    if "R0" in state.blocks:
        return np.asarray(state.R0.reshape(-1, 3, 3))
    return rotations(np.atleast_2d(state.Q0))


def rotations(Q: Array) -> Array:
    """Return the matrices (N, 3, 3) of quaternions (N, 4), w x y z."""
    return np.array(rotation_of(tuple(Q.T))).transpose(2, 0, 1)


def turning(Q: Array, w: Array) -> Array:
    """Return Q (0, w) / 2, the rate of a quaternion (4,) of a base with angular velocity w (3,), in its axes."""
    s, x, y, z = Q
    matrix = np.array([[-x, -y, -z], [s, -z, y], [z, s, -x], [-y, x, s]])
    return np.asarray(0.5 * matrix @ w)


def quaternion(R: Array) -> Array:
    """Return the quaternion w x y z of the rotation nearest to a matrix (3, 3), an eigenvector of Bar-Itzhack."""
    (a, b, c), (d, e, f), (g, h, i) = R
    K = np.array([
        [a + e + i, h - f, c - g, d - b],
        [h - f, a - e - i, b + d, c + g],
        [c - g, b + d, e - a - i, f + h],
        [d - b, c + g, f + h, i - a - e],
    ])  # fmt: skip
    Q: Array = np.linalg.eigh(K)[1][:, -1]
    return Q if Q[0] >= 0 else -Q


def placed_in_world(state: State, T: Array) -> Array:
    """Return placements (N, 4, 4) in the world from those in the base, T."""
    if not state.base:
        return T
    R, placements = rotation_at(state), T.copy()
    placements[:, :3, :3] = R @ T[:, :3, :3]
    placements[:, :3, 3] = state.P0 + (R @ T[:, :3, 3, None])[..., 0]
    return placements


def in_world(state: State, V: Array) -> Array:
    """Return twists (N, 6) in axes of the world from those in axes of the base."""
    if not state.base:
        return V
    return np.asarray((rotation_at(state)[:, None] @ V.reshape(-1, 2, 3)[..., None]).reshape(-1, 6))
