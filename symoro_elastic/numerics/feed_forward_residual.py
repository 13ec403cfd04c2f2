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
    """q, qd, qdd of all joints on a reference trajectory, and the forces A qdd + H less those of springs."""

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
    springs = _springs(point, place, velocity)
    forces = [dot(row, acceleration) + h - x for row, h, x in zip(rows, H, springs, strict=True)]
    return FeedForwardMotion(place, velocity, acceleration, forces)


def _springs(point: StateReference, q: Numbers, qd: Numbers) -> Numbers:
    """Return what springs and dampers exert on the independent variables, changes of their stiffness included."""
    bound = _bound(point)
    passive, friction = bound.passive_forces(), bound.friction_forces()
    exerted = [passive[j] + friction[j] for j in bound.machine.moving]
    entries = bound.arguments()
    symbols = point.names | dict(zip((*entries["q"], *entries["qd"]), (*q, *qd), strict=True))
    return list(map(evaluate(exerted, symbols, point.arithmetic), exerted))


def torques(point: StateReference, traced: TracedModel) -> dict[str, Numbers]:
    """Return results of a feed-forward: velocities from q by time, torques from the equations of motion."""
    motion, machine = feed_forward_motion(point, traced), point.reference.machine
    by_joint = {name: dict(zip(machine.moving, x, strict=True)) for name, x in _named(motion).items()}
    return {name: [by_joint[name][j] for j in rows] for name, rows in traced.rows.items()}


def residual(point: StateReference, traced: TracedModel) -> float:
    """Return the relative residual of the springs' law, and of the sum of motor and springs being y.

    It is 0 where no deflection balances the load of a spring whose stiffness changes with positions: such a state is
    not judged.
    """
    try:
        return _residual(point, traced)
    except ZeroDivisionError:
        return 0.0


def _residual(point: StateReference, traced: TracedModel) -> float:
    motion, machine = feed_forward_motion(point, traced), point.reference.machine
    pairs = zip(machine.moving_joints, motion.forces, strict=True)
    unbalanced = [abs(x) for joint, x in pairs if joint.kind is Kind.ELASTIC]
    q = dict(zip(machine.moving, motion.q, strict=True))
    bound = _bound(point)
    positions = load_positions(bound, chains(bound))
    symbols = point.names | machine.by_variable(q)
    value = evaluate(positions.values(), symbols, point.arithmetic)
    sums = [value(positions[j]) for j in machine.motors]
    scale = max(map(abs, motion.forces), default=0) or 1
    return max(float(max(unbalanced, default=0) / scale), distance(sums, point.numbers("y")))


def _bound(point: StateReference) -> Bound:
    coupled = point.reference.coupled
    return coupled.bound if coupled else Bound(point.reference.machine)


def _named(motion: FeedForwardMotion) -> dict[str, Numbers]:
    return {"tau": motion.forces, "q": motion.q, "qd": motion.qd}


def _value(x: Any) -> Any:
    return x.value if x.__class__ is Dual else x


def _slope(x: Any) -> Any:
    return x.tangent if x.__class__ is Dual else x * 0
