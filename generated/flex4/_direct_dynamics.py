"""Direct dynamic model of flex4 [12]-[36]: 133x 125+, 4 sin/cos a call; 23x 17+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and arrays.
"""


def constants(_f, p):
    ZZ1 = p[5]
    IA1 = p[10]
    L2 = p[22]
    XX3 = p[23]
    XZ3 = p[25]
    YY3 = p[26]
    YZ3 = p[27]
    ZZ3 = p[28]
    MX3 = p[29]
    MY3 = p[30]
    M3 = p[32]
    IA3 = p[33]
    XX4 = p[34]
    XY4 = p[35]
    XZ4 = p[36]
    YY4 = p[37]
    YZ4 = p[38]
    ZZ4 = p[39]
    MX4 = p[40]
    MY4 = p[41]
    MZ4 = p[42]
    M4 = p[43]

    # Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14].
    dJ3_yz = YY3 - ZZ3
    dJ3_xz = XX3 - ZZ3
    dJ3_xy = XX3 - YY3

    # Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14].
    dJ4_yz = YY4 - ZZ4
    dJ4_xz = XX4 - ZZ4
    dJ4_xy = XX4 - YY4

    # Backward recursion: articulated inertias and wrenches, joint 4 (j4) [28]-[32].
    Hinv4 = 1.0/ZZ4
    UH4_4 = XZ4*Hinv4
    UH4_5 = YZ4*Hinv4
    K4_14 = MY4*UH4_4
    K4_44 = XX4 - XZ4*UH4_4
    K4_15 = MZ4 + MY4*UH4_5
    K4_45 = XY4 - XZ4*UH4_5
    K4_24 = -(MZ4 + MX4*UH4_4)
    K4_25 = -MX4*UH4_5
    K4_55 = YY4 - YZ4*UH4_5

    # Backward recursion: articulated inertias and wrenches, joint 3 (j3) [28]-[32].
    Js3_14a = K4_14 - K4_25
    Js3_14b = K4_15 + K4_24
    Js3_44a = K4_44 - K4_55
    Js3_44b = 2.0*K4_45
    Js3_33 = M3 + M4
    H3 = ZZ3 + IA3
    Hinv3 = 1.0/H3
    UH3_4 = XZ3*Hinv3
    UH3_5 = YZ3*Hinv3
    K3_14a = MY3*UH3_4
    K3_44a = XZ3*UH3_4
    K3_15a = MY3*UH3_5
    K3_45a = XZ3*UH3_5
    K3_24a = MX3*UH3_4
    K3_25a = MX3*UH3_5
    K3_55a = YZ3*UH3_5

    # Backward recursion: articulated inertias and wrenches, joint 2 (j2) [28]-[32].
    Js2_66b = L2*Js3_33

    # Backward recursion: articulated inertias and wrenches, joint 1 (j1) [28]-[32].
    H1 = ZZ1 + IA1
    Hinv1 = 1.0/H1
    return (
        dJ3_yz, dJ3_xz, dJ3_xy, dJ4_yz, dJ4_xz, dJ4_xy, Hinv4, UH4_4, UH4_5, K4_14, K4_44, K4_15,
        K4_45, K4_24, K4_25, K4_55, Js3_14a, Js3_14b, Js3_44a, Js3_44b, Hinv3, UH3_4, UH3_5,
        K3_14a, K3_44a, K3_15a, K3_45a, K3_24a, K3_25a, K3_55a, Js2_66b, Hinv1,
    )


