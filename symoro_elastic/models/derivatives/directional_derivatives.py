"""Directional derivatives of models: how results change where arguments and parameters change together.

    d result = sum over the arguments of (d result / d argument) seed,

the graph of the model differentiated along the seeds: about as long as the model itself, however many arguments and
parameters there are. Dependent variables move along (L42). A sign of a velocity counts as constant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.model import Result
from symoro_elastic.models.bound.tracing import Trace
from symoro_elastic.models.derivatives.derivative_columns import moved_along
from symoro_elastic.models.derivatives.naming_derivatives import name_tangents
from symoro_elastic.quantities import Quantity, Role
from symoro_elastic.symbolic.differentiation import Differentiation
from symoro_elastic.symbolic.expression import Expression, Level
from symoro_elastic.symbolic.program import Input

SUFFIX, SEED = "_directional", "seed"
PARAMETERS = "p"


def directional_derivative(bound: Bound, trace: Trace, folded: Sequence[str] = ()) -> Trace:
    """Return the model `<name>_directional`, from the trace of a model of a bound machine.

    Its arguments are those of the model, then a seed for each of them and for the parameters that are not `folded`;
    its results are the derivatives of the model's results along the seeds.
    """
    inputs, direction = _seeds(bound, trace, folded)
    roots = [x for result in trace.results.values() for x in result.entries]
    tangents = Differentiation(roots).along(moved_along(bound, direction))
    name_tangents(bound, {SEED: tangents})
    results = {
        f"d{name}": Result(r.rows, tuple(map(tangents.of, r.entries)), r.columns, r.frames)
        for name, r in trace.results.items()
    }
    model = replace(
        trace.model,
        name=trace.model.name + SUFFIX,
        title=f"derivatives along a direction of the {trace.model.title}",
        arguments=(*trace.model.arguments, *(argument.name for argument in inputs)),
        results=tuple(results),
        own=(*trace.model.own, *map(_seed_row, inputs), *(_result_row(trace, name) for name in trace.results)),
    )
    return replace(trace, model=model, inputs=(*trace.inputs, *inputs), results=results)


def _seeds(bound: Bound, trace: Trace, folded: Sequence[str]) -> tuple[list[Input], dict[Expression, Expression]]:
    """The seeds as arguments of the derivative, and each variable's seed, which is its rate along the direction."""
    inputs: list[Input] = []
    direction: dict[Expression, Expression] = {}
    parameters = [p.name for p in bound.machine.parameters if p.name not in folded]
    arguments = [(x.name, x.symbols, Level.STATE) for x in trace.inputs if x.name != "q_dep"]
    for name, symbols, level in [*arguments, (PARAMETERS, parameters, Level.PARAMETER)]:
        if symbols:
            seeds = tuple(f"by_{SEED}_{symbol}" for symbol in symbols)
            inputs.append(Input(f"{SEED}_{name}", seeds))
            pairs = zip(symbols, seeds, strict=True)
            direction |= {bound.graph.symbol(x, level): bound.graph.symbol(seed) for x, seed in pairs}
    return inputs, direction


def _seed_row(seed: Input) -> Quantity:
    of = seed.name.removeprefix(f"{SEED}_")
    return Quantity(
        name=seed.name,
        meaning=f"change of {of} along the direction",
        symbol=rf"\delta {of}",
        unit=None,
        shape="entries",
        roles=(Role.ARGUMENT,),
    )


def _result_row(trace: Trace, name: str) -> Quantity:
    row = trace.model.quantity(name)
    return replace(
        row, name=f"d{name}", meaning=f"change of {name} along the direction", symbol=rf"\delta {row.symbol}"
    )
