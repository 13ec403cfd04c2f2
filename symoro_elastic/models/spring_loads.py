"""Deflections of springs whose stiffness changes with positions, from their loads, as time series.

A load c on the coordinate behind a spring of energy k (x - x0)^2/2 is balanced where

    f(x) = k (x - x0) + k' (x - x0)^2/2 = c,

k' being the derivative of k by this coordinate. Newton's method from x0 finds x; each further coefficient of x in time
takes one division by df/dx. Where f is not linear and the steps do not become small there is no value: a division by
zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from symoro_elastic.models.closed_chains import NEWTON_STEPS
from symoro_elastic.scalar import Scalar
from symoro_elastic.symbolic.differentiation import Differentiation, substituted
from symoro_elastic.symbolic.expression import Expression, Graph, reachable
from symoro_elastic.symbolic.functions import sign
from symoro_elastic.symbolic.time_series import TimeSeries, VariableCoefficient

SMALL_STEP = Fraction(1, 2**26)
"""Last step of Newton's method against the deflection: its square is rounding."""
NO_LOAD = Fraction(1, 2**200)
"""Square of a step that is small without any deflection, m2 or rad2."""


def balanced(
    x: Expression, f: Scalar, loads: Sequence[Scalar], start: Scalar, variables: Mapping[str, VariableCoefficient]
) -> list[Scalar]:
    """Coefficients of the symbol x in time where f(x) has those of `loads`.

    `variables` are coefficients of the other symbols of f; the search for x begins at `start`.
    """
    name, graph = x.operands[0], x.graph
    now = {key: coefficient(0) for key, coefficient in variables.items() if graph.symbol(key) in {*reachable([f])}}
    force, slope = substituted(graph, [f, Differentiation([f]).by(x).of(f)], now)
    found = [_root(x, force, slope, loads[0], start)]
    (rate,) = substituted(graph, [slope], {name: found[0]})
    for n in range(1, len(loads)):
        known = [*found, 0]
        so_far = TimeSeries({**variables, name: known.__getitem__}).of(f, n)[n]
        found.append((loads[n] - so_far) / rate)
    return found


def _root(x: Expression, force: Scalar, slope: Scalar, load: Scalar, start: Scalar) -> Scalar:
    """x of force(x) = load; one step where it is linear."""
    is_linear = x not in {*reachable([slope])}
    found, step = start, start
    for _ in range(1 if is_linear else NEWTON_STEPS):
        here, rate = substituted(x.graph, [force, slope], {x.operands[0]: found})
        step = (here - load) / rate
        found = found - step
    return found if is_linear else found / _one_where_small(x.graph, step, found - start)


def _one_where_small(graph: Graph, step: Scalar, way: Scalar) -> Scalar:
    """One where a step is small against the way, zero where it is not."""
    room = SMALL_STEP * SMALL_STEP * (way * way) + NO_LOAD - step * step
    return (1 + sign(graph, room)) * Fraction(1, 2)
