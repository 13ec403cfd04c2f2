"""Cache of results by machine, as long as the machine exists."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar

from symoro_elastic.machine.machine import Machine

P = ParamSpec("P")
T = TypeVar("T")


def once_for_each_machine(function: Callable[Concatenate[Machine, P], T]) -> Callable[Concatenate[Machine, P], T]:
    """Cache the results of a function by the identity of its machine; other arguments must not change the result."""
    results: dict[int, tuple[weakref.ref[Machine], T]] = {}

    @wraps(function)
    def wrapper(machine: Machine, /, *arguments: P.args, **named: P.kwargs) -> T:
        key = id(machine)
        entry = results.get(key)
        if entry is not None and entry[0]() is machine:
            return entry[1]
        result = function(machine, *arguments, **named)
        results[key] = weakref.ref(machine, lambda _: results.pop(key, None) if results is not None else None), result
        return result

    return wrapper
