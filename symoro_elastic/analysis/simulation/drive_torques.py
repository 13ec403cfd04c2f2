"""Torques of the drives of a motion by their states, and these states where the torques at the start hold the machine.

    tau = C z + Kv D (r - x) + kfv D rd - D xd + (kfa rdd + tau_0) P_0

D and P_0 are what goes straight through a drive, and through the path of its torque.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from symoro_elastic.analysis.control.cascade import system_of
from symoro_elastic.analysis.control.closed_loop import drive_system
from symoro_elastic.analysis.simulation.reference_motion import Motion, Reference
from symoro_elastic.foundation.array_types import Array


def states_of_drives(reference: Reference) -> Array:
    """Return the states of all drives, in order, in which they have given the torques at the start for long."""
    found = [np.zeros(0)]
    for one, torque in zip(reference.drives, reference.start.torques, strict=False):
        path = system_of(one.path)
        integral = np.zeros(len(drive_system(one).A) - len(path.A))
        found += [integral, -np.linalg.solve(path.A, path.B * torque)]
    return np.concatenate(found)


def torques_of_drives(reference: Reference, motion: Motion, z: Array) -> Array:
    """Return the torques (N, m) of the drives at their states z (N, states) along a motion."""
    return np.stack(list(_torques(reference, motion, z)), axis=1)


def _torques(reference: Reference, motion: Motion, z: Array) -> Iterator[Array]:
    (x, xd), (r, rd, rdd) = reference.of_motors(motion), reference.at(motion.t)
    first = 0
    for k, one in enumerate(reference.drives):
        whole, through = drive_system(one), system_of(one.path).D
        by_position, by_rate, by_acceleration = whole.of_set_point
        last = first + len(whole.A)
        own = z[:, first:last] @ whole.C + by_position * (r - x)[:, k] + by_rate * rd[:, k]
        yield own + by_acceleration * rdd[:, k] - whole.through[1] * xd[:, k] + through * reference.start.torques[k]
        first = last
