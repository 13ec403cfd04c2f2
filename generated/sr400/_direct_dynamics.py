"""Direct dynamic model of sr400 [12]-[36]: 503x 411+, 8 sin/cos a call; 2x 0+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime


def constants(_f, p):
    (D2, D3, D4, RL4, D8) = p

    # Backward recursion: articulated inertias and wrenches, joint 2 (shoulder) [28]-[32].
    H7d = 10.0*D8
    K2_66f = 35.0*D2
    return (D2, D3, D4, RL4, D8, H7d, K2_66f)


def program(_f, q, qd, tau, c):
    (_, th2, th4, th5, _, th7) = q
    (qd1, qd2, qd4, qd5, qd6, qd7) = qd
    (tau1, tau2, tau4, tau5, tau6, tau7) = tau
    (D2, D3, D4, RL4, D8, H7d, K2_66f) = c

    # Forward recursion: velocities, joint 2 (shoulder) [1], [3], [7], [14].
    sin_th2 = _f.sin(th2)
    cos_th2 = _f.cos(th2)
    w2_x = -qd1*sin_th2
    w2_y = -qd1*cos_th2
    Vk2_1a = qd1*(D2*qd1)
    g2_4 = -qd1*qd2
    Vk2_1 = -(cos_th2*Vk2_1a + 9.81*sin_th2)
    Vk2_2 = sin_th2*Vk2_1a - 9.81*cos_th2
    b2_3 = 3.0*w2_y*w2_y - (24.0*qd2 - 3.0*w2_x)*w2_x
    b2_5a = 1.2*qd2 - 0.75*w2_x
    b2_4a = -13.75*w2_y
    b2_4b = 13.6*qd2 - 1.2*w2_x
    b2_4 = 3.0*Vk2_2 - (w2_y*b2_4b + qd2*b2_4a)
    b2_5 = qd2*b2_5a + w2_x*b2_4b - 3.0*Vk2_1
    b2_6 = -(w2_y*b2_5a - w2_x*b2_4a + 24.0*Vk2_2)

    # Forward recursion: velocities, joint 3 (elbow) [1], [3], [7], [14].
    sin_th7 = _f.sin(th7)
    cos_th7 = _f.cos(th7)
    sin3_theta = -(cos_th2*cos_th7 + sin_th2*sin_th7)
    cos3_theta = cos_th2*sin_th7 - sin_th2*cos_th7
    w3_za = qd2 - qd7
    w3_x = cos3_theta*w2_x + sin3_theta*w2_y
    w3_y = cos3_theta*w2_y - sin3_theta*w2_x
    w3_z = qd2 - w3_za
    Vk3_3a = D3*qd2
    Vk3_1a = -D3*w2_y
    Vk3_3 = w2_x*Vk3_3a
    g3_4 = -w3_za*w2_y
    g3_5 = w3_za*w2_x
    Vk3_1b = qd2*Vk3_3a - w2_y*Vk3_1a - Vk2_1
    Vk3_1c = Vk2_2 - w2_x*Vk3_1a
    Vk3_1 = sin3_theta*Vk3_1c - cos3_theta*Vk3_1b
    Vk3_2 = sin3_theta*Vk3_1b + cos3_theta*Vk3_1c
    b3_2a = 10.0*w3_z
    b3_1a = 4.0*w3_z
    b3_1b = 10.0*w3_x - 4.0*w3_y
    b3_5a = 5.0*w3_x - w3_y
    b3_4a = w3_x - 1.2*w3_y
    b3_4b = 5.4*w3_z
    b3_1 = w3_z*b3_1a - w3_y*b3_1b - 40.0*Vk3_1
    b3_2 = w3_z*b3_2a + w3_x*b3_1b - 40.0*Vk3_2
    b3_3 = -(w3_x*b3_1a + w3_y*b3_2a + 40.0*Vk3_3)
    b3_4 = -(w3_y*b3_4b + w3_z*b3_4a + 10.0*Vk3_3)
    b3_5 = 4.0*Vk3_3 - (w3_z*b3_5a - w3_x*b3_4b)
    b3_6 = w3_x*b3_4a + w3_y*b3_5a + 10.0*Vk3_1 - 4.0*Vk3_2

    # Forward recursion: velocities, joint 4 (wrist_1) [1], [3], [7], [14].
    sin_th4 = _f.sin(th4)
    cos_th4 = _f.cos(th4)
    w4_x = cos_th4*w3_x - sin_th4*w3_z
    w4_y = -(sin_th4*w3_x + cos_th4*w3_z)
    w4_z = qd4 + w3_y
    g4_2a = RL4*w3_z
    g4_1a = RL4*w3_x - D4*w3_y
    g4_1b = D4*w3_z
    g4_4 = -qd4*w3_z
    g4_5 = -qd4*w3_x
    g4_1 = Vk3_1 - (w3_z*g4_1b - w3_y*g4_1a)
    g4_2 = -(Vk3_3 + w3_y*g4_2a + w3_x*g4_1b)
    g4_3 = Vk3_2 - (w3_x*g4_1a + w3_z*g4_2a)
    b4_2a = -6.0*w4_y
    b4_1a = 6.0*w4_x
    b4_1 = w4_z*b4_1a
    b4_2 = -w4_z*b4_2a
    b4_3 = w4_y*b4_2a - w4_x*b4_1a
    b4_5a = 2.6*w4_x
    b4_4a = -2.6*w4_y
    b4_4b = 0.1*w4_z
    b4_4 = -(w4_y*b4_4b + w4_z*b4_4a)
    b4_5 = w4_x*b4_4b - w4_z*b4_5a
    b4_6 = w4_x*b4_4a + w4_y*b4_5a

    # Forward recursion: velocities, joint 5 (wrist_2) [1], [3], [7], [14].
    sin_th5 = _f.sin(th5)
    cos_th5 = _f.cos(th5)
    w5_x = cos_th5*w4_x + sin_th5*w4_z
    w5_y = cos_th5*w4_z - sin_th5*w4_x
    w5_z = qd5 - w4_y
    g5_4 = qd5*w4_z
    g5_5 = -qd5*w4_x
    b5_2a = 0.24*w5_z
    b5_1a = 0.24*w5_x
    b5_1 = -w5_y*b5_1a
    b5_2 = w5_z*b5_2a + w5_x*b5_1a
    b5_3 = -w5_y*b5_2a
    b5_5a = 0.0672*w5_x
    b5_4a = -0.04*w5_y
    b5_4b = 0.0672*w5_z
    b5_4 = -(w5_y*b5_4b + w5_z*b5_4a)
    b5_5 = w5_x*b5_4b - w5_z*b5_5a
    b5_6 = w5_x*b5_4a + w5_y*b5_5a

    # Forward recursion: velocities, joint 6 (wrist_3) [1], [3], [7], [14].
    w6_z = qd6 + w5_y
    b6_2a = qd6*w5_z
    b6_1a = qd6*w5_x
    b6_3a = 0.3*w5_z
    b6_3b = 0.3*w5_x
    b6_3 = w5_x*b6_3b + w5_z*b6_3a
    b6_6a = 0.04*w5_x
    b6_6b = 0.04*w5_z
    b6_4a = 0.006*w6_z
    b6_6 = w5_x*b6_6b - w5_z*b6_6a
    b6_1 = 0.3*b6_1a - w6_z*b6_3b
    b6_2 = w6_z*b6_3a - 0.3*b6_2a
    b6_4 = w5_z*b6_4a - w6_z*b6_6b + 0.04*b6_2a
    b6_5 = 0.04*b6_1a - (w6_z*b6_6a - w5_x*b6_4a)

    # Forward recursion: velocities, joint 7 (crank) [1], [3], [7], [14].
    g7_4 = -qd1*qd7
    Vk7_1 = -(cos_th7*Vk2_1a + 9.81*sin_th7)
    Vk7_2 = sin_th7*Vk2_1a - 9.81*cos_th7
    b7_3 = 3.75*w3_z*w3_y
    b7_5a = -0.2*w3_y
    b7_4a = 1.0625*w3_x
    b7_4b = 1.0625*w3_z
    b7_4 = w3_x*b7_4b - w3_z*b7_4a
    b7_5 = w3_z*b7_5a + w3_y*b7_4b
    b7_6 = w3_y*b7_4a + w3_x*b7_5a + 3.75*Vk7_2

    # Forward recursion: velocities, joint 8 (rod) [1], [3], [7], [14].
    Vk8_3a = D8*w3_z
    Vk8_1a = D8*w3_x
    Vk8_3 = -w3_y*Vk8_3a
    g8_4 = -w3_za*w3_x
    g8_5 = -w3_za*w3_y
    Vk8_1b = w3_x*Vk8_1a + w3_z*Vk8_3a + Vk7_1
    Vk8_1c = -(w3_y*Vk8_1a + Vk7_2)
    Vk8_1 = cos3_theta*Vk8_1c - sin3_theta*Vk8_1b
    Vk8_2 = cos3_theta*Vk8_1b + sin3_theta*Vk8_1c
    b8_1a = 4.0*qd2
    b8_1b = -4.0*w2_y
    b8_5a = -0.02*w2_x
    b8_4a = -2.2*w2_y
    b8_4b = 2.2*qd2
    b8_4 = -(w2_y*b8_4b + qd2*b8_4a)
    b8_1 = qd2*b8_1a - w2_y*b8_1b - 10.0*Vk8_1
    b8_2 = w2_x*b8_1b - 10.0*Vk8_2
    b8_3 = -(w2_x*b8_1a + 10.0*Vk8_3)
    b8_5 = qd2*b8_5a + w2_x*b8_4b + 4.0*Vk8_3
    b8_6 = -(w2_y*b8_5a - w2_x*b8_4a + 4.0*Vk8_2)

    # Backward recursion: articulated inertias and wrenches, joint 6 (wrist_3) [28]-[32].
    Gb6 = tau6 + b6_6
    qdf6 = 1.1918951132300357*Gb6
    al6_6 = 0.007151370679380214*tau6 - 0.9928486293206198*b6_6

    # Backward recursion: articulated inertias and wrenches, joint 5 (wrist_2) [28]-[32].
    bs5_1 = b5_1 + b6_1
    bs5_2 = b5_2 + b6_3
    bs5_3 = b5_3 - b6_2
    bs5_4 = b5_4 + b6_4
    bs5_5 = b5_5 - al6_6
    bs5_6 = b5_6 - b6_5
    K5_12a = 0.22307221542227662*sin_th5
    K5_12 = -cos_th5*K5_12a
    K5_16 = -0.49571603427172584*cos_th5
    K5_26 = -0.49571603427172584*sin_th5
    K5_34 = 0.54*cos_th5
    K5_35 = 0.54*sin_th5
    K5_44a = 0.061242908224076284*sin_th5
    K5_44b = sin_th5*K5_44a
    K5_44 = 0.1072 - K5_44b
    K5_45 = cos_th5*K5_44a
    K5_55 = K5_44b + 0.04595709177592372
    Gb5 = tau5 + bs5_6
    qdf5 = 0.7649938800489596*Gb5
    al5_1a = bs5_1 + 0.4130966952264382*Gb5
    al5_1 = sin_th5*bs5_2 - cos_th5*al5_1a
    al5_2 = -(sin_th5*al5_1a + cos_th5*bs5_2)
    al5_3 = g5_4*K5_34 + g5_5*K5_35 - bs5_3
    al5_4 = g5_4*K5_44 + g5_5*K5_45 - (cos_th5*bs5_4 - sin_th5*bs5_5)
    al5_5 = g5_4*K5_45 + g5_5*K5_55 - (sin_th5*bs5_4 + cos_th5*bs5_5)
    al5_6 = 0.08200734394124846*tau5 - 0.9179926560587516*bs5_6

    # Backward recursion: articulated inertias and wrenches, joint 4 (wrist_1) [28]-[32].
    Js4_11a = sin_th5*K5_12a
    Js4_11 = Js4_11a + 30.776927784577722
    Js4_33 = 31.0 - Js4_11a
    Js4_15 = -(K5_16 + 6.0)
    Js4_24 = 6.0 - K5_34
    Js4_44 = 2.7072 - K5_44b
    Js4_66 = K5_44b + 0.14595709177592373
    bs4_1 = b4_1 - al5_1
    bs4_2 = b4_2 + al5_3
    bs4_3 = b4_3 - al5_2
    bs4_4 = b4_4 - al5_4
    bs4_5 = b4_5 + al5_6
    bs4_6 = b4_6 - al5_5
    H4 = K5_44b + 2.020957091775924
    Hinv4 = 1.0/H4
    rho4 = 1.875*Hinv4
    UH4_6 = Js4_66*Hinv4
    UH4_2 = -K5_35*Hinv4
    UH4_4 = K5_45*Hinv4
    K4_16a = K5_35*rho4
    K4_46a = K5_45*rho4
    K4_66 = Js4_66*rho4
    K4_44a = K5_45*UH4_4 - Js4_44
    K4_14a = -(Js4_24 + K5_35*UH4_4)
    K4_11a = -(K5_35*UH4_2 + 31.0)
    K4_11b = sin_th4*(Js4_11 + K4_11a)
    K4_11c = sin_th4*K4_11b
    K4_11 = Js4_11 - K4_11c
    K4_12 = cos_th4*K4_11b
    K4_22 = K4_11c - K4_11a
    K4_13 = cos_th4*K5_12
    K4_23 = sin_th4*K5_12
    K4_14b = cos_th4*(Js4_15 - K4_14a)
    K4_14 = -sin_th4*K4_14b
    K4_15a = cos_th4*K4_14b
    K4_15 = K4_14a + K4_15a
    K4_24 = K4_15a - Js4_15
    K4_16 = sin_th4*K4_16a
    K4_26 = -cos_th4*K4_16a
    K4_34 = sin_th4*K5_26
    K4_35 = -cos_th4*K5_26
    K4_44b = sin_th4*(K4_44a + 2.698408812729498)
    K4_44c = sin_th4*K4_44b
    K4_44 = K4_44c - K4_44a
    K4_45 = -cos_th4*K4_44b
    K4_55 = 2.698408812729498 - K4_44c
    K4_46 = cos_th4*K4_46a
    K4_56 = sin_th4*K4_46a
    Gb4 = tau4 + bs4_6
    qdf4 = Hinv4*Gb4
    al4_1a = -(bs4_2 + K5_35*qdf4)
    al4_4a = bs4_4 - K5_45*qdf4
    al4_1 = g4_1*K4_11 + g4_2*K4_12 + g4_3*K4_13 + g4_4*K4_14 + g4_5*K4_15 - (cos_th4*bs4_1 + sin_th4*al4_1a)
    al4_2 = g4_1*K4_12 + g4_2*K4_22 + g4_3*K4_23 + g4_4*K4_24 - g4_5*K4_14 - (sin_th4*bs4_1 - cos_th4*al4_1a)
    al4_3 = g4_1*K4_13 + g4_2*K4_23 + g4_3*Js4_33 + g4_4*K4_34 + g4_5*K4_35 - bs4_3
    al4_4 = g4_1*K4_14 + g4_2*K4_24 + g4_3*K4_34 + g4_4*K4_44 + g4_5*K4_45 - (cos_th4*al4_4a - sin_th4*bs4_5)
    al4_5 = (
        -(g4_2*K4_14 - g4_1*K4_15 - g4_3*K4_35 - (g4_4*K4_45 + g4_5*K4_55) + sin_th4*al4_4a + cos_th4*bs4_5)
    )
    al4_6 = g4_1*K4_16 + g4_2*K4_26 + g4_4*K4_46 + g4_5*K4_56 + tau4*UH4_6 - bs4_6*rho4

    # Backward recursion: articulated inertias and wrenches, joint 3 (elbow) [28]-[32].
    Js3_14 = K4_14 - RL4*K4_12
    Js3_16a = K4_15 + RL4*K4_11
    Js3_34a = RL4*K4_22 - K4_24
    Js3_24 = K4_34 - RL4*K4_23
    Js3_26a = K4_35 + RL4*K4_13
    Js3_15 = K4_16 + D4*K4_12
    Js3_25 = D4*K4_23
    Js3_26b = Js3_26a - D4*Js4_33
    Js3_35a = -(K4_26 + D4*K4_22)
    Js3_36 = -(Js3_14 + Js3_25)
    Js3_46 = D4*Js3_24 - (K4_45 + RL4*(K4_14 + Js3_14))
    Js3_56 = -(K4_56 + RL4*K4_16 + D4*Js3_36)
    Js3_11 = K4_11 + 40.0
    Js3_22 = 71.0 - Js4_11a
    Js3_33 = K4_22 + 40.0
    Js3_16 = -(Js3_16a - D4*K4_13 + 10.0)
    Js3_26 = 4.0 - Js3_26b
    Js3_34 = Js3_34a + 10.0
    Js3_35 = Js3_35a - 4.0
    Js3_44 = K4_44 + RL4*(Js3_34a - K4_24) + 5.0
    Js3_45 = K4_46 - RL4*K4_26 - D4*Js3_34a - 1.0
    Js3_55 = K4_66 - D4*(Js3_35a - K4_26) + 1.2
    Js3_66 = 5.4 - (D4*(Js3_26a + Js3_26b) - (K4_55 + RL4*(K4_15 + Js3_16a)))
    bs3_1 = b3_1 - al4_1
    bs3_2 = b3_2 - al4_3
    bs3_3 = b3_3 + al4_2
    bs3_4 = b3_4 - (al4_4 - RL4*al4_2)
    bs3_5 = b3_5 - (al4_6 + D4*al4_2)
    bs3_6 = b3_6 - (D4*al4_3 - (al4_5 + RL4*al4_1))

    # Backward recursion: articulated inertias and wrenches, joint 2 (shoulder) [28]-[32].
    Gb2a = -cos_th2*g2_4
    Gb2b = -sin_th2*g2_4
    Gb2c = D3*Gb2b
    Gb2d = g3_4 - Gb2a
    Gb2e = -(g3_5 + Gb2b)
    Gb2f = sin3_theta*Gb2e - cos3_theta*Gb2d
    Gb2g = -(sin3_theta*Gb2d + cos3_theta*Gb2e)
    al2_6a = -cos_th7*g7_4
    al2_6b = -sin_th7*g7_4
    al2_6c = D8*al2_6b
    al2_6d = al2_6a - g8_4
    al2_6e = g8_5 + al2_6b
    al2_6f = -(cos3_theta*al2_6d + sin3_theta*al2_6e)
    al2_6g = -(bs3_3 + Js3_33*Gb2c + Js3_34*Gb2f - Js3_35*Gb2g)
    al2_6h = bs3_4 + Js3_34*Gb2c - (Js3_45*Gb2g - Js3_44*Gb2f)
    al2_6i = -(bs3_5 + Js3_35*Gb2c + Js3_45*Gb2f - Js3_55*Gb2g)
    Gb2h = bs3_6 + Js3_36*Gb2c + Js3_46*Gb2f - Js3_56*Gb2g
    al2_6j = b8_3 - (10.0*al2_6c - 4.0*al2_6f)
    al2_6k = b8_4 + (cos3_theta*al2_6e - sin3_theta*al2_6d)*0.02
    al2_6l = b8_5 + 4.0*al2_6c - 2.2*al2_6f
    K2_66a = -4.0*cos3_theta
    H7a = -4.0*sin3_theta
    H7b = D8*H7a
    H7c = H7b - 2.2
    K2_66b = -2.18*cos3_theta
    K2_66c = -cos3_theta*K2_66b
    H7e = H7a - H7d
    H7f = D8*(H7a + H7e)
    K2_66d = K2_66c - 2.2 + H7f - 1.0625
    K2_66e = sin_th7*K2_66a - cos_th7*(H7e - 3.75)
    U7_6a = sin3_theta*Js3_56 - cos3_theta*Js3_46
    U7_6b = -(sin3_theta*Js3_46 + cos3_theta*Js3_56)
    H2a = sin3_theta*Js3_16 + cos3_theta*Js3_26
    H2b = -(Js3_66 + D3*H2a)
    U7_6 = sin_th2*U7_6a + cos_th2*(U7_6b + D3*Js3_36) + D2*Js3_36
    H2c = -2.0*cos3_theta
    U2_6a = cos3_theta*(Js3_24 + Js3_15) - sin3_theta*(Js3_25 - Js3_14)
    K2_66g = sin3_theta*Js3_35 - cos3_theta*Js3_34
    K2_66h = -(sin3_theta*Js3_34 + cos3_theta*Js3_35)
    K2_66i = -(sin3_theta*(Js3_55 - Js3_44) + Js3_45*H2c)
    K2_66j = -sin3_theta*K2_66i
    K2_66k = K2_66h + D3*Js3_33
    U2_6b = Js3_36 - D3*(sin3_theta*K4_12 + cos3_theta*K4_23)
    H2d = D3*(H2a + H2a - D3*(sin3_theta*(K4_13*H2c - sin3_theta*(Js3_11 - Js3_22)) - Js3_22))
    K2_66l = Js3_55 - K2_66j + D3*(K2_66h + K2_66k) + 13.75
    Gb2i = (
        1.2*Gb2a - b2_6 - (Gb2h
        + D3*(sin3_theta*(bs3_1 - (K4_12*Gb2c + Js3_15*Gb2g - Js3_14*Gb2f)) + cos3_theta*(bs3_2 - (K4_23*Gb2c + Js3_25*Gb2g - Js3_24*Gb2f))))
    )
    K2_66m = sin_th2*K2_66g + cos_th2*(K2_66k + 24.0)
    H2e = -(Js3_66 + H2b)
    H2f = H7c - H2e + 2.2
    H7 = H7b + Js3_66 + H7c - (H7f - 3.8745)
    U2_6 = (
        sin_th2*(U7_6a + D3*(Js3_15 - cos3_theta*U2_6a) + 1.2) + cos_th2*(U7_6b
        + D3*(U2_6b - (Js3_25 + sin3_theta*U2_6a))) + D2*U2_6b - U7_6
    )
    Gb2 = tau2 - (Gb2h + Gb2i - b8_6)
    Gb7 = tau7 + Gb2h + b7_6 + b8_6 + D8*(cos3_theta*b8_1 + sin3_theta*b8_2) - b8_6
    Hinv7 = 1.0/H7
    H2g = H2f*Hinv7
    H2 = H2b + Js3_66 + H2d + 21.1 - H2e + 2.2 - H2f*H2g
    Hinv2 = 1.0/H2
    K2_66n = -(U2_6 + U7_6*H2g)
    al2_6m = Hinv2*(Gb2 + Gb7*H2g)
    K2_66o = (
        U7_6*(U7_6*Hinv7) + sin_th2*(sin_th2*(K2_66l - (Js3_44 + K2_66j + 0.75))
        + (Js3_45 - cos3_theta*K2_66i - D3*K2_66g)*(2.0*cos_th2)) + K2_66d
        - sin_th7*(sin_th7*(K2_66c + 0.22 + K2_66d)
        + (sin3_theta*K2_66b + D8*K2_66a)*(2.0*cos_th7)) - K2_66l
    )
    K2_66 = (
        -(K2_66n*(Hinv2*K2_66n) + K2_66o
        + D2*(K2_66e + K2_66e - K2_66f - (K2_66m + K2_66m + D2*(K4_22 + 100.0))))
    )
    al2_6n = (
        -(U2_6*al2_6m
        + cos_th2*(b2_5 - 13.75*Gb2b - (cos3_theta*al2_6i - sin3_theta*al2_6h - D3*al2_6g))
        + sin_th7*(b7_4 + 0.2*al2_6a + cos3_theta*al2_6l - sin3_theta*al2_6k)
        + cos_th7*(b7_5 - 1.0625*al2_6b + D8*al2_6j - (cos3_theta*al2_6k + sin3_theta*al2_6l))
        + sin_th2*(b2_4 + 0.75*Gb2a + cos3_theta*al2_6h + sin3_theta*al2_6i))
    )
    al2_6 = (
        U7_6*(Gb7*Hinv7 + H2g*al2_6m) - al2_6n + (3.75*al2_6b - b7_3 - al2_6j
        - (b2_3 + 24.0*Gb2b - al2_6g))*D2
    )

    # Backward recursion: articulated inertias and wrenches, joint 1 (waist) [28]-[32].
    H1 = K2_66 + 36.2
    Gb1 = tau1 - al2_6
    qdf1 = Gb1/H1

    # Forward recursion: accelerations and torques, joint 2 (shoulder) [33]-[36].
    qdd2a = Gb7 - U7_6*qdf1
    qdd2 = Hinv2*(Gb2 - U2_6*qdf1 + H2g*qdd2a)
    vd2_z = D2*qdf1
    wd2_x = -(Gb2a + sin_th2*qdf1)
    wd2_y = Gb2b - cos_th2*qdf1

    # Forward recursion: accelerations and torques, joint 3 (elbow) [33]-[36].
    qdd7 = Hinv7*qdd2a + H2g*qdd2
    Vr3_1a = D3*qdd2
    Vr3_3 = vd2_z - D3*wd2_y
    wd3_xa = g3_4 + wd2_x
    wd3_xb = -(g3_5 + wd2_y)
    Vr3_1 = sin3_theta*Vr3_1a
    Vr3_2 = cos3_theta*Vr3_1a
    wd3_x = cos3_theta*wd3_xa - sin3_theta*wd3_xb
    wd3_y = -(sin3_theta*wd3_xa + cos3_theta*wd3_xb)
    wd3_z = qdd2 - (qdd2 - qdd7)

    # Forward recursion: accelerations and torques, joint 4 (wrist_1) [33]-[36].
    vd4_xa = RL4*wd3_z - Vr3_1 - g4_1
    vd4_xb = g4_2 + D4*wd3_y - Vr3_3 - RL4*wd3_x
    vd4_z = g4_3 + Vr3_2 + D4*wd3_z
    wd4_xa = -(g4_4 + wd3_x)
    wd4_xb = wd3_z - g4_5
    vd4_x = sin_th4*vd4_xb - cos_th4*vd4_xa
    vd4_y = sin_th4*vd4_xa + cos_th4*vd4_xb
    wd4_x = -(cos_th4*wd4_xa + sin_th4*wd4_xb)
    wd4_y = sin_th4*wd4_xa - cos_th4*wd4_xb
    qdd4 = qdf4 - UH4_2*vd4_y - UH4_4*wd4_x - UH4_6*wd3_y
    wd4_z = wd3_y + qdd4

    # Forward recursion: accelerations and torques, joint 5 (wrist_2) [33]-[36].
    vd5_x = cos_th5*vd4_x + sin_th5*vd4_z
    wd5_y = cos_th5*(g5_5 + wd4_z) - sin_th5*(g5_4 + wd4_x)
    qdd5 = qdf5 + 0.4130966952264382*vd5_x + 0.08200734394124846*wd4_y

    # Forward recursion: accelerations and torques, joint 6 (wrist_3) [33]-[36].
    qdd6 = qdf6 - 0.007151370679380214*wd5_y

    # Results.
    return (
        (qdf1, qdd2, qdd4, qdd5, qdd6, qdd7),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=6, qd=6, tau=6),
    parameters=5,
    results=((6,),),
)
