"""Forces at zero joint acceleration of two_axis [8]: 70x 58+, 4 sin/cos a call.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _run


def constants(_f, p):
    (D4, _, _, D13) = p
    return (D4, D13)


def program(_f, q, qd, c):
    (q1, q2, q3, q4, q5, q6, q7, q8, q9, q10, q11, q13) = q
    (qd1, qd2, qd3, qd4, qd5, qd6, qd7, qd8, qd9, qd10, qd11, qd13) = qd
    (D4, D13) = c

    # Forward recursion: velocities, accelerations, wrenches, joint 1 (bed_yaw) [1], [3], [6], [12].
    sin_q1 = _f.sin(q1)
    cos_q1 = _f.cos(q1)
    ww1_zz = qd1*qd1
    vd1_x = 9.81*sin_q1
    vd1_y = 9.81*cos_q1

    # Forward recursion: velocities, accelerations, wrenches, joint 2 (bed_y) [1], [3], [6], [12].
    vd2_z = vd1_y - q2*ww1_zz
    vd2_ya = 2.0*qd1
    vd2_y = vd1_x - qd2*vd2_ya

    # Forward recursion: velocities, accelerations, wrenches, joint 3 (bed_x) [1], [3], [6], [12].
    vd3_z = vd2_y - q3*ww1_zz
    vd3_x = vd2_z + qd3*vd2_ya
    Fb3_3 = 2500.0*vd3_z
    Fb3_1 = 500.0*ww1_zz + 2500.0*vd3_x
    Fb3_5 = 500.0*vd3_z

    # Forward recursion: velocities, accelerations, wrenches, joint 4 (motor_secondary) [1], [3], [6], [12].
    vd4_z = vd3_z - q4*ww1_zz
    vd4_x = qd4*vd2_ya - (D4*ww1_zz - vd3_x)
    Fb4_1 = 90.0*vd4_x
    Fb4_3 = 90.0*vd4_z

    # Forward recursion: velocities, accelerations, wrenches, joint 5 (motor_x) [1], [3], [6], [12].
    vd5_z = vd4_z - q5*ww1_zz
    vd5_x = qd5*vd2_ya + vd4_x
    Fb5_1 = 45.0*vd5_x
    Fb5_3 = 45.0*vd5_z

    # Forward recursion: velocities, accelerations, wrenches, joint 6 (cart_yaw) [1], [3], [6], [12].
    sin_q6 = _f.sin(q6)
    cos_q6 = _f.cos(q6)
    w6_z = qd1 + qd6
    ww6_zz = w6_z*w6_z
    vd6_x = cos_q6*vd5_x - sin_q6*vd5_z
    vd6_y = -(sin_q6*vd5_x + cos_q6*vd5_z)

    # Forward recursion: velocities, accelerations, wrenches, joint 7 (cart_x) [1], [3], [6], [12].
    vd7_ya = 2.0*w6_z
    vd7_z = -(q7*ww6_zz + vd6_y)
    vd7_y = -(qd7*vd7_ya + vd6_x)

    # Forward recursion: velocities, accelerations, wrenches, joint 8 (cart_y) [1], [3], [6], [12].
    vd8_z = -(q8*ww6_zz + vd7_y)
    vd8_x = vd7_z - qd8*vd7_ya
    Fb8_1 = 210.0*vd8_x - 4.2*ww6_zz
    Fb8_3 = 210.0*vd8_z - 63.0*ww6_zz
    Fb8_5 = 63.0*vd8_x - 4.2*vd8_z

    # Forward recursion: velocities, accelerations, wrenches, joint 9 (motor_y) [1], [3], [6], [12].
    vd9_z = vd8_z - q9*ww6_zz
    vd9_x = vd8_x - qd9*vd7_ya

    # Forward recursion: velocities, accelerations, wrenches, joint 10 (y_chain_1) [1], [3], [6], [12].
    vd10_z = vd9_z - q10*ww6_zz
    vd10_x = vd9_x - qd10*vd7_ya
    Fb10_1 = 8.0*vd10_x
    Fb10_3 = 8.0*vd10_z

    # Forward recursion: velocities, accelerations, wrenches, joint 11 (ram) [1], [3], [6], [12].
    vd11_z = vd10_z - q11*ww6_zz
    vd11_x = vd10_x - qd11*vd7_ya
    Fb11_1 = 95.0*vd11_x
    Fb11_3 = 14.25*ww6_zz + 95.0*vd11_z
    Fb11_5 = -14.25*vd11_x

    # Forward recursion: velocities, accelerations, wrenches, joint 13 (sensor_head) [1], [3], [6], [12].
    vd13_z = vd5_z - q13*ww1_zz
    vd13_x = qd13*vd2_ya - (D13*ww1_zz - vd5_x)
    Fb13_1 = 0.6*vd13_x
    Fb13_3 = 0.6*vd13_z

    # Backward recursion: articulated inertias and wrenches, joint 10 (y_chain_1) [15].
    f10_5 = Fb11_5 + q11*Fb11_1
    f10_1 = Fb10_1 + Fb11_1
    f10_3 = Fb10_3 + Fb11_3

    # Backward recursion: articulated inertias and wrenches, joint 9 (motor_y) [15].
    f9_5 = f10_5 + q10*f10_1

    # Backward recursion: articulated inertias and wrenches, joint 8 (cart_y) [15].
    f8_1 = Fb8_1 + f10_1
    f8_3 = Fb8_3 + f10_3
    f8_5 = Fb8_5 + f9_5 + q9*f10_1

    # Backward recursion: articulated inertias and wrenches, joint 7 (cart_x) [15].
    f7_4 = -(f8_5 + q8*f8_1)

    # Backward recursion: articulated inertias and wrenches, joint 6 (cart_yaw) [15].
    f6_6 = f7_4 + q7*f8_3

    # Backward recursion: articulated inertias and wrenches, joint 5 (motor_x) [15].
    f5_1 = Fb5_1 + Fb13_1 + cos_q6*f8_3 + sin_q6*f8_1
    f5_3 = Fb5_3 + Fb13_3 + cos_q6*f8_1 - sin_q6*f8_3
    f5_5 = q13*Fb13_1 - D13*Fb13_3 + f6_6

    # Backward recursion: articulated inertias and wrenches, joint 4 (motor_secondary) [15].
    f4_5 = f5_5 + q5*f5_1
    f4_1 = Fb4_1 + f5_1
    f4_3 = Fb4_3 + f5_3

    # Backward recursion: articulated inertias and wrenches, joint 3 (bed_x) [15].
    f3_1 = Fb3_1 + f4_1
    f3_3 = Fb3_3 + f4_3
    f3_5 = Fb3_5 + f4_5 + q4*f4_1 - D4*f4_3

    # Backward recursion: articulated inertias and wrenches, joint 2 (bed_y) [15].
    f2_4 = f3_5 + q3*f3_1

    # Backward recursion: articulated inertias and wrenches, joint 1 (bed_yaw) [15].
    f1_6 = f2_4 - q2*f3_3

    # Results.
    return (
        (f1_6, f3_1, f3_3, f4_3, f5_3, f6_6, f8_1, f8_3, f10_3, f10_3, Fb11_3, Fb13_3),
    )


model = _run.Model(
    constants,
    program,
    arguments=dict(q=12, qd=12),
    parameters=4,
    results=((12,),),
)
