"""Inverse dynamic model: motor torques and elastic accelerations of sr400 [37]-[61]: 235x 200+, 8 sin/cos a call.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 354700140  # of the files of this package: those of another run are not imported


def constants(_f, p):
    (D2, D3, D4, RL4, D8) = p
    return (D2, D3, D4, RL4, D8)


def program(_f, q, qd, qdd_motor, c):
    (_, th2, th4, th5, _, th7) = q
    (qd1, qd2, qd4, qd5, qd6, qd7) = qd
    (qdd1, qdd2, qdd4, qdd5, qdd6, qdd7) = qdd_motor
    (D2, D3, D4, RL4, D8) = c

    # Forward recursion: velocities, accelerations, wrenches, joint 1 (waist) [1], [3], [6], [12].
    ww1_zz = qd1*qd1
    Fb1_6 = 6.2*qdd1

    # Forward recursion: velocities, accelerations, wrenches, joint 2 (shoulder) [1], [3], [6], [12].
    sin_th2 = _f.sin(th2)
    cos_th2 = _f.cos(th2)
    w2_x = -qd1*sin_th2
    w2_y = -qd1*cos_th2
    ww2_yz = qd2*w2_y
    ww2_xz = qd2*w2_x
    wd2_ya = qdd1*cos_th2
    wd2_xa = qdd1*sin_th2
    wd2_x = ww2_yz - wd2_xa
    wd2_y = -(ww2_xz + wd2_ya)
    ww2_xx = w2_x*w2_x
    ww2_xy = w2_x*w2_y
    ww2_zz = qd2*qd2
    Fb2_5a = ww2_xx - ww2_zz
    Fb2_4a = qdd2 + ww2_xy
    Fb2_3a = wd2_y - ww2_xz
    vd2_xa = D2*ww1_zz
    vd2_z = D2*qdd1
    vd2_x = -(cos_th2*vd2_xa + 9.81*sin_th2)
    vd2_y = sin_th2*vd2_xa - 9.81*cos_th2
    Fb2_3 = 60.0*vd2_z - (24.0*Fb2_3a + 3.0*ww1_zz)
    Fb2_4 = -(3.0*vd2_y - 0.75*wd2_x + 0.15*ww2_yz + 1.2*Fb2_4a)
    Fb2_5 = 13.75*wd2_y + 3.0*vd2_x - 24.0*vd2_z + 1.2*Fb2_5a - 12.85*ww2_xz
    Fb2_6 = 13.6*qdd2 + 24.0*vd2_y + 13.0*ww2_xy + 1.2*wd2_xa

    # Forward recursion: velocities, accelerations, wrenches, joint 3 (elbow) [1], [3], [6], [12].
    sin_th7 = _f.sin(th7)
    cos_th7 = _f.cos(th7)
    sin3_theta = -(cos_th2*cos_th7 + sin_th2*sin_th7)
    cos3_theta = cos_th2*sin_th7 - sin_th2*cos_th7
    w3_x = cos3_theta*w2_x + sin3_theta*w2_y
    w3_y = cos3_theta*w2_y - sin3_theta*w2_x
    w3_z = qd2 - (qd2 - qd7)
    vd3_xa = ww1_zz - Fb2_5a
    ww3_yz = w3_y*w3_z
    wd3_x = ww3_yz - (sin3_theta*wd2_ya + cos3_theta*wd2_xa)
    ww3_xz = w3_x*w3_z
    wd3_y = sin3_theta*wd2_xa - cos3_theta*wd2_ya - ww3_xz
    wd3_z = qdd2 - (qdd2 - qdd7)
    ww3_xx = w3_x*w3_x
    ww3_xy = w3_x*w3_y
    ww3_zz = w3_z*w3_z
    Fb3_1a = ww1_zz - (ww3_xx - ww3_zz)
    Fb3_1b = wd3_z - ww3_xy
    Fb3_2a = wd3_z + ww3_xy
    Fb3_2b = ww3_xx + ww3_zz
    Fb3_3a = ww3_xz - wd3_y
    Fb3_3b = -(ww3_yz + wd3_x)
    vd3_xb = D3*vd3_xa - vd2_x
    vd3_xc = vd2_y + D3*Fb2_4a
    vd3_z = vd2_z - D3*Fb2_3a
    vd3_x = sin3_theta*vd3_xc - cos3_theta*vd3_xb
    vd3_y = sin3_theta*vd3_xb + cos3_theta*vd3_xc
    Fb3_1 = 40.0*vd3_x - (4.0*Fb3_1a + 10.0*Fb3_1b)
    Fb3_2 = 40.0*vd3_y + 4.0*Fb3_2a - 10.0*Fb3_2b
    Fb3_3 = 40.0*vd3_z + 4.0*Fb3_3a - 10.0*Fb3_3b
    Fb3_4 = 5.0*wd3_x + 10.0*vd3_z + Fb3_3a + 4.2*ww3_yz
    Fb3_5 = 1.2*wd3_y - 4.0*vd3_z + Fb3_3b - 0.4*ww3_xz
    Fb3_6 = 5.4*wd3_z + 4.0*vd3_y - 10.0*vd3_x + Fb3_1a - Fb3_2b - 3.8*ww3_xy

    # Forward recursion: velocities, accelerations, wrenches, joint 4 (wrist_1) [1], [3], [6], [12].
    sin_th4 = _f.sin(th4)
    cos_th4 = _f.cos(th4)
    w4_x = cos_th4*w3_x - sin_th4*w3_z
    w4_y = -(sin_th4*w3_x + cos_th4*w3_z)
    w4_z = qd4 + w3_y
    wd4_ya = cos_th4*Fb3_1b - sin_th4*Fb3_3b
    wd4_xa = sin_th4*Fb3_1b + cos_th4*Fb3_3b
    ww4_yz = w4_y*w4_z
    wd4_x = ww4_yz - wd4_xa
    ww4_xz = w4_x*w4_z
    wd4_y = -(wd4_ya + ww4_xz)
    wd4_z = qdd4 + wd3_y
    ww4_xy = w4_x*w4_y
    vd4_xa = vd3_x - D4*Fb3_1a
    vd4_xb = vd3_z + D4*Fb3_3a
    vd4_x = cos_th4*vd4_xa - sin_th4*vd4_xb - RL4*wd4_ya
    vd4_y = RL4*wd4_xa - (sin_th4*vd4_xa + cos_th4*vd4_xb)
    vd4_z = vd3_y + D4*Fb3_2a - RL4*Fb3_2b
    Fb4_1 = 20.0*vd4_x + 6.0*wd4_ya
    Fb4_2 = 20.0*vd4_y - 6.0*wd4_xa
    Fb4_3 = 20.0*vd4_z + 6.0*Fb3_2b
    Fb4_6 = 0.1*wd4_z
    Fb4_4 = 2.6*wd4_x + 6.0*vd4_y - 2.5*ww4_yz
    Fb4_5 = 2.5*ww4_xz - (6.0*vd4_x - 2.6*wd4_y)

    # Forward recursion: velocities, accelerations, wrenches, joint 5 (wrist_2) [1], [3], [6], [12].
    sin_th5 = _f.sin(th5)
    cos_th5 = _f.cos(th5)
    w5_x = cos_th5*w4_x + sin_th5*w4_z
    w5_y = cos_th5*w4_z - sin_th5*w4_x
    w5_z = qd5 - w4_y
    wd5_xa = wd4_z - ww4_xy
    wd5_xb = -(ww4_yz + wd4_x)
    ww5_yz = w5_y*w5_z
    wd5_x = sin_th5*wd5_xa - cos_th5*wd5_xb + ww5_yz
    ww5_xz = w5_x*w5_z
    wd5_y = cos_th5*wd5_xa + sin_th5*wd5_xb - ww5_xz
    wd5_z = qdd5 - wd4_y
    ww5_xx = w5_x*w5_x
    ww5_xy = w5_x*w5_y
    ww5_zz = w5_z*w5_z
    Fb5_1a = wd5_z - ww5_xy
    Fb5_2a = ww5_xx + ww5_zz
    Fb5_3a = -(ww5_yz + wd5_x)
    vd5_x = cos_th5*vd4_x + sin_th5*vd4_z
    vd5_y = cos_th5*vd4_z - sin_th5*vd4_x
    Fb5_1 = 8.0*vd5_x - 0.24*Fb5_1a
    Fb5_2 = 8.0*vd5_y - 0.24*Fb5_2a
    Fb5_3 = -(8.0*vd4_y + 0.24*Fb5_3a)
    Fb5_5 = 0.04*wd5_y
    Fb5_4 = 0.0672*wd5_x - 0.24*vd4_y + 0.0272*ww5_yz
    Fb5_6 = 0.0672*wd5_z - 0.24*vd5_x - 0.0272*ww5_xy

    # Forward recursion: velocities, accelerations, wrenches, joint 6 (wrist_3) [1], [3], [6], [12].
    w6_z = qd6 + w5_y
    ww6_yz = -w5_z*w6_z
    wd6_x = ww6_yz - Fb5_3a
    ww6_xz = w5_x*w6_z
    wd6_y = -(Fb5_1a + ww6_xz)
    wd6_z = qdd6 + wd5_y
    Fb6_1 = 3.0*vd5_x - 0.3*Fb5_1a
    Fb6_2 = 3.0*vd4_y + 0.3*Fb5_3a
    Fb6_3 = 3.0*vd5_y - 0.3*Fb5_2a
    Fb6_6 = 0.006*wd6_z
    Fb6_4 = -(0.3*vd4_y - 0.04*wd6_x + 0.034*ww6_yz)
    Fb6_5 = 0.04*wd6_y + 0.3*vd5_x + 0.034*ww6_xz

    # Forward recursion: velocities, accelerations, wrenches, joint 7 (crank) [1], [3], [6], [12].
    vd7_x = -(cos_th7*vd2_xa + 9.81*sin_th7)
    vd7_y = sin_th7*vd2_xa - 9.81*cos_th7
    Fb7_3 = 25.0*vd2_z + 3.75*Fb3_3b
    Fb7_4 = 0.2*wd3_y
    Fb7_5 = -(1.0625*wd3_x - 3.75*vd2_z + 0.8625*ww3_yz)
    Fb7_6 = 1.0625*wd3_z - 3.75*vd7_y - 0.8625*ww3_xy

    # Forward recursion: velocities, accelerations, wrenches, joint 8 (rod) [1], [3], [6], [12].
    vd8_xa = -(vd7_x + D8*Fb3_2b)
    vd8_xb = vd7_y - D8*Fb3_1b
    vd8_z = vd2_z + D8*Fb3_3b
    vd8_x = sin3_theta*vd8_xa - cos3_theta*vd8_xb
    vd8_y = -(cos3_theta*vd8_xa + sin3_theta*vd8_xb)
    Fb8_1 = 10.0*vd8_x - 4.0*vd3_xa
    Fb8_2 = 10.0*vd8_y + 4.0*Fb2_4a
    Fb8_3 = 10.0*vd8_z - 4.0*Fb2_3a
    Fb8_4 = 0.02*wd2_x
    Fb8_5 = 2.2*wd2_y - 4.0*vd8_z - 2.18*ww2_xz
    Fb8_6 = 2.2*qdd2 + 4.0*vd8_y + 2.18*ww2_xy

    # Backward recursion: articulated inertias and wrenches, joint 7 (crank) [50]-[56].
    f7_3 = Fb7_3 + Fb8_3
    f7_4 = Fb7_4 - (sin3_theta*Fb8_4 - cos3_theta*Fb8_5)
    f7_5 = Fb7_5 - (cos3_theta*Fb8_4 + sin3_theta*Fb8_5 - D8*Fb8_3)
    f7_6 = Fb7_6 + Fb8_6 + D8*(cos3_theta*Fb8_1 + sin3_theta*Fb8_2)

    # Backward recursion: articulated inertias and wrenches, joint 5 (wrist_2) [50]-[56].
    f5_1 = Fb5_1 + Fb6_1
    f5_2 = Fb5_2 + Fb6_3
    f5_3 = Fb5_3 - Fb6_2
    f5_4 = Fb5_4 + Fb6_4
    f5_5 = Fb5_5 + Fb6_6
    f5_6 = Fb5_6 - Fb6_5

    # Backward recursion: articulated inertias and wrenches, joint 4 (wrist_1) [50]-[56].
    f4_1 = Fb4_1 + cos_th5*f5_1 - sin_th5*f5_2
    f4_2 = Fb4_2 - f5_3
    f4_3 = Fb4_3 + sin_th5*f5_1 + cos_th5*f5_2
    f4_4 = Fb4_4 + cos_th5*f5_4 - sin_th5*f5_5
    f4_5 = Fb4_5 - f5_6
    f4_6 = Fb4_6 + sin_th5*f5_4 + cos_th5*f5_5

    # Backward recursion: articulated inertias and wrenches, joint 3 (elbow) [50]-[56].
    f3_4a = RL4*f4_2 - f4_4
    f3_4b = -(f4_5 + RL4*f4_1)
    f3_3a = sin_th4*f4_1 + cos_th4*f4_2
    f3_1 = Fb3_1 + cos_th4*f4_1 - sin_th4*f4_2
    f3_2 = Fb3_2 + f4_3
    f3_3 = Fb3_3 - f3_3a
    f3_4 = Fb3_4 - (cos_th4*f3_4a - sin_th4*f3_4b)
    f3_5 = Fb3_5 + f4_6 + D4*f3_3a
    f3_6 = Fb3_6 + sin_th4*f3_4a + cos_th4*f3_4b + D4*f4_3

    # Backward recursion: articulated inertias and wrenches, joint 2 (shoulder) [50]-[56].
    f2_3 = Fb2_3 + f3_3
    f2_4 = Fb2_4 - (sin3_theta*f3_5 - cos3_theta*f3_4)
    f2_5 = Fb2_5 - (D3*f3_3 - (sin3_theta*f3_4 + cos3_theta*f3_5))
    f2_6 = Fb2_6 + f3_6 + D3*(sin3_theta*f3_1 + cos3_theta*f3_2)

    # Backward recursion: articulated inertias and wrenches, joint 1 (waist) [50]-[56].
    f1_6 = D2*(f7_3 + f2_3) - (cos_th2*f2_5 - (Fb1_6 - sin_th7*f7_4 - cos_th7*f7_5 - sin_th2*f2_4))

    # Forward recursion: accelerations and torques, joint 1 (waist) [57]-[61].
    Gamma1 = 30.0*qdd1 + f1_6

    # Forward recursion: accelerations and torques, joint 2 (shoulder) [57]-[61].
    Gamma2 = f2_6 + 7.5*qdd2

    # Forward recursion: accelerations and torques, joint 4 (wrist_1) [57]-[61].
    Gamma4 = f4_6 + 1.875*qdd4

    # Forward recursion: accelerations and torques, joint 5 (wrist_2) [57]-[61].
    Gamma5 = f5_6 + 1.2*qdd5

    # Forward recursion: accelerations and torques, joint 6 (wrist_3) [57]-[61].
    Gamma6 = Fb6_6 + 0.833*qdd6

    # Forward recursion: accelerations and torques, joint 7 (crank) [57]-[61].
    Gamma7 = f7_6 + 0.612*qdd7

    # Results.
    return (
        (
            Gamma1, Fb8_6 - (f3_6 - Gamma2), Gamma4, Gamma5, Gamma6, -(Fb8_6 - (f3_6 + Gamma7)),
        ),
        (qdd1, qdd2, qdd4, qdd5, qdd6, qdd7),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=6, qd=6, qdd_motor=6),
    parameters=5,
    results=((6,), (6,)),
)
