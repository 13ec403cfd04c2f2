"""Lemmas 2 and 9, adjoints of the errors of all operations: by intervals, and by affine forms.

**Lemma 2**, the mean value theorem.

The computed result is f(e), where node i is computed as z_i = op_i(z) + e_i. Along the segment from 0 to e, for some
point xi of it,

    f(e) - f(0) = sum a_i(xi) e_i,        a_i = d(result)/d(z_i)

The adjoints a_i(xi) are sums of products of partial derivatives at perturbed values of nodes, which are at most E_i
from the exact ones (lemma 1). Over the intervals [z_i - E_i, z_i + E_i] their enclosures hold them, so that

    |f(e) - f(0)| <= sum sup|a_i| |e_i|

is exact: nothing of second order is neglected. It accounts for cancellation of errors that reach the result on
several paths, which lemma 1 ignores.

A sign has no mean value: it is a node whose own error is the bound of lemma 1, with a jump of 2.

**Lemma 9**, the values of a program as affine forms over its box: ranges, and adjoints, in which terms cancel.

The computed program has z~_i = op_i(z~) + e_i, |e_i| at most the rounding l_i (lemma 1). Let each node have the form of
op_i of the forms of its operands, its rest wider by l_i: it holds z~_i for all e_i, and z_i, for which e = 0; and all
that lies on the segment between both, which the mean value theorem looks at (lemma 2). So

    the range of z_i is that of its form, where this is smaller, and
    |f(e) - f(0)| <= sum sup|a_i| |e_i| holds with sup|a_i| from forms, as from intervals: the smaller one counts.

A sign is an interval of values as computed. With smaller ranges, errors and roundings by lemma 1 are smaller, too.

The gain is in direct models: the error of an element of the elimination reaches a result on many paths, which
cancel nearly, each as large as the force that the element multiplies. Intervals add their magnitudes. Forms are linear
in the force, and the remainder is as much as the other factors vary in a sub-box.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.guarantees.affine import AFFINE, Affine, of_interval, variable
from symoro_elastic.numerics.guarantees.box import Parts
from symoro_elastic.numerics.guarantees.intervals import INTERVALS, Interval
from symoro_elastic.numerics.guarantees.running_error import UPWARDS, Bounds, Known
from symoro_elastic.symbolic.arithmetic import Arithmetic
from symoro_elastic.symbolic.expression import Expression, Level, Operand
from symoro_elastic.symbolic.operations import COS, OPERATIONS, SIGN, SIN, SYMBOL

MOST_NUMBERS = 5e7
"""Limit of the number of slopes (adjoints, results, sub-boxes, variables); intervals are used beyond it."""


def errors_by_adjoints(
    nodes: Sequence[Expression], results: Sequence[Operand], bounds: Bounds, forms: Forms | None = None
) -> Array:
    """Error bounds (results, sub-boxes); infinite where there is none.

    `bounds` are those of the nodes by lemma 1; with `forms` the smaller adjoint of a node counts.
    """
    total = np.zeros((len(results), *bounds.shape))
    for row, x in zip(total, results, strict=True):
        row[...] = 0.0 if type(x) is Expression else bounds.error_of(x)
    with np.errstate(all="ignore"):
        by_intervals = perturbations(nodes, results, bounds, bounds.computed, INTERVALS)
        if forms is None:
            for adjoint, local in by_intervals:
                total += adjoint * local * UPWARDS
        else:
            by_forms = perturbations(nodes, results, bounds, forms.of, AFFINE)
            for (adjoint, local), (other, _) in zip(by_intervals, by_forms, strict=True):
                total += np.fmin(adjoint, other) * local * UPWARDS
    return np.where(np.isfinite(total), total * (1 + len(nodes) * 2.0**-50), np.inf)


def perturbations(
    nodes: Sequence[Expression],
    results: Sequence[Operand],
    bounds: Bounds,
    computed: Callable[[Operand], Any],
    arithmetic: Arithmetic[Any],
) -> Iterator[tuple[Array, Array]]:
    """Yield for each perturbation the largest magnitude of its adjoint, over the `computed` values, and its size.

    Adjoints have the results along their first axis. Perturbations are the roundings of operations, of numbers in the
    text and of narrowed arguments, and errors of signs.
    """
    adjoints: dict[int, Any] = {}
    for k, x in enumerate(results):
        if type(x) is Expression:
            unit = unit_adjoint(k, len(results), bounds.shape)
            add_adjoint(adjoints, x, of_interval(unit) if arithmetic is AFFINE else unit)
    for node in reversed(nodes):
        adjoint = adjoints.pop(node.id, None)
        if adjoint is None:
            continue
        yield adjoint.magnitude, (bounds.error if node.operation == SIGN else bounds.local)[node.id]
        rule = OPERATIONS[node.operation].partials if node.operation != SYMBOL else None
        if rule is None or node.level == Level.CONSTANT:
            continue
        parts = rule(arithmetic.operations, computed(node), [computed(x) for x in node.operands]).back(adjoint)
        for operand, part in zip(node.operands, parts, strict=True):
            if type(operand) is Expression:
                add_adjoint(adjoints, operand, part)
            elif np.any(error := bounds.error_of(operand)):
                yield part.magnitude, error


def unit_adjoint(k: int, count: int, shape: tuple[int, ...]) -> Interval:
    """The unit adjoint of result k, by result and sub-box."""
    unit = np.zeros((count, *shape))
    unit[k] = 1.0
    return Interval(unit, unit)


def add_adjoint(adjoints: dict[int, Any], x: Expression, part: Any) -> None:
    """Add a part to the adjoint of a node."""
    adjoints[x.id] = adjoints[x.id] + part if x.id in adjoints else part


@dataclass(frozen=True)
class Forms:
    """The computed values of nodes, by number, as affine forms of the variables of a box."""

    bounds: Bounds
    of_nodes: Mapping[int, Affine]

    def of(self, x: Operand) -> Affine:
        """The form of a node or of a constant of the text."""
        return self.of_nodes[x.id] if type(x) is Expression else of_interval(self.bounds.computed(x))

    def narrowing(self) -> Known:
        """Functions that narrow ranges of nodes to their earlier ones and those of their forms, by number."""
        before = self.bounds.range
        return {k: partial(Interval.meeting, before[k].meeting(x.range)) for k, x in self.of_nodes.items()}


def forms_of(nodes: Sequence[Expression], bounds: Bounds, parts: Parts, results: int = 0) -> Forms | None:
    """The affine forms of the computed values of nodes over sub-boxes; None where they need too much memory.

    With `results` that counts their adjoints, too.
    """
    names = [name for name, x in parts.items() if np.any(x.low < x.high)]
    angles = _angles(nodes)
    count = len(names) + 2 * len(angles)
    if not names or len(nodes) * (1 + results) * np.prod(bounds.shape) * count > MOST_NUMBERS:
        return None
    symbols = {
        name: variable(x, names.index(name), count) if name in names else of_interval(x) for name, x in parts.items()
    }
    of_nodes: dict[int, Affine] = {}
    forms = Forms(bounds, of_nodes)
    with np.errstate(all="ignore"):
        for node in nodes:
            of_nodes[node.id] = _form(node, forms, symbols)
            if node.id in angles and of_nodes[node.id].slopes.shape[-1] == count:
                number = len(names) + 2 * angles[node.id]
                of_nodes[node.id].of_circle = number, number + 1
    return forms


def _angles(nodes: Sequence[Expression]) -> dict[int, int]:
    """Position by number of the nodes that are angles of sines and cosines."""
    of = (node.operands[0] for node in nodes if node.operation in (SIN, COS))
    return {number: k for k, number in enumerate(dict.fromkeys(x.id for x in of if type(x) is Expression))}


def _form(node: Expression, forms: Forms, symbols: Mapping[str, Affine]) -> Affine:
    """The form of a node as it is computed, from those of its operands."""
    computed = forms.bounds.computed(node)
    if node.level == Level.CONSTANT or node.operation == SIGN:
        return of_interval(computed)
    if node.operation == SYMBOL:
        form = symbols[str(node.operands[0])]
    else:
        form = AFFINE.operations[node.operation](*map(forms.of, node.operands))
    return form.widen(forms.bounds.local[node.id]).at_most(computed)
