"""Factors of the linear system of an implicit step of planar_2r [28]-[32]: 0x 0+, 0 sin/cos a call.

Equation numbers are those of Khalil and Gautier. `_f` gives sin, cos, sqrt, sign and atan2, so
the same lines serve plain floats and stacks of states.
"""

from . import _runtime

_DIGEST = 786373309  # of the files of this package: those of another run are not imported


def constants(_f, p):
    return ()


def program(_f, q, qd, g, c):
    (gh0,) = g

    # Results.
    return (
        (gh0,),
    )


model = _runtime.Model(
    constants,
    program,
    arguments=dict(q=2, qd=2, g=1),
    parameters=9,
    results=((1,),),
)
