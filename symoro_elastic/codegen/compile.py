"""Generated C compiled into a shared library and called from Python."""

from __future__ import annotations

import _ctypes
import ctypes
import math
import os
import shlex
import shutil
import subprocess
import weakref
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symoro_elastic.codegen.arguments import as_numbers
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.real_numbers import real_numbers
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.input_files import is_plain_file
from symoro_elastic.foundation.output_files import fill_folder

Array: TypeAlias = NDArray[Any]

TYPES: dict[str, type[np.floating]] = {"double": np.float64, "float": np.float32}
"""Types of numpy for the types of arrays in C."""
COMPILERS = ("gcc", "clang", "cc")
STANDARD = ("-std=c99",)
"""The language; gcc then rounds each operation, and fuses products and sums without it."""
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Werror")
ON_WINDOWS = os.name == "nt"
FLAGS = (*STANDARD, *WARNINGS, *(() if ON_WINDOWS else ("-fPIC",)), "-shared")
LIBRARIES = () if ON_WINDOWS else ("-lm",)
"""Windows has its functions in the library of C, and code that can be anywhere."""
LONGEST = 3600.0
"""Timeout of a compiler, s: 30 joints with all derivatives need minutes."""
MOST_OPTIMISED = 3000
"""Statements of a function that an optimising compiler handles in a few seconds; -O0 needs a tenth of that."""


class CompilerError(InputError):
    """A C compiler has to be installed or repaired."""

    def __init__(self, what: str) -> None:
        super().__init__("symoro-elastic", "C compiler", what)


class CompilerMissing(CompilerError):
    """No C compiler is installed; the message names the package."""


class CompilationFailed(CompilerError):
    """The compiler rejected generated code (with its first message), or produced no file."""


def find_compiler() -> tuple[str, ...]:
    """The command of the C compiler: $CC if set, else the first available of gcc, clang, cc.

    Raises `CompilerMissing`.
    """
    value = os.environ.get("CC", "").strip()
    if value:
        try:
            command = words(value)
        except ValueError:
            raise CompilerMissing(f"CC is {value!r}, with an unmatched quotation mark: close it, or unset CC") from None
        if shutil.which(command[0]) is None:
            raise CompilerMissing(f"CC is {value!r}, and there is no such program: set CC to a C compiler, or unset it")
        return command
    for name in COMPILERS:
        if shutil.which(name):
            return (name,)
    raise CompilerMissing(
        f"no C compiler ({', '.join(COMPILERS)}): install one (Debian: apt install gcc), or set CC to yours"
    )


def words(command: str) -> tuple[str, ...]:
    """Return the words of a command as a shell splits them; the path of a file is a single word even with blanks.

    Raises `ValueError`, the command, for an open quotation.
    """
    if is_plain_file(command):
        return (command,)
    try:
        split = shlex.split(command, posix=not ON_WINDOWS)  # Windows has backslashes in paths
    except ValueError:
        raise ValueError(command) from None
    return tuple(word.strip('"') for word in split) if ON_WINDOWS else tuple(split)


