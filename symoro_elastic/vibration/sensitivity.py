"""Derivatives of natural frequencies by parameters.

    d lambda / dp = phi^T (dK/dp - lambda dM/dp) phi,    phi^T M phi = 1

with dK/dp along the equilibrium, which moves with p: dq/dp = -K^-1 dr/dp. Of a repeated frequency the slopes are
the eigenvalues of Phi^T (dK/dp - lambda dM/dp) Phi, since p may split it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.errors import InputError
from symoro_elastic.machine.names import did_you_mean, quoted
from symoro_elastic.vibration.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.vibration.modes import Modes


@dataclass(frozen=True)
class Sensitivity:
    """df/dp (parameters, modes), Hz by the unit of the parameter; zero for modes at 0 Hz.

    `relative` is p/f df/dp: per cent of frequency by per cent of the parameter. `repeated` are the modes of each
    frequency that comes more than once: a parameter splits it, and their slopes are in ascending order for each
    parameter, not by mode.
    """

    parameters: tuple[str, ...]
    values: Array
    slopes: Array
    frequencies: Array
    repeated: tuple[tuple[int, ...], ...] = ()

    @property
    def relative(self) -> Array:
        """p/f df/dp (parameters, modes); zero for modes at 0 Hz."""
        over = np.where(self.frequencies > 0, self.frequencies, np.inf)
        relative: Array = self.values[:, None] * self.slopes / over
        return relative

    def sharing(self, mode: int) -> tuple[int, ...]:
        """Return the modes of the same frequency, this one included."""
        return next((modes for modes in self.repeated if mode in modes), (mode,))

    def strongest(self, mode: int, count: int) -> list[tuple[str, float, float]]:
        """Return the most influential parameters, with the least and the largest of their relative derivatives."""
        relative = self.relative[:, list(self.sharing(mode))]
        order = np.argsort(-np.abs(relative).max(axis=1), kind="stable")[:count]
        rows = [(self.parameters[k], relative[k]) for k in order if relative[k].any()]
        return [(name, float(row.min()), float(row.max())) for name, row in rows]


def sensitivity(modal: Modes, parameters: Sequence[str] = ()) -> Sensitivity:
    """Return the derivatives of all frequencies by parameters, all that have an influence unless some are named.

    Numbers of the table are called `<joint>.<quantity>`, `ram.mass`. Raises `InputError` for unknown names.
    """
    motion = modal.linear.motion
    names = tuple(parameters or motion.parameters)
    for name in names:
        if name not in motion.parameters:
            what = f"no parameter {quoted(name)}{did_you_mean(name, motion.parameters)}"
            raise InputError(motion.source, "sensitivity", what)
    slopes = _eigenvalue_slopes(modal, names)
    frequencies = modal.frequencies
    rate = np.divide(1, 8 * np.pi**2 * frequencies, out=np.zeros_like(frequencies), where=frequencies > 0)
    slopes *= rate
    kept = [k for k in range(len(names)) if parameters or slopes[k].any()]
    values = np.array([motion.parameters[names[k]] for k in kept])
    swinging = [tuple(range(c.start, c.stop)) for c in modal.clusters() if modal.eigenvalues[c.start] > 0]
    repeated = tuple(modes for modes in swinging if len(modes) > 1)
    return Sensitivity(tuple(names[k] for k in kept), values, slopes[kept], frequencies, repeated)


def _eigenvalue_slopes(modal: Modes, names: Sequence[str]) -> Array:
    """Return d lambda / dp (names, modes); zero for modes at 0 Hz."""
    motion, state = modal.linear.motion, modal.linear.state
    swinging = [cluster for cluster in modal.clusters() if modal.eigenvalues[cluster.start] > 0]
    modes = [range(cluster.start, cluster.stop) for cluster in swinging]
    pairs = [(a, b) for cluster in modes for a in cluster for b in cluster]
    slopes = np.zeros((len(names), len(modal.eigenvalues)))
    if not pairs:
        return slopes
    shapes = np.zeros((len(motion.joints), len(modal.eigenvalues)))
    shapes[list(modal.linear.kept)] = modal.shapes
    left, right = shapes[:, [a for a, _ in pairs]], shapes[:, [b for _, b in pairs]]
    squared = np.concatenate([np.full(len(c) ** 2, modal.eigenvalues[list(c)].mean()) for c in modes])
    by_q, by_symbol = motion.change_slopes(state, left, right, -squared * right)
    moved = motion.work_slopes(state, _weights(motion, state, by_q))
    none = np.zeros(len(pairs))
    total = np.array([by_symbol.get(name, none) + moved.get(name, none) for name in names])
    first = 0
    for cluster, size in zip(swinging, map(len, modes), strict=True):
        split = total[:, first : first + size**2].reshape(-1, size, size)
        slopes[:, cluster] = np.linalg.eigvalsh((split + split.transpose(0, 2, 1)) / 2)
        first += size**2
    return slopes


def _weights(motion: EquationsOfMotion, state: State, by_q: Array) -> Array:
    """Return w with w^T dr/dp = by_q^T dq/dp, where the equilibrium moves by dq/dp = -K^-1 dr/dp."""
    weights, sought = np.zeros_like(by_q), list(state.sought)
    if sought:
        stiffness = motion.forces_and_stiffness(state.q)[1][np.ix_(sought, sought)]
        weights[sought] = -np.linalg.lstsq(stiffness.T, by_q[sought], rcond=None)[0]
    return weights
