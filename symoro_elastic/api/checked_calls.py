"""Functions of the command line's work as Python calls them: what is given is checked, messages name arguments."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping
from functools import wraps
from inspect import signature
from numbers import Real
from typing import Any, ParamSpec, TypeVar

from symoro_elastic.errors import InputError

P = ParamSpec("P")
T = TypeVar("T")

COMMAND, PACKAGE = "symoro-elastic", "symoro_elastic"
OTHER_NAMES = {"--from": "box"}
OPTION = re.compile(r"--[a-z][a-z-]*")


def with_arguments(function: Callable[P, T]) -> Callable[P, T]:
    """Return a function that takes one name for a list of names, and whose `InputError`s name its arguments."""
    annotations = _annotations(function)
    bound = signature(function)

    @wraps(function)
    def called(*args: P.args, **kwargs: P.kwargs) -> T:
        given = bound.bind(*args, **kwargs)
        for name in given.arguments:
            given.arguments[name] = _argument(name, given.arguments[name], annotations)
        try:
            return function(*given.args, **given.kwargs)
        except InputError as error:
            file = PACKAGE if error.file == COMMAND else error.file
            raise InputError(file, in_words(error.place, annotations), in_words(error.what, annotations)) from None

    return called


def argument(option: str, names: Collection[str]) -> str:
    """Return the argument that an option stands for, the option itself where there is none."""
    name = OTHER_NAMES.get(option, option.removeprefix("--").replace("-", "_"))
    return next((each for each in (name, f"{name}s", f"{name[:-1]}ies") if each in names), option)


def in_words(text: str, names: Collection[str]) -> str:
    """Return a message with arguments in the place of options."""
    return OPTION.sub(lambda found: argument(found[0], names), text)


def _annotations(function: Callable[..., object]) -> dict[str, str]:
    """Return the annotations of arguments as they are written, those of `**where` too."""
    found = {name: str(one.annotation) for name, one in signature(function).parameters.items()}
    if "where" in found:
        from symoro_elastic.api.vibrations import Where

        found |= {name: getattr(one, "__forward_arg__", str(one)) for name, one in Where.__annotations__.items()}
    return found


def _argument(name: str, value: Any, annotations: Mapping[str, str]) -> Any:
    """Return an argument as the function takes it; raises `InputError` for what is no mapping of names to numbers."""
    if name == "where":
        return {each: _argument(each, x, annotations) for each, x in value.items()}
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
            raise InputError(PACKAGE, name, f"{key!r}: {x!r} is no number by name: write {{'name': 1.0}}")
