"""Options of operations: each is declared once, as a field of a record.

The command line makes options from its fields, with their help and completion. `operation` makes keyword arguments
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
from symoro_elastic.api.quantities import UnitOf, convert, converted_by_name, has_unit
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
    ("--rate", or "--quick=quick" for a flag that stood for a value) and of Python ("rates"); `gone` are those of the
    version before, which are refused by their present name. `in_python` follows in the docstring alone. Numbers with
    units are converted to `unit`, or to that of the machine for a name; without one they are refused. Numbers are
    within `least` and `most`, or `above` a bound.
    """

    meaning: str
    metavar: str = ""
    kind: Kind = TEXT
    names: Callable[[], Iterable[str]] | None = None
    of_machine: Callable[[Machine], Iterable[str]] | None = None
    bare: str = ""
    formerly: tuple[str, ...] = ()
    gone: tuple[str, ...] = ()
    in_python: str = ""
    unit: str | UnitOf | None = None
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
        """Whether commands have this option."""
        return bool(self.metavar) or self.kind is FLAG

    def refuse_beyond(self, x: Any) -> None:
        """Raise `InputError` for a number beyond the bounds, NaN included."""
        bounds = {"at least": self.least, "above": self.above, "at most": self.most}
        bounded = {word: bound for word, bound in bounds.items() if bound is not None}
        if isinstance(x, Real) and not all(HOLDS[word](x, bound) for word, bound in bounded.items()):
            wanted = " and ".join(f"{word} {bound:g}" for word, bound in bounded.items())
            raise InputError(COMMAND, self.flag, f"{x!r} is out of range: give a number {wanted}")

    @property
    def help(self) -> str:
        """The help text."""
        text = self._with_names()
        return f"{text.removesuffix('.')}; may be repeated." if self.kind.many else text

    def docstring_text(self, arguments: Mapping[str, str]) -> str:
        """Return the option's meaning for docstrings: options in it, such as --value, are replaced by `arguments`."""
        text = f"{self._with_names()} {self.in_python}".rstrip()
        return WRITTEN.sub(lambda option: arguments.get(option[0], option[0]), text)

    def _with_names(self) -> str:
        if self.names is None or NAMES not in self.meaning:
            return self.meaning
        return self.meaning.replace(NAMES, ", ".join(map(str, self.names())))


def flag(name: str, is_repeated: bool = False) -> str:
    """Return the option of a name; one that may be repeated is in the singular."""
    singular = f"{name[:-3]}y" if name.endswith("ies") else name.removesuffix("s")
    return f"--{singular if is_repeated else name}".rstrip("_").replace("_", "-")


def option(default: Any, metavar: str, meaning: str, kind: Kind = TEXT, **more: Any) -> Any:
    """Return a field of a dataclass with an option; one without default, `...`, is required."""
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

    def __init__(self, *args: Any, **keywords: Any) -> None:
        values = Signature([*_parameters(type(self))]).bind(*args, **keywords).arguments
        for row in options(type(self)):
            default = dict(row.default) if isinstance(row.default, dict) else row.default
            value = values.get(row.name, default)
            if row.kind.has_numbers and not callable(row.unit):
                value = convert(value, row.unit, row.flag)
            vars(self)[row.name] = value
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
        entries = (f"{row.name}={getattr(self, row.name)!r}" for row in options(type(self)))
        return f"{type(self).__name__}({', '.join(entries)})"


def options(record: type[Any]) -> tuple[Option, ...]:
    """Return the options of a record: positional ones, its own, then those of its bases."""
    if record not in _OPTIONS:
        rows = [_option_of(item) for item in fields(record) if OPTION in item.metadata]
        rows.sort(key=lambda row: (row.is_keyword and row.name != MODELS, _depth(record, row.name)))
        _OPTIONS[record] = tuple(rows)
    return _OPTIONS[record]


_OPTIONS: dict[Any, tuple[Option, ...]] = {}


def _option_of(item: Field[Any]) -> Option:
    """Return the option of a field, with its name and default."""
    is_empty = item.default is MISSING and item.default_factory is MISSING
    default = {} if item.default_factory is not MISSING else None if is_empty else item.default
    row: Option = item.metadata[OPTION]
    return replace(row, name=item.name, default=default, required=is_empty, is_keyword=bool(item.kw_only))


