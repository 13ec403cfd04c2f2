"""Direct dynamic model of rx90 [12]-[36]: 586x 496+, 10 sin/cos a call; 5x 4+, 0 sin/cos once for each parameter set.

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

    # Forward recursion: velocities, joint 6 (j6) [1], [3], [7], [14].
    dJ6_xy = XX6 - YY6
    Js6_44a = 2.0*XY6

    # Backward recursion: articulated inertias and wrenches, joint 6 (j6) [28]-[32].
    H6 = ZZ6 + IA6
    Hinv6 = 1.0/H6
    rho6 = IA6*Hinv6
    UH6_6 = ZZ6*Hinv6
    K6_66 = ZZ6*rho6

    # Backward recursion: articulated inertias and wrenches, joint 5 (j5) [28]-[32].
    Js5_22 = M5 + M6
    Js5_55 = YY5 + K6_66
    return (
        ZZ1, IA1, XX2, XY2, XZ2, YY2, YZ2, ZZ2, MX2, MY2, MZ2, IA2, D3, XX3, XY3, XZ3, YY3, YZ3,
        ZZ3, MX3, MY3, MZ3, M3, IA3, RL4, XX4, XY4, XZ4, YY4, YZ4, ZZ4, MX4, MY4, MZ4, M4, IA4,
        XX5, XY5, XZ5, YY5, YZ5, ZZ5, MX5, MY5, MZ5, M5, IA5, XX6, XY6, XZ6, YY6, YZ6, ZZ6, MX6,
        MY6, MZ6, M6, G3, dJ6_xy, Js6_44a, Hinv6, rho6, UH6_6, Js5_22, Js5_55,
    )


def program(_f, q, qd, tau, c):
    (_, th2, th3, th4, th5, th6) = q
    (qd1, qd2, qd3, qd4, qd5, qd6) = qd
    (tau1, tau2, tau3, tau4, tau5, tau6) = tau
    (
        ZZ1, IA1, XX2, XY2, XZ2, YY2, YZ2, ZZ2, MX2, MY2, MZ2, IA2, D3, XX3, XY3, XZ3, YY3, YZ3,
        ZZ3, MX3, MY3, MZ3, M3, IA3, RL4, XX4, XY4, XZ4, YY4, YZ4, ZZ4, MX4, MY4, MZ4, M4, IA4,
        XX5, XY5, XZ5, YY5, YZ5, ZZ5, MX5, MY5, MZ5, M5, IA5, XX6, XY6, XZ6, YY6, YZ6, ZZ6, MX6,
        MY6, MZ6, M6, G3, dJ6_xy, Js6_44a, Hinv6, rho6, UH6_6, Js5_22, Js5_55,
    ) = c

    # Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14].
    sin_th2 = _f.sin(th2)
    cos_th2 = _f.cos(th2)
    w2_x = qd1*sin_th2
    w2_y = qd1*cos_th2
    g2_4 = qd1*qd2
    Vk2_1 = -G3*sin_th2
    Vk2_2 = -G3*cos_th2
    b2_5a = XX2*w2_x + XY2*w2_y + XZ2*qd2
    b2_4a = XY2*w2_x + YY2*w2_y + YZ2*qd2
    b2_4b = XZ2*w2_x + YZ2*w2_y + ZZ2*qd2
    b2_4 = MZ2*Vk2_2 - (w2_y*b2_4b - qd2*b2_4a)
    b2_5 = -(qd2*b2_5a - w2_x*b2_4b + MZ2*Vk2_1)
    b2_6 = -(w2_x*b2_4a - w2_y*b2_5a + MX2*Vk2_2 - MY2*Vk2_1)

    # Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14].
    sin_th3 = _f.sin(th3)
    cos_th3 = _f.cos(th3)
    w3_x = cos_th3*w2_x + sin_th3*w2_y
    w3_y = cos_th3*w2_y - sin_th3*w2_x
    w3_z = qd2 + qd3
    Vk3_3a = D3*qd2
    Vk3_1a = D3*w2_y
    Vk3_3 = w2_x*Vk3_3a
    g3_4 = qd3*w2_y
    g3_5 = -qd3*w2_x
    Vk3_1b = w2_y*Vk3_1a + qd2*Vk3_3a - Vk2_1
    Vk3_1c = w2_x*Vk3_1a + Vk2_2
    Vk3_1 = sin_th3*Vk3_1c - cos_th3*Vk3_1b
    Vk3_2 = sin_th3*Vk3_1b + cos_th3*Vk3_1c
    b3_2a = MY3*w3_z - MZ3*w3_y
    b3_1a = MX3*w3_z - MZ3*w3_x
    b3_1b = MY3*w3_x - MX3*w3_y
    b3_5a = XX3*w3_x + XY3*w3_y + XZ3*w3_z
    b3_4a = XY3*w3_x + YY3*w3_y + YZ3*w3_z
    b3_4b = XZ3*w3_x + YZ3*w3_y + ZZ3*w3_z
    b3_1 = w3_z*b3_1a - w3_y*b3_1b - M3*Vk3_1
    b3_2 = w3_z*b3_2a + w3_x*b3_1b - M3*Vk3_2
    b3_3 = -(w3_x*b3_1a + w3_y*b3_2a + M3*Vk3_3)
    b3_4 = w3_z*b3_4a - w3_y*b3_4b + MZ3*Vk3_2 - MY3*Vk3_3
    b3_5 = MX3*Vk3_3 - MZ3*Vk3_1 - (w3_z*b3_5a - w3_x*b3_4b)
    b3_6 = -(w3_x*b3_4a - w3_y*b3_5a + MX3*Vk3_2 - MY3*Vk3_1)

    # Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14].
    sin_th4 = _f.sin(th4)
    cos_th4 = _f.cos(th4)
    w4_x = cos_th4*w3_x - sin_th4*w3_z
    w4_y = -(sin_th4*w3_x + cos_th4*w3_z)
    w4_z = qd4 + w3_y
    g4_2a = RL4*w3_z
    g4_1a = RL4*w3_x
    g4_4 = -qd4*w3_z
    g4_5 = -qd4*w3_x
    g4_1 = w3_y*g4_1a + Vk3_1
    g4_2 = -(Vk3_3 + w3_y*g4_2a)
    g4_3 = Vk3_2 - (w3_x*g4_1a + w3_z*g4_2a)
    b4_2a = MY4*w4_z - MZ4*w4_y
    b4_1a = MX4*w4_z - MZ4*w4_x
    b4_1b = MY4*w4_x - MX4*w4_y
    b4_1 = w4_z*b4_1a - w4_y*b4_1b
    b4_2 = w4_z*b4_2a + w4_x*b4_1b
    b4_3 = -(w4_x*b4_1a + w4_y*b4_2a)
    b4_5a = XX4*w4_x + XY4*w4_y + XZ4*w4_z
    b4_4a = XY4*w4_x + YY4*w4_y + YZ4*w4_z
    b4_4b = XZ4*w4_x + YZ4*w4_y + ZZ4*w4_z
    b4_4 = w4_z*b4_4a - w4_y*b4_4b
    b4_5 = w4_x*b4_4b - w4_z*b4_5a
    b4_6 = w4_y*b4_5a - w4_x*b4_4a

    # Forward recursion: velocities, joint 5 (j5) [1], [3], [7], [14].
    sin_th5 = _f.sin(th5)
    cos_th5 = _f.cos(th5)
    w5_x = cos_th5*w4_x + sin_th5*w4_z
    w5_y = cos_th5*w4_z - sin_th5*w4_x
    w5_z = qd5 - w4_y
    g5_4 = qd5*w4_z
    g5_5 = -qd5*w4_x
    b5_2a = MY5*w5_z - MZ5*w5_y
    b5_1a = MX5*w5_z - MZ5*w5_x
    b5_1b = MY5*w5_x - MX5*w5_y
    b5_1 = w5_z*b5_1a - w5_y*b5_1b
    b5_2 = w5_z*b5_2a + w5_x*b5_1b
    b5_3 = -(w5_x*b5_1a + w5_y*b5_2a)
    b5_5a = XX5*w5_x + XY5*w5_y + XZ5*w5_z
    b5_4a = XY5*w5_x + YY5*w5_y + YZ5*w5_z
    b5_4b = XZ5*w5_x + YZ5*w5_y + ZZ5*w5_z
    b5_4 = w5_z*b5_4a - w5_y*b5_4b
    b5_5 = w5_x*b5_4b - w5_z*b5_5a
    b5_6 = w5_y*b5_5a - w5_x*b5_4a

    # Forward recursion: velocities, joint 6 (j6) [1], [3], [7], [14].
    sin_th6 = _f.sin(th6)
    cos_th6 = _f.cos(th6)
    Js6_26 = MX6*cos_th6 - MY6*sin_th6
    Js6_16 = -(MX6*sin_th6 + MY6*cos_th6)
    Js6_46 = XZ6*cos_th6 - YZ6*sin_th6
    Js6_56 = XZ6*sin_th6 + YZ6*cos_th6
    w6_z = qd6 + w5_y
    b6_2a = qd6*w5_z
    b6_1a = qd6*w5_x
    b6_2b = MZ6*w5_z - Js6_16*w6_z
    b6_1b = Js6_26*w6_z - MZ6*w5_x
    b6_1c = Js6_26*w5_z - Js6_16*w5_x
    b6_4a = Js6_46*w5_x - Js6_56*w5_z + ZZ6*w6_z
    b6_1 = w5_z*b6_1c + w6_z*b6_1b + MZ6*b6_1a
    b6_2 = w6_z*b6_2b + w5_x*b6_1c - MZ6*b6_2a
    b6_3 = -(w5_x*b6_1b - w5_z*b6_2b + Js6_16*b6_2a + Js6_26*b6_1a)
    Js6_44b = sin_th6*dJ6_xy + cos_th6*Js6_44a
    Js6_44c = sin_th6*Js6_44b
    Js6_44 = XX6 - Js6_44c
    Js6_45 = cos_th6*Js6_44b - XY6
    Js6_55 = YY6 + Js6_44c
    b6_5a = Js6_46*w6_z + w5_x*Js6_44 - w5_z*Js6_45
    b6_4b = Js6_56*w6_z - (w5_z*Js6_55 - w5_x*Js6_45)
    b6_4 = w5_z*b6_4a + w6_z*b6_4b + b6_2a*Js6_44 + b6_1a*Js6_45
    b6_5 = w5_x*b6_4a - w6_z*b6_5a + b6_2a*Js6_45 + b6_1a*Js6_55
    b6_6 = Js6_46*b6_2a + Js6_56*b6_1a - (w5_x*b6_4b + w5_z*b6_5a)

    # Backward recursion: articulated inertias and wrenches, joint 6 (j6) [28]-[32].
    UH6_1 = Js6_16*Hinv6
    UH6_2 = Js6_26*Hinv6
    UH6_4 = Js6_46*Hinv6
    UH6_5 = Js6_56*Hinv6
    K6_16 = Js6_16*rho6
    K6_26 = Js6_26*rho6
    K6_46 = Js6_46*rho6
    K6_56 = Js6_56*rho6
    K6_14 = -Js6_16*UH6_4
    K6_11 = M6 - Js6_16*UH6_1
    K6_15 = MZ6 - Js6_16*UH6_5
    K6_12 = -Js6_16*UH6_2
    K6_24 = -(MZ6 + Js6_26*UH6_4)
    K6_25 = -Js6_26*UH6_5
    K6_22 = M6 - Js6_26*UH6_2
    K6_44 = Js6_44 - Js6_46*UH6_4
    K6_45 = Js6_45 - Js6_46*UH6_5
    K6_55 = Js6_55 - Js6_56*UH6_5
    Gb6 = tau6 + b6_6
    qdf6 = Hinv6*Gb6
    al6_1 = Js6_16*qdf6 - b6_1
    al6_2 = Js6_26*qdf6 - b6_2
    al6_4 = Js6_46*qdf6 - b6_4
    al6_5 = Js6_56*qdf6 - b6_5
    al6_6 = tau6*UH6_6 - rho6*b6_6

    # Backward recursion: articulated inertias and wrenches, joint 5 (j5) [28]-[32].
    Js5_11 = M5 + K6_11
    Js5_33 = M5 + K6_22
    Js5_15 = MZ5 + K6_16
    Js5_16 = -(MY5 + K6_15)
    Js5_24 = -(MZ5 + Js6_16)
    Js5_26 = MX5 + Js6_26
    Js5_34 = MY5 - K6_24
    Js5_35 = -(MX5 + K6_26)
    Js5_45 = XY5 + K6_46
    Js5_56 = YZ5 - K6_56
    bs5_2 = b5_2 + b6_3
    K5_11a = 2.0*cos_th5
    Js5_44 = XX5 + K6_44
    Js5_46 = XZ5 - K6_45
    Js5_66 = ZZ5 + K6_55
    bs5_1 = b5_1 - al6_1
    bs5_3 = b5_3 + al6_2
    bs5_4 = b5_4 - al6_4
    bs5_5 = b5_5 - al6_6
    bs5_6 = b5_6 + al6_5
    H5 = IA5 + Js5_66
    Hinv5 = 1.0/H5
    rho5 = IA5*Hinv5
    UH5_6 = Js5_66*Hinv5
    UH5_1 = Js5_16*Hinv5
    UH5_2 = Js5_26*Hinv5
    UH5_3 = K6_25*Hinv5
    UH5_4 = Js5_46*Hinv5
    UH5_5 = Js5_56*Hinv5
    K5_16a = -Js5_16*rho5
    K5_16b = Js5_26*rho5
    K5_36 = K6_25*rho5
    K5_46a = Js5_46*rho5
    K5_46b = Js5_56*rho5
    K5_66 = Js5_66*rho5
    K5_14a = K6_14 - Js5_16*UH5_4
    K5_11b = Js5_11 - Js5_16*UH5_1
    K5_44a = Js5_44 - Js5_46*UH5_4
    K5_14b = Js5_15 - Js5_16*UH5_5
    K5_11c = -Js5_16*UH5_2
    K5_44b = Js5_45 - Js5_46*UH5_5
    K5_13a = K6_12 + Js5_16*UH5_3
    K5_14c = Js5_26*UH5_4 - Js5_24
    K5_14d = Js5_26*UH5_5
    K5_11d = Js5_22 - Js5_26*UH5_2
    K5_44c = Js5_55 - Js5_56*UH5_5
    K5_13b = -Js5_26*UH5_3
    K5_34a = Js5_34 - K6_25*UH5_4
    K5_34b = K6_25*UH5_5 - Js5_35
    K5_33 = Js5_33 - K6_25*UH5_3
    K5_11e = sin_th5*(K5_11b - K5_11d) + K5_11a*K5_11c
    K5_11f = sin_th5*K5_11e
    K5_11 = K5_11b - K5_11f
    K5_12 = cos_th5*K5_11e - K5_11c
    K5_22 = K5_11d + K5_11f
    K5_13 = -(cos_th5*K5_13a + sin_th5*K5_13b)
    K5_23 = cos_th5*K5_13b - sin_th5*K5_13a
    K5_14e = sin_th5*(K5_14a + K5_14d) + cos_th5*(K5_14b - K5_14c)
    K5_14f = sin_th5*K5_14e
    K5_14 = K5_14a - K5_14f
    K5_15a = cos_th5*K5_14e
    K5_15 = K5_14c + K5_15a
    K5_24 = K5_15a - K5_14b
    K5_25 = K5_14f - K5_14d
    K5_16 = -(cos_th5*K5_16a + sin_th5*K5_16b)
    K5_26 = cos_th5*K5_16b - sin_th5*K5_16a
    K5_34 = cos_th5*K5_34a + sin_th5*K5_34b
    K5_35 = sin_th5*K5_34a - cos_th5*K5_34b
    K5_44d = sin_th5*(K5_44a - K5_44c) + K5_11a*K5_44b
    K5_44e = sin_th5*K5_44d
    K5_44 = K5_44a - K5_44e
    K5_45 = cos_th5*K5_44d - K5_44b
    K5_55 = K5_44c + K5_44e
    K5_46 = cos_th5*K5_46a - sin_th5*K5_46b
    K5_56 = sin_th5*K5_46a + cos_th5*K5_46b
    Gb5 = tau5 + bs5_6
    qdf5 = Hinv5*Gb5
    al5_1a = bs5_1 - Js5_16*qdf5
    al5_1b = bs5_2 - Js5_26*qdf5
    al5_4a = bs5_4 - Js5_46*qdf5
    al5_4b = Js5_56*qdf5 - bs5_5
    al5_1 = g5_4*K5_14 + g5_5*K5_15 - (cos_th5*al5_1a - sin_th5*al5_1b)
    al5_2 = g5_4*K5_24 + g5_5*K5_25 - (sin_th5*al5_1a + cos_th5*al5_1b)
    al5_3 = g5_4*K5_34 + g5_5*K5_35 + K6_25*qdf5 - bs5_3
    al5_4 = g5_4*K5_44 + g5_5*K5_45 - (cos_th5*al5_4a + sin_th5*al5_4b)
    al5_5 = g5_4*K5_45 + g5_5*K5_55 - (sin_th5*al5_4a - cos_th5*al5_4b)
    al5_6 = g5_4*K5_46 + g5_5*K5_56 + tau5*UH5_6 - bs5_6*rho5

    # Backward recursion: articulated inertias and wrenches, joint 4 (j4) [28]-[32].
    K4_11a = 2.0*cos_th4
    Js4_11 = M4 + K5_11
    Js4_22 = M4 + K5_33
    Js4_33 = M4 + K5_22
    Js4_15 = MZ4 - K5_16
    Js4_16 = K5_15 - MY4
    Js4_24 = -(MZ4 + K5_34)
    Js4_26 = MX4 - K5_35
    Js4_34 = MY4 + K5_24
    Js4_35 = -(MX4 + K5_26)
    Js4_44 = XX4 + K5_44
    Js4_45 = XY4 - K5_46
    Js4_46 = XZ4 + K5_45
    Js4_55 = YY4 + K5_66
    Js4_56 = YZ4 - K5_56
    Js4_66 = ZZ4 + K5_55
    bs4_1 = b4_1 - al5_1
    bs4_2 = b4_2 + al5_3
    bs4_3 = b4_3 - al5_2
    bs4_4 = b4_4 - al5_4
    bs4_5 = b4_5 + al5_6
    bs4_6 = b4_6 - al5_5
    H4 = IA4 + Js4_66
    Hinv4 = 1.0/H4
    rho4 = IA4*Hinv4
    UH4_6 = Js4_66*Hinv4
    UH4_1 = Js4_16*Hinv4
    UH4_2 = Js4_26*Hinv4
    UH4_3 = K5_25*Hinv4
    UH4_4 = Js4_46*Hinv4
    UH4_5 = Js4_56*Hinv4
    K4_16a = -Js4_16*rho4
    K4_16b = Js4_26*rho4
    K4_36 = K5_25*rho4
    K4_46a = Js4_46*rho4
    K4_46b = Js4_56*rho4
    K4_66 = Js4_66*rho4
    K4_14a = K5_14 - Js4_16*UH4_4
    K4_11b = Js4_11 - Js4_16*UH4_1
    K4_44a = Js4_44 - Js4_46*UH4_4
    K4_14b = Js4_15 - Js4_16*UH4_5
    K4_11c = -(K5_13 + Js4_16*UH4_2)
    K4_44b = Js4_45 - Js4_46*UH4_5
    K4_13a = Js4_16*UH4_3 - K5_12
    K4_14c = Js4_26*UH4_4 - Js4_24
    K4_14d = Js4_26*UH4_5 - K5_36
    K4_11d = Js4_22 - Js4_26*UH4_2
    K4_44c = Js4_55 - Js4_56*UH4_5
    K4_13b = -(K5_23 + Js4_26*UH4_3)
    K4_34a = Js4_34 - K5_25*UH4_4
    K4_34b = K5_25*UH4_5 - Js4_35
    K4_33 = Js4_33 - K5_25*UH4_3
    K4_11e = sin_th4*(K4_11b - K4_11d) + K4_11a*K4_11c
    K4_11f = sin_th4*K4_11e
    K4_11 = K4_11b - K4_11f
    K4_12 = cos_th4*K4_11e - K4_11c
    K4_22 = K4_11d + K4_11f
    K4_13 = -(cos_th4*K4_13a + sin_th4*K4_13b)
    K4_23 = cos_th4*K4_13b - sin_th4*K4_13a
    K4_14e = sin_th4*(K4_14a + K4_14d) + cos_th4*(K4_14b - K4_14c)
    K4_14f = sin_th4*K4_14e
    K4_14 = K4_14a - K4_14f
    K4_15a = cos_th4*K4_14e
    K4_15 = K4_14c + K4_15a
    K4_24 = K4_15a - K4_14b
    K4_25 = K4_14f - K4_14d
    K4_16 = -(cos_th4*K4_16a + sin_th4*K4_16b)
    K4_26 = cos_th4*K4_16b - sin_th4*K4_16a
    K4_34 = cos_th4*K4_34a + sin_th4*K4_34b
    K4_35 = sin_th4*K4_34a - cos_th4*K4_34b
    K4_44d = sin_th4*(K4_44a - K4_44c) + K4_11a*K4_44b
    K4_44e = sin_th4*K4_44d
    K4_44 = K4_44a - K4_44e
    K4_45 = cos_th4*K4_44d - K4_44b
    K4_55 = K4_44c + K4_44e
    K4_46 = cos_th4*K4_46a - sin_th4*K4_46b
    K4_56 = sin_th4*K4_46a + cos_th4*K4_46b
    Gb4 = tau4 + bs4_6
    qdf4 = Hinv4*Gb4
    al4_1a = bs4_1 - Js4_16*qdf4
    al4_1b = bs4_2 - Js4_26*qdf4
    al4_4a = bs4_4 - Js4_46*qdf4
    al4_4b = Js4_56*qdf4 - bs4_5
    al4_1 = g4_1*K4_11 + g4_2*K4_12 + g4_3*K4_13 + g4_4*K4_14 + g4_5*K4_15 - (cos_th4*al4_1a - sin_th4*al4_1b)
    al4_2 = g4_1*K4_12 + g4_2*K4_22 + g4_3*K4_23 + g4_4*K4_24 + g4_5*K4_25 - (sin_th4*al4_1a + cos_th4*al4_1b)
    al4_3 = g4_1*K4_13 + g4_2*K4_23 + g4_3*K4_33 + g4_4*K4_34 + g4_5*K4_35 + K5_25*qdf4 - bs4_3
    al4_4 = g4_1*K4_14 + g4_2*K4_24 + g4_3*K4_34 + g4_4*K4_44 + g4_5*K4_45 - (cos_th4*al4_4a + sin_th4*al4_4b)
    al4_5 = g4_1*K4_15 + g4_2*K4_25 + g4_3*K4_35 + g4_4*K4_45 + g4_5*K4_55 - (sin_th4*al4_4a - cos_th4*al4_4b)
    al4_6 = g4_1*K4_16 + g4_2*K4_26 + g4_3*K4_36 + g4_4*K4_46 + g4_5*K4_56 + tau4*UH4_6 - bs4_6*rho4

    # Backward recursion: articulated inertias and wrenches, joint 3 (j3) [28]-[32].
    K3_22a = 2.0*cos_th3
    Js3_14a = -RL4*K4_12
    Js3_14 = K4_14 + Js3_14a
    Js3_16a = K4_15 + RL4*K4_11
    Js3_34a = RL4*K4_22 - K4_24
    Js3_36 = K4_25 - Js3_14a
    Js3_11 = M3 + K4_11
    Js3_22 = M3 + K4_33
    Js3_33 = M3 + K4_22
    Js3_15 = MZ3 + K4_16
    Js3_16 = -(MY3 + Js3_16a)
    Js3_24 = K4_34 - RL4*K4_23 - MZ3
    Js3_26 = MX3 - (K4_35 + RL4*K4_13)
    Js3_34 = MY3 + Js3_34a
    Js3_35 = -(MX3 + K4_26)
    Js3_44 = XX3 + K4_44 + RL4*(Js3_34a - K4_24)
    Js3_45 = XY3 + K4_46 - RL4*K4_26
    Js3_46 = XZ3 - (K4_45 + RL4*(K4_14 - Js3_36))
    Js3_55 = YY3 + K4_66
    Js3_56 = YZ3 - (K4_56 + RL4*K4_16)
    Js3_66 = ZZ3 + K4_55 + RL4*(K4_15 + Js3_16a)
    bs3_1 = b3_1 - al4_1
    bs3_2 = b3_2 - al4_3
    bs3_3 = b3_3 + al4_2
    bs3_4 = b3_4 + RL4*al4_2 - al4_4
    bs3_5 = b3_5 - al4_6
    bs3_6 = b3_6 + al4_5 + RL4*al4_1
    H3 = IA3 + Js3_66
    Hinv3 = 1.0/H3
    rho3 = IA3*Hinv3
    UH3_6 = Js3_66*Hinv3
    UH3_1 = Js3_16*Hinv3
    UH3_2 = Js3_26*Hinv3
    UH3_3 = Js3_36*Hinv3
    UH3_4 = Js3_46*Hinv3
    UH3_5 = Js3_56*Hinv3
    K3_36 = Js3_36*rho3
    K3_46a = Js3_46*rho3
    K3_46b = Js3_56*rho3
    K3_66 = Js3_66*rho3
    K3_44a = Js3_44 - Js3_46*UH3_4
    K3_24a = Js3_15 - Js3_16*UH3_5
    K3_44b = Js3_45 - Js3_46*UH3_5
    K3_24b = Js3_26*UH3_5 - K4_36
    K3_22b = Js3_22 - Js3_26*UH3_2
    K3_44c = Js3_55 - Js3_56*UH3_5
    K3_34a = Js3_34 - Js3_36*UH3_4
    K3_34b = Js3_36*UH3_5 - Js3_35
    K3_33 = Js3_33 - Js3_36*UH3_3
    K3_22 = K3_22b + sin_th3*(sin_th3*(Js3_11 - Js3_16*UH3_1 - K3_22b) - K3_22a*(Js3_16*UH3_2 - K4_13))
    K3_23 = -(sin_th3*(K4_12 + Js3_16*UH3_3) + cos_th3*(K4_23 + Js3_26*UH3_3))
    K3_24c = sin_th3*(Js3_14 - Js3_16*UH3_4 + K3_24b) + cos_th3*(K3_24a - (Js3_26*UH3_4 - Js3_24))
    K3_24 = cos_th3*K3_24c - K3_24a
    K3_25 = sin_th3*K3_24c - K3_24b
    K3_26 = sin_th3*(Js3_16*rho3) + cos_th3*(Js3_26*rho3)
    K3_34 = cos_th3*K3_34a + sin_th3*K3_34b
    K3_35 = sin_th3*K3_34a - cos_th3*K3_34b
    K3_44d = sin_th3*(K3_44a - K3_44c) + K3_22a*K3_44b
    K3_44e = sin_th3*K3_44d
    K3_44 = K3_44a - K3_44e
    K3_45 = cos_th3*K3_44d - K3_44b
    K3_55 = K3_44c + K3_44e
    K3_46 = cos_th3*K3_46a - sin_th3*K3_46b
    K3_56 = sin_th3*K3_46a + cos_th3*K3_46b
    Gb3 = tau3 + bs3_6
    qdf3 = Hinv3*Gb3
    al3_4a = bs3_4 - Js3_46*qdf3
    al3_4b = Js3_56*qdf3 - bs3_5
    al3_2 = g3_4*K3_24 + g3_5*K3_25 - (sin_th3*(bs3_1 - Js3_16*qdf3) + cos_th3*(bs3_2 - Js3_26*qdf3))
    al3_3 = g3_4*K3_34 + g3_5*K3_35 + Js3_36*qdf3 - bs3_3
    al3_4 = g3_4*K3_44 + g3_5*K3_45 - (cos_th3*al3_4a + sin_th3*al3_4b)
    al3_5 = g3_4*K3_45 + g3_5*K3_55 - (sin_th3*al3_4a - cos_th3*al3_4b)
    al3_6 = g3_4*K3_46 + g3_5*K3_56 + tau3*UH3_6 - bs3_6*rho3

    # Backward recursion: articulated inertias and wrenches, joint 2 (j2) [28]-[32].
    Js2_36 = K3_36 + D3*K3_23
    Js2_44 = XX2 + K3_44
    Js2_45 = XY2 - (D3*K3_34 - K3_45)
    Js2_46 = XZ2 + K3_46 + D3*K3_24
    Js2_55 = YY2 + K3_55 - D3*(K3_35 + K3_35 - D3*K3_33)
    Js2_56 = YZ2 + K3_56 - D3*(Js2_36 - K3_25)
    Js2_66 = ZZ2 + K3_66 + D3*(K3_26 + K3_26 + D3*K3_22)
    bs2_4 = b2_4 - al3_4
    bs2_5 = b2_5 + D3*al3_3 - al3_5
    bs2_6 = b2_6 - (al3_6 + D3*al3_2)
    H2 = IA2 + Js2_66
    Hinv2 = 1.0/H2
    UH2_4 = Js2_46*Hinv2
    UH2_5 = Js2_56*Hinv2
    K2_45a = Js2_45 - Js2_46*UH2_5
    K2_45b = Js2_55 - Js2_56*UH2_5
    K2_45c = sin_th2*(Js2_44 - Js2_46*UH2_4 - K2_45b) + 2.0*cos_th2*K2_45a
    K2_45 = cos_th2*K2_45c - K2_45a
    K2_55 = K2_45b + sin_th2*K2_45c
    Gb2 = tau2 + bs2_6
    qdf2 = Hinv2*Gb2
    al2_5 = g2_4*K2_45 + sin_th2*(Js2_46*qdf2 - bs2_4) + cos_th2*(Js2_56*qdf2 - bs2_5)

    # Backward recursion: articulated inertias and wrenches, joint 1 (j1) [28]-[32].
    Js1_66 = ZZ1 + K2_55
    H1 = IA1 + Js1_66
    Gb1 = tau1 - al2_5
    qdf1 = Gb1/H1

    # Forward recursion: accelerations and torques, joint 2 (j2) [33]-[36].
    wd2_x = cos_th2*g2_4 + sin_th2*qdf1
    wd2_y = cos_th2*qdf1 - sin_th2*g2_4
    qdd2 = qdf2 - (UH2_4*wd2_x + UH2_5*wd2_y)

    # Forward recursion: accelerations and torques, joint 3 (j3) [33]-[36].
    Vr3_1a = D3*qdd2
    Vr3_3 = -D3*wd2_y
    wd3_xa = g3_4 + wd2_x
    wd3_xb = -(g3_5 + wd2_y)
    Vr3_1 = sin_th3*Vr3_1a
    Vr3_2 = cos_th3*Vr3_1a
    wd3_x = cos_th3*wd3_xa - sin_th3*wd3_xb
    wd3_y = -(sin_th3*wd3_xa + cos_th3*wd3_xb)
    qdd3 = qdf3 - (UH3_1*Vr3_1 + UH3_2*Vr3_2 + UH3_3*Vr3_3) - (UH3_4*wd3_x + UH3_5*wd3_y) - UH3_6*qdd2
    wd3_z = qdd2 + qdd3

    # Forward recursion: accelerations and torques, joint 4 (j4) [33]-[36].
    vd4_xa = -(g4_1 + Vr3_1 - RL4*wd3_z)
    vd4_xb = Vr3_3 + RL4*wd3_x - g4_2
    vd4_z = g4_3 + Vr3_2
    wd4_xa = -(g4_4 + wd3_x)
    wd4_xb = wd3_z - g4_5
    vd4_x = -(cos_th4*vd4_xa + sin_th4*vd4_xb)
    vd4_y = sin_th4*vd4_xa - cos_th4*vd4_xb
    wd4_x = -(cos_th4*wd4_xa + sin_th4*wd4_xb)
    wd4_y = sin_th4*wd4_xa - cos_th4*wd4_xb
    qdd4 = qdf4 - (UH4_1*vd4_x + UH4_2*vd4_y + UH4_3*vd4_z) - (UH4_4*wd4_x + UH4_5*wd4_y) - UH4_6*wd3_y
    wd4_z = wd3_y + qdd4

    # Forward recursion: accelerations and torques, joint 5 (j5) [33]-[36].
    wd5_xa = g5_4 + wd4_x
    wd5_xb = -(g5_5 + wd4_z)
    vd5_x = cos_th5*vd4_x + sin_th5*vd4_z
    vd5_y = cos_th5*vd4_z - sin_th5*vd4_x
    wd5_x = cos_th5*wd5_xa - sin_th5*wd5_xb
    wd5_y = -(sin_th5*wd5_xa + cos_th5*wd5_xb)
    qdd5 = qdf5 - (UH5_1*vd5_x + UH5_2*vd5_y - UH5_3*vd4_y) - (UH5_4*wd5_x + UH5_5*wd5_y) + UH5_6*wd4_y
    wd5_z = qdd5 - wd4_y

    # Forward recursion: accelerations and torques, joint 6 (j6) [33]-[36].
    qdd6 = qdf6 - (UH6_1*vd5_x + UH6_2*vd4_y) - (UH6_4*wd5_x - UH6_5*wd5_z) - UH6_6*wd5_y

    # Results.
    return (
        (qdf1, qdd2, qdd3, qdd4, qdd5, qdd6),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=6, qd=6, tau=6),
    parameters=69,
    results=((6,),),
)
