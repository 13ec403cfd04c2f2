"""A digest of what a sweep computes: data of machines and arguments, functions with all that their code names."""

from __future__ import annotations

import copyreg
import dis
import functools
import hashlib
import inspect
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import PurePath
from types import CodeType, EllipsisType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import is_plain_file, read_file

OWN = __name__.partition(".")[0]
SOURCE = "source"
"""Fields that hold the name of a file, whose place does not matter."""
PLAIN = (str, int, float, complex, type(None), EllipsisType, range, slice, PurePath, Enum, np.generic)
"""Types whose `repr` says all."""


def digest(*parts: object) -> str:
    """Return a digest of machines and arguments, without the names of their files, and of functions.

    That of a function depends on its code, defaults, enclosed and global values, and on the functions and classes of
    its module that they name; of other modules on the file and the version. Raises `InputError` for what has no form
    that can be compared, such as an open file.
    """
    sha = hashlib.sha256()
    with _refuse_unknown_form("the function or its arguments"):
        for word in _Words().of(parts):
            sha.update(word + b"\0")
    return sha.hexdigest()


class _Words:
    """Conversion of data of any kind to bytes, equal for equal data; a `repr` may omit parts."""

    def __init__(self) -> None:
        self.module = ""
        self.known: dict[int, Any] = {}
        self.modules: set[str] = set()
        self.within: list[int] = []
        self.digests: dict[int, tuple[Any, bytes]] = {}

    def of(self, value: Any) -> Iterator[bytes]:
        """Yield the bytes of a value; raises `TypeError` for a value without a digest."""
        if isinstance(value, PLAIN):
            yield repr(value).encode()
        elif isinstance(value, bytes):
            yield value
        elif id(value) in self.within:
            yield b"again"
        elif id(value) not in self.digests:
            self.within.append(id(value))
            words = self._code(value) if _is_code(value) else self._data(value)
            self.digests[id(value)] = value, hashlib.sha256(b"\0".join(words)).digest()
            self.within.pop()
            yield self.digests[id(value)][1]
        else:
            yield self.digests[id(value)][1]

    def _data(self, value: Any) -> Iterator[bytes]:
        if is_dataclass(value):
            yield from self._class(type(value))
            pairs = ((item.name, getattr(value, item.name)) for item in fields(value))
            yield from self.of([pair for pair in pairs if pair[0] != SOURCE])
        elif isinstance(value, Mapping):
            yield from self.of(list(value.items()))
        elif isinstance(value, list | tuple):
            yield str(len(value)).encode()
            for entry in value:
                yield from self.of(entry)
        elif isinstance(value, set | frozenset):
            yield from sorted(b" ".join(self.of(entry)) for entry in value)
        elif isinstance(value, np.ndarray):
            yield f"{value.shape} {value.dtype}".encode()
            yield from self.of(value.tolist()) if value.dtype.hasobject else (value.tobytes(),)
        else:
            yield from self.of(type(value))
            registered = copyreg.dispatch_table.get(type(value))
            reduced = registered(value) if registered else value.__reduce_ex__(4)
            maker, *parts = (type(value), reduced) if isinstance(reduced, str) else reduced
            yield f"{maker.__module__}.{maker.__qualname__}".encode()
            yield from self.of([list(part) if isinstance(part, Iterator) else part for part in parts])

    def _code(self, value: Any) -> Iterator[bytes]:
        """Yield the bytes of a function, a class, or a module; repeated ones by name alone."""
        yield f"{getattr(value, '__module__', '')}.{getattr(value, '__qualname__', type(value).__name__)}".encode()
        if id(value) in self.known:
            return
        self.known[id(value)] = value
        if isinstance(value, ModuleType):
            yield from self._module(value.__name__)
        elif isinstance(value, type):
            yield from self._class(value)
        elif isinstance(value, MethodType):
            yield from self.of((value.__self__, value.__func__))
        elif isinstance(value, functools.partial):
            yield from self.of((value.func, value.args, value.keywords))
        elif isinstance(value, FunctionType):
            yield from self._function(value)
        elif hasattr(value, "__wrapped__"):
            yield from self.of(value.__wrapped__)
        elif not isinstance(getattr(value, "__self__", None), ModuleType | type(None)):
            yield from self.of(value.__self__)

    def _function(self, function: FunctionType) -> Iterator[bytes]:
        self.module = self.module or function.__module__
        yield from self.of((function.__defaults__, function.__kwdefaults__))
        cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
        for name, cell in cells:
            with _refuse_unknown_form(f"{name}, which {function.__name__} uses,"):
                yield from self.of(_content(cell))
        if function.__module__ != self.module:
            yield from self._module(function.__module__)
            return
        yield from self._instructions(function.__code__)
        for name, value in _global_values(function):
            with _refuse_unknown_form(f"{name}, which {function.__name__} uses,"):
                yield from (name.encode(), *self.of(value))

    def _instructions(self, code: CodeType) -> Iterator[bytes]:
        yield code.co_code
        yield from self.of((code.co_names, code.co_varnames, code.co_freevars))
        for constant in code.co_consts:
            yield from self._instructions(constant) if isinstance(constant, CodeType) else self.of(constant)

    def _class(self, kind: type) -> Iterator[bytes]:
        """Yield the bytes of a class: its methods and plain values if it is in the module of the function."""
        yield kind.__qualname__.encode()
        if kind.__module__.partition(".")[0] == OWN:
            return
        if not self.module and "__call__" in dir(kind):
            self.module = kind.__module__
        if kind.__module__ != self.module:
            yield from self._module(kind.__module__)
            return
        for name, member in vars(kind).items():
            function = getattr(member, "__func__", None) or getattr(member, "fget", None) or member
            if isinstance(function, FunctionType) or (isinstance(function, PLAIN) and not name.startswith("__")):
                yield from self.of((name, function))
        yield from self.of(kind.__bases__)

    def _module(self, name: str) -> Iterator[bytes]:
        """Yield the name of a module, and once its version and its text."""
        yield name.encode()
        if name in self.modules:
            return
        self.modules.add(name)
        module = sys.modules.get(name)
        file = getattr(module, "__file__", None) or ""
        yield str(getattr(module, "__version__", "")).encode()
        if file.endswith(".py") and is_plain_file(file):
            yield read_file(file)


