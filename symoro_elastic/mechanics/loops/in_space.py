"""Closed forms of loops in space, by inverse geometry: the chain of unknown joints leads back to where it begins.

J1 S1 ... Jn Sn = 1 with segments S that are known; where a ball is cut, only its centre comes back. Joints that the
circuit passes against their sense make the inverse motion.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from symoro_elastic.mechanics.inverse_geometry.decompositions import Chain
from symoro_elastic.mechanics.inverse_geometry.equation_types import STILL, Functions, NoClosedForm, Pose
from symoro_elastic.mechanics.inverse_geometry.points import Mover, Solution, reach
from symoro_elastic.mechanics.inverse_geometry.serial_chain import solutions
from symoro_elastic.mechanics.loops.circuit import CUT, Circuit, Segment
from symoro_elastic.mechanics.loops.planar import Closed, Complex
from symoro_elastic.mechanics.spatial import Axis, Matrix, Scalar, Vector


def closed_in_space(f: Functions, loop: Circuit, at_point: bool) -> list[Closed]:
    """Return the unknown joints of a loop in every position that closes it (L9). Raises `NoClosedForm`."""
    if not at_point:
        return [_closed_form(loop, solution, {}) for solution in _to_frame(f, loop)]
    loop = loop.from_joint(next(k for k, joint in enumerate(loop.unknown) if joint.joint == CUT))
    ball = _pose(f, loop.segments[0]).inverse().origin
    sides = {joint.joint: ball for joint in loop.unknown[1:2]}
    return [_closed_form(loop, solution, sides) for solution in _to_ball(f, loop, ball)]


def _closed_form(loop: Circuit, solution: Solution, sides: Mapping[int, Vector]) -> Closed:
    passed = {joint.joint: joint for joint in loop.unknown}
    turns, slides = dict[int, Complex](), dict[int, Scalar]()
    for joint, _, motion, _ in solution:
        if passed[joint].axis is Axis.REVOLUTE:
            turns[joint] = Complex(motion.cosine, passed[joint].sense * motion.sine)
        else:
            slides[joint] = passed[joint].sense * motion.shift
    return Closed(turns, slides, sides, {joint.joint: joint.measure for joint in solution})


def _to_ball(f: Functions, loop: Circuit, ball: Vector) -> list[Solution]:
    """Solve J1 S1 ... Jn p = P for the joints; P is the ball centre from the first joint, p from the last."""
    *between, last = (_pose(f, segment) for segment in loop.segments[1:])
    return reach(f, _movers(loop)[1:], between, last.origin, ball)


def _to_frame(f: Functions, loop: Circuit) -> list[Solution]:
    """Solve J1 S1 ... Jn = Sn^-1 for the joints, from the first joint at which a closed form can start."""
    movers, poses = _movers(loop), [_pose(f, segment) for segment in loop.segments]
    errors: list[NoClosedForm] = []
    for k in range(len(movers)):
        *between, last = poses[k:] + poses[:k]
        chain = Chain(movers[k:] + movers[:k], (STILL, *between, STILL))
        try:
            return solutions(f, chain, last.inverse())
        except NoClosedForm as error:
            errors.append(error)
    raise errors[0]


def _movers(loop: Circuit) -> tuple[Mover, ...]:
    return tuple(Mover(joint.joint, joint.axis) for joint in loop.unknown)


def _pose(f: Functions, segment: Segment) -> Pose:
    """The displacement along a segment, its numbers exact."""

    def exact(x: Scalar) -> Scalar:
        number = 0 if f.is_zero(x) else x
        return Fraction(number) if isinstance(number, int) else number

    rotation, origin = segment.frame
    return Pose(Matrix(*(Vector(*map(exact, row)) for row in rotation)), Vector(*map(exact, origin)))
