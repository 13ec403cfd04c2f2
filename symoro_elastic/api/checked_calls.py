"""Python functions for the operations of the command line: arguments are checked, and messages name them."""

from __future__ import annotations

import re
import reprlib
import sys
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import wraps
from html import escape
from inspect import BoundArguments, Signature, signature
from numbers import Real
from os import PathLike
from typing import Any, ParamSpec, TypeVar

from symoro_elastic.api.declaration import flag, options, under_present_names
from symoro_elastic.api.options import OperatingPoint, Reading
from symoro_elastic.api.quantities import has_unit
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.progress import Progress
from symoro_elastic.machine.names import did_you_mean

P = ParamSpec("P")
T = TypeVar("T")

COMMAND, PACKAGE = "symoro-elastic", "symoro_elastic"
OPTION = re.compile(r"--[a-z][a-z-]*")
SHOWN_AFTER, AT_LEAST_BETWEEN = 1.0, 0.2
"""s: when a call is long, and how often what is shown of it changes."""


def with_arguments(function: Callable[P, T]) -> Callable[P, T]:
    """Return a function that accepts a single name as a list, and whose `InputError`s name its arguments."""
    bound = signature(function)
    annotations = {name: str(parameter.annotation) for name, parameter in bound.parameters.items()}
    record = getattr(function, "options", None)
    listed = next((row.name for row in bound.parameters.values() if row.kind is row.VAR_POSITIONAL), "")

    @wraps(function)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> T:
        positional: tuple[Any, ...] = (*args, kwargs.pop(listed)) if listed in kwargs and len(args) == 1 else args
        arguments = _bound(function, bound, positional, under_present_names(record, kwargs) if record else kwargs)
        for name in arguments.arguments:
            arguments.arguments[name] = _argument(name, arguments.arguments[name], annotations)
        try:
            with progress_callbacks(function.__name__, bound.parameters, arguments.arguments) as callbacks:
                arguments.arguments.update(callbacks)
                return function(*arguments.args, **arguments.kwargs)
        except InputError as error:
            file = PACKAGE if error.file == COMMAND else error.file
            raise InputError(file, in_words(error.place, annotations), in_words(error.what, annotations)) from None

    wrapper.__signature__ = bound  # type: ignore[attr-defined]
    del wrapper.__wrapped__
    return wrapper


def _bound(
    function: Callable[..., object], bound: Signature, args: Sequence[Any], keywords: Mapping[str, Any]
) -> BoundArguments:
    """Return the arguments of a call; raises `TypeError` that names the function, the argument, and the correction."""
    try:
        return bound.bind(*args, **keywords)
    except TypeError as error:
        raise TypeError(f"{function.__name__}() {_mistake(function, bound, args, keywords) or error}") from None


def _mistake(function: Callable[..., object], bound: Signature, args: Sequence[Any], passed: Mapping[str, Any]) -> str:
    """Return the fault of a call: an unknown name, too many positional arguments, or a missing one."""
    rows = bound.parameters.values()
    by_place = [row.name for row in rows if row.kind is row.POSITIONAL_OR_KEYWORD]
    unknown = [name for name in passed if name not in bound.parameters]
    listed = [row.name for row in rows if row.kind is row.VAR_POSITIONAL and row.name in passed]
    if listed:
        return f"accepts {listed[0]} by place or by name, not both"
    if unknown:
        return f"got an unexpected keyword argument {unknown[0]!r}{_meant(function, unknown[0], bound.parameters)}"
    if len(args) > len(by_place):
        named = ", ".join(row.name for row in rows if row.kind is row.KEYWORD_ONLY)
        what = f"accepts {', '.join(by_place)} by place, but got {len(args)} arguments"
        return f"{what}: give others by name ({named})" if named else what
    missing = [row.name for row in rows if row.default is row.empty and row.kind is not row.VAR_POSITIONAL]
    missing = [name for name in missing if name not in (*by_place[: len(args)], *passed)]
    return f"is called without {', '.join(missing)}" if missing else ""


def _meant(function: Callable[..., object], name: str, parameters: Collection[str]) -> str:
    """Return the hint on an unknown argument: its new form, that `read` accepts it, or the closest of `parameters`."""
    record = getattr(function, "options", None)
    for row in options(record) if record else ():
        for old in (*row.formerly, *row.gone):
            flag, _, value = old.partition("=")
            if value and flag.removeprefix("--") == name:
                return f": write {row.name}={value!r}"
    if name in {row.name for row in options(Reading)}:
        return f": give it to read, as in {function.__name__}(read(machine, {name}=...))"
    return did_you_mean(name, parameters)


def argument(option: str, names: Collection[str]) -> str:
    """Return which of the Python arguments `names` a command-line option stands for; the option itself if none."""
    return next((name for name in names if option in (flag(name), flag(name, True))), option)


