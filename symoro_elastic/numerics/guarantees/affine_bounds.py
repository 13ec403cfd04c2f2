"""Lemma 9, the values of a program as affine forms over its box: ranges, and adjoints of errors, in which terms cancel.

The computed program has z~_i = op_i(z~) + e_i, |e_i| at most the rounding l_i (lemma 1). Let each node have the form of
op_i of the forms of its operands, its rest wider by l_i: it holds z~_i for all e_i, and z_i, for which e = 0; and all
that lies on the segment between both, which the mean value theorem looks at (lemma 2). So

    the range of z_i is that of its form, where this is smaller, and
    |f(e) - f(0)| <= sum sup|a_i| |e_i| holds with sup|a_i| from forms, as from intervals: the smaller one counts.

A sign is an interval of values as computed. With smaller ranges, errors and roundings by lemma 1 are smaller, too.

What is gained lies in direct models: the error of an element of the elimination comes to a result on many ways, which
cancel nearly, each as large as the force that the element multiplies. Intervals add their magnitudes. Forms are linear
in the force, and what is left is as much as the other factors vary in a sub-box.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.numerics.guarantees.affine import AFFINE, Affine, of_interval, variable
from symoro_elastic.numerics.guarantees.intervals import Interval
from symoro_elastic.numerics.guarantees.running_error import Bounds, Known
from symoro_elastic.numerics.guarantees.sub_boxes import Parts
from symoro_elastic.symbolic.expression import Expression, Level, Operand
from symoro_elastic.symbolic.operations import COS, SIGN, SIN, SYMBOL

MOST_NUMBERS = 5e7
"""Slopes of the adjoints of all nodes, results, sub-boxes and variables: beyond, intervals have to do."""


@dataclass(frozen=True)
class Forms:
    """The computed values of nodes, by number, as affine forms of the variables of a box."""

    bounds: Bounds
    of_nodes: Mapping[int, Affine]

    def of(self, x: Operand) -> Affine:
        """The form of a node or of a constant of the text."""
        return self.of_nodes[x.id] if type(x) is Expression else of_interval(self.bounds.computed(x))

    def narrowing(self) -> Known:
        """Ranges of nodes that are no larger than those of forms."""
        return {number: _Narrowed(self.bounds.range[number], x.range) for number, x in self.of_nodes.items()}


@dataclass(frozen=True)
class _Narrowed:
    """What is in the interval that was found before, and in that of a form."""

    before: Interval
    by_form: Interval

    def __call__(self, found: Interval) -> Interval:
        return found.meeting(self.before).meeting(self.by_form)


def forms_of(nodes: Sequence[Expression], bounds: Bounds, parts: Parts, results: int = 0) -> Forms | None:
    """The forms of nodes in order over sub-boxes, from their bounds by lemma 1; None where they are too many.

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
    found: dict[int, Affine] = {}
    forms = Forms(bounds, found)
    with np.errstate(all="ignore"):
        for node in nodes:
            found[node.id] = _form(node, forms, symbols)
            if node.id in angles and found[node.id].slopes.shape[-1] == count:
                number = len(names) + 2 * angles[node.id]
                found[node.id].of_circle = number, number + 1
    return forms


def _angles(nodes: Sequence[Expression]) -> dict[int, int]:
    """What sines and cosines are of, in order."""
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
    return form.widened(forms.bounds.local[node.id]).at_most(computed)
