"""Methods of integration on linear systems: one step, and what a step makes of y' = lambda y.

f(i, Y) is the right side at stage i, `solve` gives (I - gamma h T)^-1 r for the T of the method. Exact coefficients
serve as floats do, which `in_floats` makes of them once: fractions are slow.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from fractions import Fraction
from functools import singledispatch
from typing import Any

import numpy as np

from symoro_elastic.codegen.integration.methods import Method, Midpoint, times_of
from symoro_elastic.codegen.integration.rosenbrock import Rosenbrock
from symoro_elastic.codegen.integration.tableaus import Coefficients, Tableau
from symoro_elastic.codegen.integration.w_methods import WMethod
from symoro_elastic.foundation.array_types import AnyArray, Array

Rate = Callable[[int, AnyArray], AnyArray]
Solve = Callable[[AnyArray], AnyArray]


def in_floats(method: Method) -> Method:
    """Return a method with its coefficients in double precision."""
    values = {field.name: getattr(method, field.name) for field in fields(method)}
    return replace(method, **{name: _floats(value) for name, value in values.items()})


def _floats(value: Any) -> Any:
    """Return a value with floats for the fractions in it."""
    if isinstance(value, tuple):
        return tuple(map(_floats, value))
    return float(value) if isinstance(value, Fraction) else value


def nodes(method: Method) -> Array:
    """Return the parts of a step after which a method takes the right side, one a stage."""
    return np.array(times_of(method), dtype=float)


def gamma(method: Method) -> float:
    """Return gamma of the linear systems of a method, 0 for an explicit one."""
    if isinstance(method, Midpoint):
        return 0.5
    return 0.0 if isinstance(method, Tableau) else float(method.gamma)


@singledispatch
def step(method: Method, h: float, y: AnyArray, f: Rate, solve: Solve, of_time: AnyArray) -> AnyArray:
    """Return y (...,) after a step of h; `of_time` is df/dt at its start, which methods with exact derivatives take."""
    raise NotImplementedError


@step.register
def _(method: Tableau, h: float, y: AnyArray, f: Rate, solve: Solve, of_time: AnyArray) -> AnyArray:
    k: list[AnyArray] = []
    for i, row in enumerate(method.A):
        k.append(f(i, y + h * _sum(row, k)))
    return y + h * _sum(method.b, k)


@step.register
def _(method: WMethod, h: float, y: AnyArray, f: Rate, solve: Solve, of_time: AnyArray) -> AnyArray:
    k: list[AnyArray] = []
    for i, (a, g) in enumerate(zip(method.a, method.g, strict=True)):
        w = _sum(g, k) / float(method.gamma)
        k.append(solve(f(i, y + h * _sum(a, k)) + w) - w)
    return y + h * _sum(method.b, k)


@step.register
def _(method: Rosenbrock, h: float, y: AnyArray, f: Rate, solve: Solve, of_time: AnyArray) -> AnyArray:
    u: list[AnyArray] = []
    for i, (a, c) in enumerate(zip(method.a, method.c, strict=True)):
        right = f(i, y + _sum(a, u)) + _sum(c, u) / h + float(method.gammas[i]) * h * of_time
        u.append(float(method.gamma) * h * solve(right))
    return y + _sum(method.m, u)


@step.register
def _(method: Midpoint, h: float, y: AnyArray, f: Rate, solve: Solve, of_time: AnyArray) -> AnyArray:
    k = 0.0 * y
    for _iteration in range(method.iterations):
        k = k + solve(f(0, y + h / 2 * k) - k)
    return y + h * k


def growth(method: Method, z: AnyArray) -> AnyArray:
    """Return R(z): what a step makes of y where y' = lambda y, z = lambda h and T is exact."""
    one = np.ones_like(z)
    return step(method, 1.0, one, lambda _, y: z * y, lambda r: r / (1 - gamma(method) * z), 0.0 * one)


def _sum(weights: Coefficients, terms: list[AnyArray]) -> AnyArray:
    """Return sum_j weights_j terms_j, zero where there are none."""
    parts = [float(weight) * term for weight, term in zip(weights, terms, strict=True) if weight]
    return sum(parts[1:], start=parts[0]) if parts else np.zeros(())
