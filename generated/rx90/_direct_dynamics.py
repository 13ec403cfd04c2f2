"""Direct dynamic model of rx90 [12]-[36]: 632x 575+, 10 sin/cos a call; 24x 29+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and arrays.
"""


def constants(_f, p):
    XX2 = p[11]
    YY2 = p[14]
    ZZ2 = p[16]
    XX3 = p[23]
    YY3 = p[26]
    ZZ3 = p[28]
    XX4 = p[35]
    YY4 = p[38]
    ZZ4 = p[40]
    XX5 = p[46]
    YY5 = p[49]
    ZZ5 = p[51]
    M5 = p[55]
    XX6 = p[57]
    XY6 = p[58]
    XZ6 = p[59]
    YY6 = p[60]
    YZ6 = p[61]
    ZZ6 = p[62]
    MX6 = p[63]
    MY6 = p[64]
    MZ6 = p[65]
    M6 = p[66]
    IA6 = p[67]

    # Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14].
    dJ2_yz = YY2 - ZZ2
    dJ2_xz = XX2 - ZZ2
    dJ2_xy = XX2 - YY2

    # Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14].
    dJ3_yz = YY3 - ZZ3
    dJ3_xz = XX3 - ZZ3
    dJ3_xy = XX3 - YY3

    # Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14].
    dJ4_yz = YY4 - ZZ4
    dJ4_xz = XX4 - ZZ4
    dJ4_xy = XX4 - YY4

    # Forward recursion: velocities, joint 5 (j5) [1], [3], [7], [14].
    dJ5_yz = YY5 - ZZ5
    dJ5_xz = XX5 - ZZ5
    dJ5_xy = XX5 - YY5

    # Forward recursion: velocities, joint 6 (j6) [1], [3], [7], [14].
    dJ6_yz = YY6 - ZZ6
    dJ6_xz = XX6 - ZZ6
    dJ6_xy = XX6 - YY6

    # Backward recursion: articulated inertias and wrenches, joint 6 (j6) [28]-[32].
    H6 = ZZ6 + IA6
    Hinv6 = 1.0/H6
    UH6_1 = -MY6*Hinv6
    UH6_2 = MX6*Hinv6
    UH6_4 = XZ6*Hinv6
    UH6_5 = YZ6*Hinv6
    UH6_6 = ZZ6*Hinv6
    rho6 = IA6*Hinv6
    K6_16 = -MY6*rho6
    K6_26 = MX6*rho6
    K6_46 = XZ6*rho6
    K6_56 = YZ6*rho6
    K6_66 = ZZ6*rho6
    K6_14 = MY6*UH6_4
    K6_11 = M6 + MY6*UH6_1
    K6_44 = XX6 - XZ6*UH6_4
    K6_15 = MZ6 + MY6*UH6_5
    K6_12 = MY6*UH6_2
    K6_45 = XY6 - XZ6*UH6_5
    K6_24 = -(MZ6 + MX6*UH6_4)
    K6_25 = -MX6*UH6_5
    K6_22 = M6 - MX6*UH6_2
    K6_55 = YY6 - YZ6*UH6_5

    # Backward recursion: articulated inertias and wrenches, joint 5 (j5) [28]-[32].
    Js5_14a = K6_14 - K6_25
    Js5_13a = K6_11 - K6_22
    Js5_13b = 2.0*K6_12
    Js5_14b = K6_15 + K6_24
    Js5_44a = K6_44 - K6_55
    Js5_44b = 2.0*K6_45
    Js5_22 = M5 + M6
    Js5_55 = YY5 + K6_66
    return (
        dJ2_yz, dJ2_xz, dJ2_xy, dJ3_yz, dJ3_xz, dJ3_xy, dJ4_yz, dJ4_xz, dJ4_xy, dJ5_yz, dJ5_xz,
        dJ5_xy, dJ6_yz, dJ6_xz, dJ6_xy, Hinv6, UH6_1, UH6_2, UH6_4, UH6_5, UH6_6, rho6, K6_16,
        K6_26, K6_46, K6_56, K6_14, K6_11, K6_44, K6_15, K6_12, K6_45, K6_24, K6_25, K6_22, K6_55,
        Js5_14a, Js5_13a, Js5_13b, Js5_14b, Js5_44a, Js5_44b, Js5_22, Js5_55,
    )


