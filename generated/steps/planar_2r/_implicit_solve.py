"""Solution z of (I - g T) z = r, by the factors of planar_2r [28]-[36]: 2x 2+, 0 sin/cos a call.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 786373309  # of the files of this package: those of another run are not imported


def constants(_f, p):
    return ()


def program(_f, factors, r_q, r_v, c):
    (gh0,) = factors
    (rhq1, rhq2) = r_q
    (rhv1, rhv2) = r_v

    # Results.
    return (
        (rhq1 + gh0*rhv1, rhq2 + gh0*rhv2),
        (rhv1, rhv2),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(factors=1, r_q=2, r_v=2),
    parameters=9,
    results=((2,), (2,)),
)
