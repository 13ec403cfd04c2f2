"""The binary of an FMU for this platform."""

from __future__ import annotations

import platform
import tempfile
from pathlib import Path

from symoro_elastic.codegen.compile import CompilationFailed, CompilerMissing, compile_library
from symoro_elastic.codegen.described import Files
from symoro_elastic.codegen.package import Package
from symoro_elastic.errors import InputError
from symoro_elastic.fmu.sources import interface_file

MOST_OPTIMISED = 20_000
"""Statements of a function that are compiled at -O2 in half a minute; longer ones at -O1."""
SYSTEMS = {"Linux": "linux", "Darwin": "darwin", "Windows": "windows"}
MACHINES = {"amd64": "x86_64", "x86_64": "x86_64", "arm64": "aarch64", "aarch64": "aarch64"}
OF_FMI_2 = {"x86_64-linux": "linux64", "x86_64-darwin": "darwin64", "x86_64-windows": "win64"}


def platform_folder(version: int) -> str:
    """Return the name of the folder of binaries for this platform."""
    system, machine = platform.system(), platform.machine().lower()
    named = f"{MACHINES.get(machine, machine)}-{SYSTEMS.get(system, system.lower())}"
    return OF_FMI_2.get(named, named) if version == 2 else named


def compiled(package: Package, sources: Files, version: int) -> bytes | None:
    """Return the shared library made of the sources; None where there is no compiler. Raises `InputError`."""
    longest = max(len(f.program.once) + len(f.program.statements) for f in package.functions)
    level = "-O2" if longest <= MOST_OPTIMISED else "-O1"
    flags = (level, "-ffp-contract=off", "-fvisibility=hidden", "-Wno-error")
    names = [f"{package.name}.c", interface_file(version)]
    with tempfile.TemporaryDirectory(prefix="symoro_elastic_") as folder:
        try:
            return compile_library(sources, Path(folder), flags=flags, sources=names).read_bytes()
        except CompilerMissing:
            return None
        except CompilationFailed as error:
            raise InputError(package.source or package.name, "C compiler", str(error)) from None
