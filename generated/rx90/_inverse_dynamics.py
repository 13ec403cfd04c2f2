"""Inverse dynamic model: motor torques and elastic accelerations of rx90 [37]-[61]: 292x 277+, 10 sin/cos a call; 0x 15+, 0 sin/cos once for each parameter set.

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
    XX6 = p[57]
    YY6 = p[60]
    ZZ6 = p[62]

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
    return (
        dJ2_yz, dJ2_xz, dJ2_xy, dJ3_yz, dJ3_xz, dJ3_xy, dJ4_yz, dJ4_xz, dJ4_xy, dJ5_yz, dJ5_xz,
        dJ5_xy, dJ6_yz, dJ6_xz, dJ6_xy,
    )


def program(_f, q, qd, qdd_motor, p, c):
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
    qdd1 = qdd_motor[0]
    qdd2 = qdd_motor[1]
    qdd3 = qdd_motor[2]
    qdd4 = qdd_motor[3]
    qdd5 = qdd_motor[4]
    qdd6 = qdd_motor[5]
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
    YY5 = p[49]
    YZ5 = p[50]
    ZZ5 = p[51]
    MX5 = p[52]
    MY5 = p[53]
    MZ5 = p[54]
    M5 = p[55]
    IA5 = p[56]
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
    wd2_x = ww2_yz + qdd1*sin_th2
    wd2_y = qdd1*cos_th2 - ww2_xz
    vd2_x = -G3*sin_th2
    vd2_y = -G3*cos_th2

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
    ww3_yz = w3_y*w3_z
    vd3_xa = qdd2 + ww2_xy
    vd3_za = ww2_xz - wd2_y
    wd3_x = qd3*w3_y + cos_th3*wd2_x + sin_th3*wd2_y
    wd3_y = -(qd3*w3_x + sin_th3*wd2_x - cos_th3*wd2_y)
    wd3_z = qdd2 + qdd3
    vd3_z = D3*vd3_za
    vd3_xb = D3*(ww2_yy + ww2_zz) - vd2_x
    vd3_xc = -(vd2_y + D3*vd3_xa)
    vd3_x = -(cos_th3*vd3_xb + sin_th3*vd3_xc)
    vd3_y = sin_th3*vd3_xb - cos_th3*vd3_xc

    # Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14].
    sin_th4 = _f.sin(th4)
    cos_th4 = _f.cos(th4)
    w4_x = cos_th4*w3_x - sin_th4*w3_z
    w4_y = -(sin_th4*w3_x + cos_th4*w3_z)
    w4_z = qd4 + w3_y
    vd4_za = ww3_xx + ww3_zz
    ww4_xx = w4_x*w4_x
    ww4_yy = w4_y*w4_y
    ww4_zz = w4_z*w4_z
    ww4_xy = w4_x*w4_y
    ww4_xz = w4_x*w4_z
    ww4_yz = w4_y*w4_z
    vd4_xa = wd3_z - ww3_xy
    vd4_xb = -(ww3_yz + wd3_x)
    wd4_x = qd4*w4_y - (sin_th4*wd3_z - cos_th4*wd3_x)
    wd4_y = -(qd4*w4_x + sin_th4*wd3_x + cos_th4*wd3_z)
    wd4_z = qdd4 + wd3_y
    vd4_xc = RL4*vd4_xa - vd3_x
    vd4_z = vd3_y - RL4*vd4_za
    vd4_xd = vd3_z - RL4*vd4_xb
    vd4_x = -(cos_th4*vd4_xc + sin_th4*vd4_xd)
    vd4_y = sin_th4*vd4_xc - cos_th4*vd4_xd

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
    wd5_x = qd5*w5_y + cos_th5*wd4_x + sin_th5*wd4_z
    wd5_y = cos_th5*wd4_z - sin_th5*wd4_x - qd5*w5_x
    wd5_z = qdd5 - wd4_y
    vd5_x = cos_th5*vd4_x + sin_th5*vd4_z
    vd5_y = cos_th5*vd4_z - sin_th5*vd4_x

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
    wd6_x = qd6*w6_y - (sin_th6*wd5_z - cos_th6*wd5_x)
    wd6_y = -(qd6*w6_x + sin_th6*wd5_x + cos_th6*wd5_z)
    wd6_z = qdd6 + wd5_y
    vd6_x = cos_th6*vd5_x + sin_th6*vd4_y
    vd6_y = cos_th6*vd4_y - sin_th6*vd5_x

    # Backward recursion: articulated inertias and wrenches, joint 6 (j6) [50]-[56].
    f6_1a = wd6_z - ww6_xy
    f6_1b = ww6_xz + wd6_y
    f6_2a = -(ww6_xy + wd6_z)
    f6_2b = wd6_x - ww6_yz
    f6_3a = ww6_xz - wd6_y
    f6_3b = -(ww6_yz + wd6_x)
    f6_1 = M6*vd6_x - (MX6*(ww6_yy + ww6_zz) + MY6*f6_1a - MZ6*f6_1b)
    f6_2 = M6*vd6_y - (MX6*f6_2a + MY6*(ww6_xx + ww6_zz) + MZ6*f6_2b)
    f6_3 = M6*vd5_y + MX6*f6_3a - MY6*f6_3b - MZ6*(ww6_xx + ww6_yy)
    f6_4 = YZ6*(ww6_yy - ww6_zz) - ww6_yz*dJ6_yz - XZ6*f6_2a - XY6*f6_3a + XX6*wd6_x + MY6*vd5_y - MZ6*vd6_y
    f6_5 = (
        -(XZ6*(ww6_xx - ww6_zz) - ww6_xz*dJ6_xz - YZ6*f6_1a + XY6*f6_3b - YY6*wd6_y + MX6*vd5_y - MZ6*vd6_x)
    )
    f6_6 = XY6*(ww6_xx - ww6_yy) - ww6_xy*dJ6_xy + YZ6*f6_1b + XZ6*f6_2b + ZZ6*wd6_z + MX6*vd6_y - MY6*vd6_x

    # Backward recursion: articulated inertias and wrenches, joint 5 (j5) [50]-[56].
    f5_1a = wd5_z - ww5_xy
    f5_1b = ww5_xz + wd5_y
    f5_2a = -(ww5_xy + wd5_z)
    f5_2b = wd5_x - ww5_yz
    f5_3a = ww5_xz - wd5_y
    f5_3b = -(ww5_yz + wd5_x)
    f5_1 = -(MX5*(ww5_yy + ww5_zz) + MY5*f5_1a - MZ5*f5_1b - M5*vd5_x + sin_th6*f6_2 - cos_th6*f6_1)
    f5_2 = M5*vd5_y - (MX5*f5_2a + MY5*(ww5_xx + ww5_zz) + MZ5*f5_2b) + f6_3
    f5_3 = -(M5*vd4_y - (MX5*f5_3a - MY5*f5_3b - MZ5*(ww5_xx + ww5_yy)) + sin_th6*f6_1 + cos_th6*f6_2)
    f5_4 = (
        YZ5*(ww5_yy - ww5_zz) - ww5_yz*dJ5_yz - XZ5*f5_2a - XY5*f5_3a + XX5*wd5_x - (MY5*vd4_y
        + MZ5*vd5_y) + cos_th6*f6_4 - sin_th6*f6_5
    )
    f5_5 = (
        f6_6 - (XZ5*(ww5_xx - ww5_zz) - ww5_xz*dJ5_xz - YZ5*f5_1a + XY5*f5_3b - YY5*wd5_y
        - (MZ5*vd5_x + MX5*vd4_y))
    )
    f5_6 = (
        XY5*(ww5_xx - ww5_yy) - ww5_xy*dJ5_xy + YZ5*f5_1b + XZ5*f5_2b + ZZ5*wd5_z + MX5*vd5_y
        - MY5*vd5_x - (sin_th6*f6_4 + cos_th6*f6_5)
    )

    # Backward recursion: articulated inertias and wrenches, joint 4 (j4) [50]-[56].
    f4_1a = wd4_z - ww4_xy
    f4_1b = ww4_xz + wd4_y
    f4_2a = -(ww4_xy + wd4_z)
    f4_2b = wd4_x - ww4_yz
    f4_3a = ww4_xz - wd4_y
    f4_3b = -(ww4_yz + wd4_x)
    f4_1 = -(MX4*(ww4_yy + ww4_zz) + MY4*f4_1a - MZ4*f4_1b - M4*vd4_x + sin_th5*f5_2 - cos_th5*f5_1)
    f4_2 = M4*vd4_y - (MX4*f4_2a + MY4*(ww4_xx + ww4_zz) + MZ4*f4_2b) - f5_3
    f4_3 = M4*vd4_z + MX4*f4_3a - MY4*f4_3b - MZ4*(ww4_xx + ww4_yy) + sin_th5*f5_1 + cos_th5*f5_2
    f4_4 = (
        YZ4*(ww4_yy - ww4_zz) - ww4_yz*dJ4_yz - XZ4*f4_2a - XY4*f4_3a + XX4*wd4_x - (MZ4*vd4_y
        - MY4*vd4_z) + cos_th5*f5_4 - sin_th5*f5_5
    )
    f4_5 = (
        -(XZ4*(ww4_xx - ww4_zz) - ww4_xz*dJ4_xz - YZ4*f4_1a + XY4*f4_3b - YY4*wd4_y + MX4*vd4_z
        - MZ4*vd4_x + f5_6)
    )
    f4_6 = (
        XY4*(ww4_xx - ww4_yy) - ww4_xy*dJ4_xy + YZ4*f4_1b + XZ4*f4_2b + ZZ4*wd4_z + MX4*vd4_y
        - MY4*vd4_x + sin_th5*f5_4 + cos_th5*f5_5
    )

    # Backward recursion: articulated inertias and wrenches, joint 3 (j3) [50]-[56].
    f3_1a = ww3_xz + wd3_y
    f3_2a = -(ww3_xy + wd3_z)
    f3_2b = wd3_x - ww3_yz
    f3_3a = ww3_xz - wd3_y
    f3_4a = f4_4 - RL4*f4_2
    f3_4b = -(f4_5 + RL4*f4_1)
    f3_1 = -(MX3*(ww3_yy + ww3_zz) + MY3*vd4_xa - MZ3*f3_1a - M3*vd3_x + sin_th4*f4_2 - cos_th4*f4_1)
    f3_2 = M3*vd3_y - (MX3*f3_2a + MY3*vd4_za + MZ3*f3_2b) + f4_3
    f3_3 = M3*vd3_z + MX3*f3_3a - MY3*vd4_xb - MZ3*(ww3_xx + ww3_yy) - (sin_th4*f4_1 + cos_th4*f4_2)
    f3_4 = (
        YZ3*(ww3_yy - ww3_zz) - ww3_yz*dJ3_yz - XZ3*f3_2a - XY3*f3_3a + XX3*wd3_x + MY3*vd3_z
        - MZ3*vd3_y + cos_th4*f3_4a + sin_th4*f3_4b
    )
    f3_5 = (
        f4_6 - (XZ3*(ww3_xx - ww3_zz) - ww3_xz*dJ3_xz - YZ3*vd4_xa + XY3*vd4_xb - YY3*wd3_y
        + MX3*vd3_z - MZ3*vd3_x)
    )
    f3_6 = (
        XY3*(ww3_xx - ww3_yy) - ww3_xy*dJ3_xy + YZ3*f3_1a + XZ3*f3_2b + ZZ3*wd3_z + MX3*vd3_y
        - MY3*vd3_x - (sin_th4*f3_4a - cos_th4*f3_4b)
    )

    # Backward recursion: articulated inertias and wrenches, joint 2 (j2) [50]-[56].
    f2_4 = (
        YZ2*(ww2_yy - ww2_zz) - ww2_yz*dJ2_yz + XZ2*vd3_xa - XY2*vd3_za + XX2*wd2_x - MZ2*vd2_y
        + cos_th3*f3_4 - sin_th3*f3_5
    )
    f2_5 = (
        sin_th3*f3_4 + cos_th3*f3_5 - D3*f3_3 - (XZ2*(ww2_xx - ww2_zz) - ww2_xz*dJ2_xz
        - YZ2*(qdd2 - ww2_xy) - XY2*(ww2_yz + wd2_x) - YY2*wd2_y - MZ2*vd2_x)
    )
    f2_6 = (
        XY2*(ww2_xx - ww2_yy) - ww2_xy*dJ2_xy + YZ2*(ww2_xz + wd2_y) - XZ2*(ww2_yz - wd2_x)
        + ZZ2*qdd2 - (MY2*vd2_x - MX2*vd2_y) + f3_6 + D3*(sin_th3*f3_1 + cos_th3*f3_2)
    )

    # Backward recursion: articulated inertias and wrenches, joint 1 (j1) [50]-[56].
    f1_6 = ZZ1*qdd1 + sin_th2*f2_4 + cos_th2*f2_5

    # Forward recursion: accelerations and torques, joint 1 (j1) [57]-[61].
    Gamma1 = f1_6 + IA1*qdd1

    # Forward recursion: accelerations and torques, joint 2 (j2) [57]-[61].
    Gamma2 = f2_6 + IA2*qdd2

    # Forward recursion: accelerations and torques, joint 3 (j3) [57]-[61].
    Gamma3 = f3_6 + IA3*qdd3

    # Forward recursion: accelerations and torques, joint 4 (j4) [57]-[61].
    Gamma4 = f4_6 + IA4*qdd4

    # Forward recursion: accelerations and torques, joint 5 (j5) [57]-[61].
    Gamma5 = f5_6 + IA5*qdd5

    # Forward recursion: accelerations and torques, joint 6 (j6) [57]-[61].
    Gamma6 = f6_6 + IA6*qdd6

    # Results.
    return (
        (Gamma1, Gamma2, Gamma3, Gamma4, Gamma5, Gamma6),
        (qdd1, qdd2, qdd3, qdd4, qdd5, qdd6),
    )
