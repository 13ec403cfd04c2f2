"""Responses with the loops of drives closed, and their slopes by parameters of the machine: G_c = (1 - G_t S H) G.

G_t are the columns of the torques that drives give, H the responses of drives to positions, S = (1 + H G_t)^-1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.control.cascade import Cascade, cascade_of, laplace
from symoro_elastic.analysis.control.driven_machine import load_ratio
from symoro_elastic.analysis.vibration.linearization import LinearSlopes, response_slopes
from symoro_elastic.foundation.array_types import Array, ComplexArray
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import drives_of
from symoro_elastic.machine.drives import MOTOR, NO_NUMBER
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion
from symoro_elastic.numerics.motion.signals import outputs


@dataclass(frozen=True)
class Feedback:
    """Feedback of a drive: its cascade with numbers, the motor's position and the controlled position by signal."""

    cascade: Cascade
    own: str
    controlled: str

    @property
    def torque(self) -> str:
        """Name of the signal of the drive's torque."""
        return f"{self.cascade.motor}.tau"


def feedbacks_of(motion: EquationsOfMotion, sought: Sequence[str]) -> dict[str, Feedback]:
    """Return the drives of a machine and the positions that they feed back, by motor.

    Raises `InputError` for gains without value, or to be estimated.
    """
    joints, found = {joint.name: joint for joint in motion.asked.joints}, {}
    for name, drive in drives_of(motion.asked).by_motor.items():
        cascade = cascade_of(joints[name], drive, motion.parameters, motion.source)
        if cascade.tuned_gains:
            raise InputError(motion.source, f"drives, {name}, {cascade.tuned_gains[0]}", f"is {NO_NUMBER}")
        if shared := cascade.by_parameter.keys() & {*sought}:
            key = next((key for key, formula in drive.formulas if min(shared) in formula.names), "current")
            what = f"depends on {min(shared)}, which is sought: give it a number, or name what is sought (--seek)"
            raise InputError(motion.source, f"drives, {name}, {key}", what)
        own = f"{name}.q"
        found[name] = Feedback(
            cascade, own, own if drive.measured == MOTOR else outputs(motion.given, [drive.measured])[0].name
        )
    return found


def closed_response_slopes(
    slopes: LinearSlopes, f: Array | ComplexArray, loops: Sequence[Feedback]
) -> tuple[ComplexArray, ComplexArray]:
    """Return G (f, outputs, inputs) with loops closed, and its derivatives (p, f, outputs, inputs)."""
    G, dG = response_slopes(slopes, f)
    if not loops:
        return G, dG
    H, dH = _feedback(slopes, laplace(f), loops)
    torques = [slopes.linear.inputs.index(loop.torque) for loop in loops]
    G_t = G[:, :, torques]
    S = np.linalg.inv(np.eye(len(loops)) + H @ G_t)
    L, R = np.eye(G.shape[1]) - G_t @ S @ H, np.tile(np.eye(G.shape[2], dtype=complex), (len(f), 1, 1))
    R[:, torques] -= S @ H @ G
    closed: ComplexArray = L @ G
    return closed, L @ dG @ R - (G_t @ S) @ dH @ closed


def _feedback(slopes: LinearSlopes, s: ComplexArray, loops: Sequence[Feedback]) -> tuple[ComplexArray, ComplexArray]:
    """Return H (f, loops, outputs) and its derivatives (p, f, loops, outputs).

    A position of a load counts over what it changes with its motor, which a sag and the geometry change.
    """
    linear = slopes.linear
    H = np.zeros((len(s), len(loops), len(linear.outputs)), dtype=complex)
    dH = np.zeros((len(slopes.names), *H.shape), dtype=complex)
    for k, loop in enumerate(loops):
        own, controlled = linear.outputs.index(loop.own), linear.outputs.index(loop.controlled)
        cascade, C, ratio, change = loop.cascade, loop.cascade.controller(s), 1.0, np.zeros(len(slopes.names))
        H[:, k, own] = s * (C + cascade.current.drag_response(s) if cascade.current else C)
        if controlled != own:
            (v, row), (dv, drow) = linear.Cq[[own, controlled]], slopes.C[0][:, [own, controlled]].transpose(1, 0, 2)
            ratio = load_ratio(linear, cascade.motor, v, loop.controlled)
            change = (drow @ v + dv @ row - 2 * ratio * (dv @ v)) / float(v @ v)
        H[:, k, controlled] += cascade.Kv / ratio * C
        dH[:, :, k, controlled] = np.outer(-change / ratio**2, cascade.Kv * C)
    return H, dH
