"""Direct dynamic model of flex4 [12]-[36]: 119x 97+, 4 sin/cos a call; 9x 4+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 738153786  # of the files of this package: those of another run are not imported


def constants(_f, p):
    (
        _, _, _, _, _, ZZ1, _, _, _, _, IA1, _, _, _, _, _, ZZ2, _, _, _, _, k2, L2, XX3, XY3, XZ3,
        YY3, YZ3, ZZ3, MX3, MY3, MZ3, M3, IA3, XX4, XY4, XZ4, YY4, YZ4, ZZ4, MX4, MY4, MZ4, M4, k4,
        G3,
    ) = p

    # Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14].
    dJ4_xy = XX4 - YY4
    Js4_44a = 2.0*XY4

    # Backward recursion: articulated inertias and wrenches, joint 4 (j4) [28]-[32].
    Hinv4 = 1.0/ZZ4

    # Backward recursion: articulated inertias and wrenches, joint 3 (j3) [28]-[32].
    Js3_33 = M3 + M4
    H3 = ZZ3 + IA3
    Hinv3 = 1.0/H3
    UH3_4 = XZ3*Hinv3
    UH3_5 = YZ3*Hinv3
    K3_45a = XZ3*UH3_4
    K3_45b = XZ3*UH3_5
    K3_45c = YZ3*UH3_5

    # Backward recursion: articulated inertias and wrenches, joint 2 (j2) [28]-[32].
    Js2_66a = L2*Js3_33

    # Backward recursion: articulated inertias and wrenches, joint 1 (j1) [28]-[32].
    H1 = ZZ1 + IA1
    return (
        ZZ2, k2, L2, XX3, XY3, XZ3, YY3, YZ3, ZZ3, MX3, MY3, MZ3, XX4, XY4, XZ4, YY4, YZ4, ZZ4,
        MX4, MY4, MZ4, k4, G3, dJ4_xy, Js4_44a, Hinv4, Hinv3, UH3_4, UH3_5, K3_45a, K3_45b, K3_45c,
        Js2_66a, H1,
    )


def program(_f, q, qd, tau, c):
    (_, th2, th3, th4) = q
    (qd1, qd2, qd3, qd4) = qd
    (tau1, tau3) = tau
    (
        ZZ2, k2, L2, XX3, XY3, XZ3, YY3, YZ3, ZZ3, MX3, MY3, MZ3, XX4, XY4, XZ4, YY4, YZ4, ZZ4,
        MX4, MY4, MZ4, k4, G3, dJ4_xy, Js4_44a, Hinv4, Hinv3, UH3_4, UH3_5, K3_45a, K3_45b, K3_45c,
        Js2_66a, H1,
    ) = c

    # Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14].
    w2_z = qd1 + qd2

    # Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14].
    sin_th3 = _f.sin(th3)
    cos_th3 = _f.cos(th3)
    w3_x = sin_th3*w2_z
    w3_y = cos_th3*w2_z
    Vk3_1a = w2_z*(L2*w2_z)
    g3_4 = qd3*w2_z
    Vk3_1 = -(cos_th3*Vk3_1a + G3*sin_th3)
    Vk3_2 = sin_th3*Vk3_1a - G3*cos_th3
    b3_3 = w3_y*(MZ3*w3_y - MY3*qd3) - w3_x*(MX3*qd3 - MZ3*w3_x)
    b3_5a = XX3*w3_x + XY3*w3_y + XZ3*qd3
    b3_4a = XY3*w3_x + YY3*w3_y + YZ3*qd3
    b3_4b = XZ3*w3_x + YZ3*w3_y + ZZ3*qd3
    b3_4 = MZ3*Vk3_2 - (w3_y*b3_4b - qd3*b3_4a)
    b3_5 = -(qd3*b3_5a - w3_x*b3_4b + MZ3*Vk3_1)
    b3_6 = -(w3_x*b3_4a - w3_y*b3_5a + MX3*Vk3_2 - MY3*Vk3_1)

    # Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14].
    sin_th4 = _f.sin(th4)
    cos_th4 = _f.cos(th4)
    Js4_26 = MX4*cos_th4 - MY4*sin_th4
    Js4_16 = -(MX4*sin_th4 + MY4*cos_th4)
    Js4_46 = XZ4*cos_th4 - YZ4*sin_th4
    Js4_56 = XZ4*sin_th4 + YZ4*cos_th4
    w4_z = qd3 + qd4
    b4_3a = qd4*w3_y
    b4_3b = qd4*w3_x
    b4_4a = Js4_46*w3_x + Js4_56*w3_y + ZZ4*w4_z
    b4_3 = -(w3_x*(Js4_26*w4_z - MZ4*w3_x) - w3_y*(MZ4*w3_y + Js4_16*w4_z) + Js4_26*b4_3b - Js4_16*b4_3a)
    Js4_44b = sin_th4*dJ4_xy + cos_th4*Js4_44a
    Js4_44c = sin_th4*Js4_44b
    Js4_44 = XX4 - Js4_44c
    Js4_45 = cos_th4*Js4_44b - XY4
    Js4_55 = YY4 + Js4_44c
    b4_5a = Js4_46*w4_z + w3_x*Js4_44 + w3_y*Js4_45
    b4_4b = Js4_56*w4_z + w3_x*Js4_45 + w3_y*Js4_55
    b4_4 = MZ4*Vk3_2 - (b4_3a*Js4_44 - b4_3b*Js4_45) - (w3_y*b4_4a - w4_z*b4_4b)
    b4_5 = w3_x*b4_4a - w4_z*b4_5a + b4_3b*Js4_55 - b4_3a*Js4_45 - MZ4*Vk3_1
    b4_6 = -(Js4_16*Vk3_1 + Js4_26*Vk3_2 + Js4_46*b4_3a - Js4_56*b4_3b + w3_x*b4_4b - w3_y*b4_5a)

    # Backward recursion: articulated inertias and wrenches, joint 4 (j4) [28]-[32].
    Gamma4 = -k4*th4
    UH4_4 = Js4_46*Hinv4
    UH4_5 = Js4_56*Hinv4
    K4_44 = Js4_44 - Js4_46*UH4_4
    K4_45 = Js4_45 - Js4_46*UH4_5
    K4_55 = Js4_55 - Js4_56*UH4_5
    Gb4 = Gamma4 + b4_6
    qdf4 = Hinv4*Gb4
    al4_4 = Js4_46*qdf4 - b4_4
    al4_5 = Js4_56*qdf4 - b4_5

    # Backward recursion: articulated inertias and wrenches, joint 3 (j3) [28]-[32].
    Js3_34 = MY3 - Js4_16
    Js3_35 = -(MX3 + Js4_26)
    bs3_3 = b3_3 + b4_3
    bs3_6 = b3_6 - Gamma4
    K3_34 = cos_th3*Js3_34 - sin_th3*Js3_35
    K3_35 = sin_th3*Js3_34 + cos_th3*Js3_35
    Gb3 = tau3 + bs3_6
    qdf3 = Hinv3*Gb3
    al3_3 = g3_4*K3_34 - bs3_3
    Js3_44 = XX3 + K4_44
    Js3_45 = XY3 + K4_45
    Js3_55 = YY3 + K4_55
    bs3_4 = b3_4 - al4_4
    bs3_5 = b3_5 - al4_5
    K3_45d = K3_45b - Js3_45
    K3_45e = K3_45c - Js3_55
    K3_45f = sin_th3*(K3_45a - Js3_44 - K3_45e) + 2.0*cos_th3*K3_45d
    K3_45 = K3_45d - cos_th3*K3_45f
    K3_55 = -(K3_45e + sin_th3*K3_45f)
    al3_5 = g3_4*K3_45 + sin_th3*(XZ3*qdf3 - bs3_4) + cos_th3*(YZ3*qdf3 - bs3_5)

    # Backward recursion: articulated inertias and wrenches, joint 2 (j2) [28]-[32].
    Gamma2 = -k2*th2
    Js2_66 = ZZ2 - (L2*(K3_35 + K3_35 - Js2_66a) - K3_55)
    bs2_6 = L2*al3_3 - al3_5
    Gb2 = Gamma2 + bs2_6
    qdf2 = Gb2/Js2_66

    # Backward recursion: articulated inertias and wrenches, joint 1 (j1) [28]-[32].
    Gb1 = tau1 - Gamma2
    qdf1 = Gb1/H1

    # Forward recursion: accelerations and torques, joint 2 (j2) [33]-[36].
    qdd2 = qdf2 - qdf1

    # Forward recursion: accelerations and torques, joint 3 (j3) [33]-[36].
    wd3_x = cos_th3*g3_4 + sin_th3*qdf2
    wd3_y = cos_th3*qdf2 - sin_th3*g3_4
    qdd3 = qdf3 - (UH3_4*wd3_x + UH3_5*wd3_y)

    # Forward recursion: accelerations and torques, joint 4 (j4) [33]-[36].
    wd4_z = qdf4 - (UH4_4*wd3_x + UH4_5*wd3_y)
    qdd4 = wd4_z - qdd3

    # Results.
    return (
        (qdf1, qdd2, qdd3, qdd4),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=4, qd=4, tau=2),
    parameters=46,
    results=((4,),),
)
