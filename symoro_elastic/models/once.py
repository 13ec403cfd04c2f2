"""Results that are computed once for each machine, as long as it lives."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from functools import wraps
from typing import Concatenate, ParamSpec, TypeVar

from symoro_elastic.machine.machine import Machine

P = ParamSpec("P")
T = TypeVar("T")


def once_for_each_machine(function: Callable[Concatenate[Machine, P], T]) -> Callable[Concatenate[Machine, P], T]:
    """A function that gives a machine, the same object, the same result; its other arguments never change it."""
    known: dict[int, tuple[weakref.ref[Machine], T]] = {}

    @wraps(function)
    def remembered(machine: Machine, /, *arguments: P.args, **named: P.kwargs) -> T:
        key = id(machine)
        found = known.get(key)
        if found is not None and found[0]() is machine:
            return found[1]
        result = function(machine, *arguments, **named)
        known[key] = weakref.ref(machine, lambda _: known.pop(key, None) if known is not None else None), result
        return result

    return remembered
