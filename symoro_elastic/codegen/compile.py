"""Generated C compiled into a shared library and called from Python."""

from __future__ import annotations

import ctypes
import math
import os
import shlex
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symoro_elastic.codegen.c import render_c
from symoro_elastic.codegen.package import Function, Package

Array: TypeAlias = NDArray[np.float64]

COMPILERS = ("gcc", "clang", "cc")
FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fPIC", "-shared")
# gcc's register allocation is super-linear in straight-line code: 2000 statements take 1 s, 6000
# take 10 s and 15 000 a minute at -O2 (and at -O1), 1.5 s at -O0.
MOST_OPTIMISED = 3000


class CompilerMissing(Exception):
    """There is no C compiler; the message says what to install."""


class CompilationFailed(Exception):
    """The compiler refused generated code; the message is its first complaint."""


def find_compiler() -> tuple[str, ...]:
    """The command of the C compiler: $CC where it is set, else the first of gcc, clang, cc.

    Raises `CompilerMissing`.
    """
    asked = os.environ.get("CC", "").strip()
    if asked:
        command = tuple(shlex.split(asked))
        if shutil.which(command[0]) is None:
            raise CompilerMissing(f"CC is {asked!r}, and there is no such program: set CC to a C compiler, or unset it")
        return command
    for name in COMPILERS:
        if shutil.which(name):
            return (name,)
    raise CompilerMissing(
        f"no C compiler ({', '.join(COMPILERS)}): install one (Debian: apt install gcc), or set CC to yours"
    )


def optimisation(package: Package) -> str:
    """-O2, and -O0 for functions so long that an optimising compiler would take minutes."""
    longest = max((len(f.program.once) + len(f.program.statements) for f in package.functions), default=0)
    return "-O2" if longest <= MOST_OPTIMISED else "-O0"


def compile_library(
    files: Mapping[str, str], folder: Path, compiler: Sequence[str] = (), flags: Sequence[str] = ("-O2",)
) -> Path:
    """Write C files (name to text) into a folder, compile them there, return the shared library.

    Raises `CompilerMissing`, `CompilationFailed`.
    """
    command = [*(compiler or find_compiler()), *FLAGS, *flags]
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    sources = [name for name in files if name.endswith(".c")]
    library = folder / f"{Path(sources[0]).stem}.so"
    done = subprocess.run(
        [*command, *sources, "-o", library.name, "-lm"], cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise CompilationFailed(f"{command[0]}: {_first_complaint(done.stderr)}")
    return library


def _first_complaint(messages: str) -> str:
    """The first line that holds an error, without the notes before it."""
    lines = [line.strip() for line in messages.splitlines() if line.strip()]
    return next((line for line in lines if "error:" in line), lines[0] if lines else "failed without a message")


class CompiledPackage:
    """The functions of a package, compiled; SI units, radians, arrays as in its header."""

    def __init__(self, package: Package, library: Path) -> None:
        """Load a library made from the C text of this package."""
        self.package = package
        self._functions = {function.name: function for function in package.functions}
        loaded = ctypes.CDLL(str(library.resolve()))
        self._entries = {name: _entry(loaded, package, function) for name, function in self._functions.items()}
        self._defaults = np.array([parameter.value for parameter in package.parameters], dtype=float)

    def call(self, function: str, **arrays: ArrayLike) -> dict[str, Array]:
        """Results by name of a function such as `direct_dynamics` at q=..., qd=..., tau=..., p=....

        Leading axes broadcast; p defaults to the machine's values. Raises `ValueError` naming
        the array whose shape is wrong, `TypeError` for arguments that the function has not.
        """
        signature, entry = self._functions[function], self._entries[function]
        inputs = self._inputs(signature, arrays)
        lead = np.broadcast_shapes(*(array.shape[:-1] for array in inputs))
        states = math.prod(lead)
        rows = [
            np.ascontiguousarray(np.broadcast_to(a, (*lead, a.shape[-1]))).reshape(states, a.shape[-1]) for a in inputs
        ]
        results = [np.empty((states, math.prod(result.shape))) for result in signature.results]
        steps = [(array.ctypes.data, array.strides[0]) for array in (*rows, *results)]
        for state in range(states):
            entry(*(address + state * stride for address, stride in steps))
        return {
            result.name: array.reshape((*lead, *result.shape))
            for result, array in zip(signature.results, results, strict=True)
        }

    def _inputs(self, signature: Function, arrays: Mapping[str, ArrayLike]) -> list[Array]:
        sizes = {argument.name: argument.size for argument in signature.arguments}
        if self.package.parameters:
            sizes["p"] = len(self.package.parameters)
        given: dict[str, ArrayLike] = {"p": self._defaults, **arrays}
        if set(sizes) - set(given) or set(arrays) - {*sizes, "p"}:
            raise TypeError(f"{signature.name} takes {', '.join(sizes)}, not {', '.join(arrays)}")
        return [_checked(name, given[name], size) for name, size in sizes.items()]


def compile_package(
    package: Package, folder: Path, files: Mapping[str, str] | None = None, compiler: Sequence[str] = ()
) -> CompiledPackage:
    """A package compiled in a folder, from its C text `files` where that is at hand.

    Raises `CompilerMissing`, `CompilationFailed`.
    """
    texts = render_c(package) if files is None else files
    return CompiledPackage(package, compile_library(texts, folder, compiler, (optimisation(package),)))


def _entry(library: ctypes.CDLL, package: Package, function: Function) -> Any:
    entry = library[f"{package.name}_{function.name}"]
    count = len(function.arguments) + bool(package.parameters) + len(function.results)
    entry.argtypes, entry.restype = [ctypes.c_void_p] * count, None
    return entry


def _rows(array: Array, lead: tuple[int, ...], states: int) -> Array:
    """An array broadcast to the leading axes, one state a row."""
    size = array.shape[-1]
    return np.ascontiguousarray(np.broadcast_to(array, (*lead, size))).reshape(states, size)


def _checked(name: str, value: ArrayLike, size: int) -> Array:
    array = np.asarray(value, dtype=float)
    if array.ndim == 0 or array.shape[-1] != size:
        raise ValueError(f"{name} has shape {array.shape}: (..., {size}) is expected")
    return array
