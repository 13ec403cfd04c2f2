"""Placement of frames of two_axis [1], [2]: 32x 28+, 4 sin/cos a call.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _run


def constants(_f, p):
    (D4, D12, L12, D13) = p
    return (D4, D12, L12, D13)


def program(_f, q, c):
    (q1, q2, q3, q4, q5, q6, q7, q8, q9, q10, q11, q13) = q
    (D4, D12, L12, D13) = c

    # Geometry, joint 1 (bed_yaw) [1], [2].
    sin_q1 = _f.sin(q1)
    cos_q1 = _f.cos(q1)

    # Geometry, joint 2 (bed_y) [1], [2].
    P2_x = -q2*sin_q1
    P2_y = q2*cos_q1

    # Geometry, joint 3 (bed_x) [1], [2].
    P3_x = P2_x + q3*cos_q1
    P3_y = P2_y + q3*sin_q1

    # Geometry, joint 4 (motor_secondary) [1], [2].
    P4_x = q4*cos_q1 - (D4*sin_q1 - P3_x)
    P4_y = P3_y + D4*cos_q1 + q4*sin_q1

    # Geometry, joint 5 (motor_x) [1], [2].
    P5_x = P4_x + q5*cos_q1
    P5_y = P4_y + q5*sin_q1

    # Geometry, joint 6 (cart_yaw) [1], [2].
    sin_q6 = _f.sin(q6)
    cos_q6 = _f.cos(q6)
    A6_11 = -(sin_q1*cos_q6 + cos_q1*sin_q6)
    A6_12 = sin_q1*sin_q6 - cos_q1*cos_q6

    # Geometry, joint 7 (cart_x) [1], [2].
    P7_x = P5_x - q7*A6_12
    P7_y = P5_y - q7*A6_11

    # Geometry, joint 8 (cart_y) [1], [2].
    P8_x = P7_x + q8*A6_11
    P8_y = P7_y - q8*A6_12

    # Geometry, joint 9 (motor_y) [1], [2].
    P9_x = P8_x + q9*A6_11
    P9_y = P8_y - q9*A6_12

    # Geometry, joint 10 (y_chain_1) [1], [2].
    P10_x = P9_x + q10*A6_11
    P10_y = P9_y - q10*A6_12

    # Geometry, joint 11 (ram) [1], [2].
    P11_x = P10_x + q11*A6_11
    P11_y = P10_y - q11*A6_12

    # Geometry, joint 12 (tool) [1], [2].
    P12_x = L12*A6_11 - (D12*A6_12 - P11_x)
    P12_y = P11_y - D12*A6_11 - L12*A6_12

    # Geometry, joint 13 (sensor_head) [1], [2].
    P13_x = q13*cos_q1 - (D13*sin_q1 - P5_x)
    P13_y = P5_y + D13*cos_q1 + q13*sin_q1

    # Results.
    return (
        (
            cos_q1, -sin_q1, 0.0, 0.0, sin_q1, cos_q1, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0,
            1.0, 0.0, cos_q1, -sin_q1, P2_x, 0.0, sin_q1, cos_q1, P2_y, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0,
            0.0, 1.0, -sin_q1, 0.0, cos_q1, P3_x, cos_q1, 0.0, sin_q1, P3_y, 0.0, 1.0, 0.0, 0.0, 0.0,
            0.0, 0.0, 1.0, -sin_q1, 0.0, cos_q1, P4_x, cos_q1, 0.0, sin_q1, P4_y, 0.0, 1.0, 0.0, 0.0,
            0.0, 0.0, 0.0, 1.0, -sin_q1, 0.0, cos_q1, P5_x, cos_q1, 0.0, sin_q1, P5_y, 0.0, 1.0, 0.0,
            0.0, 0.0, 0.0, 0.0, 1.0, A6_11, A6_12, 0.0, P5_x, -A6_12, A6_11, 0.0, P5_y, 0.0, 0.0, 1.0,
            0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -A6_11, -A6_12, P7_x, 0.0, A6_12, -A6_11, P7_y, 1.0, 0.0,
            0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -A6_12, 0.0, A6_11, P8_x, -A6_11, 0.0, -A6_12, P8_y, 0.0,
            -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -A6_12, 0.0, A6_11, P9_x, -A6_11, 0.0, -A6_12, P9_y,
            0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -A6_12, 0.0, A6_11, P10_x, -A6_11, 0.0, -A6_12,
            P10_y, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -A6_12, 0.0, A6_11, P11_x, -A6_11, 0.0,
            -A6_12, P11_y, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -A6_12, 0.0, A6_11, P12_x, -A6_11,
            0.0, -A6_12, P12_y, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, -sin_q1, 0.0, cos_q1, P13_x,
            cos_q1, 0.0, sin_q1, P13_y, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0,
        ),
    )


model = _run.Model(
    constants,
    program,
    arguments=dict(q=12),
    parameters=4,
    results=((13, 4, 4),),
)