def program(_f, q, qd, tau, p, c):
    th2 = q[1]
    th3 = q[2]
    th4 = q[3]
    qd1 = qd[0]
    qd2 = qd[1]
    qd3 = qd[2]
    qd4 = qd[3]
    tau1 = tau[0]
    tau3 = tau[1]
    ZZ2 = p[16]
    k2 = p[21]
    L2 = p[22]
    XX3 = p[23]
    XY3 = p[24]
    XZ3 = p[25]
    YY3 = p[26]
    YZ3 = p[27]
    MX3 = p[29]
    MY3 = p[30]
    MZ3 = p[31]
    XY4 = p[35]
    XZ4 = p[36]
    YZ4 = p[38]
    ZZ4 = p[39]
    MX4 = p[40]
    MY4 = p[41]
    MZ4 = p[42]
    k4 = p[44]
    G3 = p[45]
    dJ3_yz = c[0]
    dJ3_xz = c[1]
    dJ3_xy = c[2]
    dJ4_yz = c[3]
    dJ4_xz = c[4]
    dJ4_xy = c[5]
    Hinv4 = c[6]
    UH4_4 = c[7]
    UH4_5 = c[8]
    K4_14 = c[9]
    K4_44 = c[10]
    K4_15 = c[11]
    K4_45 = c[12]
    K4_24 = c[13]
    K4_25 = c[14]
    K4_55 = c[15]
    Js3_14a = c[16]
    Js3_14b = c[17]
    Js3_44a = c[18]
    Js3_44b = c[19]
    Hinv3 = c[20]
    UH3_4 = c[21]
    UH3_5 = c[22]
    K3_14a = c[23]
    K3_44a = c[24]
    K3_15a = c[25]
    K3_45a = c[26]
    K3_24a = c[27]
    K3_25a = c[28]
    K3_55a = c[29]
    Js2_66b = c[30]
    Hinv1 = c[31]

    # Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14].
    w2_z = qd1 + qd2
    ww2_zz = w2_z*w2_z

    # Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14].
    sin_th3 = _f.sin(th3)
    cos_th3 = _f.cos(th3)
    w3_x = sin_th3*w2_z
    w3_y = cos_th3*w2_z
    ww3_xx = w3_x*w3_x
    ww3_yy = w3_y*w3_y
    ww3_zz = qd3*qd3
    ww3_xy = w3_x*w3_y
    ww3_xz = qd3*w3_x
    ww3_yz = qd3*w3_y
    g3_1a = L2*ww2_zz
    g3_1 = -cos_th3*g3_1a
    g3_2 = sin_th3*g3_1a
    b3_3 = MZ3*(ww3_xx + ww3_yy) - (MX3*ww3_xz + MY3*ww3_yz)
    b3_4 = XY3*ww3_xz - (YZ3*(ww3_yy - ww3_zz) - ww3_yz*dJ3_yz + XZ3*ww3_xy)
    b3_5 = XZ3*(ww3_xx - ww3_zz) - ww3_xz*dJ3_xz + YZ3*ww3_xy - XY3*ww3_yz
    b3_6 = XZ3*ww3_yz - (XY3*(ww3_xx - ww3_yy) - ww3_xy*dJ3_xy + YZ3*ww3_xz)

    # Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14].
    sin_th4 = _f.sin(th4)
    cos_th4 = _f.cos(th4)
    w4_x = cos_th4*w3_x + sin_th4*w3_y
    w4_y = cos_th4*w3_y - sin_th4*w3_x
    w4_z = qd3 + qd4
    ww4_xx = w4_x*w4_x
    ww4_yy = w4_y*w4_y
    ww4_zz = w4_z*w4_z
    ww4_xy = w4_x*w4_y
    ww4_xz = w4_x*w4_z
    ww4_yz = w4_y*w4_z
    g4_4 = qd4*w4_y
    g4_5 = -qd4*w4_x
    b4_3 = MZ4*(ww4_xx + ww4_yy) - (MX4*ww4_xz + MY4*ww4_yz)
    b4_4 = XY4*ww4_xz - (YZ4*(ww4_yy - ww4_zz) - ww4_yz*dJ4_yz + XZ4*ww4_xy)
    b4_5 = XZ4*(ww4_xx - ww4_zz) - ww4_xz*dJ4_xz + YZ4*ww4_xy - XY4*ww4_yz
    b4_6 = XZ4*ww4_yz - (XY4*(ww4_xx - ww4_yy) - ww4_xy*dJ4_xy + YZ4*ww4_xz)

    # Backward recursion: articulated inertias and wrenches, joint 4 (j4) [28]-[32].
    Gamma4 = -k4*th4
    Gb4 = Gamma4 + b4_6
    al4_3 = -(b4_3 + MX4*g4_5 - MY4*g4_4)
    al4_4 = g4_4*K4_44 + g4_5*K4_45 + UH4_4*Gb4 - b4_4
    al4_5 = g4_4*K4_45 + g4_5*K4_55 + UH4_5*Gb4 - b4_5

    # Backward recursion: articulated inertias and wrenches, joint 3 (j3) [28]-[32].
    Js3_14c = sin_th4*Js3_14a + cos_th4*Js3_14b
    Js3_14d = sin_th4*Js3_14c
    Js3_14 = K4_14 - Js3_14d
    Js3_15a = cos_th4*Js3_14c
    Js3_25 = K4_25 + Js3_14d
    Js3_44c = sin_th4*Js3_44a + cos_th4*Js3_44b
    Js3_44d = sin_th4*Js3_44c
    Js3_15 = MZ3 + Js3_15a - K4_24
    Js3_24 = -(MZ3 + K4_15 - Js3_15a)
    Js3_34 = MY3 + MY4*cos_th4 + MX4*sin_th4
    Js3_35 = MY4*sin_th4 - MX4*cos_th4 - MX3
    Js3_44 = XX3 + K4_44 - Js3_44d
    Js3_45 = XY3 - (K4_45 - cos_th4*Js3_44c)
    Js3_55 = YY3 + K4_55 + Js3_44d
    bs3_3 = b3_3 - al4_3
    bs3_4 = b3_4 - (cos_th4*al4_4 - sin_th4*al4_5)
    bs3_5 = b3_5 - (sin_th4*al4_4 + cos_th4*al4_5)
    bs3_6 = b3_6 - Gamma4
    K3_14 = Js3_14 + K3_14a
    K3_44 = Js3_44 - K3_44a
    K3_15 = Js3_15 + K3_15a
    K3_45 = Js3_45 - K3_45a
    K3_24 = Js3_24 - K3_24a
    K3_25 = Js3_25 - K3_25a
    K3_55 = Js3_55 - K3_55a
    Gb3 = tau3 + bs3_6
    al3_3 = ww3_yz*Js3_34 - ww3_xz*Js3_35 - bs3_3
    al3_4 = g3_1*K3_14 + g3_2*K3_24 + ww3_yz*K3_44 - ww3_xz*K3_45 + UH3_4*Gb3 - bs3_4
    al3_5 = g3_1*K3_15 + g3_2*K3_25 + ww3_yz*K3_45 - ww3_xz*K3_55 + UH3_5*Gb3 - bs3_5

    # Backward recursion: articulated inertias and wrenches, joint 2 (j2) [28]-[32].
    Gamma2 = -k2*th2
    Js2_36 = K3_25 + sin_th3*(sin_th3*(K3_14 - K3_25) + cos_th3*(K3_15 + K3_24))
    Js2_66a = sin_th3*Js3_34 + cos_th3*Js3_35
    Js2_66 = (
        ZZ2 + K3_55 + sin_th3*(sin_th3*(K3_44 - K3_55) + 2.0*K3_45*cos_th3) - L2*(Js2_66a
        + Js2_66a - Js2_66b)
    )
    bs2_6 = L2*al3_3 - (sin_th3*al3_4 + cos_th3*al3_5)
    Hinv2 = 1.0/Js2_66
    Gb2 = Gamma2 + bs2_6

    # Backward recursion: articulated inertias and wrenches, joint 1 (j1) [28]-[32].
    Gb1 = tau1 - Gamma2

    # Forward recursion: accelerations and torques, joint 1 (j1) [33]-[36].
    qdd1 = Hinv1*Gb1

    # Forward recursion: accelerations and torques, joint 2 (j2) [33]-[36].
    qdd2 = -Hinv2*(Js2_66*qdd1 - (Gb2 + G3*Js2_36))
    wd2_z = qdd1 + qdd2

    # Forward recursion: accelerations and torques, joint 3 (j3) [33]-[36].
    vd3_x = g3_1 - G3*sin_th3
    vd3_y = g3_2 - G3*cos_th3
    wd3_x = ww3_yz + sin_th3*wd2_z
    wd3_y = cos_th3*wd2_z - ww3_xz
    qdd3 = Hinv3*(Gb3 - (MX3*vd3_y - MY3*vd3_x) - (XZ3*wd3_x + YZ3*wd3_y))

    # Forward recursion: accelerations and torques, joint 4 (j4) [33]-[36].
    vd4_x = cos_th4*vd3_x + sin_th4*vd3_y
    vd4_y = cos_th4*vd3_y - sin_th4*vd3_x
    wd4_x = g4_4 + cos_th4*wd3_x + sin_th4*wd3_y
    wd4_y = g4_5 - (sin_th4*wd3_x - cos_th4*wd3_y)
    qdd4 = -Hinv4*(MX4*vd4_y - MY4*vd4_x - Gb4 + XZ4*wd4_x + YZ4*wd4_y + ZZ4*qdd3)

    # Results.
    return (
        (qdd1, qdd2, qdd3, qdd4),
    )
