"""Forces at zero joint acceleration of planar_2r [8]: 17x 8+, 4 sin/cos a call; 2x 0+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 568275864  # of the files of this package: those of another run are not imported


def constants(_f, p):
    (g0, m1, m2, l1, _, lc1, lc2, _, _) = p

    # Forward recursion: velocities, accelerations, wrenches, joint 1 (shoulder) [1], [3], [6], [12].
    MS1_x = m1*lc1

    # Forward recursion: velocities, accelerations, wrenches, joint 2 (elbow) [1], [3], [6], [12].
    MS2_x = m2*lc2
    return (g0, m2, l1, MS1_x, MS2_x)


def program(_f, q, qd, c):
    (q1, q2) = q
    (qd1, qd2) = qd
    (g0, m2, l1, MS1_x, MS2_x) = c

    # Forward recursion: velocities, accelerations, wrenches, joint 1 (shoulder) [1], [3], [6], [12].
    sin_q1 = _f.sin(q1)
    cos_q1 = _f.cos(q1)
    ww1_zz = qd1*qd1
    vd1_x = g0*sin_q1
    vd1_y = g0*cos_q1
    Fb1_6 = MS1_x*vd1_y

    # Forward recursion: velocities, accelerations, wrenches, joint 2 (elbow) [1], [3], [6], [12].
    sin_q2 = _f.sin(q2)
    cos_q2 = _f.cos(q2)
    w2_z = qd1 + qd2
    ww2_zz = w2_z*w2_z
    vd2_xa = vd1_x - l1*ww1_zz
    vd2_x = cos_q2*vd2_xa + sin_q2*vd1_y
    vd2_y = cos_q2*vd1_y - sin_q2*vd2_xa
    Fb2_2 = m2*vd2_y
    Fb2_1 = m2*vd2_x - MS2_x*ww2_zz
    Fb2_6 = MS2_x*vd2_y

    # Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [15].
    f1_6 = Fb1_6 + Fb2_6 + l1*(sin_q2*Fb2_1 + cos_q2*Fb2_2)

    # Results.
    return (
        (f1_6, Fb2_6),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=2, qd=2),
    parameters=9,
    results=((2,),),
)
