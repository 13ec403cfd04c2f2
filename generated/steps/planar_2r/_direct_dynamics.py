"""Direct dynamic model of planar_2r [12]-[36]: 26x 15+, 4 sin/cos a call; 8x 4+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 786373309  # of the files of this package: those of another run are not imported


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
    K2_22a = m2 - MS2_x*UH2_2
    K2_22b = m2 - K2_22a

    # Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [28]-[32].
    Js1_66a = l1*l1
    return (g0, m2, l1, MS1_x, J1_yy, MS2_x, Hinv2, UH2_2, K2_22a, K2_22b, Js1_66a)


def program(_f, q, qd, tau, c):
    (q1, q2) = q
    (qd1, qd2) = qd
    (tau1, tau2) = tau
    (g0, m2, l1, MS1_x, J1_yy, MS2_x, Hinv2, UH2_2, K2_22a, K2_22b, Js1_66a) = c

    # Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14].
    sin_q1 = _f.sin(q1)
    cos_q1 = _f.cos(q1)
    Vk1_1 = g0*sin_q1
    Vk1_2 = g0*cos_q1
    b1_6 = -MS1_x*Vk1_2

    # Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14].
    sin_q2 = _f.sin(q2)
    cos_q2 = _f.cos(q2)
    w2_z = qd1 + qd2
    Vk2_1a = qd1*(l1*qd1) - Vk1_1
    Vk2_1 = sin_q2*Vk1_2 - cos_q2*Vk2_1a
    Vk2_2 = sin_q2*Vk2_1a + cos_q2*Vk1_2
    b2_2 = -m2*Vk2_2
    b2_6 = -MS2_x*Vk2_2
    b2_1 = w2_z*(MS2_x*w2_z) - m2*Vk2_1

    # Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [28]-[32].
    K2_22 = K2_22a + sin_q2*(sin_q2*K2_22b)
    Gb2 = tau2 + b2_6
    qdf2 = Hinv2*Gb2
    al2_2 = cos_q2*(MS2_x*qdf2 - b2_2) - sin_q2*b2_1

    # Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [28]-[32].
    bs1_6 = b1_6 - (tau2 + l1*al2_2)
    Gb1 = tau1 + bs1_6
    Js1_66 = J1_yy + K2_22*Js1_66a
    qdf1 = Gb1/Js1_66

    # Forward recursion: accelerations and torques, joint 2 (elbow) [33]-[36].
    Vr2_2 = cos_q2*(l1*qdf1)
    wd2_z = qdf2 - UH2_2*Vr2_2
    qdd2 = wd2_z - qdf1

    # Results.
    return (
        (qdf1, qdd2),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=2, qd=2, tau=2),
    parameters=9,
    results=((2,),),
)
