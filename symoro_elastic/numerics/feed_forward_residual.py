"""Residual of the feed-forward in the equations of motion, in many digits.

The program is evaluated at y(t) with its rate, which gives q(t), its velocity and acceleration; A and H [8] then give
the torques. The springs' law, and the sum of motor and springs being y, are checked apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from symoro_elastic.machine.machine import Kind
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.catalogue import TracedModel
from symoro_elastic.models.load_coordinates import chains, load_positions
from symoro_elastic.numerics.linear_systems import Numbers, distance, dot
from symoro_elastic.numerics.reference import StateReference
from symoro_elastic.quantities import HIGHEST_DERIVATIVE, MOTION
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.duals import Dual, differentiating


@dataclass(frozen=True)
class FeedForwardMotion:
    """q, qd, qdd of all joints on a reference trajectory, and the forces A qdd + H."""

    q: Numbers
    qd: Numbers
    qdd: Numbers
    forces: Numbers


def feed_forward_motion(point: StateReference, traced: TracedModel) -> FeedForwardMotion:
    """Return the motion of a feed-forward, differentiated by time, and its forces."""
    symbols: dict[str, Any] = dict(point.names)
    for argument in traced.program.inputs:
        rate = min(len(argument.name), HIGHEST_DERIVATIVE)  # of the highest derivative, any
        rates = point.numbers(MOTION[rate].name)
        symbols |= zip(argument.symbols, map(Dual, point.numbers(argument.name), rates), strict=True)
    outputs = {o.name: o.entries for o in traced.program.outputs}
    value = evaluate((*outputs["q"], *outputs["qd"]), symbols, differentiating(point.arithmetic))
    q, qd = ([value(x) for x in outputs[name]] for name in ("q", "qd"))
    place, velocity, acceleration = [_value(x) for x in q], [_slope(x) for x in q], [_slope(x) for x in qd]
    A = point.run(point.reference.inertia, {"q": place})["A"]
    H = point.run(point.reference.bias, {"q": place, "qd": velocity})["H"]
    n = len(place)
    rows = [A[row * n : (row + 1) * n] for row in range(n)]
    return FeedForwardMotion(
        place, velocity, acceleration, [dot(row, acceleration) + h for row, h in zip(rows, H, strict=True)]
    )


def torques(point: StateReference, traced: TracedModel) -> dict[str, Numbers]:
    """Return results of a feed-forward: velocities from q by time, torques from the equations of motion."""
    motion, machine = feed_forward_motion(point, traced), point.reference.machine
    by_joint = {name: dict(zip(machine.moving, x, strict=True)) for name, x in _named(motion).items()}
    return {name: [by_joint[name][j] for j in rows] for name, rows in traced.rows.items()}


def residual(point: StateReference, traced: TracedModel) -> float:
    """Return the relative residual of the springs' law, and of the sum of motor and springs being y."""
    motion, machine = feed_forward_motion(point, traced), point.reference.machine
    joints = machine.moving_joints
    springs = [
        -point.cell(joint.spring.stiffness) * (q - point.cell(joint.spring.neutral))
        for joint, q in zip(joints, motion.q, strict=True)
        if joint.kind is Kind.ELASTIC
    ]
    exerted = [x for joint, x in zip(joints, motion.forces, strict=True) if joint.kind is Kind.ELASTIC]
    q = dict(zip(machine.moving, motion.q, strict=True))
    bound = Bound(machine)
    positions = load_positions(bound, chains(bound))
    symbols = point.names | machine.by_variable(q)
    value = evaluate(positions.values(), symbols, point.arithmetic)
    sums = [value(positions[j]) for j in machine.motors]
    scale = max(map(abs, motion.forces), default=0) or 1
    bent = max((abs(x - y) / scale for x, y in zip(springs, exerted, strict=True)), default=0)
    return max(float(bent), distance(sums, point.numbers("y")))


def _named(motion: FeedForwardMotion) -> dict[str, Numbers]:
    return {"tau": motion.forces, "q": motion.q, "qd": motion.qd}


def _value(x: Any) -> Any:
    return x.value if x.__class__ is Dual else x


def _slope(x: Any) -> Any:
    return x.tangent if x.__class__ is Dual else x * 0
