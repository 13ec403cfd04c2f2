"""Dependent variables of closed loops in many digits, by Newton's method on the equations of the loops."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.loops.assembly import Position
from symoro_elastic.models.loops.plan import Plan
from symoro_elastic.numerics.linear_systems import solve
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision

DIGITS, STEPS = 50, 4
"""From an error of 1e-11, two steps give 44 digits."""


def closed_variables(machine: Machine, plan: Plan, near: Position, values: Mapping[str, float]) -> dict[int, Any]:
    """Own variables of a position, the independent ones as they are, the others in many digits.

    `values` are those of the parameters, which are exact as they are.
    """
    arithmetic = multiprecision(DIGITS)
    kept = [one for loop in plan.loops for one in plan.assembly.equations if one.loop == loop.loop.name]
    kept = [one for one in kept if one.row in next(x.kept for x in plan.loops if x.loop.name == one.loop)]
    leaves = [x for one in kept for x in (one.error, *one.columns.values())]
    found = {j: arithmetic.number(Fraction(x)) for j, x in near.items()}
    symbols = {name: arithmetic.number(Fraction(x)) for name, x in values.items()}
    for _ in range(STEPS):
        here = symbols | machine.by_variable(found)
        value = evaluate(leaves, here, arithmetic)
        W = [[value(one.columns.get(j, 0)) for j in machine.dependent] for one in kept]
        for j, step in zip(machine.dependent, solve(W, [value(one.error) for one in kept]), strict=True):
            found[j] -= step
    return found
