"""Inverse dynamic model: motor torques and elastic accelerations of ball_screw [37]-[61]: 22x 21+, 0 sin/cos a call; 6x 0+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 367225390  # of the files of this package: those of another run are not imported


def constants(_f, p):
    (_, Rm, Rv, pitch, kp) = p

    # Backward recursion: articulated inertias and wrenches, joint 5 (screw) [50]-[56].
    Gamma5a = pitch/6.283185307179586

    # Backward recursion: articulated inertias and wrenches, joint 4 (screw_pulley) [50]-[56].
    Gamma4a = 2.0*kp*(Rv*Rv)

    # Backward recursion: articulated inertias and wrenches, joint 2 (motor_pulley) [50]-[56].
    Gamma2a = Rm/Rv
    Gamma2b = Gamma2a*Gamma5a
    return (Gamma5a, Gamma4a, Gamma2a, Gamma2b)


def program(_f, q, qd, qdd_motor, c):
    (_, d_shaft, d_axial, d_belt, d_torsion, d_nut, d_table, d_encoder) = q
    (qdd1,) = qdd_motor
    (Gamma5a, Gamma4a, Gamma2a, Gamma2b) = c

    # Forward recursion: velocities, accelerations, wrenches, joint 1 (motor) [1], [3], [6], [12].
    Fb1_6 = 0.0042*qdd1

    # Backward recursion: articulated inertias and wrenches, joint 8 (encoder) [50]-[56].
    Gamma8 = -40000000.0*d_encoder
    qdf8 = -100000000.0*d_encoder

    # Backward recursion: articulated inertias and wrenches, joint 7 (table) [50]-[56].
    Gamma7 = -400000000.0*d_table
    Gb7 = Gamma7 - Gamma8
    qdf7 = 0.0025*Gb7

    # Backward recursion: articulated inertias and wrenches, joint 6 (nut) [50]-[56].
    Gamma6 = -500000000.0*d_nut
    Gb6 = Gamma6 - Gamma7
    qdf6 = 0.2*Gb6

    # Backward recursion: articulated inertias and wrenches, joint 5 (screw) [50]-[56].
    Gamma5b = -Gamma5a*Gamma6
    Gamma5 = Gamma5b - 40200.0*d_torsion
    qdf5 = 562.5879043600563*Gamma5

    # Backward recursion: articulated inertias and wrenches, joint 4 (screw_pulley) [50]-[56].
    Gamma4 = Gamma5b - d_belt*Gamma4a
    Gb4 = Gamma4 - Gamma5
    qdf4 = 313.23414252153486*Gb4

    # Backward recursion: articulated inertias and wrenches, joint 3 (bearing) [50]-[56].
    Gamma3 = -(170000000.0*d_axial + Gamma6)
    qdf3 = 0.0847457627118644*Gamma3

    # Backward recursion: articulated inertias and wrenches, joint 2 (motor_pulley) [50]-[56].
    Gamma2c = -Gamma2a*Gamma4
    Gamma2d = -Gamma6*Gamma2b
    Gamma2 = Gamma2d - (45000.0*d_shaft - Gamma2c)
    qdf2 = 1111.111111111111*Gamma2

    # Backward recursion: articulated inertias and wrenches, joint 1 (motor) [50]-[56].
    f1_6 = Gamma2 + Fb1_6

    # Forward recursion: accelerations and torques, joint 2 (motor_pulley) [57]-[61].
    qdd2 = qdf2 - qdd1

    # Forward recursion: accelerations and torques, joint 5 (screw) [57]-[61].
    qdd5 = qdf5 - qdf4

    # Forward recursion: accelerations and torques, joint 7 (table) [57]-[61].
    qdd7 = qdf7 - qdf6

    # Forward recursion: accelerations and torques, joint 8 (encoder) [57]-[61].
    qdd8 = qdf8 - qdf7

    # Results
    result_a = qdd1 + qdd2
    result_b = qdf4 - Gamma2a*result_a

    # Results.
    return (
        (-(Gamma2c + Gamma2d - f1_6),),
        (
            qdd1, qdd2, qdf3, result_b, qdd5,
            -(Gamma5a*qdd5 + Gamma5a*result_b + qdf3 - qdf6 + Gamma2b*result_a), qdd7, qdd8,
        ),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=8, qd=8, qdd_motor=1),
    parameters=5,
    results=((1,), (8,)),
)