def program(_f, q, qd, tau, p, c):
    th2 = q[1]
    th3 = q[2]
    th4 = q[3]
    th5 = q[4]
    th6 = q[5]
    qd1 = qd[0]
    qd2 = qd[1]
    qd3 = qd[2]
    qd4 = qd[3]
    qd5 = qd[4]
    qd6 = qd[5]
    tau1 = tau[0]
    tau2 = tau[1]
    tau3 = tau[2]
    tau4 = tau[3]
    tau5 = tau[4]
    tau6 = tau[5]
    ZZ1 = p[5]
    IA1 = p[10]
    XX2 = p[11]
    XY2 = p[12]
    XZ2 = p[13]
    YY2 = p[14]
    YZ2 = p[15]
    ZZ2 = p[16]
    MX2 = p[17]
    MY2 = p[18]
    MZ2 = p[19]
    IA2 = p[21]
    D3 = p[22]
    XX3 = p[23]
    XY3 = p[24]
    XZ3 = p[25]
    YY3 = p[26]
    YZ3 = p[27]
    ZZ3 = p[28]
    MX3 = p[29]
    MY3 = p[30]
    MZ3 = p[31]
    M3 = p[32]
    IA3 = p[33]
    RL4 = p[34]
    XX4 = p[35]
    XY4 = p[36]
    XZ4 = p[37]
    YY4 = p[38]
    YZ4 = p[39]
    ZZ4 = p[40]
    MX4 = p[41]
    MY4 = p[42]
    MZ4 = p[43]
    M4 = p[44]
    IA4 = p[45]
    XX5 = p[46]
    XY5 = p[47]
    XZ5 = p[48]
    YZ5 = p[50]
    ZZ5 = p[51]
    MX5 = p[52]
    MY5 = p[53]
    MZ5 = p[54]
    M5 = p[55]
    IA5 = p[56]
    XY6 = p[58]
    XZ6 = p[59]
    YZ6 = p[61]
    ZZ6 = p[62]
    MX6 = p[63]
    MY6 = p[64]
    MZ6 = p[65]
    G3 = p[68]
    dJ2_yz = c[0]
    dJ2_xz = c[1]
    dJ2_xy = c[2]
    dJ3_yz = c[3]
    dJ3_xz = c[4]
    dJ3_xy = c[5]
    dJ4_yz = c[6]
    dJ4_xz = c[7]
    dJ4_xy = c[8]
    dJ5_yz = c[9]
    dJ5_xz = c[10]
    dJ5_xy = c[11]
    dJ6_yz = c[12]
    dJ6_xz = c[13]
    dJ6_xy = c[14]
    Hinv6 = c[15]
    UH6_1 = c[16]
    UH6_2 = c[17]
    UH6_4 = c[18]
    UH6_5 = c[19]
    UH6_6 = c[20]
    rho6 = c[21]
    K6_16 = c[22]
    K6_26 = c[23]
    K6_46 = c[24]
    K6_56 = c[25]
    K6_14 = c[26]
    K6_11 = c[27]
    K6_44 = c[28]
    K6_15 = c[29]
    K6_12 = c[30]
    K6_45 = c[31]
    K6_24 = c[32]
    K6_25 = c[33]
    K6_22 = c[34]
    K6_55 = c[35]
    Js5_14a = c[36]
    Js5_13a = c[37]
    Js5_13b = c[38]
    Js5_14b = c[39]
    Js5_44a = c[40]
    Js5_44b = c[41]
    Js5_22 = c[42]
    Js5_55 = c[43]

    # Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14].
    sin_th2 = _f.sin(th2)
    cos_th2 = _f.cos(th2)
    w2_x = qd1*sin_th2
    w2_y = qd1*cos_th2
    ww2_xx = w2_x*w2_x
    ww2_yy = w2_y*w2_y
    ww2_zz = qd2*qd2
    ww2_xy = w2_x*w2_y
    ww2_xz = qd2*w2_x
    ww2_yz = qd2*w2_y
    b2_4 = XY2*ww2_xz - (YZ2*(ww2_yy - ww2_zz) - ww2_yz*dJ2_yz + XZ2*ww2_xy)
    b2_5 = XZ2*(ww2_xx - ww2_zz) - ww2_xz*dJ2_xz + YZ2*ww2_xy - XY2*ww2_yz
    b2_6 = XZ2*ww2_yz - (XY2*(ww2_xx - ww2_yy) - ww2_xy*dJ2_xy + YZ2*ww2_xz)

    # Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14].
    sin_th3 = _f.sin(th3)
    cos_th3 = _f.cos(th3)
    w3_x = cos_th3*w2_x + sin_th3*w2_y
    w3_y = cos_th3*w2_y - sin_th3*w2_x
    w3_z = qd2 + qd3
    ww3_xx = w3_x*w3_x
    ww3_yy = w3_y*w3_y
    ww3_zz = w3_z*w3_z
    ww3_xy = w3_x*w3_y
    ww3_xz = w3_x*w3_z
    b3_2a = ww3_xx + ww3_zz
    ww3_yz = w3_y*w3_z
    g3_1a = D3*(ww2_yy + ww2_zz)
    g3_1b = D3*ww2_xy
    g3_3 = D3*ww2_xz
    g3_1 = sin_th3*g3_1b - cos_th3*g3_1a
    g3_2 = sin_th3*g3_1a + cos_th3*g3_1b
    g3_4 = qd3*w3_y
    g3_5 = -qd3*w3_x
    b3_1 = MX3*(ww3_yy + ww3_zz) - MY3*ww3_xy - MZ3*ww3_xz
    b3_2 = MY3*b3_2a - MX3*ww3_xy - MZ3*ww3_yz
    b3_3 = MZ3*(ww3_xx + ww3_yy) - (MX3*ww3_xz + MY3*ww3_yz)
    b3_4 = XY3*ww3_xz - (YZ3*(ww3_yy - ww3_zz) - ww3_yz*dJ3_yz + XZ3*ww3_xy)
    b3_5 = XZ3*(ww3_xx - ww3_zz) - ww3_xz*dJ3_xz + YZ3*ww3_xy - XY3*ww3_yz
    b3_6 = XZ3*ww3_yz - (XY3*(ww3_xx - ww3_yy) - ww3_xy*dJ3_xy + YZ3*ww3_xz)

    # Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14].
    sin_th4 = _f.sin(th4)
    cos_th4 = _f.cos(th4)
    w4_x = cos_th4*w3_x - sin_th4*w3_z
    w4_y = -(sin_th4*w3_x + cos_th4*w3_z)
    w4_z = qd4 + w3_y
    ww4_xx = w4_x*w4_x
    ww4_yy = w4_y*w4_y
    ww4_zz = w4_z*w4_z
    ww4_xy = w4_x*w4_y
    ww4_xz = w4_x*w4_z
    ww4_yz = w4_y*w4_z
    g4_1a = -RL4*ww3_xy
    g4_3 = -RL4*b3_2a
    g4_1b = -RL4*ww3_yz
    g4_1 = sin_th4*g4_1b - cos_th4*g4_1a
    g4_2 = sin_th4*g4_1a + cos_th4*g4_1b
    g4_4 = qd4*w4_y
    g4_5 = -qd4*w4_x
    b4_1 = MX4*(ww4_yy + ww4_zz) - MY4*ww4_xy - MZ4*ww4_xz
    b4_2 = MY4*(ww4_xx + ww4_zz) - MX4*ww4_xy - MZ4*ww4_yz
    b4_3 = MZ4*(ww4_xx + ww4_yy) - (MX4*ww4_xz + MY4*ww4_yz)
    b4_4 = XY4*ww4_xz - (YZ4*(ww4_yy - ww4_zz) - ww4_yz*dJ4_yz + XZ4*ww4_xy)
    b4_5 = XZ4*(ww4_xx - ww4_zz) - ww4_xz*dJ4_xz + YZ4*ww4_xy - XY4*ww4_yz
    b4_6 = XZ4*ww4_yz - (XY4*(ww4_xx - ww4_yy) - ww4_xy*dJ4_xy + YZ4*ww4_xz)

    # Forward recursion: velocities, joint 5 (j5) [1], [3], [7], [14].
    sin_th5 = _f.sin(th5)
    cos_th5 = _f.cos(th5)
    w5_x = cos_th5*w4_x + sin_th5*w4_z
    w5_y = cos_th5*w4_z - sin_th5*w4_x
    w5_z = qd5 - w4_y
    ww5_xx = w5_x*w5_x
    ww5_yy = w5_y*w5_y
    ww5_zz = w5_z*w5_z
    ww5_xy = w5_x*w5_y
    ww5_xz = w5_x*w5_z
    ww5_yz = w5_y*w5_z
    g5_4 = qd5*w5_y
    g5_5 = -qd5*w5_x
    b5_1 = MX5*(ww5_yy + ww5_zz) - MY5*ww5_xy - MZ5*ww5_xz
    b5_2 = MY5*(ww5_xx + ww5_zz) - MX5*ww5_xy - MZ5*ww5_yz
    b5_3 = MZ5*(ww5_xx + ww5_yy) - (MX5*ww5_xz + MY5*ww5_yz)
    b5_4 = XY5*ww5_xz - (YZ5*(ww5_yy - ww5_zz) - ww5_yz*dJ5_yz + XZ5*ww5_xy)
    b5_5 = XZ5*(ww5_xx - ww5_zz) - ww5_xz*dJ5_xz + YZ5*ww5_xy - XY5*ww5_yz
    b5_6 = XZ5*ww5_yz - (XY5*(ww5_xx - ww5_yy) - ww5_xy*dJ5_xy + YZ5*ww5_xz)

    # Forward recursion: velocities, joint 6 (j6) [1], [3], [7], [14].
    sin_th6 = _f.sin(th6)
    cos_th6 = _f.cos(th6)
    w6_x = cos_th6*w5_x - sin_th6*w5_z
    w6_y = -(sin_th6*w5_x + cos_th6*w5_z)
    w6_z = qd6 + w5_y
    ww6_xx = w6_x*w6_x
    ww6_yy = w6_y*w6_y
    ww6_zz = w6_z*w6_z
    ww6_xy = w6_x*w6_y
    ww6_xz = w6_x*w6_z
    ww6_yz = w6_y*w6_z
    g6_4 = qd6*w6_y
    g6_5 = -qd6*w6_x
    b6_1 = MX6*(ww6_yy + ww6_zz) - MY6*ww6_xy - MZ6*ww6_xz
    b6_2 = MY6*(ww6_xx + ww6_zz) - MX6*ww6_xy - MZ6*ww6_yz
    b6_3 = MZ6*(ww6_xx + ww6_yy) - (MX6*ww6_xz + MY6*ww6_yz)
    b6_4 = XY6*ww6_xz - (YZ6*(ww6_yy - ww6_zz) - ww6_yz*dJ6_yz + XZ6*ww6_xy)
    b6_5 = XZ6*(ww6_xx - ww6_zz) - ww6_xz*dJ6_xz + YZ6*ww6_xy - XY6*ww6_yz
    b6_6 = XZ6*ww6_yz - (XY6*(ww6_xx - ww6_yy) - ww6_xy*dJ6_xy + YZ6*ww6_xz)

    # Backward recursion: articulated inertias and wrenches, joint 6 (j6) [28]-[32].
    Gb6 = tau6 + b6_6
    al6_1 = g6_4*K6_14 + g6_5*K6_15 + UH6_1*Gb6 - b6_1
    al6_2 = g6_4*K6_24 + g6_5*K6_25 + UH6_2*Gb6 - b6_2
    al6_3 = -(b6_3 + MX6*g6_5 - MY6*g6_4)
    al6_4 = g6_4*K6_44 + g6_5*K6_45 + UH6_4*Gb6 - b6_4
    al6_5 = g6_4*K6_45 + g6_5*K6_55 + UH6_5*Gb6 - b6_5
    al6_6 = g6_4*K6_46 + g6_5*K6_56 + tau6*UH6_6 - b6_6*rho6

    # Backward recursion: articulated inertias and wrenches, joint 5 (j5) [28]-[32].
    Js5_13c = sin_th6*Js5_13a + cos_th6*Js5_13b
    Js5_11a = sin_th6*Js5_13c
    Js5_13 = K6_12 - cos_th6*Js5_13c
    Js5_14c = sin_th6*Js5_14a + cos_th6*Js5_14b
    Js5_14d = sin_th6*Js5_14c
    Js5_14 = K6_14 - Js5_14d
    Js5_16a = cos_th6*Js5_14c
    Js5_36 = K6_25 + Js5_14d
    Js5_44c = sin_th6*Js5_44a + cos_th6*Js5_44b
    Js5_44d = sin_th6*Js5_44c
    Js5_11 = M5 + K6_11 - Js5_11a
    Js5_33 = M5 + K6_22 + Js5_11a
    Js5_15 = MZ5 - (sin_th6*K6_26 - cos_th6*K6_16)
    Js5_16 = -(MY5 + Js5_16a - K6_24)
    Js5_24 = MY6*cos_th6 + MX6*sin_th6 - MZ5
    Js5_26 = MX5 - (MY6*sin_th6 - MX6*cos_th6)
    Js5_34 = MY5 + K6_15 - Js5_16a
    Js5_35 = -(MX5 + sin_th6*K6_16 + cos_th6*K6_26)
    Js5_44 = XX5 + K6_44 - Js5_44d
    Js5_45 = XY5 + cos_th6*K6_46 - sin_th6*K6_56
    Js5_46 = XZ5 + K6_45 - cos_th6*Js5_44c
    Js5_56 = YZ5 - (sin_th6*K6_46 + cos_th6*K6_56)
    Js5_66 = ZZ5 + K6_55 + Js5_44d
    bs5_1 = b5_1 + sin_th6*al6_2 - cos_th6*al6_1
    bs5_2 = b5_2 - al6_3
    bs5_3 = b5_3 + sin_th6*al6_1 + cos_th6*al6_2
    bs5_4 = b5_4 - (cos_th6*al6_4 - sin_th6*al6_5)
    bs5_5 = b5_5 - al6_6
    bs5_6 = b5_6 + sin_th6*al6_4 + cos_th6*al6_5
    H5 = IA5 + Js5_66
    Hinv5 = 1.0/H5
    UH5_1 = Js5_16*Hinv5
    UH5_2 = Js5_26*Hinv5
    UH5_3 = Js5_36*Hinv5
    UH5_4 = Js5_46*Hinv5
    UH5_5 = Js5_56*Hinv5
    UH5_6 = Js5_66*Hinv5
    rho5 = IA5*Hinv5
    K5_16 = Js5_16*rho5
    K5_26 = Js5_26*rho5
    K5_36 = Js5_36*rho5
    K5_46 = Js5_46*rho5
    K5_56 = Js5_56*rho5
    K5_66 = Js5_66*rho5
    K5_14 = Js5_14 - Js5_16*UH5_4
    K5_11 = Js5_11 - Js5_16*UH5_1
    K5_44 = Js5_44 - Js5_46*UH5_4
    K5_15 = Js5_15 - Js5_16*UH5_5
    K5_12 = -Js5_16*UH5_2
    K5_45 = Js5_45 - Js5_46*UH5_5
    K5_13 = Js5_13 - Js5_16*UH5_3
    K5_24 = Js5_24 - Js5_26*UH5_4
    K5_25 = -Js5_26*UH5_5
    K5_22 = Js5_22 - Js5_26*UH5_2
    K5_55 = Js5_55 - Js5_56*UH5_5
    K5_23 = -Js5_26*UH5_3
    K5_34 = Js5_34 - Js5_36*UH5_4
    K5_35 = Js5_35 - Js5_36*UH5_5
    K5_33 = Js5_33 - Js5_36*UH5_3
    Gb5 = tau5 + bs5_6
    al5_1 = g5_4*K5_14 + g5_5*K5_15 + UH5_1*Gb5 - bs5_1
    al5_2 = g5_4*K5_24 + g5_5*K5_25 + UH5_2*Gb5 - bs5_2
    al5_3 = g5_4*K5_34 + g5_5*K5_35 + UH5_3*Gb5 - bs5_3
    al5_4 = g5_4*K5_44 + g5_5*K5_45 + UH5_4*Gb5 - bs5_4
    al5_5 = g5_4*K5_45 + g5_5*K5_55 + UH5_5*Gb5 - bs5_5
    al5_6 = g5_4*K5_46 + g5_5*K5_56 + tau5*UH5_6 - bs5_6*rho5

    # Backward recursion: articulated inertias and wrenches, joint 4 (j4) [28]-[32].
    Js4_13a = sin_th5*(K5_11 - K5_22) + 2.0*K5_12*cos_th5
    Js4_11a = sin_th5*Js4_13a
    Js4_13 = cos_th5*Js4_13a - K5_12
    Js4_12 = sin_th5*K5_23 - cos_th5*K5_13
    Js4_23 = -(sin_th5*K5_13 + cos_th5*K5_23)
    Js4_14a = sin_th5*(K5_14 - K5_25) + cos_th5*(K5_15 + K5_24)
    Js4_14b = sin_th5*Js4_14a
    Js4_14 = K5_14 - Js4_14b
    Js4_16a = cos_th5*Js4_14a
    Js4_36 = K5_25 + Js4_14b
    Js4_44a = sin_th5*(K5_44 - K5_55) + 2.0*K5_45*cos_th5
    Js4_44b = sin_th5*Js4_44a
    Js4_11 = M4 + K5_11 - Js4_11a
    Js4_22 = M4 + K5_33
    Js4_33 = M4 + K5_22 + Js4_11a
    Js4_15 = MZ4 + sin_th5*K5_26 - cos_th5*K5_16
    Js4_16 = Js4_16a - K5_24 - MY4
    Js4_24 = -(MZ4 + cos_th5*K5_34 - sin_th5*K5_35)
    Js4_26 = MX4 - (sin_th5*K5_34 + cos_th5*K5_35)
    Js4_34 = MY4 - (K5_15 - Js4_16a)
    Js4_35 = -(MX4 + sin_th5*K5_16 + cos_th5*K5_26)
    Js4_44 = XX4 + K5_44 - Js4_44b
    Js4_45 = XY4 - (cos_th5*K5_46 - sin_th5*K5_56)
    Js4_46 = XZ4 - (K5_45 - cos_th5*Js4_44a)
    Js4_55 = YY4 + K5_66
    Js4_56 = YZ4 - (sin_th5*K5_46 + cos_th5*K5_56)
    Js4_66 = ZZ4 + K5_55 + Js4_44b
    bs4_1 = b4_1 + sin_th5*al5_2 - cos_th5*al5_1
    bs4_2 = b4_2 + al5_3
    bs4_3 = b4_3 - (sin_th5*al5_1 + cos_th5*al5_2)
    bs4_4 = b4_4 - (cos_th5*al5_4 - sin_th5*al5_5)
    bs4_5 = b4_5 + al5_6
    bs4_6 = b4_6 - (sin_th5*al5_4 + cos_th5*al5_5)
    H4 = IA4 + Js4_66
    Hinv4 = 1.0/H4
    UH4_1 = Js4_16*Hinv4
    UH4_2 = Js4_26*Hinv4
    UH4_3 = Js4_36*Hinv4
    UH4_4 = Js4_46*Hinv4
    UH4_5 = Js4_56*Hinv4
    UH4_6 = Js4_66*Hinv4
    rho4 = IA4*Hinv4
    K4_16 = Js4_16*rho4
    K4_26 = Js4_26*rho4
    K4_36 = Js4_36*rho4
    K4_46 = Js4_46*rho4
    K4_56 = Js4_56*rho4
    K4_66 = Js4_66*rho4
    K4_14 = Js4_14 - Js4_16*UH4_4
    K4_11 = Js4_11 - Js4_16*UH4_1
    K4_44 = Js4_44 - Js4_46*UH4_4
    K4_15 = Js4_15 - Js4_16*UH4_5
    K4_12 = Js4_12 - Js4_16*UH4_2
    K4_45 = Js4_45 - Js4_46*UH4_5
    K4_13 = Js4_13 - Js4_16*UH4_3
    K4_24 = Js4_24 - Js4_26*UH4_4
    K4_25 = K5_36 - Js4_26*UH4_5
    K4_22 = Js4_22 - Js4_26*UH4_2
    K4_55 = Js4_55 - Js4_56*UH4_5
    K4_23 = Js4_23 - Js4_26*UH4_3
    K4_34 = Js4_34 - Js4_36*UH4_4
    K4_35 = Js4_35 - Js4_36*UH4_5
    K4_33 = Js4_33 - Js4_36*UH4_3
    Gb4 = tau4 + bs4_6
    al4_1 = g4_1*K4_11 + g4_2*K4_12 + g4_3*K4_13 + g4_4*K4_14 + g4_5*K4_15 + UH4_1*Gb4 - bs4_1
    al4_2 = g4_1*K4_12 + g4_2*K4_22 + g4_3*K4_23 + g4_4*K4_24 + g4_5*K4_25 + UH4_2*Gb4 - bs4_2
    al4_3 = g4_1*K4_13 + g4_2*K4_23 + g4_3*K4_33 + g4_4*K4_34 + g4_5*K4_35 + UH4_3*Gb4 - bs4_3
    al4_4 = g4_1*K4_14 + g4_2*K4_24 + g4_3*K4_34 + g4_4*K4_44 + g4_5*K4_45 + UH4_4*Gb4 - bs4_4
    al4_5 = g4_1*K4_15 + g4_2*K4_25 + g4_3*K4_35 + g4_4*K4_45 + g4_5*K4_55 + UH4_5*Gb4 - bs4_5
    al4_6 = g4_1*K4_16 + g4_2*K4_26 + g4_3*K4_36 + g4_4*K4_46 + g4_5*K4_56 + tau4*UH4_6 - bs4_6*rho4

    # Backward recursion: articulated inertias and wrenches, joint 3 (j3) [28]-[32].
    Js3_14a = -RL4*K4_12
    Js3_14b = K4_14 + Js3_14a
    Js3_14c = K4_15 + RL4*K4_11
    Js3_14d = RL4*K4_22 - K4_24
    Js3_14e = Js3_14a - K4_25
    Js3_24a = K4_34 - RL4*K4_23
    Js3_24b = -(K4_35 + RL4*K4_13)
    Js3_45a = K4_46 - RL4*K4_26
    Js3_45b = K4_56 + RL4*K4_16
    Js3_44a = K4_44 + RL4*(Js3_14d - K4_24)
    Js3_44b = K4_55 + RL4*(K4_15 + Js3_14c)
    Js3_44c = K4_45 + RL4*(K4_14 + Js3_14e)
    Js3_13a = sin_th4*(K4_11 - K4_22) + 2.0*K4_12*cos_th4
    Js3_11a = sin_th4*Js3_13a
    Js3_13 = K4_12 - cos_th4*Js3_13a
    Js3_12 = cos_th4*K4_13 - sin_th4*K4_23
    Js3_23 = -(sin_th4*K4_13 + cos_th4*K4_23)
    Js3_14f = sin_th4*(Js3_14b + Js3_14e) + cos_th4*(Js3_14c - Js3_14d)
    Js3_14g = sin_th4*Js3_14f
    Js3_14 = Js3_14b - Js3_14g
    Js3_16a = cos_th4*Js3_14f
    Js3_36 = Js3_14g - Js3_14e
    Js3_44d = sin_th4*(Js3_44a - Js3_44b) + 2.0*Js3_44c*cos_th4
    Js3_44e = sin_th4*Js3_44d
    Js3_11 = M3 + K4_11 - Js3_11a
    Js3_22 = M3 + K4_33
    Js3_33 = M3 + K4_22 + Js3_11a
    Js3_15 = MZ3 - (sin_th4*K4_26 - cos_th4*K4_16)
    Js3_16 = -(MY3 + Js3_14d + Js3_16a)
    Js3_24 = cos_th4*Js3_24a + sin_th4*Js3_24b - MZ3
    Js3_26 = MX3 - (sin_th4*Js3_24a - cos_th4*Js3_24b)
    Js3_34 = MY3 + Js3_14c - Js3_16a
    Js3_35 = -(MX3 + sin_th4*K4_16 + cos_th4*K4_26)
    Js3_44 = XX3 + Js3_44a - Js3_44e
    Js3_45 = XY3 + cos_th4*Js3_45a - sin_th4*Js3_45b
    Js3_46 = XZ3 + Js3_44c - cos_th4*Js3_44d
    Js3_55 = YY3 + K4_66
    Js3_56 = YZ3 - (sin_th4*Js3_45a + cos_th4*Js3_45b)
    Js3_66 = ZZ3 + Js3_44b + Js3_44e
    bs3_4a = al4_4 - RL4*al4_2
    bs3_4b = -(al4_5 + RL4*al4_1)
    bs3_1 = b3_1 + sin_th4*al4_2 - cos_th4*al4_1
    bs3_2 = b3_2 - al4_3
    bs3_3 = b3_3 + sin_th4*al4_1 + cos_th4*al4_2
    bs3_4 = b3_4 - (cos_th4*bs3_4a + sin_th4*bs3_4b)
    bs3_5 = b3_5 - al4_6
    bs3_6 = b3_6 + sin_th4*bs3_4a - cos_th4*bs3_4b
    H3 = IA3 + Js3_66
    Hinv3 = 1.0/H3
    UH3_1 = Js3_16*Hinv3
    UH3_2 = Js3_26*Hinv3
    UH3_3 = Js3_36*Hinv3
    UH3_4 = Js3_46*Hinv3
    UH3_5 = Js3_56*Hinv3
    UH3_6 = Js3_66*Hinv3
    rho3 = IA3*Hinv3
    K3_16 = Js3_16*rho3
    K3_26 = Js3_26*rho3
    K3_36 = Js3_36*rho3
    K3_46 = Js3_46*rho3
    K3_56 = Js3_56*rho3
    K3_66 = Js3_66*rho3
    K3_14 = Js3_14 - Js3_16*UH3_4
    K3_11 = Js3_11 - Js3_16*UH3_1
    K3_44 = Js3_44 - Js3_46*UH3_4
    K3_15 = Js3_15 - Js3_16*UH3_5
    K3_12 = Js3_12 - Js3_16*UH3_2
    K3_45 = Js3_45 - Js3_46*UH3_5
    K3_13 = Js3_13 - Js3_16*UH3_3
    K3_24 = Js3_24 - Js3_26*UH3_4
    K3_25 = K4_36 - Js3_26*UH3_5
    K3_22 = Js3_22 - Js3_26*UH3_2
    K3_55 = Js3_55 - Js3_56*UH3_5
    K3_23 = Js3_23 - Js3_26*UH3_3
    K3_34 = Js3_34 - Js3_36*UH3_4
    K3_35 = Js3_35 - Js3_36*UH3_5
    K3_33 = Js3_33 - Js3_36*UH3_3
    Gb3 = tau3 + bs3_6
    al3_1 = g3_1*K3_11 + g3_2*K3_12 + g3_3*K3_13 + g3_4*K3_14 + g3_5*K3_15 + UH3_1*Gb3 - bs3_1
    al3_2 = g3_1*K3_12 + g3_2*K3_22 + g3_3*K3_23 + g3_4*K3_24 + g3_5*K3_25 + UH3_2*Gb3 - bs3_2
    al3_3 = g3_1*K3_13 + g3_2*K3_23 + g3_3*K3_33 + g3_4*K3_34 + g3_5*K3_35 + UH3_3*Gb3 - bs3_3
    al3_4 = g3_1*K3_14 + g3_2*K3_24 + g3_3*K3_34 + g3_4*K3_44 + g3_5*K3_45 + UH3_4*Gb3 - bs3_4
    al3_5 = g3_1*K3_15 + g3_2*K3_25 + g3_3*K3_35 + g3_4*K3_45 + g3_5*K3_55 + UH3_5*Gb3 - bs3_5
    al3_6 = g3_1*K3_16 + g3_2*K3_26 + g3_3*K3_36 + g3_4*K3_46 + g3_5*K3_56 + tau3*UH3_6 - bs3_6*rho3

    # Backward recursion: articulated inertias and wrenches, joint 2 (j2) [28]-[32].
    Js2_12a = sin_th3*(K3_11 - K3_22) + 2.0*K3_12*cos_th3
    Js2_12 = cos_th3*Js2_12a - K3_12
    Js2_13 = cos_th3*K3_13 - sin_th3*K3_23
    Js2_23 = sin_th3*K3_13 + cos_th3*K3_23
    Js2_14a = sin_th3*(K3_14 - K3_25) + cos_th3*(K3_15 + K3_24)
    Js2_14b = sin_th3*Js2_14a
    Js2_14 = K3_14 - Js2_14b
    Js2_15a = cos_th3*Js2_14a
    Js2_24a = K3_15 - Js2_15a
    Js2_25a = -(K3_25 + Js2_14b)
    Js2_26a = -(sin_th3*K3_16 + cos_th3*K3_26)
    Js2_55a = sin_th3*K3_34 + cos_th3*K3_35
    Js2_44a = sin_th3*(K3_44 - K3_55) + 2.0*K3_45*cos_th3
    Js2_44b = sin_th3*Js2_44a
    Js2_25b = -D3*Js2_23
    Js2_25 = Js2_25b - Js2_25a
    Js2_26b = Js2_26a - D3*(K3_22 + sin_th3*Js2_12a)
    Js2_36 = K3_36 - Js2_25b
    Js2_15 = MZ2 + Js2_15a - K3_24 - D3*Js2_13
    Js2_16 = -(MY2 + sin_th3*K3_26 - cos_th3*K3_16 - D3*Js2_12)
    Js2_24 = -(MZ2 + Js2_24a)
    Js2_26 = MX2 - Js2_26b
    Js2_44 = XX2 + K3_44 - Js2_44b
    Js2_45 = XY2 - (K3_45 - cos_th3*Js2_44a + D3*(cos_th3*K3_34 - sin_th3*K3_35))
    Js2_46 = XZ2 + cos_th3*K3_46 - sin_th3*K3_56 - D3*Js2_24a
    Js2_55 = YY2 + K3_55 + Js2_44b - D3*(Js2_55a + Js2_55a - D3*K3_33)
    Js2_56 = YZ2 + sin_th3*K3_46 + cos_th3*K3_56 - D3*(Js2_25a + Js2_36)
    Js2_66 = ZZ2 + K3_66 - D3*(Js2_26a + Js2_26b)
    bs2_4 = b2_4 - (cos_th3*al3_4 - sin_th3*al3_5)
    bs2_5 = b2_5 - (sin_th3*al3_4 + cos_th3*al3_5 - D3*al3_3)
    bs2_6 = b2_6 - (al3_6 + D3*(sin_th3*al3_1 + cos_th3*al3_2))
    H2 = IA2 + Js2_66
    Hinv2 = 1.0/H2
    UH2_4 = Js2_46*Hinv2
    UH2_5 = Js2_56*Hinv2
    K2_14 = Js2_14 - Js2_16*UH2_4
    K2_44 = Js2_44 - Js2_46*UH2_4
    K2_15 = Js2_15 - Js2_16*UH2_5
    K2_45 = Js2_45 - Js2_46*UH2_5
    K2_24 = Js2_24 - Js2_26*UH2_4
    K2_25 = Js2_25 - Js2_26*UH2_5
    K2_55 = Js2_55 - Js2_56*UH2_5
    Gb2 = tau2 + bs2_6
    al2_4 = ww2_yz*K2_44 - ww2_xz*K2_45 + UH2_4*Gb2 - bs2_4
    al2_5 = ww2_yz*K2_45 - ww2_xz*K2_55 + UH2_5*Gb2 - bs2_5

    # Backward recursion: articulated inertias and wrenches, joint 1 (j1) [28]-[32].
    Js1_36 = K2_25 + sin_th2*(sin_th2*(K2_14 - K2_25) + cos_th2*(K2_15 + K2_24))
    Js1_66 = ZZ1 + K2_55 + sin_th2*(sin_th2*(K2_44 - K2_55) + 2.0*K2_45*cos_th2)
    bs1_6 = -(sin_th2*al2_4 + cos_th2*al2_5)
    H1 = IA1 + Js1_66
    Hinv1 = 1.0/H1
    Gb1 = tau1 + bs1_6

    # Forward recursion: accelerations and torques, joint 1 (j1) [33]-[36].
    qdd1 = Hinv1*(Gb1 + G3*Js1_36)

    # Forward recursion: accelerations and torques, joint 2 (j2) [33]-[36].
    vd2_x = -G3*sin_th2
    vd2_y = -G3*cos_th2
    wd2_x = ww2_yz + sin_th2*qdd1
    wd2_y = cos_th2*qdd1 - ww2_xz
    qdd2 = Hinv2*(Gb2 - (Js2_16*vd2_x + Js2_26*vd2_y) - (Js2_46*wd2_x + Js2_56*wd2_y))

    # Forward recursion: accelerations and torques, joint 3 (j3) [33]-[36].
    vd3_xa = -(vd2_y + D3*qdd2)
    vd3_x = g3_1 - (sin_th3*vd3_xa - cos_th3*vd2_x)
    vd3_y = g3_2 - (sin_th3*vd2_x + cos_th3*vd3_xa)
    vd3_z = g3_3 - D3*wd2_y
    wd3_x = g3_4 + cos_th3*wd2_x + sin_th3*wd2_y
    wd3_y = g3_5 - (sin_th3*wd2_x - cos_th3*wd2_y)
    qdd3 = (
        Hinv3*(Gb3 - (Js3_16*vd3_x + Js3_26*vd3_y + Js3_36*vd3_z)
        - (Js3_46*wd3_x + Js3_56*wd3_y + Js3_66*qdd2))
    )
    wd3_z = qdd2 + qdd3

    # Forward recursion: accelerations and torques, joint 4 (j4) [33]-[36].
    vd4_ya = sin_th4*wd3_z - cos_th4*wd3_x
    vd4_xa = -(sin_th4*wd3_x + cos_th4*wd3_z)
    vd4_x = g4_1 - (sin_th4*vd3_z - cos_th4*vd3_x - RL4*vd4_xa)
    vd4_y = g4_2 + RL4*vd4_ya - (sin_th4*vd3_x + cos_th4*vd3_z)
    vd4_z = g4_3 + vd3_y
    wd4_x = g4_4 - vd4_ya
    wd4_y = g4_5 + vd4_xa
    qdd4 = (
        Hinv4*(Gb4 - (Js4_16*vd4_x + Js4_26*vd4_y + Js4_36*vd4_z)
        - (Js4_46*wd4_x + Js4_56*wd4_y + Js4_66*wd3_y))
    )
    wd4_z = wd3_y + qdd4

    # Forward recursion: accelerations and torques, joint 5 (j5) [33]-[36].
    vd5_x = cos_th5*vd4_x + sin_th5*vd4_z
    vd5_y = cos_th5*vd4_z - sin_th5*vd4_x
    wd5_x = g5_4 + cos_th5*wd4_x + sin_th5*wd4_z
    wd5_y = g5_5 + cos_th5*wd4_z - sin_th5*wd4_x
    qdd5 = (
        Hinv5*(Gb5 - (Js5_16*vd5_x + Js5_26*vd5_y - Js5_36*vd4_y) + Js5_66*wd4_y
        - (Js5_46*wd5_x + Js5_56*wd5_y))
    )
    wd5_z = qdd5 - wd4_y

    # Forward recursion: accelerations and torques, joint 6 (j6) [33]-[36].
    vd6_x = cos_th6*vd5_x + sin_th6*vd4_y
    vd6_y = cos_th6*vd4_y - sin_th6*vd5_x
    wd6_x = g6_4 - (sin_th6*wd5_z - cos_th6*wd5_x)
    wd6_y = g6_5 - (sin_th6*wd5_x + cos_th6*wd5_z)
    qdd6 = Hinv6*(Gb6 - (MX6*vd6_y - MY6*vd6_x) - (XZ6*wd6_x + YZ6*wd6_y + ZZ6*wd5_y))

    # Results.
    return (
        (qdd1, qdd2, qdd3, qdd4, qdd5, qdd6),
    )
