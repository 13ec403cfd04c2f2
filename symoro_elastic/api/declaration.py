"""Options of operations: each is declared once, as a field of a record.

The command line makes its options of these fields, with their help and completion. `operation` makes keyword arguments
of them, the signature and the section "Parameters" of the docstring; `read_options` reads them from a TOML file.
"""

from __future__ import annotations

import inspect
import operator
import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import MISSING, Field, FrozenInstanceError, dataclass, field, fields, replace
from functools import wraps
from inspect import Parameter, Signature, cleandoc
from numbers import Real
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, Protocol, TypeVar, dataclass_transform, overload

from symoro_elastic.api.kinds import COMMAND, FLAG, TEXT, Kind
from symoro_elastic.foundation.errors import InputError

if TYPE_CHECKING:
    from pathlib import Path

    from symoro_elastic.machine.machine import Machine

P = ParamSpec("P")
M = TypeVar("M")
M_contra = TypeVar("M_contra", contravariant=True)
O = TypeVar("O")  # noqa: E741
R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)

PACKAGE = "symoro_elastic"
OPTION, NAMES, MODELS = "option", "{names}", "models"
MACHINE = "A machine, its file or its tables."
PYTHON = Kind()
WIDTH, INDENT = 112, " " * 4
HOLDS: dict[str, Callable[[Any, float], bool]] = {"at least": operator.ge, "above": operator.gt, "at most": operator.le}
WRITTEN = re.compile(r"--[a-z][a-z-]*")


@dataclass(frozen=True, eq=False)
class Option:
    """One option of an operation.

    `meaning` is a sentence that help and docstrings share; `{names}` in it are the names that `names()` returns, of a
    registry, which the shell completes, as it does those that `of_machine` returns of the machine. `metavar` is how
    its value is written on the command line; without one, and not a flag, Python alone has the option. `bare` is its
    value where the command line gives none. `formerly` are the names it had in the last version, of the command line
    ("--rate", or "--quick=quick" for a flag that stood for a value) and of Python ("rates"). `in_python` follows in
    the docstring alone. Numbers are within `least` and `most`, or `above` a bound.
    """

    meaning: str
    metavar: str = ""
    kind: Kind = TEXT
    names: Callable[[], Iterable[str]] | None = None
    of_machine: Callable[[Machine], Iterable[str]] | None = None
    bare: str = ""
    formerly: tuple[str, ...] = ()
    in_python: str = ""
    least: float | None = None
    above: float | None = None
    most: float | None = None
    name: str = ""
    default: Any = None
    required: bool = False
    is_keyword: bool = True

    @property
    def flag(self) -> str:
        """Its name on the command line: `--value` for `values`, which may be repeated there."""
        return flag(self.name, self.kind.many)

    @property
    def on_command_line(self) -> bool:
        """Whether commands have it."""
        return bool(self.metavar) or self.kind is FLAG

    def refuse_beyond(self, x: Any) -> None:
        """Raise `InputError` for a number beyond the bounds, NaN included."""
        bounds = {"at least": self.least, "above": self.above, "at most": self.most}
        given = {word: bound for word, bound in bounds.items() if bound is not None}
        if isinstance(x, Real) and not all(HOLDS[word](x, bound) for word, bound in given.items()):
            wanted = " and ".join(f"{word} {bound:g}" for word, bound in given.items())
            raise InputError(COMMAND, self.flag, f"{x!r} is out of range: give a number {wanted}")

    @property
    def help(self) -> str:
        """The help text."""
        text = self._with_names()
        return f"{text.removesuffix('.')}; may be repeated." if self.kind.many else text

    def described(self, arguments: Mapping[str, str]) -> str:
        """Return the text of docstrings, with `arguments` by option in the place of options."""
        text = f"{self._with_names()} {self.in_python}".rstrip()
        return WRITTEN.sub(lambda option: arguments.get(option[0], option[0]), text)

    def _with_names(self) -> str:
        if self.names is None or NAMES not in self.meaning:
            return self.meaning
        return self.meaning.replace(NAMES, ", ".join(map(str, self.names())))


def flag(name: str, is_repeated: bool = False) -> str:
    """Return the option of a name; one that may be repeated is in the singular."""
    singular = f"{name[:-3]}y" if name.endswith("ies") else name.removesuffix("s")
    return f"--{singular if is_repeated else name}".replace("_", "-")


