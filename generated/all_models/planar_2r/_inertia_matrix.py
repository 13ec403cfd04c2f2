"""Inertia matrix of planar_2r [8]: 3x 5+, 1 sin/cos a call; 5x 2+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 568275864  # of the files of this package: those of another run are not imported


def constants(_f, p):
    (_, m1, m2, l1, _, lc1, lc2, I1, I2) = p

    # Geometry, joint 1 (shoulder) [1].
    MS1_x = m1*lc1
    J1_yy = I1 + lc1*MS1_x

    # Geometry, joint 2 (elbow) [1].
    MS2_x = m2*lc2
    J2_yy = I2 + lc2*MS2_x

    # Composite inertias and inertia matrix, joint 1 (shoulder) [8], [13].
    J1_czza = m2*l1
    return (l1, J1_yy, MS2_x, J2_yy, J1_czza)


def program(_f, q, c):
    (_, q2) = q
    (l1, J1_yy, MS2_x, J2_yy, J1_czza) = c

    # Geometry, joint 2 (elbow) [1].
    cos_q2 = _f.cos(q2)

    # Composite inertias and inertia matrix, joint 2 (elbow) [8], [13].
    A1_2a = cos_q2*MS2_x
    A1_2 = J2_yy + l1*A1_2a

    # Composite inertias and inertia matrix, joint 1 (shoulder) [8], [13].
    J1_czz = J1_yy + J2_yy + l1*(A1_2a + A1_2a + J1_czza)

    # Results.
    return (
        (J1_czz, A1_2, A1_2, J2_yy),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=2),
    parameters=9,
    results=((2, 2),),
)
