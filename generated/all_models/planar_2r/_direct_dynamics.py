"""Direct dynamic model of planar_2r [12]-[36]: 28x 15+, 4 sin/cos a call; 7x 4+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _run


def constants(_f, p):
    (g0, m1, m2, l1, _, lc1, lc2, I1, I2) = p

    # Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14].
    MS1_x = m1*lc1
    J1_yy = I1 + lc1*MS1_x

    # Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14].
    MS2_x = m2*lc2
    J2_yy = I2 + lc2*MS2_x

    # Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [28]-[32].
    Hinv2 = 1.0/J2_yy
    UH2_2 = MS2_x*Hinv2
    K2_12a = m2 - MS2_x*UH2_2
    K2_12b = m2 - K2_12a
    return (g0, l1, MS1_x, J1_yy, MS2_x, Hinv2, UH2_2, K2_12a, K2_12b)


def program(_f, q, qd, tau, c):
    (q1, q2) = q
    (qd1, qd2) = qd
    (tau1, tau2) = tau
    (g0, l1, MS1_x, J1_yy, MS2_x, Hinv2, UH2_2, K2_12a, K2_12b) = c

    # Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14].
    sin_q1 = _f.sin(q1)
    cos_q1 = _f.cos(q1)

    # Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14].
    sin_q2 = _f.sin(q2)
    cos_q2 = _f.cos(q2)
    w2_z = qd1 + qd2
    g2_1 = -qd1*(l1*qd1)
    b2_1 = w2_z*(MS2_x*w2_z)

    # Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [28]-[32].
    K2_12c = sin_q2*K2_12b
    K2_12 = cos_q2*K2_12c
    K2_22 = K2_12a + sin_q2*K2_12c
    qdf2 = tau2*Hinv2
    al2_2 = g2_1*K2_12 - (sin_q2*b2_1 - cos_q2*(MS2_x*qdf2))

    # Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [28]-[32].
    Js1_16 = l1*K2_12
    Js1_26a = l1*K2_22
    Js1_26 = MS1_x + Js1_26a
    Js1_66 = J1_yy + l1*Js1_26a
    bs1_6 = -(tau2 + l1*al2_2)
    Hinv1 = 1.0/Js1_66
    UH1_1 = Js1_16*Hinv1
    UH1_2 = Js1_26*Hinv1
    Gb1 = tau1 + bs1_6
    qdf1 = Hinv1*Gb1

    # Forward recursion: accelerations and torques, joint 1 (shoulder) [33]-[36].
    vd1_x = g0*sin_q1
    vd1_y = g0*cos_q1
    qdd1 = qdf1 - (UH1_1*vd1_x + UH1_2*vd1_y)

    # Forward recursion: accelerations and torques, joint 2 (elbow) [33]-[36].
    vd2_y = cos_q2*(vd1_y + l1*qdd1) - sin_q2*(g2_1 + vd1_x)
    wd2_z = qdf2 - UH2_2*vd2_y
    qdd2 = wd2_z - qdd1

    # Results.
    return (
        (qdd1, qdd2),
    )


model = _run.Model(
    constants,
    program,
    arguments=dict(q=2, qd=2, tau=2),
    parameters=9,
    results=((2,),),
)
