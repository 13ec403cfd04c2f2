"""Variables by which models are differentiated (arguments, entries, parameters), and variables that follow them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.arguments import PARAMETERS, arguments, columns_of_base
from symoro_elastic.mechanics.base_body import DEGREES
from symoro_elastic.mechanics.loops.linear import solve
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.symbolic.differentiation import Differentiation
from symoro_elastic.symbolic.expression import Expression, Level, reachable
from symoro_elastic.symbolic.operations import SYMBOL

Variables = Mapping[str, Mapping[int, Expression]]
"""Variables of differentiation, by argument and joint, degree of freedom of the base or number of the parameter."""


def all_columns(bound: Bound, driving: Variables) -> Variables:
    """The variables by which dynamic models are differentiated."""
    on_base = {
        name: dict(zip(DEGREES, map(bound.graph.symbol, arguments(bound.machine)[name]), strict=True))
        for name in columns_of_base(bound.machine)
    }
    return {"q": bound.q, "qd": bound.qd, **driving, **on_base}


def chosen_columns(bound: Bound, by: Variables) -> Variables:
    """Variables that a scene names (arguments or entries), in its order; all where it names none."""
    if not bound.by:
        return by
    chosen = {}
    for name, variables in by.items():
        columns = [c for word in bound.by for c, x in variables.items() if word in (name, x.operands[0])]
        if columns:
            chosen[name] = {c: variables[c] for c in columns}
    return chosen


def needed_columns(bound: Bound, by: Variables) -> Variables:
    """Variables that a scene names, and those that the columns of the pose depend on."""
    chosen = chosen_columns(bound, by)
    posed = "pose" in chosen and "V0d" in by
    complete = {"qdd_motor"} | ({"V0d"} if posed else set())
    needed = {*chosen, *(("V0d",) if posed else ())} - {"pose"}
    return {name: by[name] if name in complete else chosen[name] for name in by if name in needed}


def parameter_columns(bound: Bound, results: Iterable[Scalar]) -> Variables:
    """The parameters that a scene names, or else those that results are made of, numbered as in the table."""
    if bound.by:
        numbers = {p.name: c for c, p in enumerate(bound.machine.parameters)}
        return {PARAMETERS: {numbers[name]: bound.graph.symbol(name, Level.PARAMETER) for name in bound.by}}
    used = {x for x in reachable(results) if x.operation == SYMBOL}
    names = {x.operands[0]: x for x in used if x.level is Level.PARAMETER}
    if not names:
        source = bound.machine.label
        raise InputError(source, "parameters", "nothing depends on a parameter that has a name: fold fewer of them")
    return {PARAMETERS: {c: names[p.name] for c, p in enumerate(bound.machine.parameters) if p.name in names}}


def moved_with(bound: Bound, name: str, c: int, variable: Expression) -> dict[Expression, Scalar]:
    """Derivatives of the variable itself and of dependent variables that are arguments, by the variable (L42)."""
    changes: dict[int, Scalar] = {}
    if name == "q":
        changes = {d: bound.coordinates.S_x[d].get(c, 0) for d in bound.assembled}
    elif name == PARAMETERS:
        changes = _assembled_along(bound, {variable: 1})
    return {variable: 1, **_variable_changes(bound, changes)}


def _variable_changes(bound: Bound, changes: Mapping[int, Scalar]) -> dict[Expression, Scalar]:
    return {bound.graph.symbol(name): x for name, x in bound.machine.by_variable(changes).items()}


def moved_along(bound: Bound, direction: Mapping[Expression, Scalar]) -> dict[Expression, Scalar]:
    """A direction of independent variables and parameters, extended by dependent variables that follow (L42)."""
    return {**direction, **_variable_changes(bound, _assembled_along(bound, direction))}


def _assembled_along(bound: Bound, direction: Mapping[Expression, Scalar]) -> dict[int, Scalar]:
    """Changes of dependent variables along a direction, x of W_d x = -dr, r being the closing error (L18)."""
    rates: dict[int, Scalar] = {}
    for block in bound.coordinates.assembled_blocks:
        errors = bound.coordinates.errors_of(block)
        tangents = Differentiation(errors).along({**direction, **_variable_changes(bound, rates)})
        (changes,) = solve(bound.coordinates.columns_of(block), [[-tangents.of(x) for x in errors]])
        rates |= zip(bound.coordinates.unknown(block), changes, strict=True)
    return rates