def in_words(text: str, names: Collection[str]) -> str:
    """Return a message with arguments in place of options."""
    return OPTION.sub(lambda option: argument(option[0], names), text)


BY_NAME = ("Over", "Values")
"""Annotations of arguments that give numbers by name."""


def _argument(name: str, value: Any, annotations: Mapping[str, str]) -> Any:
    """Return an argument in the type of the function; raises `InputError` for values that are not numbers by name."""
    expected = annotations.get(name, "")
    if name == "models" and isinstance(value, tuple) and len(value) == 1 and isinstance(value[0], list | tuple):
        return _names(name, value[0])
    if (expected.startswith("Sequence[str]") and value is not None) or name == "models":
        return _names(name, value)
    if expected.startswith("OperatingPoint") and not (value is None or isinstance(value, OperatingPoint)):
        by_name = next((key for key, kind in annotations.items() if kind in BY_NAME), "values")
        what = f"{type(value).__name__} is not an operating point: numbers by name are {by_name}={{...}}"
        raise InputError(PACKAGE, name, what)
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
    "float": ("a number", lambda x: hasattr(type(x), "__float__") or _has_unit(x)),
}
"""What annotations ask for, as a message says it, and whether a value is that: numbers of numpy are numbers."""


def _refuse_other(name: str, value: Any, expected: str) -> None:
    """Raise `InputError` for a value of another type than the plain types of an argument."""
    kinds = expected.split(" | ")
    if not PLAIN.keys() >= {*kinds} or any(PLAIN[kind][1](value) for kind in kinds):
        return
    wanted = " or ".join(PLAIN[kind][0] for kind in kinds if kind != "None")
    raise InputError(PACKAGE, name, f"{reprlib.repr(value)} is not {wanted}")


def _names(name: str, value: Any) -> Any:
    """Return names as passed, a single one as a list; raises `InputError` for other values."""
    if isinstance(value, str):
        return [value]
    if isinstance(value, list | tuple) and (wrong := [entry for entry in value if not isinstance(entry, str)]):
        raise InputError(PACKAGE, name, f"{wrong[0]!r} is not a name: write 'name'")
    return value


def _is_number(value: Any, expected: str) -> bool:
    return "| float" in expected and (isinstance(value, Real) or _has_unit(value))


def _has_unit(value: Any) -> bool:
    """Return whether a value is a text of a number with a unit."""
    return isinstance(value, str) and has_unit(value)


def _refuse_no_mapping(name: str, value: Any) -> None:
    if not isinstance(value, Mapping):
        what = f'{value!r} gives no numbers by name: write {{"name": 1.0}}'
        raise InputError(PACKAGE, name, what)
    for key, x in value.items():
        if not isinstance(key, str) or not (isinstance(x, Real) or _has_unit(x)):
            raise InputError(PACKAGE, name, f"{key!r}: {x!r} is not a number by name: write {{'name': 1.0}}")


@contextmanager
def progress_callbacks(name: str, parameters: Collection[str], passed: Collection[str]) -> Iterator[dict[str, Any]]:
    """Yield the callbacks among `parameters` that are not `passed`: they show progress in a notebook.

    Elsewhere there are none. What is shown comes after a second and goes at the end.
    """
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if getattr(shell, "kernel", None) is None:
        yield {}
        return
    from IPython.display import display, update_display

    line = _Shown(name, display, update_display)
    callbacks = {"progress": line.progress, "announce": line.announce, "watched": line.step_progress}
    try:
        yield {key: call for key, call in callbacks.items() if key in parameters and key not in passed}
    finally:
        line.end()


class _Shown:
    """A line and a progress bar below a notebook cell."""

    def __init__(self, name: str, display: Any, update: Any) -> None:
        self.name, self.step = name, ""
        self._display, self._update = display, update
        self._next = time.monotonic() + SHOWN_AFTER
        self._id: str | None = None

    def announce(self, step: str) -> None:
        self.step = step
        self._show("", "")

    def step_progress(self, step: str) -> Progress:
        self.announce(step)
        return self.progress

    def progress(self, done: int, total: int) -> None:
        bar = f'<progress max="{int(total)}" value="{int(done)}" aria-label="{escape(self.name)}"></progress> '
        self._show(bar, f" {done} of {total}")

    def end(self) -> None:
        """Remove the line and the bar."""
        if self._id:
            self._show("", None)

    def _show(self, bar: str, count: str | None) -> None:
        if count is not None and time.monotonic() < self._next:
            return
        self._next = time.monotonic() + AT_LEAST_BETWEEN
        text = "" if count is None else f"{self.name}{f', {self.step}' if self.step else ''}{count}"
        data = {"text/plain": text, "text/html": bar + escape(text)}
        if self._id:
            self._update(data, display_id=self._id, raw=True)
        else:
            self._id = self._display(data, display_id=True, raw=True).display_id
