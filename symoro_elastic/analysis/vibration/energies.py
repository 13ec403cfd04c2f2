"""Shares of kinetic energy by body and of strain energy by spring in each mode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.vibration.modes import Modes
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.scalar import Scalar

GRAVITY_AND_LOADS = "gravity and loads"


@dataclass(frozen=True)
class Shares:
    """Shares of energy, rows by `names`, columns by mode; a column sums to 1, or is zero where there is no energy."""

    names: tuple[str, ...]
    shares: Array

    @property
    def by_name(self) -> dict[str, Array]:
        """The shares (modes,) of each name."""
        return dict(zip(self.names, self.shares, strict=True))

    def largest(self, mode: int) -> tuple[str, float]:
        """Return the name with most of the energy of a mode, and its share."""
        k = int(self.shares[:, mode].argmax())
        return self.names[k], float(self.shares[k, mode])


def frame_shapes(modal: Modes) -> Array:
    """Return J phi (frames, 6, modes): displacement and small rotation of every frame, in axes of frame 0."""
    motion = modal.linear.motion
    moved = _moved(modal, motion.frame_motions[0])
    frames = moved.reshape(len(moved) // 6, 6, moved.shape[1])
    return frames[1 : 1 + len(motion.machine.joints)]


def kinetic_shares(modal: Modes) -> Shares:
    """Return (V_j^T JJ_j V_j) / 2 of each body and Ia qd_j^2 / 2 of each rotor [13], over their sum."""
    motion = modal.linear.motion
    moved = _moved(modal, motion.body_velocities)
    screws = moved.reshape(len(moved) // 6, 6, modal.shapes.shape[1])
    bodies = motion.body_inertias()
    energies = np.einsum("jkm,jkl,jlm->jm", screws[1 : 1 + len(bodies)], bodies, screws[1 : 1 + len(bodies)])
    inertias = motion.values(inertia for inertia, _ in motion.rotors.values())
    turning = inertias[:, None] * _moved(modal, [rate for _, rate in motion.rotors.values()]) ** 2
    massive, driven = np.flatnonzero(bodies.any(axis=(1, 2))), np.flatnonzero(inertias)
    rotors = list(motion.rotors)
    names = [motion.machine.joints[j].name for j in massive] + [f"{rotors[k]} (rotor)" for k in driven]
    return _shares(names, np.vstack([energies[massive], turning[driven]]))


def strain_shares(modal: Modes) -> Shares:
    """Return k dx^2 / 2 of springs and controllers [9], and the rest of phi^T K phi / 2, over their sum.

    All are zero for motions at 0 Hz. Gravity's part may be negative.
    """
    linear, shapes = modal.linear, modal.shapes
    motion = linear.motion
    deflections = _moved(modal, [rate for _, _, rate in motion.springs.values()])
    springs = motion.spring_stiffnesses(linear.state.q)[:, None] * deflections**2
    controllers = linear.gains[:, :1] * (linear.motors @ shapes) ** 2
    total = np.einsum("im,ij,jm->m", shapes, linear.K, shapes)
    driven = np.flatnonzero(linear.gains[:, 0])
    rest = total - springs.sum(axis=0) - controllers.sum(axis=0)
    names = [*motion.springs, *(f"{motion.motor_names[m]} (controller)" for m in driven)]
    energies = np.vstack([springs, controllers[driven], rest])
    return _shares([*names, GRAVITY_AND_LOADS], np.where(modal.eigenvalues > 0, energies, 0.0))


def _shares(names: list[str], energies: Array) -> Shares:
    total = energies.sum(axis=0)
    return Shares(tuple(names), np.divide(energies, total, out=np.zeros_like(energies), where=total > 0))


def _moved(modal: Modes, rates: Sequence[Scalar]) -> Array:
    """Return the changes (rates, modes) in each mode of what has these rates."""
    linear = modal.linear
    _, by_qd, _ = linear.motion.jacobians(rates, linear.state)
    moved: Array = by_qd[:, list(linear.kept)] @ modal.shapes
    return moved
