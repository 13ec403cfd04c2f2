"""Functions that compute in many digits."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

import mpmath

P = ParamSpec("P")
T = TypeVar("T")


def with_digits(digits: int) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """A decorator of functions that compute in so many decimal digits."""

    def decorated(function: Callable[P, T]) -> Callable[P, T]:
        @wraps(function)
        def computed(*arguments: P.args, **named: P.kwargs) -> T:
            with mpmath.workdps(digits):
                return function(*arguments, **named)

        return computed

    return decorated
