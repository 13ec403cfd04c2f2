"""Inverse dynamic model: motor torques and elastic accelerations of rx90 [37]-[61]: 280x 264+, 10 sin/cos a call; 0x 15+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 394688354  # of the files of this package: those of another run are not imported


def constants(_f, p):
    (
        _, _, _, _, _, ZZ1, _, _, _, _, IA1, XX2, XY2, XZ2, YY2, YZ2, ZZ2, MX2, MY2, MZ2, _, IA2,
        D3, XX3, XY3, XZ3, YY3, YZ3, ZZ3, MX3, MY3, MZ3, M3, IA3, RL4, XX4, XY4, XZ4, YY4, YZ4,
        ZZ4, MX4, MY4, MZ4, M4, IA4, XX5, XY5, XZ5, YY5, YZ5, ZZ5, MX5, MY5, MZ5, M5, IA5, XX6,
        XY6, XZ6, YY6, YZ6, ZZ6, MX6, MY6, MZ6, M6, IA6, G3,
    ) = p

    # Forward recursion: velocities, accelerations, wrenches, joint 2 (j2) [1], [3], [6], [12].
    dJ2_yz = YY2 - ZZ2
    dJ2_xz = XX2 - ZZ2
    dJ2_xy = XX2 - YY2

    # Forward recursion: velocities, accelerations, wrenches, joint 3 (j3) [1], [3], [6], [12].
    dJ3_yz = YY3 - ZZ3
    dJ3_xz = XX3 - ZZ3
    dJ3_xy = XX3 - YY3

    # Forward recursion: velocities, accelerations, wrenches, joint 4 (j4) [1], [3], [6], [12].
    dJ4_yz = YY4 - ZZ4
    dJ4_xz = XX4 - ZZ4
    dJ4_xy = XX4 - YY4

    # Forward recursion: velocities, accelerations, wrenches, joint 5 (j5) [1], [3], [6], [12].
    dJ5_yz = YY5 - ZZ5
    dJ5_xz = XX5 - ZZ5
    dJ5_xy = XX5 - YY5

    # Forward recursion: velocities, accelerations, wrenches, joint 6 (j6) [1], [3], [6], [12].
    dJ6_yz = YY6 - ZZ6
    dJ6_xz = XX6 - ZZ6
    dJ6_xy = XX6 - YY6
    return (
        ZZ1, IA1, XX2, XY2, XZ2, YY2, YZ2, ZZ2, MX2, MY2, MZ2, IA2, D3, XX3, XY3, XZ3, YY3, YZ3,
        ZZ3, MX3, MY3, MZ3, M3, IA3, RL4, XX4, XY4, XZ4, YY4, YZ4, ZZ4, MX4, MY4, MZ4, M4, IA4,
        XX5, XY5, XZ5, YY5, YZ5, ZZ5, MX5, MY5, MZ5, M5, IA5, XX6, XY6, XZ6, YY6, YZ6, ZZ6, MX6,
        MY6, MZ6, M6, IA6, G3, dJ2_yz, dJ2_xz, dJ2_xy, dJ3_yz, dJ3_xz, dJ3_xy, dJ4_yz, dJ4_xz,
        dJ4_xy, dJ5_yz, dJ5_xz, dJ5_xy, dJ6_yz, dJ6_xz, dJ6_xy,
    )


def program(_f, q, qd, qdd_motor, c):
    (_, th2, th3, th4, th5, th6) = q
    (qd1, qd2, qd3, qd4, qd5, qd6) = qd
    (qdd1, qdd2, qdd3, qdd4, qdd5, qdd6) = qdd_motor
    (
        ZZ1, IA1, XX2, XY2, XZ2, YY2, YZ2, ZZ2, MX2, MY2, MZ2, IA2, D3, XX3, XY3, XZ3, YY3, YZ3,
        ZZ3, MX3, MY3, MZ3, M3, IA3, RL4, XX4, XY4, XZ4, YY4, YZ4, ZZ4, MX4, MY4, MZ4, M4, IA4,
        XX5, XY5, XZ5, YY5, YZ5, ZZ5, MX5, MY5, MZ5, M5, IA5, XX6, XY6, XZ6, YY6, YZ6, ZZ6, MX6,
        MY6, MZ6, M6, IA6, G3, dJ2_yz, dJ2_xz, dJ2_xy, dJ3_yz, dJ3_xz, dJ3_xy, dJ4_yz, dJ4_xz,
        dJ4_xy, dJ5_yz, dJ5_xz, dJ5_xy, dJ6_yz, dJ6_xz, dJ6_xy,
    ) = c

    # Forward recursion: velocities, accelerations, wrenches, joint 1 (j1) [1], [3], [6], [12].
    ww1_zz = qd1*qd1
    Fb1_6 = ZZ1*qdd1

    # Forward recursion: velocities, accelerations, wrenches, joint 2 (j2) [1], [3], [6], [12].
    sin_th2 = _f.sin(th2)
    cos_th2 = _f.cos(th2)
    w2_x = qd1*sin_th2
    w2_y = qd1*cos_th2
    ww2_yz = qd2*w2_y
    ww2_xz = qd2*w2_x
    wd2_ya = qdd1*cos_th2
    wd2_xa = qdd1*sin_th2
    wd2_x = ww2_yz + wd2_xa
    wd2_y = wd2_ya - ww2_xz
    ww2_xx = w2_x*w2_x
    ww2_xy = w2_x*w2_y
    ww2_zz = qd2*qd2
    Fb2_5a = ww2_xx - ww2_zz
    Fb2_6a = ww1_zz - Fb2_5a
    Fb2_4a = qdd2 + ww2_xy
    Fb2_4b = ww2_xx + ww2_zz
    Fb2_4c = ww2_xz - wd2_y
    vd2_x = -G3*sin_th2
    vd2_y = -G3*cos_th2
    Fb2_4 = XX2*wd2_x - MZ2*vd2_y + YZ2*(ww1_zz - Fb2_4b) - ww2_yz*dJ2_yz + XZ2*Fb2_4a - XY2*Fb2_4c
    Fb2_5 = YY2*wd2_y + MZ2*vd2_x - (XZ2*Fb2_5a - ww2_xz*dJ2_xz - YZ2*(qdd2 - ww2_xy) - XY2*(ww2_yz + wd2_x))
    Fb2_6 = (
        ZZ2*qdd2 + MX2*vd2_y - MY2*vd2_x - (XY2*(Fb2_6a - Fb2_4b) + ww2_xy*dJ2_xy - YZ2*wd2_ya - XZ2*wd2_xa)
    )

    # Forward recursion: velocities, accelerations, wrenches, joint 3 (j3) [1], [3], [6], [12].
    sin_th3 = _f.sin(th3)
    cos_th3 = _f.cos(th3)
    w3_x = cos_th3*w2_x + sin_th3*w2_y
    w3_y = cos_th3*w2_y - sin_th3*w2_x
    w3_z = qd2 + qd3
    wd3_ya = cos_th3*wd2_ya - sin_th3*wd2_xa
    wd3_xa = sin_th3*wd2_ya + cos_th3*wd2_xa
    ww3_yz = w3_y*w3_z
    wd3_x = wd3_xa + ww3_yz
    ww3_xz = w3_x*w3_z
    wd3_y = wd3_ya - ww3_xz
    wd3_z = qdd2 + qdd3
    ww3_xx = w3_x*w3_x
    ww3_xy = w3_x*w3_y
    ww3_zz = w3_z*w3_z
    Fb3_1a = ww3_xx - ww3_zz
    Fb3_1b = ww1_zz - Fb3_1a
    Fb3_1c = wd3_z - ww3_xy
    Fb3_2a = wd3_z + ww3_xy
    Fb3_2b = ww3_xx + ww3_zz
    Fb3_3a = ww3_xz - wd3_y
    Fb3_3b = -(ww3_yz + wd3_x)
    vd3_z = D3*Fb2_4c
    vd3_xa = D3*Fb2_6a - vd2_x
    vd3_xb = -(vd2_y + D3*Fb2_4a)
    vd3_x = -(cos_th3*vd3_xa + sin_th3*vd3_xb)
    vd3_y = sin_th3*vd3_xa - cos_th3*vd3_xb
    Fb3_1 = M3*vd3_x - (MX3*Fb3_1b + MY3*Fb3_1c - MZ3*wd3_ya)
    Fb3_2 = M3*vd3_y + MX3*Fb3_2a - MY3*Fb3_2b - MZ3*wd3_xa
    Fb3_3 = M3*vd3_z + MX3*Fb3_3a - MY3*Fb3_3b - MZ3*ww1_zz
    Fb3_4 = (
        XX3*wd3_x + MY3*vd3_z - MZ3*vd3_y + YZ3*(ww1_zz - Fb3_2b) - ww3_yz*dJ3_yz + XZ3*Fb3_2a - XY3*Fb3_3a
    )
    Fb3_5 = YY3*wd3_y + MZ3*vd3_x - MX3*vd3_z - (XZ3*Fb3_1a - ww3_xz*dJ3_xz - YZ3*Fb3_1c + XY3*Fb3_3b)
    Fb3_6 = (
        ZZ3*wd3_z + MX3*vd3_y - MY3*vd3_x - (XY3*(Fb3_1b - Fb3_2b) + ww3_xy*dJ3_xy - YZ3*wd3_ya
        - XZ3*wd3_xa)
    )

    # Forward recursion: velocities, accelerations, wrenches, joint 4 (j4) [1], [3], [6], [12].
    sin_th4 = _f.sin(th4)
    cos_th4 = _f.cos(th4)
    w4_x = cos_th4*w3_x - sin_th4*w3_z
    w4_y = -(sin_th4*w3_x + cos_th4*w3_z)
    w4_z = qd4 + w3_y
    wd4_ya = cos_th4*Fb3_1c - sin_th4*Fb3_3b
    wd4_xa = sin_th4*Fb3_1c + cos_th4*Fb3_3b
    ww4_yz = w4_y*w4_z
    wd4_x = ww4_yz - wd4_xa
    ww4_xz = w4_x*w4_z
    wd4_y = -(wd4_ya + ww4_xz)
    wd4_z = qdd4 + wd3_y
    ww4_xx = w4_x*w4_x
    ww4_xy = w4_x*w4_y
    ww4_zz = w4_z*w4_z
    Fb4_1a = ww4_xx - ww4_zz
    Fb4_1b = Fb3_2b - Fb4_1a
    Fb4_1c = wd4_z - ww4_xy
    Fb4_2a = wd4_z + ww4_xy
    Fb4_2b = ww4_xx + ww4_zz
    Fb4_3a = ww4_xz - wd4_y
    Fb4_3b = -(ww4_yz + wd4_x)
    vd4_x = -(sin_th4*vd3_z - cos_th4*vd3_x + RL4*wd4_ya)
    vd4_y = RL4*wd4_xa - (sin_th4*vd3_x + cos_th4*vd3_z)
    vd4_z = vd3_y - RL4*Fb3_2b
    Fb4_1 = M4*vd4_x - (MX4*Fb4_1b + MY4*Fb4_1c + MZ4*wd4_ya)
    Fb4_2 = M4*vd4_y + MX4*Fb4_2a - MY4*Fb4_2b + MZ4*wd4_xa
    Fb4_3 = M4*vd4_z + MX4*Fb4_3a - MY4*Fb4_3b - MZ4*Fb3_2b
    Fb4_4 = (
        YZ4*(Fb3_2b - Fb4_2b) - ww4_yz*dJ4_yz + XZ4*Fb4_2a - XY4*Fb4_3a - (MZ4*vd4_y
        - (XX4*wd4_x + MY4*vd4_z))
    )
    Fb4_5 = -(MX4*vd4_z - (YY4*wd4_y + MZ4*vd4_x) + XZ4*Fb4_1a - ww4_xz*dJ4_xz - YZ4*Fb4_1c + XY4*Fb4_3b)
    Fb4_6 = (
        ZZ4*wd4_z + MX4*vd4_y - MY4*vd4_x - (XY4*(Fb4_1b - Fb4_2b) + ww4_xy*dJ4_xy + YZ4*wd4_ya
        + XZ4*wd4_xa)
    )

    # Forward recursion: velocities, accelerations, wrenches, joint 5 (j5) [1], [3], [6], [12].
    sin_th5 = _f.sin(th5)
    cos_th5 = _f.cos(th5)
    w5_x = cos_th5*w4_x + sin_th5*w4_z
    w5_y = cos_th5*w4_z - sin_th5*w4_x
    w5_z = qd5 - w4_y
    wd5_ya = cos_th5*Fb4_1c + sin_th5*Fb4_3b
    wd5_xa = sin_th5*Fb4_1c - cos_th5*Fb4_3b
    ww5_yz = w5_y*w5_z
    wd5_x = wd5_xa + ww5_yz
    ww5_xz = w5_x*w5_z
    wd5_y = wd5_ya - ww5_xz
    wd5_z = qdd5 - wd4_y
    ww5_xx = w5_x*w5_x
    ww5_xy = w5_x*w5_y
    ww5_zz = w5_z*w5_z
    Fb5_1a = ww5_xx - ww5_zz
    Fb5_1b = Fb4_2b - Fb5_1a
    Fb5_1c = wd5_z - ww5_xy
    Fb5_2a = wd5_z + ww5_xy
    Fb5_2b = ww5_xx + ww5_zz
    Fb5_3a = ww5_xz - wd5_y
    Fb5_3b = -(ww5_yz + wd5_x)
    vd5_x = cos_th5*vd4_x + sin_th5*vd4_z
    vd5_y = cos_th5*vd4_z - sin_th5*vd4_x
    Fb5_1 = M5*vd5_x - (MX5*Fb5_1b + MY5*Fb5_1c - MZ5*wd5_ya)
    Fb5_2 = M5*vd5_y + MX5*Fb5_2a - MY5*Fb5_2b - MZ5*wd5_xa
    Fb5_3 = MX5*Fb5_3a - MY5*Fb5_3b - MZ5*Fb4_2b - M5*vd4_y
    Fb5_4 = (
        XX5*wd5_x - MY5*vd4_y - MZ5*vd5_y + YZ5*(Fb4_2b - Fb5_2b) - ww5_yz*dJ5_yz + XZ5*Fb5_2a - XY5*Fb5_3a
    )
    Fb5_5 = YY5*wd5_y + MZ5*vd5_x + MX5*vd4_y - (XZ5*Fb5_1a - ww5_xz*dJ5_xz - YZ5*Fb5_1c + XY5*Fb5_3b)
    Fb5_6 = (
        ZZ5*wd5_z + MX5*vd5_y - MY5*vd5_x - (XY5*(Fb5_1b - Fb5_2b) + ww5_xy*dJ5_xy - YZ5*wd5_ya
        - XZ5*wd5_xa)
    )

    # Forward recursion: velocities, accelerations, wrenches, joint 6 (j6) [1], [3], [6], [12].
    sin_th6 = _f.sin(th6)
    cos_th6 = _f.cos(th6)
    w6_x = cos_th6*w5_x - sin_th6*w5_z
    w6_y = -(sin_th6*w5_x + cos_th6*w5_z)
    w6_z = qd6 + w5_y
    wd6_ya = cos_th6*Fb5_1c - sin_th6*Fb5_3b
    wd6_xa = sin_th6*Fb5_1c + cos_th6*Fb5_3b
    ww6_yz = w6_y*w6_z
    wd6_x = ww6_yz - wd6_xa
    ww6_xz = w6_x*w6_z
    wd6_y = -(wd6_ya + ww6_xz)
    wd6_z = qdd6 + wd5_y
    ww6_xx = w6_x*w6_x
    ww6_xy = w6_x*w6_y
    ww6_zz = w6_z*w6_z
    Fb6_1a = ww6_xx - ww6_zz
    Fb6_1b = Fb5_2b - Fb6_1a
    Fb6_1c = wd6_z - ww6_xy
    Fb6_2a = wd6_z + ww6_xy
    Fb6_2b = ww6_xx + ww6_zz
    Fb6_3a = ww6_xz - wd6_y
    Fb6_3b = -(ww6_yz + wd6_x)
    vd6_x = cos_th6*vd5_x + sin_th6*vd4_y
    vd6_y = cos_th6*vd4_y - sin_th6*vd5_x
    Fb6_1 = M6*vd6_x - (MX6*Fb6_1b + MY6*Fb6_1c + MZ6*wd6_ya)
    Fb6_2 = M6*vd6_y + MX6*Fb6_2a - MY6*Fb6_2b + MZ6*wd6_xa
    Fb6_3 = M6*vd5_y + MX6*Fb6_3a - MY6*Fb6_3b - MZ6*Fb5_2b
    Fb6_4 = (
        YZ6*(Fb5_2b - Fb6_2b) - ww6_yz*dJ6_yz + XZ6*Fb6_2a - XY6*Fb6_3a - (MZ6*vd6_y
        - (XX6*wd6_x + MY6*vd5_y))
    )
    Fb6_5 = -(MX6*vd5_y - (YY6*wd6_y + MZ6*vd6_x) + XZ6*Fb6_1a - ww6_xz*dJ6_xz - YZ6*Fb6_1c + XY6*Fb6_3b)
    Fb6_6 = (
        ZZ6*wd6_z + MX6*vd6_y - MY6*vd6_x - (XY6*(Fb6_1b - Fb6_2b) + ww6_xy*dJ6_xy + YZ6*wd6_ya
        + XZ6*wd6_xa)
    )

    # Backward recursion: articulated inertias and wrenches, joint 5 (j5) [50]-[56].
    f5_1 = Fb5_1 - (sin_th6*Fb6_2 - cos_th6*Fb6_1)
    f5_2 = Fb5_2 + Fb6_3
    f5_3 = Fb5_3 - (sin_th6*Fb6_1 + cos_th6*Fb6_2)
    f5_4 = Fb5_4 - (sin_th6*Fb6_5 - cos_th6*Fb6_4)
    f5_5 = Fb5_5 + Fb6_6
    f5_6 = Fb5_6 - (sin_th6*Fb6_4 + cos_th6*Fb6_5)

    # Backward recursion: articulated inertias and wrenches, joint 4 (j4) [50]-[56].
    f4_1 = Fb4_1 - (sin_th5*f5_2 - cos_th5*f5_1)
    f4_2 = Fb4_2 - f5_3
    f4_3 = Fb4_3 + sin_th5*f5_1 + cos_th5*f5_2
    f4_4 = Fb4_4 + cos_th5*f5_4 - sin_th5*f5_5
    f4_5 = Fb4_5 - f5_6
    f4_6 = Fb4_6 + sin_th5*f5_4 + cos_th5*f5_5

    # Backward recursion: articulated inertias and wrenches, joint 3 (j3) [50]-[56].
    f3_4a = RL4*f4_2 - f4_4
    f3_4b = -(f4_5 + RL4*f4_1)
    f3_1 = Fb3_1 - (sin_th4*f4_2 - cos_th4*f4_1)
    f3_2 = Fb3_2 + f4_3
    f3_3 = Fb3_3 - (sin_th4*f4_1 + cos_th4*f4_2)
    f3_4 = Fb3_4 - (cos_th4*f3_4a - sin_th4*f3_4b)
    f3_5 = Fb3_5 + f4_6
    f3_6 = Fb3_6 + sin_th4*f3_4a + cos_th4*f3_4b

    # Backward recursion: articulated inertias and wrenches, joint 2 (j2) [50]-[56].
    f2_4 = Fb2_4 + cos_th3*f3_4 - sin_th3*f3_5
    f2_5 = Fb2_5 + sin_th3*f3_4 + cos_th3*f3_5 - D3*f3_3
    f2_6 = Fb2_6 + f3_6 + D3*(sin_th3*f3_1 + cos_th3*f3_2)

    # Backward recursion: articulated inertias and wrenches, joint 1 (j1) [50]-[56].
    f1_6 = Fb1_6 + sin_th2*f2_4 + cos_th2*f2_5

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
    Gamma6 = Fb6_6 + IA6*qdd6

    # Results.
    return (
        (Gamma1, Gamma2, Gamma3, Gamma4, Gamma5, Gamma6),
        (qdd1, qdd2, qdd3, qdd4, qdd5, qdd6),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=6, qd=6, qdd_motor=6),
    parameters=69,
    results=((6,), (6,)),
)
