"""Python functions for the work of the command line: arguments are checked, and messages name them."""

from __future__ import annotations

import re
import reprlib
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import wraps
from inspect import BoundArguments, Signature, signature
from numbers import Real
from os import PathLike
from typing import Any, ParamSpec, TypeVar

from symoro_elastic.api.declaration import flag, options, renamed
from symoro_elastic.api.in_notebooks import followed
from symoro_elastic.api.options import OperatingPoint
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.names import did_you_mean

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
        given = _bound(function, bound, args, _renamed(function, kwargs))
        for name in given.arguments:
            given.arguments[name] = _argument(name, given.arguments[name], annotations)
        try:
            with followed(function.__name__, bound.parameters, given.arguments) as callbacks:
                given.arguments.update(callbacks)
                return function(*given.args, **given.kwargs)
        except InputError as error:
            file = PACKAGE if error.file == COMMAND else error.file
            raise InputError(file, in_words(error.place, annotations), in_words(error.what, annotations)) from None

    called.__signature__ = bound  # type: ignore[attr-defined]
    del called.__wrapped__
    return called


def _bound(
    function: Callable[..., object], bound: Signature, args: Sequence[Any], given: Mapping[str, Any]
) -> BoundArguments:
    """Return the arguments of a call; raises `TypeError` that names the function, the argument, and what is meant."""
    try:
        return bound.bind(*args, **given)
    except TypeError as error:
        raise TypeError(f"{function.__name__}() {_mistake(function, bound, args, given) or error}") from None


def _mistake(function: Callable[..., object], bound: Signature, args: Sequence[Any], given: Mapping[str, Any]) -> str:
    """Return what is wrong with a call: an unknown name, too many arguments by their place, or one that is missing."""
    rows = bound.parameters.values()
    placed = [row.name for row in rows if row.kind is row.POSITIONAL_OR_KEYWORD]
    unknown = [name for name in given if name not in bound.parameters]
    listed = [row.name for row in rows if row.kind is row.VAR_POSITIONAL and row.name in given]
    if listed:
        return f"takes {listed[0]} by place, after {', '.join(placed)}: give them without a name"
    if unknown:
        return f"got an unexpected keyword argument {unknown[0]!r}{_meant(function, unknown[0], bound.parameters)}"
    if len(args) > len(placed):
        named = ", ".join(row.name for row in rows if row.kind is row.KEYWORD_ONLY)
        what = f"takes {', '.join(placed)} by place, but got {len(args)} arguments"
        return f"{what}: give others by name ({named})" if named else what
    missing = [row.name for row in rows if row.default is row.empty and row.kind is not row.VAR_POSITIONAL]
    missing = [name for name in missing if name not in (*placed[: len(args)], *given)]
    return f"is called without {', '.join(missing)}" if missing else ""


def _meant(function: Callable[..., object], name: str, known: Collection[str]) -> str:
    """Return the end of a message about an unknown argument: a former flag with its value, or the closest name."""
    record = getattr(function, "options", None)
    for row in options(record) if record else ():
        for old in row.formerly:
            flag, _, value = old.partition("=")
            if value and flag.removeprefix("--") == name:
                return f": write {row.name}={value!r}"
    return did_you_mean(name, known)


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
    if name == "models" and isinstance(value, tuple) and len(value) == 1 and isinstance(value[0], list | tuple):
        return _names(name, value[0])
    if (expected.startswith("Sequence[str]") and value is not None) or name == "models":
        return _names(name, value)
    if expected.startswith("OperatingPoint") and not (value is None or isinstance(value, OperatingPoint)):
        raise InputError(
            PACKAGE, name, f"{type(value).__name__} is not an operating point: give other arguments by name"
        )
    if expected.startswith(("Values", "Mapping[str, float]")) and not _is_number(value, expected):
        _refuse_no_mapping(name, value)
    _refuse_other(name, value, expected)
    return value


PLAIN: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "None": ("", lambda x: x is None),
    "str": ("a text", lambda x: isinstance(x, str)),
    "Path": ("a path", lambda x: isinstance(x, PathLike)),
    "bool": ("True or False", lambda x: hasattr(type(x), "__bool__") and x is not None),
    "int": ("a whole number", lambda x: hasattr(type(x), "__float__") and float(x).is_integer()),
    "float": ("a number", lambda x: hasattr(type(x), "__float__")),
}
"""What annotations ask for, as a message says it, and whether a value is that: numbers of numpy are numbers."""


def _refuse_other(name: str, value: Any, expected: str) -> None:
    """Raise `InputError` for an argument that is neither of the plain types that it may have."""
    kinds = expected.split(" | ")
    if not PLAIN.keys() >= {*kinds} or any(PLAIN[kind][1](value) for kind in kinds):
        return
    wanted = " or ".join(PLAIN[kind][0] for kind in kinds if kind != "None")
    raise InputError(PACKAGE, name, f"{reprlib.repr(value)} is not {wanted}")


def _names(name: str, value: Any) -> Any:
    """Return names as they are given, one as a list; raises `InputError` for what is none."""
    if isinstance(value, str):
        return [value]
    if isinstance(value, list | tuple) and (wrong := [one for one in value if not isinstance(one, str)]):
        raise InputError(PACKAGE, name, f"{wrong[0]!r} is not a name: write 'name'")
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