def _depth(record: type[Any], name: str) -> int:
    """Return the index of the farthest base of a dataclass that has a field."""
    return max(k for k, base in enumerate(record.__mro__) if name in getattr(base, "__dataclass_fields__", ()))


def in_si_units(machine: Any, record: O) -> O:
    """Return options whose values by name are numbers in the units that a machine, or its file, needs.

    Raises `InputError`.
    """
    late = [row for row in options(type(record)) if callable(row.unit) and has_unit(vars(record)[row.name])]
    parts = {name: x for name, x in vars(record).items() if isinstance(x, Options)}
    if not late and not parts:
        return record
    from symoro_elastic.generation.pipeline import prepare
    from symoro_elastic.machine.machine import Machine

    described = prepare(machine) if late and not isinstance(machine, Machine) else machine
    changed = {name: in_si_units(described, x) for name, x in parts.items()}
    for row in late:
        x = converted_by_name(vars(record)[row.name], row.unit, described, row.flag)  # type: ignore[arg-type]
        again = row.kind.parse if row.kind.is_text and row.kind.parse else None
        changed[row.name] = again([f"{name}={text}" for name, text in x.items()], row.flag) if again else x
    copy: Any = object.__new__(type(record))
    vars(copy).update({**vars(record), **changed})
    return copy  # type: ignore[no-any-return]


def part(record: Callable[..., O], source: Any) -> O:
    """Return a record of type `record` with the values that the options have in another record."""
    return record(**{item.name: getattr(source, item.name) for item in fields(record)})  # type: ignore[arg-type]


def under_present_names(record: type[Any], arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return arguments under their present names; warns of former ones, refuses those of the version before."""
    gone = {old: row.name for row in options(record) for old in row.gone if not old.startswith("-")}
    for old in arguments.keys() & gone.keys():
        raise TypeError(f"{old} is now {gone[old]}")
    former = {old: row.name for row in options(record) for old in row.formerly if not old.startswith("-")}
    for old in arguments.keys() & former.keys():
        what = f"{old} is now {former[old]}: the former name goes with the next version"
        warnings.warn(what, DeprecationWarning, stacklevel=outside())
    return {former.get(name, name): x for name, x in arguments.items()}


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
        def wrapper(machine: M, *args: P.args, **kwargs: P.kwargs) -> R:
            options = record(*args, **under_present_names(record, kwargs))  # type: ignore[arg-type]
            return function(machine, in_si_units(machine, options))

        wrapped: Any = _with_signature(wrapper, record, meaning)
        return wrapped  # type: ignore[no-any-return]

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
    """Return a decorator of a function of a machine and a record: its `models` become *models, others keywords."""

    def decorate(function: Callable[[M, O], R]) -> OfModels[M, P, R]:
        @wraps(function)
        def wrapper(machine: M, *models: str, **keywords: Any) -> R:
            keywords = under_present_names(record, keywords)  # type: ignore[arg-type]
            options = record(**{**keywords, MODELS: models or keywords.get(MODELS, ())})  # type: ignore[call-arg]
            return function(machine, in_si_units(machine, options))

        wrapped: Any = _with_signature(wrapper, record, MACHINE, MODELS)
        return wrapped  # type: ignore[no-any-return]

    return decorate


def _with_signature(function: Any, record: Any, machine: str, models: str = "") -> Any:
    """Return a function with the signature and the docstring of the options of a record.

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


def _parameters(record: type[Any], models: str = "") -> Iterator[Parameter]:
    types = {item.name: item.type for item in fields(record)}
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
        lines += wrap(row.docstring_text(arguments), WIDTH, initial_indent=INDENT, subsequent_indent=INDENT)
    before, raises, after = cleandoc(text).partition(RAISES)
    return "\n".join([before.rstrip(), "", *lines, "", f"{raises}{after}"]).rstrip() + "\n"


def read_options(path: str | Path, record: type[Any]) -> dict[str, Any]:
    """Return the options of a record in a TOML file, by name; raises `InputError`."""
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
