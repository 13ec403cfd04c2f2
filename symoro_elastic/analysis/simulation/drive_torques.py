"""Drives along motions: inputs of their laws, states at the start, torques."""

from __future__ import annotations

import numpy as np

from symoro_elastic.analysis.control.drive_laws import law_of
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.foundation.array_types import Array


def inputs_of(reference: Reference, motion: Motion, controlled: Array, xd: Array) -> Array:
    """Return the inputs (N, m, 6) of all drives along a motion, with the positions (N, m) that are controlled."""
    fed = reference.fed_torques(motion.t)
    return np.stack([*reference.at(motion.t), controlled, xd, fed], axis=-1)


def states_of_drives(reference: Reference) -> Array:
    """Return the states of all drives, in order, in which they have given the torques at the start for long."""
    if not reference.drives:
        return np.zeros(0)
    first = np.zeros((1, len(reference.drives)))
    r, rd, _ = reference.at(np.zeros(1))
    tau = reference.start.torques[: len(reference.drives)][None]
    (u,) = np.stack([r, rd, first, first, first, tau], axis=-1)
    return np.concatenate([law_of(one).rest @ x for one, x in zip(reference.drives, u, strict=True)])


def torques_of_drives(reference: Reference, motion: Motion, z: Array) -> Array:
    """Return the torques (N, m) of the drives at their states z (N, states) along a motion."""
    x, xd = reference.of_motors(motion)
    u, found, first = inputs_of(reference, motion, x, xd), [], 0
    for k, law in enumerate(map(law_of, reference.drives)):
        last = first + len(law.A)
        found.append(law.torques(z[:, first:last], u[:, k]))
        first = last
    return np.stack(found, axis=1)
