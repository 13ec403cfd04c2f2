"""Lemma 2, the mean value theorem on the errors of all operations at once.

The computed result is f(e), where node i is computed as z_i = op_i(z) + e_i. Along the segment from 0 to e, for some
point xi of it,

    f(e) - f(0) = sum a_i(xi) e_i,        a_i = d(result)/d(z_i)

The adjoints a_i(xi) are sums of products of partial derivatives at perturbed values of nodes, which are at most E_i
from the exact ones (lemma 1). Over the intervals [z_i - E_i, z_i + E_i] their enclosures hold them, so that

    |f(e) - f(0)| <= sum sup|a_i| |e_i|

is exact: nothing of second order is neglected. Cancellation that lemma 1 does not see, of errors that come to the
result on several ways, is seen here.

A sign has no mean value: it is a node whose own error is all that lemma 1 says of it, a jump of 2 among it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.guarantees.affine import AFFINE, of_interval
from symoro_elastic.numerics.guarantees.affine_bounds import Forms
from symoro_elastic.numerics.guarantees.intervals import INTERVALS, Interval
from symoro_elastic.numerics.guarantees.running_error import UPWARDS, Bounds
from symoro_elastic.symbolic.arithmetic import Arithmetic
from symoro_elastic.symbolic.expression import Expression, Level, Operand
from symoro_elastic.symbolic.operations import OPERATIONS, SIGN, SYMBOL


@dataclass(frozen=True)
class Computed:
    """The values of nodes as the program computes them, in an arithmetic, and how it takes an interval."""

    of: Callable[[Operand], Any]
    arithmetic: Arithmetic[Any]
    taken: Callable[[Interval], Any]

    @classmethod
    def in_intervals(cls, bounds: Bounds) -> Computed:
        """As intervals."""
        return cls(bounds.computed, INTERVALS, lambda x: x)

    @classmethod
    def in_forms(cls, forms: Forms) -> Computed:
        """As affine forms (lemma 9)."""
        return cls(forms.of, AFFINE, of_interval)


def errors_by_adjoints(
    nodes: Sequence[Expression], results: Sequence[Operand], bounds: Bounds, forms: Forms | None = None
) -> Array:
    """The error of each result, by sub-box: results along the first axis; infinite where it is not bounded.

    `bounds` are those of the nodes by lemma 1; with `forms` the smaller one of both adjoints of a node counts.
    """
    total = np.zeros((len(results), *bounds.shape))
    for row, x in zip(total, results, strict=True):
        row[...] = 0.0 if type(x) is Expression else bounds.error_of(x)
    with np.errstate(all="ignore"):
        found = perturbations(nodes, results, bounds, Computed.in_intervals(bounds))
        if forms is None:
            for adjoint, local in found:
                total += adjoint * local * UPWARDS
        else:
            by_forms = perturbations(nodes, results, bounds, Computed.in_forms(forms))
            for (adjoint, local), (other, _) in zip(found, by_forms, strict=True):
                total += np.fmin(adjoint, other) * local * UPWARDS
    return np.where(np.isfinite(total), total * (1 + len(nodes) * 2.0**-50), np.inf)


def perturbations(
    nodes: Sequence[Expression], results: Sequence[Operand], bounds: Bounds, computed: Computed
) -> Iterator[tuple[Array, Array]]:
    """The largest magnitude of the adjoint of each perturbation, over perturbed values, and its size.

    Adjoints have the results along their first axis. Perturbations are the roundings of operations, of numbers in the
    text, and of arguments that are narrowed, and errors of signs.
    """
    adjoints: dict[int, Any] = {}
    for k, x in enumerate(results):
        if type(x) is Expression:
            _add(adjoints, x, computed.taken(_unit(k, len(results), bounds.shape)))
    for node in reversed(nodes):
        adjoint = adjoints.pop(node.id, None)
        if adjoint is None:
            continue
        yield adjoint.magnitude, (bounds.error if node.operation == SIGN else bounds.local)[node.id]
        rule = OPERATIONS[node.operation].partials if node.operation != SYMBOL else None
        if rule is None or node.level == Level.CONSTANT:
            continue
        operands = [computed.of(x) for x in node.operands]
        parts = rule(computed.arithmetic.operations, computed.of(node), operands).back(adjoint)
        for operand, part in zip(node.operands, parts, strict=True):
            if type(operand) is Expression:
                _add(adjoints, operand, part)
            elif np.any(error := bounds.error_of(operand)):
                yield part.magnitude, error


def _unit(k: int, count: int, shape: tuple[int, ...]) -> Interval:
    """The derivatives of all results by result k."""
    one = np.zeros((count, *shape))
    one[k] = 1.0
    return Interval(one, one)


def _add(adjoints: dict[int, Any], x: Expression, part: Any) -> None:
    adjoints[x.id] = adjoints[x.id] + part if x.id in adjoints else part
