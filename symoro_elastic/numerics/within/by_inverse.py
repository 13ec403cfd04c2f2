"""Direct models within a tolerance, proven: terms are left out of A and the right side; A qdd = right stays exact.

    1. Ranges of A and of the right side over the box, and from these the range Q of all accelerations.
    2. The residual A qdd - right may be wrong by as much as the tolerances of the accelerations allow (lemma 7).
    3. Terms of A and of the right side are left out of the residual within these errors, for all |qdd| <= Q, as
       `reduction` does it: what is proven of an inverse model is proven by polynomials.
    4. From the errors that are proven of it follow those of the accelerations, and how small pivots may be.

Entries of A stand once, so it stays symmetric; no matrix in its new range is singular, so it stays positive definite.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.limits import Range
from symoro_elastic.machine.within import Tolerance
from symoro_elastic.models.bound.model import Joints
from symoro_elastic.models.programs.forms import InertiaForm
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.guarantees.box import Box, Parts, cut
from symoro_elastic.numerics.guarantees.certificate import Knowledge
from symoro_elastic.numerics.guarantees.intervals import Interval, interval
from symoro_elastic.numerics.guarantees.inverse_on_cells import allowed_right_sides, largest_solutions, widened
from symoro_elastic.numerics.guarantees.largest_value import WORK, largest
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, running_errors
from symoro_elastic.numerics.within.reduction import reduce_program
from symoro_elastic.numerics.within.results import EntryError, ErrorBound, Reduction
from symoro_elastic.numerics.within.states import unseen
from symoro_elastic.numerics.within.tape import Tape, with_values
from symoro_elastic.numerics.within.trials import MANY, Task
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Expression, Operand, reachable
from symoro_elastic.symbolic.operations import NEGATE, SYMBOL
from symoro_elastic.symbolic.program import Program

DOUBLE = ROUNDINGS["double"]
MOST_SUB_BOXES, DRAWN = 64, 2000
GAMMA = "Gamma"
"""The residual."""


@dataclass(frozen=True)
class Residual:
    """A residual of which terms may be omitted: its program and box, allowed errors, and the range of A."""

    form: InertiaForm
    program: Program
    box: Box
    allowed: Array
    A: Interval
    reach: Array

    @property
    def tolerances(self) -> dict[str, list[Tolerance]]:
        """Absolute tolerances by row of the residual."""
        return {GAMMA: [Tolerance(float(x), relative=False) for x in self.allowed]}

    @property
    def parts(self) -> frozenset[int]:
        """The nodes of A and of the right side, by number: no other may be changed."""
        return frozenset(node.id for node in self.form.program.nodes)

    def matrices(self, errors: Array) -> Interval:
        """The range of A_S for which the residual is wrong by at most `errors`."""
        return widened(self.A, errors[:, None] / self.reach)


def residual_of(form: InertiaForm, box: Box, most: Array) -> Residual | None:
    """Return the residual of a direct model whose accelerations may be wrong by at most `most`; None without a proof.

    `box` is that of the direct model; `most` (joints,) is infinite for what is not asked for.
    """
    entries, right = (output.entries for output in form.program.outputs)
    A = _matrix(form, entries, box)
    reach = largest_solutions(A, np.array([_magnitude(x, box) for x in right])).max(axis=1)
    if not np.isfinite(reach).all():
        return None
    reach = np.maximum(reach, np.finfo(float).tiny)
    most = np.minimum(most, reach)
    allowed = allowed_right_sides(A, most)
    allowed = allowed_right_sides(widened(A, allowed[:, None] / reach), most)
    if not (allowed > 0).all():
        return None
    ranges = {name: Range(-x, x) for name, x in zip(form.accelerations, reach.tolist(), strict=True)}
    with_accelerations = Box({**box.ranges, **ranges}, box.positions)
    return Residual(form, form.residual(), with_accelerations, allowed, A, reach)


@dataclass(frozen=True)
class SolvedExactly:
    """A direct model that solves a reduced A x = b, terms left out: its reduction, and least pivots by name."""

    reduction: Reduction
    pivots: Mapping[str, float]

    def knowledge(self) -> Knowledge:
        """Ranges of the pivots of its program, in any sub-boxes."""
        ranges: dict[int, Callable[[Interval], Interval]] = {}
        for name, least in self.pivots.items():
            x = self.reduction.reduced.quantities.get(name)
            if isinstance(x, Expression):
                above = Interval(np.array(least), np.array(np.inf))
                ranges[x.positive.id] = (-above if x.operation == NEGATE else above).meeting
        return lambda parts: ranges


def solved_exactly(task: Task, joints: Joints, residual: Residual, bound: ErrorBound) -> SolvedExactly:
    """Return the direct model of a task with as few terms of A and of the right side as its tolerances allow.

    `asked` are the joints of its results, `bound` proves errors of the residual. Where nothing can be left out, or
    proven, the program stays whole.
    """
    form, required = residual.form, replace(task.required, confident=False, bound=bound, changing=residual.parts)
    reduced_residual = reduce_program(residual.program, residual.box.ranges, residual.tolerances, required)
    if not reduced_residual.left_out:
        unreduced = replace(task.without_changes().reduction(), unproven=reduced_residual.unproven)
        return SolvedExactly(unreduced, {})
    errors = np.array([entry.bounded or 0.0 for entry in reduced_residual.errors])
    A = residual.matrices(errors)
    accelerations = dict(zip(form.joints, largest_solutions(A, errors).max(axis=1), strict=True))
    values = reduced_residual.values
    reduced = form.solved(with_values(form.program, values), form.names.moved(values), joints)
    reduction = replace(
        task.without_changes().reduction(),
        reduced=reduced,
        outputs=reduced.outputs,
        left_out=reduced_residual.left_out,
        ended=reduced_residual.ended,
        errors=tuple(_errors(task, reduced, [float(accelerations[j]) for j in joints])),
    )
    return SolvedExactly(reduction, _pivots(form, A))


def _errors(task: Task, reduced: Program, bounds: Sequence[float]) -> Iterator[EntryError]:
    """The errors of all results: those at states that are not searched, and those that are proven."""
    tape, states = Tape(reduced, task.required.positions), task.required.states
    at_unseen = unseen(task.tape, tape, task.box, task.judging, states, (task.seed, MANY, 0))
    for output, index, k in task.entries():
        worst = float(at_unseen.worst[k] / task.judging[k])
        sizes = float(task.largest[k]), float(task.allowed[k])
        yield EntryError(output, index, *sizes, worst, worst, worst, None, bounds[index])


def _pivots(form: InertiaForm, A: Interval) -> dict[str, float]:
    """Lower bounds of H_j, a Schur complement over some joints: at least that over all, 1 / (A^-1)_jj."""
    units = np.eye(len(form.joints))
    inverse = [largest_solutions(A, unit)[k].max() for k, unit in enumerate(units)]
    return {f"H{j}": float(np.nextafter(1 / x, 0)) for j, x in zip(form.joints, inverse, strict=True)}


def _parts(entries: Sequence[Operand], box: Box) -> Parts:
    """The sub-boxes in which the entries of A are nearest to numbers."""
    nodes, box_of_positions = reachable(entries), _whole_box(entries, box)
    names = [name for name in box_of_positions if name in box.positions and name in box.open]

    def widths(parts: Parts) -> Array:
        bounds = running_errors(nodes, parts, DOUBLE)
        ranges = [bounds.range_of(x) for x in entries if isinstance(x, Expression)]
        return np.array([np.broadcast_to(x.high - x.low, bounds.shape) for x in ranges])

    return cut(box_of_positions, names, widths, MOST_SUB_BOXES, least_gain=-np.inf) if nodes else box_of_positions


def _whole_box(entries: Sequence[Operand], box: Box) -> Parts:
    return box.of(node.operands[0] for node in reachable(entries) if node.operation == SYMBOL).whole


def _matrix(form: InertiaForm, entries: Sequence[Operand], box: Box) -> Interval:
    """The range of A (n, n, sub-boxes): by intervals, where these do not suffice by polynomials, too."""
    bounds = running_errors(reachable(entries), _parts(entries, box), DOUBLE)
    ranges = [bounds.range_of(x) for x in entries]
    A = _symmetric(form, ranges, bounds.shape)
    if np.isfinite(largest_solutions(A, np.ones(len(form.joints)))).all():
        return A
    drawn = evaluate(entries, box.states(DRAWN, np.random.default_rng(0)), arithmetic(np.float64))
    values = [np.asarray(drawn(x), dtype=float) for x in entries]
    about_middles = [_about(x, (value.min() + value.max()) / 2, box) for x, value in zip(entries, values, strict=True)]
    ranges = [x.meeting(y) for x, y in zip(ranges, about_middles, strict=True)]
    return _symmetric(form, ranges, bounds.shape)


def _symmetric(form: InertiaForm, ranges: Sequence[Interval], shape: tuple[int, ...]) -> Interval:
    """The matrix (n, n, sub-boxes) with these entries in its lower triangle."""
    size = len(form.joints)
    row, column = np.tril_indices(size)
    low, high = (np.empty((size, size, *shape)) for _ in range(2))
    for i, j, x in zip(row, column, ranges, strict=True):
        low[i, j], high[i, j] = low[j, i], high[j, i] = x.low, x.high
    return Interval(low, high)


def _about(x: Operand, middle: float, box: Box) -> Interval:
    """The range of a polynomial over a box: its largest distance from about its middle."""
    if not isinstance(x, Expression):
        return interval(x)
    half = largest(x - Fraction(middle), box, work=WORK).bound
    return Interval(np.nextafter(middle - half, -np.inf), np.nextafter(middle + half, np.inf))


def _magnitude(x: Operand, box: Box) -> float:
    """The largest magnitude of an expression over a box."""
    if not isinstance(x, Expression):
        return float(interval(x).magnitude)
    bounds = running_errors(reachable([x]), _whole_box([x], box), DOUBLE)
    by_intervals = float(np.max(bounds.range_of(x).magnitude))
    return min(by_intervals, largest(x, box, work=WORK).bound)