def _is_code(value: Any) -> bool:
    is_wrapper = callable(value) and hasattr(value, "__wrapped__")
    return isinstance(value, ModuleType | type | functools.partial) or inspect.isroutine(value) or is_wrapper


def _content(cell: Any) -> Any:
    try:
        return cell.cell_contents
    except ValueError:
        return None


def _global_values(function: FunctionType) -> list[tuple[str, Any]]:
    """Return the global values that the code of a function names, and `module.value` of modules, by name."""
    values: dict[str, Any] = {}
    for code in _codes(function.__code__):
        steps = list(dis.get_instructions(code))
        for step, then in zip(steps, [*steps[1:], None], strict=True):
            name = str(step.argval)
            if step.opname not in ("LOAD_GLOBAL", "LOAD_NAME") or name not in function.__globals__:
                continue
            values[name] = value = function.__globals__[name]
            if isinstance(value, ModuleType) and then is not None and then.opname in ("LOAD_ATTR", "LOAD_METHOD"):
                values[f"{name}.{then.argval}"] = getattr(value, str(then.argval), None)
    return sorted(values.items(), key=lambda pair: pair[0])


def _codes(code: CodeType) -> Iterable[CodeType]:
    """Yield a code object and those of its inner functions."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


@contextmanager
def _refuse_unknown_form(what: str) -> Iterator[None]:
    """Turn errors of values without a digest into `InputError`."""
    try:
        yield
    except (TypeError, ValueError, AttributeError, RecursionError):
        cannot = f"cannot detect whether {what} has changed since"
        ways_out = "create it inside the function, or leave out the journal"
        raise InputError("symoro-elastic", "journal", f"{cannot}: {ways_out}") from None
