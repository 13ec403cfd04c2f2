"""Functions of the command line's work as Python calls them: messages name arguments instead of options."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from functools import wraps
from inspect import signature
from typing import ParamSpec, TypeVar, get_type_hints

from symoro_elastic.errors import InputError

P = ParamSpec("P")
T = TypeVar("T")

COMMAND, PACKAGE = "symoro-elastic", "symoro_elastic"
OTHER_NAMES = {"--from": "box", "--free": "free"}


def with_arguments(function: Callable[P, T]) -> Callable[P, T]:
    """Return a function whose `InputError`s about options of the command line name its arguments."""
    names = _arguments(function)

    @wraps(function)
    def called(*args: P.args, **kwargs: P.kwargs) -> T:
        try:
            return function(*args, **kwargs)
        except InputError as error:
            if error.file != COMMAND:
                raise
            raise InputError(PACKAGE, argument(error.place, names), in_words(error.what, names)) from None

    return called


def argument(option: str, names: Collection[str]) -> str:
    """Return the argument that an option stands for, the option itself where there is none."""
    name = OTHER_NAMES.get(option, option.removeprefix("--").replace("-", "_"))
    return next((each for each in (name, f"{name}s") if each in names), option)


def in_words(text: str, names: Collection[str]) -> str:
    """Return a message with arguments in the place of options."""
    return re.sub(r"--[a-z][a-z-]*", lambda found: argument(found[0], names), text)


def _arguments(function: Callable[..., object]) -> set[str]:
    """Return the names of arguments, those of `**where` too."""
    found = set(signature(function).parameters)
    if "where" in found:
        from symoro_elastic.api.vibrations import Where

        found |= set(get_type_hints(Where))
    return found
