"""Placement of frames of planar_2r [1], [2]: 8x 4+, 4 sin/cos a call.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 568275864  # of the files of this package: those of another run are not imported


def constants(_f, p):
    (_, _, _, l1, l2, _, _, _, _) = p
    return (l1, l2)


def program(_f, q, c):
    (q1, q2) = q
    (l1, l2) = c

    # Geometry, joint 1 (shoulder) [1], [2].
    sin_q1 = _f.sin(q1)
    cos_q1 = _f.cos(q1)

    # Geometry, joint 2 (elbow) [1], [2].
    sin_q2 = _f.sin(q2)
    cos_q2 = _f.cos(q2)
    P2_x = l1*cos_q1
    P2_y = l1*sin_q1
    A2_11 = cos_q1*cos_q2 - sin_q1*sin_q2
    A2_12 = -(cos_q1*sin_q2 + sin_q1*cos_q2)

    # Geometry, joint 3 (tip) [1], [2].
    P3_x = P2_x + l2*A2_11
    P3_y = P2_y - l2*A2_12

    # Results.
    return (
        (
            cos_q1, -sin_q1, 0.0, 0.0, sin_q1, cos_q1, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0,
            1.0, A2_11, A2_12, 0.0, P2_x, -A2_12, A2_11, 0.0, P2_y, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0,
            1.0, A2_11, A2_12, 0.0, P3_x, -A2_12, A2_11, 0.0, P3_y, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0,
            1.0,
        ),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=2),
    parameters=9,
    results=((3, 4, 4),),
)
