"""Inertia matrix of two_axis [8]: 51x 64+, 2 sin/cos a call; 3x 0+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _run


def constants(_f, p):
    (D4, _, _, D13) = p

    # Composite inertias and inertia matrix, joint 13 (sensor_head) [8], [13].
    A1_13a = 0.6*D13

    # Composite inertias and inertia matrix, joint 5 (motor_x) [8], [13].
    J5_cyyb = D13*A1_13a

    # Composite inertias and inertia matrix, joint 4 (motor_secondary) [8], [13].
    A1_4a = 448.6*D4
    return (D4, A1_13a, J5_cyyb, A1_4a)


def program(_f, q, c):
    (_, q2, q3, q4, q5, q6, q7, q8, q9, q10, q11, q13) = q
    (D4, A1_13a, J5_cyyb, A1_4a) = c

    # Geometry, joint 6 (cart_yaw) [1].
    sin_q6 = _f.sin(q6)
    cos_q6 = _f.cos(q6)

    # Composite inertias and inertia matrix, joint 13 (sensor_head) [8], [13].
    A1_13b = D4 + q2
    A1_13 = -(A1_13a + 0.6*A1_13b)

    # Composite inertias and inertia matrix, joint 11 (ram) [8], [13].
    A6_11 = 95.0*q7
    A2_11 = 95.0*cos_q6
    A3_11 = -95.0*sin_q6
    A1_11a = q3 + q4 + q5
    A1_11 = A6_11 - D4*A3_11 - q2*A3_11 + A2_11*A1_11a

    # Composite inertias and inertia matrix, joint 10 (y_chain_1) [8], [13].
    MS10_c_za = 95.0*q11
    MS10_c_z = MS10_c_za - 14.25
    J10_cyy = q11*(MS10_c_za - 28.5) + 9.2375
    A6_10 = 103.0*q7
    A2_10 = 103.0*cos_q6
    A3_10 = -103.0*sin_q6
    A1_10 = A6_10 - D4*A3_10 - q2*A3_10 + A2_10*A1_11a

    # Composite inertias and inertia matrix, joint 9 (motor_y) [8], [13].
    MS9_c_z = MS10_c_z + 103.0*q10
    J9_cyy = J10_cyy + q10*(MS10_c_z + MS9_c_z)

    # Composite inertias and inertia matrix, joint 8 (cart_y) [8], [13].
    J8_cyya = MS9_c_z + 103.0*q9
    J8_cyy = J9_cyy + q9*(MS9_c_z + J8_cyya) + 34.984
    MS8_c_z = J8_cyya + 63.0
    A6_8a = 313.0*q7
    A6_8 = A6_8a + 4.2
    A2_8 = 313.0*cos_q6
    A3_8 = -313.0*sin_q6
    A1_8 = A6_8 - D4*A3_8 - q2*A3_8 + A2_8*A1_11a

    # Composite inertias and inertia matrix, joint 7 (cart_x) [8], [13].
    MS7_c_y = -(MS8_c_z + 313.0*q8)
    J7_cxx = J8_cyy + q8*(MS8_c_z - MS7_c_y)
    A1_7 = -(q2*A2_8 + D4*A2_8 - MS7_c_y + A3_8*A1_11a)

    # Composite inertias and inertia matrix, joint 6 (cart_yaw) [8], [13].
    J6_czz = J7_cxx + q7*(A6_8a + 8.4)
    A3_6 = cos_q6*MS7_c_y - sin_q6*A6_8
    A2_6 = sin_q6*MS7_c_y + cos_q6*A6_8
    A1_6 = J6_czz - D4*A3_6 - q2*A3_6 + A2_6*A1_11a

    # Composite inertias and inertia matrix, joint 5 (motor_x) [8], [13].
    J5_cyya = 0.6*q13
    J5_cyy = q13*J5_cyya + 0.001 + J5_cyyb + 3.0 + J6_czz
    MS5_c_x = A1_13a - A3_6
    MS5_c_z = J5_cyya + A2_6
    A1_5 = -(MS5_c_x + 358.6*A1_13b)

    # Composite inertias and inertia matrix, joint 4 (motor_secondary) [8], [13].
    MS4_c_z = MS5_c_z + 358.6*q5
    J4_cyy = J5_cyy + q5*(MS5_c_z + MS4_c_z) + 12.0
    A1_4b = MS5_c_x + A1_4a
    A1_4 = -(A1_4b + 448.6*q2)

    # Composite inertias and inertia matrix, joint 3 (bed_x) [8], [13].
    MS3_c_z = MS4_c_z + 448.6*q4
    J3_cyy = J4_cyy + q4*(MS4_c_z + MS3_c_z) + D4*(MS5_c_x + A1_4b) + 1200.0
    MS3_c_x = A1_4b - 500.0
    A1_3 = -(MS3_c_x + 2948.6*q2)

    # Composite inertias and inertia matrix, joint 2 (bed_y) [8], [13].
    MS2_c_y = MS3_c_z + 2948.6*q3
    J2_cxx = J3_cyy + q3*(MS3_c_z + MS2_c_y)

    # Composite inertias and inertia matrix, joint 1 (bed_yaw) [8], [13].
    J1_czz = J2_cxx + q2*(MS3_c_x - A1_3)

    # Results.
    return (
        (
            J1_czz, MS2_c_y, A1_3, A1_4, A1_5, A1_6, A1_7, A1_8, A1_10, A1_10, A1_11, A1_13, MS2_c_y,
            2948.6, 0.0, 0.0, 0.0, A2_6, -A3_8, A2_8, A2_10, A2_10, A2_11, 0.0, A1_3, 0.0, 2948.6,
            448.6, 358.6, A3_6, A2_8, A3_8, A3_10, A3_10, A3_11, 0.6, A1_4, 0.0, 448.6, 448.6, 358.6,
            A3_6, A2_8, A3_8, A3_10, A3_10, A3_11, 0.6, A1_5, 0.0, 358.6, 358.6, 358.6, A3_6, A2_8,
            A3_8, A3_10, A3_10, A3_11, 0.6, A1_6, A2_6, A3_6, A3_6, A3_6, J6_czz, MS7_c_y, A6_8, A6_10,
            A6_10, A6_11, 0.0, A1_7, -A3_8, A2_8, A2_8, A2_8, MS7_c_y, 313.0, 0.0, 0.0, 0.0, 0.0, 0.0,
            A1_8, A2_8, A3_8, A3_8, A3_8, A6_8, 0.0, 313.0, 103.0, 103.0, 95.0, 0.0, A1_10, A2_10,
            A3_10, A3_10, A3_10, A6_10, 0.0, 103.0, 283.0, 103.0, 95.0, 0.0, A1_10, A2_10, A3_10,
            A3_10, A3_10, A6_10, 0.0, 103.0, 103.0, 103.0, 95.0, 0.0, A1_11, A2_11, A3_11, A3_11,
            A3_11, A6_11, 0.0, 95.0, 95.0, 95.0, 95.0, 0.0, A1_13, 0.0, 0.6, 0.6, 0.6, 0.0, 0.0, 0.0,
            0.0, 0.0, 0.0, 0.6,
        ),
    )


model = _run.Model(
    constants,
    program,
    arguments=dict(q=12),
    parameters=4,
    results=((12, 12),),
)
