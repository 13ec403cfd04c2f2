"""Inverse dynamic model: motor torques and elastic accelerations of flex4 [37]-[61]: 142x 113+, 4 sin/cos a call; 14x 9+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _run


def constants(_f, p):
    (
        _, _, _, _, _, ZZ1, _, _, _, _, IA1, _, _, _, _, _, ZZ2, _, _, _, _, k2, L2, XX3, XY3, XZ3,
        YY3, YZ3, ZZ3, MX3, MY3, MZ3, M3, IA3, XX4, XY4, XZ4, YY4, YZ4, ZZ4, MX4, MY4, MZ4, M4, k4,
        G3,
    ) = p

    # Backward recursion: articulated inertias and wrenches, joint 4 (j4) [50]-[56].
    Hinv4 = 1.0/ZZ4
    UH4_1 = -MY4*Hinv4
    UH4_2 = MX4*Hinv4
    UH4_4 = XZ4*Hinv4
    UH4_5 = YZ4*Hinv4
    K4_14a = MY4*UH4_4
    K4_44a = XX4 - XZ4*UH4_4
    K4_14b = MZ4 + MY4*UH4_5
    K4_44b = XY4 - XZ4*UH4_5
    K4_14c = MZ4 + MX4*UH4_4
    K4_14d = MX4*UH4_5
    K4_44c = YY4 - YZ4*UH4_5
    K4_14e = K4_14a + K4_14d
    K4_14f = K4_14b - K4_14c
    K4_44d = K4_44a - K4_44c
    K4_44e = 2.0*K4_44b

    # Backward recursion: articulated inertias and wrenches, joint 3 (j3) [50]-[56].
    Js3_33 = M3 + M4

    # Backward recursion: articulated inertias and wrenches, joint 2 (j2) [50]-[56].
    Js2_66a = L2*Js3_33
    return (
        ZZ1, IA1, ZZ2, k2, L2, XX3, XY3, XZ3, YY3, YZ3, ZZ3, MX3, MY3, MZ3, IA3, XX4, XY4, XZ4,
        YY4, YZ4, ZZ4, MX4, MY4, MZ4, k4, G3, Hinv4, UH4_1, UH4_2, UH4_4, UH4_5, K4_14a, K4_44a,
        K4_14b, K4_44b, K4_14c, K4_14d, K4_44c, K4_14e, K4_14f, K4_44d, K4_44e, Js2_66a,
    )


def program(_f, q, qd, qdd_motor, c):
    (_, th2, th3, th4) = q
    (qd1, qd2, qd3, qd4) = qd
    (qdd1, qdd3) = qdd_motor
    (
        ZZ1, IA1, ZZ2, k2, L2, XX3, XY3, XZ3, YY3, YZ3, ZZ3, MX3, MY3, MZ3, IA3, XX4, XY4, XZ4,
        YY4, YZ4, ZZ4, MX4, MY4, MZ4, k4, G3, Hinv4, UH4_1, UH4_2, UH4_4, UH4_5, K4_14a, K4_44a,
        K4_14b, K4_44b, K4_14c, K4_14d, K4_44c, K4_14e, K4_14f, K4_44d, K4_44e, Js2_66a,
    ) = c

    # Forward recursion: velocities, accelerations, wrenches, joint 1 (j1) [1], [3], [6], [12].
    Fb1_6 = ZZ1*qdd1

    # Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14].
    w2_z = qd1 + qd2

    # Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14].
    sin_th3 = _f.sin(th3)
    cos_th3 = _f.cos(th3)
    w3_x = sin_th3*w2_z
    w3_y = cos_th3*w2_z
    g3_1 = -w2_z*(L2*w2_z)
    g3_4 = qd3*w2_z
    b3_3 = w3_y*(MZ3*w3_y - MY3*qd3) - w3_x*(MX3*qd3 - MZ3*w3_x)
    b3_5a = XX3*w3_x + XY3*w3_y + XZ3*qd3
    b3_4a = XY3*w3_x + YY3*w3_y + YZ3*qd3
    b3_4b = XZ3*w3_x + YZ3*w3_y + ZZ3*qd3
    b3_4 = qd3*b3_4a - w3_y*b3_4b
    b3_5 = w3_x*b3_4b - qd3*b3_5a
    b3_6 = w3_y*b3_5a - w3_x*b3_4a

    # Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14].
    sin_th4 = _f.sin(th4)
    cos_th4 = _f.cos(th4)
    w4_x = cos_th4*w3_x + sin_th4*w3_y
    w4_y = cos_th4*w3_y - sin_th4*w3_x
    w4_z = qd3 + qd4
    g4_4 = qd4*w3_y
    g4_5 = -qd4*w3_x
    b4_3 = -(w4_x*(MX4*w4_z - MZ4*w4_x) + w4_y*(MY4*w4_z - MZ4*w4_y))
    b4_5a = XX4*w4_x + XY4*w4_y + XZ4*w4_z
    b4_4a = XY4*w4_x + YY4*w4_y + YZ4*w4_z
    b4_4b = XZ4*w4_x + YZ4*w4_y + ZZ4*w4_z
    b4_4 = w4_z*b4_4a - w4_y*b4_4b
    b4_5 = w4_x*b4_4b - w4_z*b4_5a
    b4_6 = w4_y*b4_5a - w4_x*b4_4a

    # Backward recursion: articulated inertias and wrenches, joint 4 (j4) [50]-[56].
    Gamma4 = -k4*th4
    K4_14g = sin_th4*K4_14e + cos_th4*K4_14f
    K4_14h = sin_th4*K4_14g
    K4_14 = K4_14a - K4_14h
    K4_15a = cos_th4*K4_14g
    K4_15 = K4_14c + K4_15a
    K4_24 = K4_15a - K4_14b
    K4_25 = K4_14h - K4_14d
    K4_34 = MY4*cos_th4 + MX4*sin_th4
    K4_35 = MY4*sin_th4 - MX4*cos_th4
    Gb4 = Gamma4 + b4_6
    qdf4 = Hinv4*Gb4
    al4_4a = b4_4 - XZ4*qdf4
    al4_4b = YZ4*qdf4 - b4_5
    al4_3 = g4_4*K4_34 + g4_5*K4_35 - b4_3
    K4_44f = sin_th4*K4_44d + cos_th4*K4_44e
    K4_44g = sin_th4*K4_44f
    K4_44 = K4_44a - K4_44g
    K4_45 = cos_th4*K4_44f - K4_44b
    K4_55 = K4_44c + K4_44g
    al4_4 = g4_4*K4_44 + g4_5*K4_45 - (cos_th4*al4_4a + sin_th4*al4_4b)
    al4_5 = g4_4*K4_45 + g4_5*K4_55 - (sin_th4*al4_4a - cos_th4*al4_4b)

    # Backward recursion: articulated inertias and wrenches, joint 3 (j3) [50]-[56].
    Js3_15 = MZ3 + K4_15
    Js3_24 = K4_24 - MZ3
    Js3_34 = MY3 + K4_34
    Js3_35 = K4_35 - MX3
    bs3_3 = b3_3 - al4_3
    bs3_6 = b3_6 - Gamma4
    K3_15a = sin_th3*(K4_14 - K4_25) + cos_th3*(Js3_15 + Js3_24)
    K3_15 = cos_th3*K3_15a - Js3_24
    K3_25 = K4_25 + sin_th3*K3_15a
    K3_16 = -(MY3*cos_th3 + MX3*sin_th3)
    K3_26 = MX3*cos_th3 - MY3*sin_th3
    K3_34 = cos_th3*Js3_34 - sin_th3*Js3_35
    K3_35 = sin_th3*Js3_34 + cos_th3*Js3_35
    K3_46 = XZ3*cos_th3 - YZ3*sin_th3
    K3_56 = XZ3*sin_th3 + YZ3*cos_th3
    al3_3 = g3_4*K3_34 - bs3_3
    al3_6 = g3_1*K3_16 + g3_4*K3_46 - (bs3_6 - ZZ3*qdd3)
    Js3_44 = XX3 + K4_44
    Js3_45 = XY3 + K4_45
    Js3_55 = YY3 + K4_55
    bs3_4 = b3_4 - al4_4
    bs3_5 = b3_5 - al4_5
    K3_45a = sin_th3*(Js3_44 - Js3_55) + 2.0*cos_th3*Js3_45
    K3_45 = cos_th3*K3_45a - Js3_45
    K3_55 = Js3_55 + sin_th3*K3_45a
    al3_5 = g3_1*K3_15 + g3_4*K3_45 + sin_th3*(XZ3*qdd3 - bs3_4) + cos_th3*(YZ3*qdd3 - bs3_5)

    # Backward recursion: articulated inertias and wrenches, joint 2 (j2) [50]-[56].
    Gamma2 = -k2*th2
    Js2_66 = ZZ2 - (L2*(K3_35 + K3_35 - Js2_66a) - K3_55)
    bs2_6 = L2*al3_3 - al3_5
    Hinv2 = 1.0/Js2_66
    UH2_3 = K3_25*Hinv2
    Gb2 = Gamma2 + bs2_6
    qdf2 = Hinv2*Gb2

    # Backward recursion: articulated inertias and wrenches, joint 1 (j1) [50]-[56].
    f1_6 = Gamma2 + Fb1_6

    # Forward recursion: accelerations and torques, joint 1 (j1) [57]-[61].
    Gamma1 = f1_6 + IA1*qdd1

    # Forward recursion: accelerations and torques, joint 2 (j2) [57]-[61].
    wd2_z = qdf2 + G3*UH2_3
    qdd2 = wd2_z - qdd1

    # Forward recursion: accelerations and torques, joint 3 (j3) [57]-[61].
    vd3_x = cos_th3*g3_1 - G3*sin_th3
    vd3_y = -(sin_th3*g3_1 + G3*cos_th3)
    f3_6 = al3_6 + K3_56*wd2_z - G3*K3_26
    wd3_x = cos_th3*g3_4 + sin_th3*wd2_z
    wd3_y = cos_th3*wd2_z - sin_th3*g3_4
    Gamma3 = IA3*qdd3 + f3_6

    # Forward recursion: accelerations and torques, joint 4 (j4) [57]-[61].
    vd4_x = cos_th4*vd3_x + sin_th4*vd3_y
    vd4_y = cos_th4*vd3_y - sin_th4*vd3_x
    wd4_xa = g4_4 + wd3_x
    wd4_xb = -(g4_5 + wd3_y)
    wd4_x = cos_th4*wd4_xa - sin_th4*wd4_xb
    wd4_y = -(sin_th4*wd4_xa + cos_th4*wd4_xb)
    wd4_z = -(UH4_1*vd4_x + UH4_2*vd4_y - qdf4 + UH4_4*wd4_x + UH4_5*wd4_y)
    qdd4 = wd4_z - qdd3

    # Results.
    return (
        (Gamma1, Gamma3),
        (qdd1, qdd2, qdd3, qdd4),
    )


model = _run.Model(
    constants,
    program,
    arguments=dict(q=4, qd=4, qdd_motor=2),
    parameters=46,
    results=((2,), (4,)),
)
