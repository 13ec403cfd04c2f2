"""The methods that time steps are generated for, by name."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

from symoro_elastic.codegen.integration.rosenbrock import RODAS4, Rosenbrock
from symoro_elastic.codegen.integration.tableaus import RK4, Coefficients, Tableau
from symoro_elastic.codegen.integration.w_methods import W2, W3, WMethod
from symoro_elastic.quantities.time_steps import TimeStep


@dataclass(frozen=True)
class Midpoint:
    """The implicit midpoint rule, y(t + h) = y + h k, k = f(t + h/2, y + h k/2).

    It has a fixed number of steps of Newton's method, each with the system of W-methods.
    """

    name: str
    title: str
    order: int
    iterations: int


MIDPOINT = Midpoint(TimeStep.MIDPOINT, "implicit midpoint rule, order 2", 2, 4)
"""Hairer, Lubich and Wanner, Geometric Numerical Integration, section II.1.1, Gauss method of one stage: it keeps the
energy of linear vibrations."""

Method: TypeAlias = Tableau | WMethod | Rosenbrock | Midpoint
METHODS: dict[str, Method] = {method.name: method for method in (W3, W2, RK4, RODAS4, MIDPOINT)}


def times_of(method: Method) -> Coefficients:
    """Return the times of the stages, in steps."""
    if isinstance(method, Rosenbrock):
        return method.alpha
    return (Fraction(1, 2),) if isinstance(method, Midpoint) else method.c


def nodes_of(method: Method, driven: bool = False) -> Coefficients:
    """Return the times, in steps, at which motors are given: those of stages, and the end where they are `driven`."""
    return tuple(dict.fromkeys((*times_of(method), *([Fraction(1)] if driven else []))))


def share_of_halving(method: Method) -> float:
    """Return the error of a step over what halving it changes, 2^p / (2^p - 1) for order p."""
    return float(2**method.order / (2**method.order - 1))
