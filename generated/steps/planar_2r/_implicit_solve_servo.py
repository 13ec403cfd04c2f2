"""Solution z of (I - g T) z = r, by the factors of planar_2r [28]-[36]: 15x 10+, 0 sin/cos a call.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 786373309  # of the files of this package: those of another run are not imported


def constants(_f, p):
    (_, _, _, l1, _, _, _, _, _) = p
    return (l1,)


def program(_f, factors, r_q, r_v, c):
    (cos_q2, gh0, gK1, gK2, Sg1, Sg2, Hinv2, UH2_6, UH2_2, handed9, H1) = factors
    (rhq1, rhq2) = r_q
    (rhv1, rhv2) = r_v
    (l1,) = c

    # Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [28]-[32].
    Gamma2 = rhv2*Sg2 + rhq2*gK2
    qdf2 = Hinv2*Gamma2
    al2_6 = UH2_6*Gamma2
    al2_2 = handed9*qdf2

    # Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [28]-[32].
    Gamma1 = rhv1*Sg1 + rhq1*gK1
    bs1_6 = -(al2_6 + l1*al2_2)
    Gb1 = Gamma1 + bs1_6
    qdf1 = Gb1/H1

    # Forward recursion: accelerations and torques, joint 2 (elbow) [33]-[36].
    vd2_y = cos_q2*(l1*qdf1)
    qdd2 = qdf2 - UH2_2*vd2_y - UH2_6*qdf1

    # Results
    result_a = rhv1 - qdf1
    result_b = rhv2 - qdd2

    # Results.
    return (
        (rhq1 + gh0*result_a, rhq2 + gh0*result_b),
        (result_a, result_b),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(factors=11, r_q=2, r_v=2),
    parameters=9,
    results=((2,), (2,)),
)
