"""Derivatives of wrench and torques by the motion of the base.

Its six degrees of freedom have the numbers `DEGREES`, linear part first. All that it carries is one body.
In axes of the base a velocity e more changes, as in the recursion for joints,

    angular: dA = [0; w x e],   theta = e,       linear: nothing,

where the acceleration of its origin is given; an acceleration changes dA by itself. Turned by a small
angle about e, its components of velocity and acceleration kept, it feels gravity as if its origin were
accelerated by e x g, in its axes; a small displacement changes nothing. Under a known wrench that is
the acceleration of all that falls: its own changes by g x e, those of the joints do not.
"""

from __future__ import annotations

from symoro_elastic.mechanics.base_body import DEGREES
from symoro_elastic.mechanics.derivatives.torques import Change, Entries, TorqueDerivatives
from symoro_elastic.mechanics.spatial import IDENTITY, ZERO, Twist, Vector, cross


def add_base(made: TorqueDerivatives, w: Vector) -> None:
    """Rows of the wrench on a base that turns with `w`, columns of its velocity and acceleration."""
    whole = made.composites[0]
    sped = {m: Change(Twist(ZERO, cross(w, e)), e) for m, e in zip(DEGREES[3:], IDENTITY, strict=True)}
    for m, entries in zip(DEGREES, whole.inertia.spatial.rows, strict=True):
        made.by_qdd.update({(m, n): x for n, x in zip(DEGREES, entries, strict=True)})
    for n, change in sped.items():
        made.by_qd.update({(m, n): x for m, x in zip(DEGREES, whole.wrench(change).entries, strict=True)})
    for j in made.moved:
        row, (by_q, by_qd) = made.rows[j, 0], made.columns[j, 0]
        made.by_qd.update({(j, n): row.of(change) for n, change in sped.items()})
        for k, m in enumerate(DEGREES):
            made.by_q[m, j], made.by_qd[m, j] = by_q.entries[k], by_qd.entries[k]
            made.by_qdd[m, j] = made.by_qdd[j, m] = row.of_acceleration.entries[k]


def by_pose(by_acceleration: Entries, gravity: Vector) -> Entries:
    """Columns of a small displacement (zero) and turn of a base whose acceleration is given, from its columns."""
    found: Entries = {}
    for n, e in zip(DEGREES[3:], IDENTITY, strict=True):
        x, y, z = cross(e, gravity)
        for i in dict.fromkeys(i for i, _ in by_acceleration):
            a, b, c = (by_acceleration.get((i, m), 0) for m in DEGREES[:3])
            found[i, n] = x * a + y * b + z * c
    return found


def falling_by_pose(gravity: Vector) -> Entries:
    """Columns of a small displacement (zero) and turn: of the acceleration of a base under a known wrench."""
    turned = {n: (*cross(gravity, e), 0, 0, 0) for n, e in zip(DEGREES[3:], IDENTITY, strict=True)}
    return {(m, n): x for n, column in turned.items() for m, x in zip(DEGREES, column, strict=True)}
