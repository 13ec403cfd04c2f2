"""Deflections of springs whose stiffness changes with positions, from their loads, as time series.

A load c on the coordinate behind a spring of energy k d^2/2 is balanced at the deflection d where

    f(d) = k d + k' d^2/2 = c,

k' being the derivative of k by this coordinate. Newton's method finds d; each further coefficient of d in time takes
one division by df/dd. Where f is not linear and the steps do not become small there is no value: a division by zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.differentiation import Differentiation, substituted
from symoro_elastic.symbolic.expression import Expression, Graph, reachable
from symoro_elastic.symbolic.functions import sign
from symoro_elastic.symbolic.time_series import TimeSeries, VariableCoefficient

NEWTON_STEPS = 8
"""Enough where df/dd triples along the deflection, or falls to a quarter."""
SMALL_STEP = Fraction(1, 2**30)
"""The step before the last one, against the deflection: the last one then is its square, below rounding."""
NO_LOAD = Fraction(1, 2**200)
"""Square of a step that is small without any deflection, m2 or rad2."""


def balanced(
    d: Expression, f: Scalar, loads: Sequence[Scalar], variables: Mapping[str, VariableCoefficient]
) -> list[Scalar]:
    """Coefficients of the symbol d in time where f(d) has those of `loads`.

    `variables` are coefficients of the other symbols of f.
    """
    name, graph = d.operands[0], d.graph
    now = {key: coefficient(0) for key, coefficient in variables.items() if graph.symbol(key) in {*reachable([f])}}
    force, slope = substituted(graph, [f, Differentiation([f]).by(d).of(f)], now)
    found = [_root(d, force, slope, loads[0])]
    (rate,) = substituted(graph, [slope], {name: found[0]})
    for n in range(1, len(loads)):
        known = [*found, 0]
        so_far = TimeSeries({**variables, name: known.__getitem__}).of(f, n)[n]
        found.append((loads[n] - so_far) / rate)
    return found


def _root(d: Expression, force: Scalar, slope: Scalar, load: Scalar) -> Scalar:
    """d of force(d) = load; one step from zero where it is linear."""
    is_linear = d not in {*reachable([slope])}
    found: Scalar = 0
    steps: list[Scalar] = []
    for _ in range(1 if is_linear else NEWTON_STEPS):
        here, rate = substituted(d.graph, [force, slope], {d.operands[0]: found})
        steps.append((here - load) / rate)
        found = found - steps[-1]
    return found if is_linear else found / _one_where_small(d.graph, steps[-2], found)


def _one_where_small(graph: Graph, step: Scalar, whole: Scalar) -> Scalar:
    """One where a step is small against the whole, zero where it is not."""
    room = SMALL_STEP * SMALL_STEP * (whole * whole) + NO_LOAD - step * step
    return (1 + sign(graph, room)) * Fraction(1, 2)