def option(default: Any, metavar: str, meaning: str, kind: Kind = TEXT, **more: Any) -> Any:
    """Return a field of a dataclass that holds an option; one without default, `...`, must be given."""
    return _field(Option(meaning, metavar, kind, **more), default)


def switch(meaning: str, **more: Any) -> Any:
    """Return a field that holds an option without a value."""
    return _field(Option(meaning, "", FLAG, **more), False)


def argument(default: Any, meaning: str, **more: Any) -> Any:
    """Return a field that holds an argument of Python, which commands do not have."""
    return _field(Option(meaning, kind=PYTHON, **more), default)


def _field(row: Option, default: Any) -> Any:
    metadata = {OPTION: row}
    if default is ...:
        return field(metadata=metadata)
    if isinstance(default, dict):
        return field(default_factory=dict, metadata=metadata)
    return field(default=default, metadata=metadata)


@dataclass_transform(frozen_default=True, kw_only_default=True)
class Options:
    """Base of records of options: its subclasses are frozen dataclasses, for which no code is compiled at start-up."""

    def __init_subclass__(cls, kw_only: bool = True) -> None:
        dataclass(init=False, repr=False, eq=False, kw_only=kw_only)(cls)

    def __init__(self, *args: Any, **given: Any) -> None:
        values = _signature(type(self)).bind(*args, **given).arguments
        for row in options(type(self)):
            default = dict(row.default) if isinstance(row.default, dict) else row.default
            vars(self)[row.name] = values.get(row.name, default)
            row.refuse_beyond(vars(self)[row.name])
        self.__post_init__()

    def __post_init__(self) -> None:
        """Raise `InputError` for options that exclude each other."""

    def __setattr__(self, name: str, value: Any) -> None:
        raise FrozenInstanceError(f"cannot assign to field {name!r}")

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and vars(self) == vars(other)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        given = (f"{row.name}={getattr(self, row.name)!r}" for row in options(type(self)))
        return f"{type(self).__name__}({', '.join(given)})"


def options(record: type[Any]) -> tuple[Option, ...]:
    """Return the options of a record: those given by their place, its own, then those of its bases."""
    if record not in _OPTIONS:
        rows = [_completed(one) for one in fields(record) if OPTION in one.metadata]
        rows.sort(key=lambda row: (row.is_keyword and row.name != MODELS, _depth(record, row.name)))
        _OPTIONS[record] = tuple(rows)
    return _OPTIONS[record]


_OPTIONS: dict[Any, tuple[Option, ...]] = {}


def _completed(one: Field[Any]) -> Option:
    """Return the option that a field holds, with its name and default."""
    is_empty = one.default is MISSING and one.default_factory is MISSING
    default = {} if one.default_factory is not MISSING else None if is_empty else one.default
    row: Option = one.metadata[OPTION]
    return replace(row, name=one.name, default=default, required=is_empty, is_keyword=bool(one.kw_only))


def _depth(record: type[Any], name: str) -> int:
    """Return how far up in the bases of a dataclass a field comes from."""
    return max(k for k, base in enumerate(record.__mro__) if name in getattr(base, "__dataclass_fields__", ()))


def part(record: Callable[..., O], whole: Any) -> O:
    """Return those options of a record that another one has, as that one."""
    return record(**{one.name: getattr(whole, one.name) for one in fields(record)})  # type: ignore[arg-type]


