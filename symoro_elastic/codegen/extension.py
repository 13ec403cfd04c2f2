"""Generated C called from Python through an extension module, which is compiled once for a process."""

from __future__ import annotations

import ctypes
import platform
import sys
import sysconfig
from collections.abc import Callable, Mapping
from functools import cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

from symoro_elastic.codegen.arguments import call_anyhow, describe
from symoro_elastic.codegen.c.calls import called_functions
from symoro_elastic.codegen.compile import CompilationFailed, compile_library, load_library
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.real_numbers import real_numbers
from symoro_elastic.codegen.targets.python import CALLS, render_calls, render_table
from symoro_elastic.foundation.input_files import is_plain_file
from symoro_elastic.foundation.output_files import temporary_folder

FLAGS = ("-O2", "-ffp-contract=off", *(("-march=native",) if platform.machine() in ("x86_64", "AMD64") else ()))
"""Flags for this processor only, with the results of any other: no product is fused with a sum."""
UNDEFINED = ("-undefined", "dynamic_lookup") if sys.platform == "darwin" else ()
"""Linker options that leave the functions of Python to the process that loads a module, where needed."""


@cache
def calls_module() -> ModuleType:
    """Return the module that calls functions of tables; raises `CompilerMissing`, `CompilationFailed`."""
    include = sysconfig.get_path("include")
    if not is_plain_file(Path(include, "Python.h")):
        raise CompilationFailed("the headers of Python are missing (Debian: apt install python3-dev)")
    with temporary_folder() as folder:
        flags = ("-O2", "-Wno-pedantic", f"-isystem{include}", *UNDEFINED)
        library = compile_library(render_calls(), Path(folder), flags=flags, sources=(CALLS,))
        spec = spec_from_file_location("_calls", library)
        if spec is None or spec.loader is None:
            raise CompilationFailed(f"this Python imports no modules that end in {library.suffix}")
        try:
            module = module_from_spec(spec)
            spec.loader.exec_module(module)
        except ImportError as error:
            raise CompilationFailed(f"what the compiler wrote cannot be loaded: {error}") from None
    return module


def extension_functions(package: Package, folder: Path, described: Mapping[str, Callable[..., Any]]) -> dict[str, Any]:
    """Return compiled models and time steps by name, with the docstrings in `described`.

    Their library is closed when none of them is held any more; those with a sentence in `closed` raise it as a
    `ValueError`. Raises `CompilerMissing`, `CompilationFailed`.
    """
    module = calls_module()
    library = load_library(compile_library(render_table(package), folder, flags=FLAGS))
    table = ctypes.addressof(ctypes.c_char.in_dll(library, f"{package.name}_table"))
    functions = {}
    for called in called_functions(package):
        function = module.Function(called.name, call_anyhow, table, library)
        inputs = {array.name: array.shapes for array in called.inputs}
        functions[called.name] = describe(function, described[called.name], inputs, real_numbers)
    return functions
