"""Direct dynamic model of planar_2r [12]-[36]: 30x 16+, 4 sin/cos a call; 7x 4+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and arrays.
"""


def constants(_f, p):
    m1 = p[1]
    m2 = p[2]
    lc1 = p[5]
    lc2 = p[6]
    I1 = p[7]
    I2 = p[8]

    # Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14].
    MS1_x = m1*lc1
    J1_yy = I1 + lc1*MS1_x

    # Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14].
    MS2_x = m2*lc2
    J2_yy = I2 + lc2*MS2_x

    # Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [28]-[32].
    Hinv2 = 1.0/J2_yy
    UH2_2 = MS2_x*Hinv2
    K2_22 = m2 - MS2_x*UH2_2

    # Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [28]-[32].
    Js1_12a = m2 - K2_22
    return (MS1_x, J1_yy, MS2_x, J2_yy, Hinv2, UH2_2, K2_22, Js1_12a)


def program(_f, q, qd, tau, p, c):
    q1 = q[0]
    q2 = q[1]
    qd1 = qd[0]
    qd2 = qd[1]
    tau1 = tau[0]
    tau2 = tau[1]
    g0 = p[0]
    m2 = p[2]
    l1 = p[3]
    MS1_x = c[0]
    J1_yy = c[1]
    MS2_x = c[2]
    J2_yy = c[3]
    Hinv2 = c[4]
    UH2_2 = c[5]
    K2_22 = c[6]
    Js1_12a = c[7]

    # Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14].
    sin_q1 = _f.sin(q1)
    cos_q1 = _f.cos(q1)
    ww1_zz = qd1*qd1

    # Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14].
    sin_q2 = _f.sin(q2)
    cos_q2 = _f.cos(q2)
    w2_z = qd1 + qd2
    ww2_zz = w2_z*w2_z
    g2_1a = l1*ww1_zz
    g2_1 = -cos_q2*g2_1a
    g2_2 = sin_q2*g2_1a
    b2_1 = MS2_x*ww2_zz

    # Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [28]-[32].
    al2_2 = g2_2*K2_22 + tau2*UH2_2
    al2_1 = m2*g2_1 - b2_1

    # Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [28]-[32].
    Js1_12b = sin_q2*Js1_12a
    Js1_12 = cos_q2*Js1_12b
    Js1_16 = l1*Js1_12
    Js1_26a = l1*(K2_22 + sin_q2*Js1_12b)
    Js1_26 = MS1_x + Js1_26a
    Js1_66 = J1_yy + l1*Js1_26a
    bs1_2 = -(sin_q2*al2_1 + cos_q2*al2_2)
    bs1_6 = l1*bs1_2 - tau2
    Hinv1 = 1.0/Js1_66
    Gb1 = tau1 + bs1_6

    # Forward recursion: accelerations and torques, joint 1 (shoulder) [33]-[36].
    vd1_x = g0*sin_q1
    vd1_y = g0*cos_q1
    qdd1 = Hinv1*(Gb1 - (Js1_16*vd1_x + Js1_26*vd1_y))

    # Forward recursion: accelerations and torques, joint 2 (elbow) [33]-[36].
    vd2_y = g2_2 - (sin_q2*vd1_x - cos_q2*(vd1_y + l1*qdd1))
    qdd2 = Hinv2*(tau2 - MS2_x*vd2_y - J2_yy*qdd1)

    # Results.
    return (
        (qdd1, qdd2),
    )
