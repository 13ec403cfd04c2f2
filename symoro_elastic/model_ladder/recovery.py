"""Motions of a whole machine from those of the machine without some springs."""

from __future__ import annotations

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.simulation.observed import Motion, Observer
from symoro_elastic.simulation.reference import Reference


def whole_motion(reference: Reference, reduced: Observer, motion: Motion) -> Motion:
    """Return the motion of the whole machine of a reference from that of a reduced one.

    Springs that are left out stay where the motion starts; those that are static deflect by the reactions.
    Springs that are static in the whole machine have no variable in its motion.
    """
    rows = {joint.name: k for k, joint in enumerate(reference.machine.moving_joints)}
    moved = [rows[joint.name] for joint in reduced.machine.moving_joints]
    static = [rows[joint.name] for joint in reduced.machine.static.values() if joint.name in rows]

    def spread(x: Array, start: Array) -> Array:
        found = np.tile(start, (len(x), 1))
        found[:, moved] = x
        return found

    still = np.zeros(len(rows))
    q, qd, qdd = spread(motion.q, reference.start.q), spread(motion.qd, still), spread(motion.qdd, still)
    if static:
        q[:, static] = reduced.deflections(motion)
    return Motion(motion.t, q, qd, qdd, motion.tau, motion.f_ext)
