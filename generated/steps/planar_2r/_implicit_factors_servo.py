"""Factors of the linear system of an implicit step of planar_2r [28]-[32]: 16x 11+, 2 sin/cos a call; 4x 2+, 0 sin/cos once for each parameter set.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 786373309  # of the files of this package: those of another run are not imported


def constants(_f, p):
    (_, m1, m2, l1, _, lc1, lc2, I1, I2) = p

    # Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14].
    MS1_x = m1*lc1
    J1_yy = I1 + lc1*MS1_x

    # Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14].
    MS2_x = m2*lc2
    J2_yy = I2 + lc2*MS2_x
    return (m2, l1, J1_yy, MS2_x, J2_yy)


def program(_f, q, qd, g, kp, kd, c):
    (_, q2) = q
    (gh0,) = g
    (kpm1, kpm2) = kp
    (kdm1, kdm2) = kd
    (m2, l1, J1_yy, MS2_x, J2_yy) = c

    # Implicit step: springs, dampers and servos as rotor inertias
    gK1 = gh0*kpm1
    gK2 = gh0*kpm2
    Sg1 = gh0*(kdm1 + gK1)
    Sg2 = gh0*(kdm2 + gK2)

    # Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14].
    sin_q2 = _f.sin(q2)
    cos_q2 = _f.cos(q2)

    # Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [28]-[32].
    H2 = J2_yy + Sg2
    Hinv2 = 1.0/H2
    rho2 = Sg2*Hinv2
    UH2_6 = J2_yy*Hinv2
    UH2_2 = MS2_x*Hinv2
    K2_66 = J2_yy*rho2
    K2_22a = m2 - MS2_x*UH2_2
    K2_22 = K2_22a + sin_q2*(sin_q2*(m2 - K2_22a))
    K2_35 = -cos_q2*MS2_x
    K2_26 = -rho2*K2_35

    # Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [28]-[32].
    Js1_66 = J1_yy + K2_66 + l1*(K2_26 + l1*K2_22 + K2_26)
    H1 = Sg1 + Js1_66

    # Results.
    return (
        (cos_q2, gh0, gK1, gK2, Sg1, Sg2, Hinv2, UH2_6, UH2_2, -K2_35, H1),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=2, qd=2, g=1, kp=2, kd=2),
    parameters=9,
    results=((11,),),
)
