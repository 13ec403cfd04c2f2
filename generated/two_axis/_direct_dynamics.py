"""Direct dynamic model of two_axis [12]-[36]: 144x 123+, 4 sin/cos a call.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and arrays.
"""


def constants(_f, p):
    return ()


def program(_f, q, qd, tau, p, c):
    q1 = q[0]
    q2 = q[1]
    q3 = q[2]
    q4 = q[3]
    q5 = q[4]
    q6 = q[5]
    q7 = q[6]
    q8 = q[7]
    q9 = q[8]
    q10 = q[9]
    q11 = q[10]
    q13 = q[11]
    qd1 = qd[0]
    qd2 = qd[1]
    qd3 = qd[2]
    qd4 = qd[3]
    qd5 = qd[4]
    qd6 = qd[5]
    qd7 = qd[6]
    qd8 = qd[7]
    qd9 = qd[8]
    qd10 = qd[9]
    qd11 = qd[10]
    qd13 = qd[11]
    tau5 = tau[0]
    tau9 = tau[1]
    D4 = p[0]
    D13 = p[3]

    # Forward recursion: velocities, joint 1 (bed_yaw) [1], [3], [7], [14].
    sin_q1 = _f.sin(q1)
    cos_q1 = _f.cos(q1)
    ww1_zz = qd1*qd1

    # Forward recursion: velocities, joint 2 (bed_y) [1], [3], [7], [14].
    g2_3 = -q2*ww1_zz
    g2_2 = -2.0*qd2*qd1

    # Forward recursion: velocities, joint 3 (bed_x) [1], [3], [7], [14].
    g3_3 = -q3*ww1_zz
    g3_1 = 2.0*qd3*qd1
    b3_1 = -500.0*ww1_zz

    # Forward recursion: velocities, joint 4 (motor_secondary) [1], [3], [7], [14].
    g4_3 = -q4*ww1_zz
    g4_1 = 2.0*qd4*qd1 - D4*ww1_zz

    # Forward recursion: velocities, joint 5 (motor_x) [1], [3], [7], [14].
    g5_3 = -q5*ww1_zz
    g5_1 = 2.0*qd5*qd1

    # Forward recursion: velocities, joint 6 (cart_yaw) [1], [3], [7], [14].
    sin_q6 = _f.sin(q6)
    cos_q6 = _f.cos(q6)
    w6_z = qd1 + qd6
    ww6_zz = w6_z*w6_z

    # Forward recursion: velocities, joint 7 (cart_x) [1], [3], [7], [14].
    g7_3 = -q7*ww6_zz
    g7_2 = -2.0*qd7*w6_z

    # Forward recursion: velocities, joint 8 (cart_y) [1], [3], [7], [14].
    g8_3 = -q8*ww6_zz
    g8_1 = -2.0*qd8*w6_z
    b8_1 = 4.2*ww6_zz
    b8_3 = 63.0*ww6_zz

    # Forward recursion: velocities, joint 9 (motor_y) [1], [3], [7], [14].
    g9_3 = -q9*ww6_zz
    g9_1 = -2.0*qd9*w6_z

    # Forward recursion: velocities, joint 10 (y_chain_1) [1], [3], [7], [14].
    g10_3 = -q10*ww6_zz
    g10_1 = -2.0*qd10*w6_z

    # Forward recursion: velocities, joint 11 (ram) [1], [3], [7], [14].
    g11_3 = -q11*ww6_zz
    g11_1 = -2.0*qd11*w6_z
    b11_3 = -14.25*ww6_zz

    # Forward recursion: velocities, joint 13 (sensor_head) [1], [3], [7], [14].
    g13_3 = -q13*ww1_zz
    g13_1 = 2.0*qd13*qd1 - D13*ww1_zz

    # Backward recursion: articulated inertias and wrenches, joint 13 (sensor_head) [28]-[32].
    Gamma13 = -25000000.0*q13
    al13_1 = 0.6*g13_1

    # Backward recursion: articulated inertias and wrenches, joint 11 (ram) [28]-[32].
    Gamma11 = -250000000.0*q11
    al11_1 = 95.0*g11_1
    al11_5 = -14.25*g11_1
    Gb11 = Gamma11 + b11_3

    # Backward recursion: articulated inertias and wrenches, joint 10 (y_chain_1) [28]-[32].
    Gamma10 = -120000000.0*q10
    Js10_15a = 95.0*q11
    Js10_15 = Js10_15a - 14.25
    Js10_55 = q11*(Js10_15a - 28.5) + 9.2375
    bs10_5 = -(al11_5 + q11*al11_1)
    Gb10 = Gamma10 - Gamma11
    al10_1 = al11_1 + 103.0*g10_1
    al10_5 = g10_1*Js10_15 - bs10_5

    # Backward recursion: articulated inertias and wrenches, joint 9 (motor_y) [28]-[32].
    Js9_15 = Js10_15 + 103.0*q10
    Js9_55 = Js10_55 + q10*(Js10_15 + Js9_15)
    bs9_5 = -(al10_5 + q10*al10_1)
    Gb9 = tau9 - Gamma10
    al9_1 = al10_1 + 103.0*g9_1
    al9_5 = g9_1*Js9_15 - bs9_5

    # Backward recursion: articulated inertias and wrenches, joint 8 (cart_y) [28]-[32].
    Gamma8 = -500000000.0*q8
    Js8_15a = Js9_15 + 103.0*q9
    Js8_15 = Js8_15a + 63.0
    bs8_5 = -(al9_5 + q9*al9_1)
    bs8_1 = b8_1 - al9_1
    bs8_3 = b8_3 - Gamma10
    K8_55 = Js9_55 + q9*(Js9_15 + Js8_15a) + 34.9
    Gb8 = Gamma8 + bs8_3
    al8_1 = 313.0*g8_1 - bs8_1
    al8_5 = -(bs8_5 + 0.02*Gb8 - g8_1*Js8_15)

    # Backward recursion: articulated inertias and wrenches, joint 7 (cart_x) [28]-[32].
    Gamma7 = -350000000.0*q7
    Js7_16 = Js8_15 + 313.0*q8
    Js7_44 = K8_55 + q8*(Js8_15 + Js7_16)
    bs7_4 = al8_5 + q8*al8_1
    UH7_4 = -0.003194888178913738*Js7_16
    K7_44 = Js7_44 + Js7_16*UH7_4
    Gb7 = Gamma7 - al8_1
    al7_4 = UH7_4*Gb7 - bs7_4

    # Backward recursion: articulated inertias and wrenches, joint 6 (cart_yaw) [28]-[32].
    Gamma6 = -11000000.0*q6
    bs6_6 = -(al7_4 + q7*Gamma8)
    Hinv6 = 1.0/K7_44
    Gb6 = Gamma6 + bs6_6

    # Backward recursion: articulated inertias and wrenches, joint 5 (motor_x) [28]-[32].
    Js5_15 = 0.6*q13
    Js5_55 = q13*Js5_15 + 3.001
    bs5_1 = -(al13_1 + cos_q6*Gamma8 + sin_q6*Gamma7)
    bs5_3 = -(Gamma13 + cos_q6*Gamma7 - sin_q6*Gamma8)
    bs5_5 = D13*Gamma13 - q13*al13_1 - Gamma6
    Gb5 = tau5 + bs5_3
    al5_1 = 45.6*g5_1 - bs5_1
    al5_5 = g5_1*Js5_15 - bs5_5

    # Backward recursion: articulated inertias and wrenches, joint 4 (motor_secondary) [28]-[32].
    Gamma4 = -600000000.0*q4
    Js4_15 = Js5_15 + 45.6*q5
    Js4_55 = Js5_55 + q5*(Js5_15 + Js4_15) + 12.0
    bs4_5 = -(al5_5 + q5*al5_1)
    Gb4 = Gamma4 - tau5
    al4_1 = al5_1 + 135.6*g4_1
    al4_5 = g4_1*Js4_15 - bs4_5

    # Backward recursion: articulated inertias and wrenches, joint 3 (bed_x) [28]-[32].
    Gamma3 = -100000000.0*q3
    Js3_15 = Js4_15 + 135.6*q4
    bs3_5 = D4*Gamma4 - (al4_5 + q4*al4_1)
    bs3_1 = b3_1 - al4_1
    K3_55 = Js4_55 + q4*(Js4_15 + Js3_15) + 1100.0
    Gb3 = Gamma3 - Gamma4
    al3_1 = 2635.6*g3_1 - bs3_1
    al3_5 = g3_1*Js3_15 + 0.2*Gb3 - bs3_5

    # Backward recursion: articulated inertias and wrenches, joint 2 (bed_y) [28]-[32].
    Gamma2 = -150000000.0*q2
    Js2_34 = Js3_15 + 2635.6*q3
    Js2_44 = K3_55 + q3*(Js3_15 + Js2_34)
    bs2_4 = -(al3_5 + q3*al3_1)
    UH2_4 = 0.0003794202458643193*Js2_34
    K2_44 = Js2_44 - Js2_34*UH2_4
    Gb2 = Gamma2 - al3_1
    al2_4 = UH2_4*Gb2 - bs2_4

    # Backward recursion: articulated inertias and wrenches, joint 1 (bed_yaw) [28]-[32].
    Gamma1 = -40000000.0*q1
    bs1_6 = q2*Gamma3 - al2_4
    Hinv1 = 1.0/K2_44
    Gb1 = Gamma1 + bs1_6

    # Forward recursion: accelerations and torques, joint 1 (bed_yaw) [33]-[36].
    vd1_x = 9.81*sin_q1
    vd1_y = 9.81*cos_q1
    qdd1 = Hinv1*Gb1

    # Forward recursion: accelerations and torques, joint 2 (bed_y) [33]-[36].
    vd2_y = g2_2 + vd1_x - q2*qdd1
    qdd2a = -(g2_3 + vd1_y)
    qdd2 = -(Js2_34*qdd1 - (Gb2 + 2635.6*qdd2a))*0.0003794202458643193
    vd2_z = qdd2 - qdd2a

    # Forward recursion: accelerations and torques, joint 3 (bed_x) [33]-[36].
    vd3_x = g3_1 + vd2_z + q3*qdd1
    qdd3a = -(g3_3 + vd2_y)
    qdd3 = -(500.0*qdd1 - (Gb3 + 2500.0*qdd3a))*0.0004
    vd3_z = qdd3 - qdd3a

    # Forward recursion: accelerations and torques, joint 4 (motor_secondary) [33]-[36].
    vd4_x = g4_1 + vd3_x + q4*qdd1
    qdd4a = D4*qdd1 - vd3_z - g4_3
    qdd4 = (Gb4 + 90.0*qdd4a)*0.011111111111111112
    vd4_z = qdd4 - qdd4a

    # Forward recursion: accelerations and torques, joint 5 (motor_x) [33]-[36].
    vd5_x = g5_1 + vd4_x + q5*qdd1
    qdd5a = -(g5_3 + vd4_z)
    qdd5 = (Gb5 + 45.0*qdd5a)*0.022222222222222223
    vd5_z = qdd5 - qdd5a

    # Forward recursion: accelerations and torques, joint 6 (cart_yaw) [33]-[36].
    vd6_x = cos_q6*vd5_x - sin_q6*vd5_z
    vd6_y = -(sin_q6*vd5_x + cos_q6*vd5_z)
    qdd6 = -Hinv6*(K7_44*qdd1 - Gb6)
    wd6_z = qdd1 + qdd6

    # Forward recursion: accelerations and torques, joint 7 (cart_x) [33]-[36].
    vd7_y = g7_2 - (vd6_x + q7*wd6_z)
    qdd7 = (Gb7 + (vd6_y - g7_3)*313.0 + Js7_16*wd6_z)*0.003194888178913738

    # Forward recursion: accelerations and torques, joint 8 (cart_y) [33]-[36].
    qdd8a = vd7_y - g8_3
    qdd8 = -(4.2*wd6_z - (Gb8 + 210.0*qdd8a))*0.004761904761904762
    vd8_z = qdd8 - qdd8a

    # Forward recursion: accelerations and torques, joint 9 (motor_y) [33]-[36].
    qdd9 = 0.005555555555555556*Gb9
    vd9_z = g9_3 + vd8_z + qdd9

    # Forward recursion: accelerations and torques, joint 10 (y_chain_1) [33]-[36].
    qdd10a = -(g10_3 + vd9_z)
    qdd10 = (Gb10 + 8.0*qdd10a)*0.125
    vd10_z = qdd10 - qdd10a

    # Forward recursion: accelerations and torques, joint 11 (ram) [33]-[36].
    qdd11 = -((g11_3 + vd10_z)*95.0 - Gb11)*0.010526315789473684

    # Forward recursion: accelerations and torques, joint 13 (sensor_head) [33]-[36].
    qdd13 = (Gamma13 + (D13*qdd1 - vd5_z - g13_3)*0.6)*1.6666666666666667

    # Results.
    return (
        (qdd1, qdd2, qdd3, qdd4, qdd5, qdd6, qdd7, qdd8, qdd9, qdd10, qdd11, qdd13),
    )
