"""Python functions for the work of the command line: arguments are checked, and messages name them."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from functools import wraps
from inspect import signature
from numbers import Real
from typing import Any, ParamSpec, TypeVar

from symoro_elastic.api.declaration import flag, renamed
from symoro_elastic.foundation.errors import InputError

P = ParamSpec("P")
T = TypeVar("T")

COMMAND, PACKAGE = "symoro-elastic", "symoro_elastic"
OPTION = re.compile(r"--[a-z][a-z-]*")


def with_arguments(function: Callable[P, T]) -> Callable[P, T]:
    """Return a function that takes one name for a list of names, and whose `InputError`s name its arguments."""
    bound = signature(function)
    annotations = {name: str(one.annotation) for name, one in bound.parameters.items()}

    @wraps(function)
    def called(*args: P.args, **kwargs: P.kwargs) -> T:
        given = bound.bind(*args, **_renamed(function, kwargs))
        for name in given.arguments:
            given.arguments[name] = _argument(name, given.arguments[name], annotations)
        try:
            return function(*given.args, **given.kwargs)
        except InputError as error:
            file = PACKAGE if error.file == COMMAND else error.file
            raise InputError(file, in_words(error.place, annotations), in_words(error.what, annotations)) from None

    return called


def _renamed(function: Callable[..., object], given: dict[str, Any]) -> dict[str, Any]:
    """Return arguments under the names that they have now; warns of former ones."""
    record = getattr(function, "options", None)
    return renamed(record, given) if record else given


def argument(option: str, names: Collection[str]) -> str:
    """Return the argument that an option stands for, the option itself where there is none."""
    return next((name for name in names if option in (flag(name), flag(name, True))), option)


def in_words(text: str, names: Collection[str]) -> str:
    """Return a message with arguments in the place of options."""
    return OPTION.sub(lambda option: argument(option[0], names), text)


def _argument(name: str, value: Any, annotations: Mapping[str, str]) -> Any:
    """Return an argument as the function takes it; raises `InputError` for what should give numbers by name."""
    expected = annotations.get(name, "")
    if expected.startswith("Sequence[str]") and isinstance(value, str):
        return [value]
    if expected.startswith(("Values", "Mapping[str, float]")) and not _is_number(value, expected):
        _refuse_no_mapping(name, value)
    return value


def _is_number(value: Any, expected: str) -> bool:
    return "| float" in expected and isinstance(value, Real)


def _refuse_no_mapping(name: str, value: Any) -> None:
    if not isinstance(value, Mapping):
        what = f'{value!r} gives no numbers by name: write {{"name": 1.0}}'
        raise InputError(PACKAGE, name, what)
    for key, x in value.items():
        if not isinstance(key, str) or not isinstance(x, Real):
            raise InputError(PACKAGE, name, f"{key!r}: {x!r} is not a number by name: write {{'name': 1.0}}")