def run_program(command: Sequence[str], folder: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a program of a compiler and return its output, in any encoding.

    Raises `CompilationFailed` where it cannot be started, and where it does not end.
    """
    try:
        return subprocess.run(
            command, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, encoding="utf-8", errors="replace",
            timeout=LONGEST, check=False,
        )  # fmt: skip
    except OSError as error:
        what = f"cannot be started ({error.strerror}): set CC to a C compiler, or unset it"
    except subprocess.TimeoutExpired:
        what = f"has not ended in {LONGEST:g} s: ask for fewer models, or set CC to another compiler"
    raise CompilationFailed(f"{command[0]}: {what}")


def optimisation(package: Package) -> str:
    """The optimization option for code that is compiled for checks: -O2, or -O0 for long functions."""
    longest = max((len(f.program.once) + len(f.program.statements) for f in package.functions), default=0)
    return "-O2" if longest <= MOST_OPTIMISED else "-O0"


def compile_library(
    files: Mapping[str, str],
    folder: Path,
    compiler: Sequence[str] = (),
    flags: Sequence[str] = ("-O2",),
    sources: Sequence[str] = (),
) -> Path:
    """Write C files (name to text) into a folder, compile all or the given sources, return the shared library.

    Raises `CompilerMissing`, `CompilationFailed`.
    """
    command = [*(compiler or find_compiler()), *FLAGS, *flags]
    sources = sources or [name for name in files if name.endswith(".c")]
    library = folder / f"{Path(sources[0]).stem}.so"
    return _run_compiler(files, [*command, *sources, "-o", library.name, *LIBRARIES], library)


def compile_object(
    files: Mapping[str, str], folder: Path, compiler: Sequence[str], flags: Sequence[str], source: str
) -> Path:
    """Write C files (name to text) into a folder, compile one of them, return the object file.

    `flags` are the options of the code; warnings are errors in addition. Raises `CompilationFailed`.
    """
    target = folder / f"{Path(source).stem}.o"
    return _run_compiler(files, [*compiler, *WARNINGS, *flags, "-c", source, "-o", target.name], target)


def _run_compiler(files: Mapping[str, str], command: Sequence[str], target: Path) -> Path:
    """Write files into the folder of the target, run a command there, and return the target."""
    fill_folder(target.parent, files)
    done = run_program(command, target.parent)
    if done.returncode:
        raise CompilationFailed(f"{command[0]}: {_first_complaint(done.stderr)}")
    if not is_plain_file(target):
        kind = (
            "object file, is it a C compiler?"
            if target.suffix == ".o"
            else "library: set CC to a C compiler, or unset it"
        )
        raise CompilationFailed(f"{command[0]}: wrote no {kind}")
    return target


def _first_complaint(messages: str) -> str:
    """The first line of compiler messages that contains an error, without the notes before it."""
    lines = [line.strip() for line in messages.splitlines() if line.strip()]
    return next((line for line in lines if "error:" in line), lines[0] if lines else "failed without a message")


class CompiledPackage:
    """The functions of a package, compiled; SI units, radians, arrays as in its header."""

    def __init__(self, package: Package, library: Path, precision: Precision = DOUBLE) -> None:
        """Load a library made from the C text of this package in a precision; raises `CompilationFailed`."""
        self.package, self.precision = package, precision
        self.type = TYPES[precision.state]
        self._functions = {function.name: function for function in package.functions}
        loaded = load_library(library)
        self._entries, self._batches = {}, {}
        for name, function in self._functions.items():
            in_c = precision.function(package.name, name)
            arrays = len(package.inputs(function)) + len(function.results)
            self._entries[name] = _entry(loaded, in_c, arrays)
            if function.arguments:
                with suppress(CompilationFailed):
                    self._batches[name] = _entry(loaded, f"{in_c}_batch", arrays, ctypes.c_size_t)
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
        rows = [self._rows(array, lead) for array in inputs]
        results = [np.empty((states, math.prod(result.shape)), self.type) for result in signature.results]
        steps = [(array.ctypes.data, array.strides[0]) for array in (*rows, *results)]
        for state in range(states):
            entry(*(address + state * stride for address, stride in steps))
        return self._by_name(signature, results, lead)

    def call_batch(self, function: str, **arrays: ArrayLike) -> dict[str, Array]:
        """Results by name at many states, as of `call`, by a single call of the batch entry; one p for all.

        Raises `KeyError` where the library was compiled without the files of the target `c-batch`.
        """
        signature = self._functions[function]
        *inputs, p = self._inputs(signature, arrays)
        lead = np.broadcast_shapes(*(array.shape[:-1] for array in inputs))
        states = math.prod(lead)
        columns = [np.ascontiguousarray(self._rows(array, lead).T) for array in inputs]
        results = [np.empty((math.prod(result.shape), states), self.type) for result in signature.results]
        parameters = np.ascontiguousarray(p, self.type)
        self._batches[function](states, *(array.ctypes.data for array in (*columns, parameters, *results)))
        return self._by_name(signature, [np.ascontiguousarray(array.T) for array in results], lead)

    def _rows(self, array: Array, lead: tuple[int, ...]) -> Array:
        """An array broadcast to the leading axes, with one row per state."""
        size = array.shape[-1]
        wide = array if array.shape[:-1] == lead else np.broadcast_to(array, (*lead, size))
        return np.ascontiguousarray(wide, self.type).reshape(math.prod(lead), size)

    def _by_name(self, signature: Function, results: Sequence[Array], lead: tuple[int, ...]) -> dict[str, Array]:
        return {
            result.name: array.reshape((*lead, *result.shape))
            for result, array in zip(signature.results, results, strict=True)
        }

    def _inputs(self, signature: Function, arrays: Mapping[str, ArrayLike]) -> list[Array]:
        sizes = self.package.inputs(signature)
        inputs: dict[str, ArrayLike] = {"p": self._defaults, **arrays}
        if inputs.keys() != sizes.keys():
            raise TypeError(f"{signature.name} takes {', '.join(sizes)}, not {', '.join(arrays)}")
        return [as_numbers(name, real_numbers(inputs[name]), ((size,),)) for name, size in sizes.items()]


def compile_package(
    package: Package,
    folder: Path,
    files: Mapping[str, str] | None = None,
    compiler: Sequence[str] = (),
    precision: Precision = DOUBLE,
    flags: Sequence[str] = (),
) -> CompiledPackage:
    """Compile a package in a folder, from its C text `files` if available, by default for checks.

    Raises `CompilerMissing`, `CompilationFailed`.
    """
    texts = render_c_batch(package, precision) if files is None else files
    return CompiledPackage(
        package, compile_library(texts, folder, compiler, flags or (optimisation(package),)), precision
    )


def load_library(library: Path) -> ctypes.CDLL:
    """Return a compiled library, which is closed when neither it nor a function of it is referenced any more.

    Raises `CompilationFailed` for a file that is not a library.
    """
    try:
        loaded = ctypes.CDLL(str(library.resolve()))
    except OSError as error:
        raise CompilationFailed(f"what the compiler wrote cannot be loaded: {error}") from None
    if close := getattr(_ctypes, "dlclose", None) or getattr(_ctypes, "FreeLibrary", None):
        weakref.finalize(loaded, close, loaded._handle).atexit = False
    return loaded


def function_in(library: ctypes.CDLL, name: str) -> Any:
    """Return a function of a library; raises `CompilationFailed` where it has none of that name."""
    try:
        return library[name]
    except AttributeError:
        what = f"the library that the compiler wrote has no function {name}: is CC a C compiler?"
        raise CompilationFailed(what) from None


def _entry(library: ctypes.CDLL, name: str, arrays: int, *first: Any) -> Any:
    """A function of the library whose arguments are the types `first`, then pointers to arrays."""
    entry = function_in(library, name)
    entry.argtypes, entry.restype = [*first, *[ctypes.c_void_p] * arrays], None
    return entry
