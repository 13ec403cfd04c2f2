"""Direct dynamic model of two_axis [12]-[36]: 124x 116+, 4 sin/cos a call.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 991358372  # of the files of this package: those of another run are not imported


def constants(_f, p):
    (D4, _, _, D13) = p
    return (D4, D13)


def program(_f, q, qd, tau, c):
    (q1, q2, q3, q4, q5, q6, q7, q8, q9, q10, q11, q13) = q
    (qd1, qd2, qd3, qd4, qd5, qd6, qd7, qd8, qd9, qd10, qd11, qd13) = qd
    (tau5, tau9) = tau
    (D4, D13) = c

    # Forward recursion: velocities, joint 1 (bed_yaw) [1], [3], [7], [14].
    sin_q1 = _f.sin(q1)
    cos_q1 = _f.cos(q1)
    Vk1_1 = 9.81*sin_q1
    Vk1_2 = 9.81*cos_q1
    ww1_zz = qd1*qd1

    # Forward recursion: velocities, joint 2 (bed_y) [1], [3], [7], [14].
    g2_1a = 2.0*qd1
    g2_1 = Vk1_1 - qd2*g2_1a
    g2_3 = Vk1_2 - q2*ww1_zz

    # Forward recursion: velocities, joint 3 (bed_x) [1], [3], [7], [14].
    g3_3 = -q3*ww1_zz
    g3_2 = -qd3*g2_1a
    b3_1 = -500.0*ww1_zz

    # Forward recursion: velocities, joint 4 (motor_secondary) [1], [3], [7], [14].
    g4_3 = -q4*ww1_zz
    g4_1 = qd4*g2_1a - D4*ww1_zz

    # Forward recursion: velocities, joint 5 (motor_x) [1], [3], [7], [14].
    g5_3 = -q5*ww1_zz
    g5_1 = qd5*g2_1a

    # Forward recursion: velocities, joint 6 (cart_yaw) [1], [3], [7], [14].
    sin_q6 = _f.sin(q6)
    cos_q6 = _f.cos(q6)
    w6_z = qd1 + qd6
    ww6_zz = w6_z*w6_z

    # Forward recursion: velocities, joint 7 (cart_x) [1], [3], [7], [14].
    g7_3 = -q7*ww6_zz
    g7_1a = 2.0*w6_z
    g7_1 = qd7*g7_1a

    # Forward recursion: velocities, joint 8 (cart_y) [1], [3], [7], [14].
    g8_3 = -q8*ww6_zz
    g8_2 = -qd8*g7_1a
    b8_1 = 4.2*ww6_zz
    b8_3 = 63.0*ww6_zz

    # Forward recursion: velocities, joint 9 (motor_y) [1], [3], [7], [14].
    g9_3 = -q9*ww6_zz
    g9_1 = -qd9*g7_1a

    # Forward recursion: velocities, joint 10 (y_chain_1) [1], [3], [7], [14].
    g10_3 = -q10*ww6_zz
    g10_1 = -qd10*g7_1a

    # Forward recursion: velocities, joint 11 (ram) [1], [3], [7], [14].
    g11_3 = -q11*ww6_zz
    g11_1 = -qd11*g7_1a
    b11_3 = -14.25*ww6_zz

    # Forward recursion: velocities, joint 13 (sensor_head) [1], [3], [7], [14].
    Js5_15 = 0.6*q13
    b13_1 = (D13*ww1_zz - qd13*g2_1a)*0.6
    b13_3 = Js5_15*ww1_zz

    # Backward recursion: articulated inertias and wrenches, joint 13 (sensor_head) [28]-[32].
    Gamma13 = -25000000.0*q13
    Gb13 = Gamma13 + b13_3
    qdf13 = 1.6666666666666667*Gb13

    # Backward recursion: articulated inertias and wrenches, joint 11 (ram) [28]-[32].
    Gamma11 = -250000000.0*q11
    Gb11 = Gamma11 + b11_3
    al11_1 = 95.0*g11_1
    al11_5 = -14.25*g11_1
    qdf11 = 0.010526315789473684*Gb11

    # Backward recursion: articulated inertias and wrenches, joint 10 (y_chain_1) [28]-[32].
    Gamma10 = -120000000.0*q10
    Js10_15a = 95.0*q11
    Js10_15 = Js10_15a - 14.25
    Js10_55 = q11*(Js10_15a - 28.5) + 9.2375
    Gb10 = Gamma10 - Gamma11
    qdf10 = 0.125*Gb10
    bs10_5 = -(al11_5 + q11*al11_1)
    al10_1 = al11_1 + 103.0*g10_1
    al10_5 = Js10_15*g10_1 - bs10_5

    # Backward recursion: articulated inertias and wrenches, joint 9 (motor_y) [28]-[32].
    Js9_15 = Js10_15 + 103.0*q10
    Js9_55 = Js10_55 + q10*(Js10_15 + Js9_15)
    Gb9 = tau9 - Gamma10
    qdf9 = 0.005555555555555556*Gb9
    bs9_5 = -(al10_5 + q10*al10_1)
    al9_1 = al10_1 + 103.0*g9_1
    al9_5 = Js9_15*g9_1 - bs9_5

    # Backward recursion: articulated inertias and wrenches, joint 8 (cart_y) [28]-[32].
    Gamma8 = -500000000.0*q8
    Js8_15a = Js9_15 + 103.0*q9
    Js8_15 = Js8_15a + 63.0
    K8_44 = Js9_55 + q9*(Js9_15 + Js8_15a) + 34.9
    bs8_5 = -(al9_5 + q9*al9_1)
    bs8_1 = b8_1 - al9_1
    bs8_3 = b8_3 - Gamma10
    Gb8 = Gamma8 + bs8_3
    qdf8 = 0.004761904761904762*Gb8
    al8_2 = 313.0*g8_2 - bs8_1
    al8_4 = bs8_5 + 0.02*Gb8 - Js8_15*g8_2

    # Backward recursion: articulated inertias and wrenches, joint 7 (cart_x) [28]-[32].
    Gamma7 = -350000000.0*q7
    Js7_16 = Js8_15 + 313.0*q8
    Js7_44 = K8_44 + q8*(Js8_15 + Js7_16)
    UH7_4 = -0.003194888178913738*Js7_16
    K7_55 = Js7_44 + Js7_16*UH7_4
    bs7_4 = q8*al8_2 - al8_4
    Gb7 = Gamma7 - al8_2
    qdf7 = 0.003194888178913738*Gb7
    al7_5 = -(bs7_4 + Js7_16*qdf7)

    # Backward recursion: articulated inertias and wrenches, joint 6 (cart_yaw) [28]-[32].
    Gamma6 = -11000000.0*q6
    al6_1 = cos_q6*Gamma8 + sin_q6*Gamma7
    al6_2 = sin_q6*Gamma8 - cos_q6*Gamma7
    bs6_6 = -(q7*Gamma8 + al7_5)
    Gb6 = Gamma6 + bs6_6
    qdf6 = Gb6/K7_55

    # Backward recursion: articulated inertias and wrenches, joint 5 (motor_x) [28]-[32].
    Js5_55 = q13*Js5_15 + 3.001
    bs5_3 = al6_2 - Gamma13
    Gb5 = tau5 + bs5_3
    qdf5 = 0.022222222222222223*Gb5
    bs5_1 = b13_1 - al6_1
    bs5_5 = D13*Gamma13 + q13*b13_1 - Gamma6
    al5_1 = 45.6*g5_1 - bs5_1
    al5_5 = Js5_15*g5_1 - bs5_5

    # Backward recursion: articulated inertias and wrenches, joint 4 (motor_secondary) [28]-[32].
    Gamma4 = -600000000.0*q4
    Js4_15 = Js5_15 + 45.6*q5
    Js4_55 = Js5_55 + q5*(Js5_15 + Js4_15) + 12.0
    Gb4 = Gamma4 - tau5
    qdf4 = 0.011111111111111112*Gb4
    bs4_5 = -(al5_5 + q5*al5_1)
    al4_1 = al5_1 + 135.6*g4_1
    al4_5 = Js4_15*g4_1 - bs4_5

    # Backward recursion: articulated inertias and wrenches, joint 3 (bed_x) [28]-[32].
    Gamma3 = -100000000.0*q3
    Js3_15 = Js4_15 + 135.6*q4
    K3_44 = Js4_55 + q4*(Js4_15 + Js3_15) + 1100.0
    Gb3 = Gamma3 - Gamma4
    qdf3 = 0.0004*Gb3
    bs3_5 = D4*Gamma4 - (al4_5 + q4*al4_1)
    bs3_1 = b3_1 - al4_1
    al3_2 = bs3_1 + 2635.6*g3_2
    al3_4 = -(Js3_15*g3_2 + bs3_5 - 0.2*Gb3)

    # Backward recursion: articulated inertias and wrenches, joint 2 (bed_y) [28]-[32].
    Gamma2 = -150000000.0*q2
    Js2_34 = Js3_15 + 2635.6*q3
    Js2_44 = K3_44 + q3*(Js3_15 + Js2_34)
    UH2_4 = 0.0003794202458643193*Js2_34
    K2_55 = Js2_44 - Js2_34*UH2_4
    bs2_4 = q3*al3_2 - al3_4
    Gb2 = Gamma2 + al3_2
    qdf2 = 0.0003794202458643193*Gb2
    al2_5 = bs2_4 - Js2_34*qdf2

    # Backward recursion: articulated inertias and wrenches, joint 1 (bed_yaw) [28]-[32].
    Gamma1 = -40000000.0*q1
    bs1_6 = q2*Gamma3 + al2_5
    Gb1 = Gamma1 + bs1_6
    qdf1 = Gb1/K2_55

    # Forward recursion: accelerations and torques, joint 2 (bed_y) [33]-[36].
    vd2_y = g2_1 - q2*qdf1
    vd2_z = qdf2 - UH2_4*qdf1
    qdd2 = vd2_z - g2_3

    # Forward recursion: accelerations and torques, joint 3 (bed_x) [33]-[36].
    vd3_x = vd2_z + q3*qdf1 - g3_2
    vd3_z = qdf3 - 0.2*qdf1
    qdd3 = vd3_z - (g3_3 + vd2_y)

    # Forward recursion: accelerations and torques, joint 4 (motor_secondary) [33]-[36].
    vd4_x = g4_1 + vd3_x + q4*qdf1
    qdd4 = qdf4 + D4*qdf1 - vd3_z - g4_3

    # Forward recursion: accelerations and torques, joint 5 (motor_x) [33]-[36].
    qdd5 = qdf5 - (qdf4 + g5_3)
    vd5_x = g5_1 + vd4_x + q5*qdf1

    # Forward recursion: accelerations and torques, joint 6 (cart_yaw) [33]-[36].
    vd6_x = cos_q6*vd5_x - sin_q6*qdf5
    vd6_y = -(cos_q6*qdf5 + sin_q6*vd5_x)
    qdd6 = qdf6 - qdf1

    # Forward recursion: accelerations and torques, joint 7 (cart_x) [33]-[36].
    vd7_y = -(g7_1 + vd6_x + q7*qdf6)
    vd7_z = qdf7 - UH7_4*qdf6
    qdd7 = vd6_y - g7_3 + vd7_z

    # Forward recursion: accelerations and torques, joint 8 (cart_y) [33]-[36].
    vd8_z = qdf8 - 0.02*qdf6
    qdd8 = vd7_y - g8_3 + vd8_z

    # Forward recursion: accelerations and torques, joint 9 (motor_y) [33]-[36].
    vd9_z = qdf9 + g9_3 + vd8_z

    # Forward recursion: accelerations and torques, joint 10 (y_chain_1) [33]-[36].
    qdd10 = qdf10 - (g10_3 + vd9_z)

    # Forward recursion: accelerations and torques, joint 11 (ram) [33]-[36].
    qdd11 = qdf11 - (qdf10 + g11_3)

    # Forward recursion: accelerations and torques, joint 13 (sensor_head) [33]-[36].
    qdd13 = qdf13 - (qdf5 - D13*qdf1)

    # Results.
    return (
        (qdf1, qdd2, qdd3, qdd4, qdd5, qdd6, qdd7, qdd8, qdf9, qdd10, qdd11, qdd13),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=12, qd=12, tau=2),
    parameters=4,
    results=((12,),),
)
