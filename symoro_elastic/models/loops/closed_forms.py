"""Closed forms of the loops of a bound machine: expressions of dependent variables."""

from __future__ import annotations

import math
import random
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from symoro_elastic.foundation.scalar import Scalar, quotient
from symoro_elastic.machine.loops import Closing, Loop, branches
from symoro_elastic.mechanics.inverse_geometry.equation_types import Functions, NoClosedForm
from symoro_elastic.mechanics.loops.circuit import Circuit, circuit
from symoro_elastic.mechanics.loops.constant_maps import coaxial, parallelogram
from symoro_elastic.mechanics.loops.in_space import closed_in_space
from symoro_elastic.mechanics.loops.planar import Closed, Complex, close_circuit
from symoro_elastic.mechanics.spatial import Axis
from symoro_elastic.models.loops.assembly import SEED, Assembly, Position, cut_joint, loop_branches
from symoro_elastic.models.tree.modular import zero_test
from symoro_elastic.models.tree.tree import Tree
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from symoro_elastic.symbolic.expression import is_constant
from symoro_elastic.symbolic.functions import QUARTERS, arc_tangent, square_root
from symoro_elastic.symbolic.tape import Tape

Angles = dict[int, Scalar]
AGREEING = 1e-7
PARALLEL = 1e-12
"""Cosine or sine of the angle between axes that are at right angles, or parallel."""


def loop_circuit(tree: Tree, loop: Loop, unknown: Sequence[int]) -> Circuit:
    """The circuit of a loop with the joints `unknown` as unknowns."""
    rows = branches(tree.machine.antecedents, loop)
    return circuit(tree.mechanism, rows, cut_joint(tree.machine, loop), unknown)


def parallelogram_angles(
    tree: Tree, loop: Loop, dependent: Sequence[int], other: Collection[int] = ()
) -> Angles | None:
    """Angles of the dependent joints of a parallelogram, or of turns about one axis; None where a loop is neither.

    `other` are joints whose angles are not sums of independent ones.
    """
    moving = tree.machine.around(loop)
    angles = {j: tree.angle(j) for j in moving if j not in other}

    def angle_of(turn: Complex) -> Scalar:
        if turn not in QUARTERS:
            return arc_tangent(tree.graph, turn.y, turn.x)
        return ((QUARTERS.index(turn) + 1) % 4 - 1) * (tree.graph.pi / 2)

    around, unknown = loop_circuit(tree, loop, moving), {0, *dependent}
    solution = parallelogram(around, unknown, angles, angle_of) or coaxial(around, unknown, angles, angle_of)
    return None if solution is None else {j: x for j, x in solution.items() if j}


def is_planar(assembly: Assembly, loop: Loop) -> bool:
    """Whether all turns of a loop are about one direction, and all its slides across it, in any position."""
    view = loop_branches(assembly.tree, loop)
    axes = [(link.axis, view.seen.frames[k].z) for k, link in view.mechanism.from_base() if link.axis is not Axis.NONE]
    if view.cut.axis is not Axis.NONE:
        axes.append((view.cut.axis, view.seen.frames[view.number[view.cut.m]].z))
    source = random.Random(SEED)
    anywhere = assembly.symbols({j: source.uniform(-3, 3) for j in assembly.machine.with_variable})
    value = evaluate([x for _, z in axes for x in z], anywhere, FLOATS)
    numbers = [(axis, np.array([value(x) for x in z])) for axis, z in axes]
    turning = [z for axis, z in numbers if axis is Axis.REVOLUTE]
    if not turning:
        return False
    normal = turning[0]
    return all(
        np.linalg.norm(np.cross(normal, z)) < PARALLEL if axis is Axis.REVOLUTE else abs(normal @ z) < PARALLEL
        for axis, z in numbers
    )


def planar(tree: Tree, loop: Loop, dependent: Sequence[int], signs: Mapping[int, int]) -> Closed:
    """Closed form of the unknown joints of a planar loop on a branch."""
    return close_circuit(loop_circuit(tree, loop, dependent), lambda x: square_root(tree.graph, x), signs)


def in_space(
    tree: Tree, loop: Loop, dependent: Sequence[int], assembly: Assembly, positions: Sequence[Position]
) -> Closed | None:
    """Closed form of the unknown joints of a spatial loop by inverse geometry, on the branch of assembled positions.

    None where there is none, or two that coincide at these positions. Which solution it is depends on which parameters
    are numbers, so it is looked for each time.
    """
    at_point = loop.closes is Closing.POINT
    try:
        solutions = closed_in_space(_functions(tree), loop_circuit(tree, loop, dependent), at_point)
    except (NoClosedForm, ZeroDivisionError):  # an angle of no point is not determined
        return None
    forms = [x for x in solutions if agreeing_joints(tree, assembly, dependent, x, positions) == [*dependent]]
    return forms[0] if len(forms) == 1 else None


def agreeing_joints(
    tree: Tree, assembly: Assembly, dependent: Sequence[int], closed_form: Closed, positions: Sequence[Position]
) -> list[int]:
    """Dependent joints whose closed forms agree with the assembled positions."""
    forms = {**closed_form.turns, **closed_form.slides}
    return [j for j in dependent if agrees(tree, assembly, j, forms[j], positions)]


def _functions(tree: Tree) -> Functions:
    """Functions of expressions for inverse geometry; unreachable positions have no value."""

    def turn(x: Scalar, y: Scalar, distance: Scalar) -> tuple[Scalar, Scalar, Scalar]:
        inverse = quotient(1, distance)
        return arc_tangent(tree.graph, y, x), x * inverse, y * inverse

    return Functions(lambda x: square_root(tree.graph, x), turn, lambda _: 1, zero_test(SEED), is_constant)


def own_variable(tree: Tree, joint: int, turn: Complex, half_turns: int) -> Scalar:
    """The coordinate of a joint from its cosine and sine, within half a turn of `half_turns` half turns."""
    x, y = (-turn.x, -turn.y) if half_turns % 2 else turn
    angle = arc_tangent(tree.graph, y, x) + half_turns * tree.graph.pi
    return angle - tree.offset(joint)


def agrees(tree: Tree, assembly: Assembly, joint: int, form: Complex | Scalar, positions: Sequence[Position]) -> bool:
    """Whether a closed form of a joint, as cosine and sine or as position, gives the assembled positions."""
    tape = Tape([tree.offset(joint), *(form if isinstance(form, Complex) else [form])], FLOATS)
    for position in positions:
        try:
            offset, *numbers = tape.values(assembly.symbols(position))
        except (ArithmeticError, ValueError):
            return False
        expected = offset + position[joint]
        if isinstance(form, Complex):
            errors = [numbers[0] - math.cos(expected), numbers[1] - math.sin(expected)]
        else:
            turns = tree.machine.joint(joint).sigma == 0
            errors = [math.remainder(numbers[0] - expected, 2 * math.pi) if turns else numbers[0] - expected]
        if not all(abs(error) < AGREEING for error in errors):
            return False
    return True
