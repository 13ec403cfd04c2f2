"""Names of the quantities of the feed-forward: `rate_2_f3_6` is f3_6 twice derived by time, over 2!."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import factorial

from symoro_elastic.models.bind import Bound
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.expression import Expression
from symoro_elastic.symbolic.operations import COS, NEGATE, SIN, SYMBOL
from symoro_elastic.symbolic.program import Label, Section
from symoro_elastic.symbolic.time_series import TimeSeries

RATE = "rate_"
MOTION = "Deflections of springs, motion of motors"


def name_series(bound: Bound, series: TimeSeries) -> None:
    """Name the coefficients in time of what has a name."""
    for number, (label, negative) in list(bound.names.labels.items()):
        coefficients = series.found.get(number, ())
        name = _angle_name(bound, coefficients[0], label) or label.name if coefficients else ""
        for k, x in enumerate(coefficients):
            bound.names.give(-x if negative else x, f"{RATE}{k}_{name}" if k else name, label.section)


def _angle_name(bound: Bound, x: Scalar, label: Label) -> str:
    """`sin_y3_0` for the sine of a wanted angle, `sin_y3_motor` for that of a motor; else empty."""
    node = x.operands[0] if isinstance(x, Expression) and x.operation == NEGATE else x
    if not isinstance(node, Expression) or node.operation not in (SIN, COS):
        return ""
    angle, j = node.operands[0], label.section.joint
    if isinstance(angle, Expression) and angle.operation == SYMBOL:
        return f"{node.operation}_{angle.operands[0]}"
    return f"{node.operation}_y{j}_motor" if j in bound.motors else ""


def name_coordinates(bound: Bound, coordinates: Mapping[int, Sequence[Scalar]], wanted: Mapping[int, int]) -> None:
    """Name coefficients in time of z_j, z'_j and z''_j; `wanted` tells of which motor z_j is the wanted motion."""
    for j, coefficients in coordinates.items():
        motor = (f"y{j}_motor", f"qd{j}", f"qdd{j}") if j in bound.motors else (f"y{j}_link",)
        outboard = [f"y{wanted[j]}_{rate}" for rate in range(3)] if j in wanted else ()
        for rate, name in enumerate(outboard or motor):
            for k, x in enumerate(coefficients[rate:]):
                scaled = x * (factorial(k + rate) // factorial(k))
                bound.names.give(scaled, f"{RATE}{k}_{name}" if k else name, Section(MOTION, j, "[9]"))


def name_results(bound: Bound, q: Mapping[int, Sequence[Scalar]], tau: Mapping[int, Scalar]) -> None:
    """Name the compliance of springs, the variable and the velocity of each joint, and torques."""
    for j, (variable, velocity, *_) in q.items():
        here = Section(MOTION, j, "[9]")
        if j not in tau:
            bound.names.give(1 / bound.cell(bound.machine.joint(j).spring.stiffness), f"y{j}_compliance", here)
        bound.names.give(variable, f"y{j}_{'motor' if j in tau else 'spring'}", here)
        bound.names.give(velocity, f"qd{j}", here)
    for j, torque in tau.items():
        bound.names.give(torque, f"tau{j}", Section("Motor torques", j, "[61]"))
