"""Inverse dynamic model: motor torques and elastic accelerations of planar_2r [37]-[61]: 21x 13+, 4 sin/cos a call; 4x 2+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 786373309  # of the files of this package: those of another run are not imported


def constants(_f, p):
    (g0, m1, m2, l1, _, lc1, lc2, I1, I2) = p

    # Forward recursion: velocities, accelerations, wrenches, joint 1 (shoulder) [1], [3], [6], [12].
    MS1_x = m1*lc1
    J1_yy = I1 + lc1*MS1_x

    # Forward recursion: velocities, accelerations, wrenches, joint 2 (elbow) [1], [3], [6], [12].
    MS2_x = m2*lc2
    J2_yy = I2 + lc2*MS2_x
    return (g0, m2, l1, MS1_x, J1_yy, MS2_x, J2_yy)


def program(_f, q, qd, qdd_motor, c):
    (q1, q2) = q
    (qd1, qd2) = qd
    (qdd1, qdd2) = qdd_motor
    (g0, m2, l1, MS1_x, J1_yy, MS2_x, J2_yy) = c

    # Forward recursion: velocities, accelerations, wrenches, joint 1 (shoulder) [1], [3], [6], [12].
    sin_q1 = _f.sin(q1)
    cos_q1 = _f.cos(q1)
    ww1_zz = qd1*qd1
    vd1_x = g0*sin_q1
    vd1_y = g0*cos_q1
    Fb1_6 = qdd1*J1_yy + MS1_x*vd1_y

    # Forward recursion: velocities, accelerations, wrenches, joint 2 (elbow) [1], [3], [6], [12].
    sin_q2 = _f.sin(q2)
    cos_q2 = _f.cos(q2)
    w2_z = qd1 + qd2
    wd2_z = qdd1 + qdd2
    ww2_zz = w2_z*w2_z
    vd2_xa = vd1_x - l1*ww1_zz
    vd2_xb = vd1_y + l1*qdd1
    vd2_x = cos_q2*vd2_xa + sin_q2*vd2_xb
    vd2_y = cos_q2*vd2_xb - sin_q2*vd2_xa
    Fb2_1 = m2*vd2_x - MS2_x*ww2_zz
    Fb2_2 = m2*vd2_y + MS2_x*wd2_z
    Fb2_6 = J2_yy*wd2_z + MS2_x*vd2_y

    # Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [50]-[56].
    f1_6 = Fb1_6 + Fb2_6 + l1*(sin_q2*Fb2_1 + cos_q2*Fb2_2)

    # Results.
    return (
        (f1_6, Fb2_6),
        (qdd1, qdd2),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=2, qd=2, qdd_motor=2),
    parameters=9,
    results=((2,), (2,)),
)
