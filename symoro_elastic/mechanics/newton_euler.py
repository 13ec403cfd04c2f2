"""Newton-Euler equations of a body [12], [14]: as printed, and in forms with fewer operations."""

from __future__ import annotations

from symoro_elastic.mechanics.spatial import Matrix, RigidInertia, Twist, Vector, Wrench, cross


def newton_euler(body: RigidInertia, w: Vector, wd: Vector, vd: Vector, U: Matrix) -> Wrench:
    """Wrench F that gives a body its acceleration [12], about the origin of its frame.

    U = hat(wd) + hat(w) hat(w). With it F = [M v' + U MS; MS x v' + J wd + w x (J w)], where SYMORO's form of the
    moment needs 15 products. Its terms that may cancel weight against acceleration come first, so that little is
    rounded before they do. `newton_euler_as_printed` is the printed form.
    """
    force = body.mass * vd + U * body.moments  # (12)
    (x, y, z), (xx, xy, xz, yy, yz, zz) = body.moments, body.inertia
    accelerated = Vector(
        xx * wd.x + y * vd.z - z * vd.y,
        yy * wd.y + z * vd.x - x * vd.z,
        zz * wd.z + x * vd.y - y * vd.x,
    )  # fmt: skip
    gyroscopic = Vector(  # J wd + w x (J w) without the products of J's diagonal and wd
        (U.y.y - U.z.z) * yz + w.y * w.z * (zz - yy) + xz * U.y.x - xy * U.z.x,
        (w.z * w.z - w.x * w.x) * xz + w.x * w.z * (xx - zz) - yz * U.x.y + xy * U.z.y,
        (U.x.x - U.y.y) * xy + w.x * w.y * (yy - xx) + yz * U.x.z - xz * U.y.z,
    )
    return Wrench(force, accelerated + gyroscopic)  # (12)


def newton_euler_as_printed(body: RigidInertia, w: Vector, Vd: Twist) -> Wrench:
    """Wrench F = JJ V' + [w x (w x MS); w x (J w)] [12], term by term."""
    return body.spatial * Vd + Wrench(cross(w, cross(w, body.moments)), cross(w, body.inertia * w))  # (12)


def bias_wrench(body: RigidInertia, w: Vector, bias: Twist) -> Wrench:
    """Wrench beta = -[w x (w x MS); w x (J w)] - JJ bias [14], for a V' split into bias and remainder.

    With a bias of zero it is the printed form.
    """
    return -(Wrench(cross(w, cross(w, body.moments)), cross(w, body.inertia * w)) + body.spatial * bias)  # (14)