def renamed(record: type[Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return arguments under the names that they have now; warns of former ones."""
    former = {old: row.name for row in options(record) for old in row.formerly if not old.startswith("-")}
    for old in given.keys() & former.keys():
        what = f"{old} is now {former[old]}: the former name goes with the next version"
        warnings.warn(what, DeprecationWarning, stacklevel=outside())
    return {former.get(name, name): x for name, x in given.items()}


def outside() -> int:
    """Return the stack level of the line of the user's program, as `warnings.warn` counts where this is called."""
    frame, level = inspect.currentframe(), 0
    while frame and str(frame.f_globals.get("__name__", "")).partition(".")[0] == PACKAGE:
        frame, level = frame.f_back, level + 1
    return level


def operation(
    record: Callable[P, O], machine: str = MACHINE
) -> Callable[[Callable[[M, O], R]], Callable[Concatenate[M, P], R]]:
    """Return a decorator of a function of a machine and a record: its fields become arguments."""
    meaning = machine

    def decorate(function: Callable[[M, O], R]) -> Callable[Concatenate[M, P], R]:
        @wraps(function)
        def called(machine: M, *args: P.args, **kwargs: P.kwargs) -> R:
            return function(machine, record(*args, **renamed(record, kwargs)))  # type: ignore[arg-type]

        made: Any = _described(called, record, meaning)
        return made  # type: ignore[no-any-return]

    return decorate


class OfModels(Protocol[M_contra, P, R_co]):
    """A function of a machine, names of models, and options."""

    @overload
    def __call__(self, machine: M_contra, /, *args: P.args, **options: P.kwargs) -> R_co: ...
    @overload
    def __call__(self, machine: M_contra, model: str, /, *args: P.args, **options: P.kwargs) -> R_co: ...
    @overload
    def __call__(self, machine: M_contra, one: str, two: str, /, *args: P.args, **options: P.kwargs) -> R_co: ...
    @overload
    def __call__(
        self, machine: M_contra, one: str, two: str, three: str, /, *args: P.args, **options: P.kwargs
    ) -> R_co: ...


def operation_on_models(record: Callable[P, O]) -> Callable[[Callable[[M, O], R]], OfModels[M, P, R]]:
    """Return the decorator of `operation` for a record of `models`, which are given one after the other."""

    def decorate(function: Callable[[M, O], R]) -> OfModels[M, P, R]:
        @wraps(function)
        def called(machine: M, *models: str, **given: Any) -> R:
            given = renamed(record, given)  # type: ignore[arg-type]
            return function(machine, record(**{**given, MODELS: models or given.get(MODELS, ())}))  # type: ignore[call-arg]

        made: Any = _described(called, record, MACHINE, MODELS)
        return made  # type: ignore[no-any-return]

    return decorate


def _described(function: Any, record: Any, machine: str, models: str = "") -> Any:
    """Return a function with the signature and the docstring that follow from the options of a record.

    It does not lead to the function that it wraps: programs that write documentation would show that one's signature.
    """
    annotations = [*function.__annotations__.values(), Signature.empty]
    first = Parameter("machine", Parameter.POSITIONAL_OR_KEYWORD, annotation=annotations[0])
    returned = function.__annotations__.get("return", Signature.empty)
    function.__signature__ = Signature([first, *_parameters(record, models)], return_annotation=returned)
    function.__doc__ = with_parameters(function.__doc__ or "", record, machine)
    function.options = record
    del function.__wrapped__
    return function


def _signature(record: type[Any]) -> Signature:
    return Signature([*_parameters(record)])


def _parameters(record: type[Any], models: str = "") -> Iterator[Parameter]:
    types = {one.name: one.type for one in fields(record)}
    for row in options(record):
        if row.name == models:
            yield Parameter(MODELS, Parameter.VAR_POSITIONAL, annotation="str")
        else:
            kind = Parameter.KEYWORD_ONLY if row.is_keyword else Parameter.POSITIONAL_OR_KEYWORD
            default = Parameter.empty if row.required else row.default
            yield Parameter(row.name, kind, default=default, annotation=types[row.name])


RAISES = "Raises\n------"


def with_parameters(text: str, record: type[Any], machine: str = MACHINE) -> str:
    """Return a docstring with the options of a record as its section "Parameters"."""
    rows = options(record)
    arguments = {row.flag: row.name for row in rows}
    lines = [
        "Parameters",
        "----------",
        "machine",
        *wrap(machine, WIDTH, initial_indent=INDENT, subsequent_indent=INDENT),
    ]
    for row in rows:
        lines.append(f"{row.name} : {row.kind.shape}" if row.kind.shape else row.name)
        lines += wrap(row.described(arguments), WIDTH, initial_indent=INDENT, subsequent_indent=INDENT)
    before, raises, after = cleandoc(text).partition(RAISES)
    return "\n".join([before.rstrip(), "", *lines, "", f"{raises}{after}"]).rstrip() + "\n"


def read_options(path: str | Path, record: type[Any]) -> dict[str, Any]:
    """Return the options of a record that a TOML file gives, by name; raises `InputError`."""
    from symoro_elastic.formats.files import load_text
    from symoro_elastic.formats.toml.tables import load

    rows = {row.name: row for row in options(record)}
    former = {old: row.name for row in rows.values() for old in row.formerly if not old.startswith("-")}
    top = load(load_text(path), str(path)).only([*(name for name, row in rows.items() if row.kind.read), *former])
    values: dict[str, Any] = {}
    for key in top.entries:
        read = rows[former.get(key, key)].kind.read
        if read is None:
            raise InputError(COMMAND, key, "is not an option of files")
        values[former.get(key, key)] = read(top, key)
    return values
