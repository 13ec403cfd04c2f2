"""The compiler of a processor: generated C compiled to an object file, which objdump lists."""

from __future__ import annotations

import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from symoro_elastic.codegen.compile import (
    STANDARD,
    CompilationFailed,
    CompilerMissing,
    compile_object,
    find_compiler,
    words,
)
from symoro_elastic.foundation.input_files import is_plain_file, read_file

PACKAGES = {
    "gcc": "gcc",
    "clang": "clang",
    "arm-none-eabi-gcc": "gcc-arm-none-eabi",
    "arm-linux-gnueabihf-gcc": "gcc-arm-linux-gnueabihf",
}
"""Packages of Debian."""
OBJDUMP = ("-d", "-r", "-l", "-h", "-t", "--no-show-raw-insn")


@dataclass(frozen=True)
class ToolChain:
    """A compiler with its options, as a command that compiles one file: all that its code depends on."""

    compiler: tuple[str, ...]
    flags: tuple[str, ...]

    @property
    def command(self) -> str:
        """The command as one types it."""
        return shlex.join([*self.compiler, *self.flags])


@dataclass(frozen=True)
class Compiled:
    """What a compiler wrote: the listing of the object file, and how much stack each function takes."""

    listing: str
    stack: str


def tool_chain(compiler: str = "", flags: str = "") -> ToolChain:
    """Return the compiler that is named, else that of this computer, with options; -std=c99 -O2 comes before them.

    Raises `CompilerMissing` that names the package, `ValueError` that is the text with an open quotation mark.
    """
    command = words(compiler) or find_compiler()
    if shutil.which(command[0]) is None:
        package = PACKAGES.get(Path(command[0]).name)
        remedy = f"install it (Debian: apt install {package})" if package else "install it, or name another"
        raise CompilerMissing(f"there is no program {command[0]!r}: {remedy}")
    return ToolChain(command, (*STANDARD, "-O2", *words(flags)))


def compile_file(files: Mapping[str, str], source: str, tools: ToolChain) -> Compiled:
    """Compile one of the files (name to text) and return what there is in it.

    Raises `CompilerMissing` where there is no objdump, `CompilationFailed`.
    """
    with tempfile.TemporaryDirectory() as folder:
        flags = [*tools.flags, "-g1", "-fstack-usage"]  # lines of code only: all of -g takes gcc a third longer
        made = compile_object(files, Path(folder), tools.compiler, flags, source)
        usage = made.with_suffix(".su")
        if not is_plain_file(usage):
            raise CompilationFailed(f"{tools.compiler[0]}: does not report the stack of functions (-fstack-usage)")
        return Compiled(_listing(made, tools), read_file(usage).decode("utf-8"))


def _listing(made: Path, tools: ToolChain) -> str:
    """What objdump prints of an object file; that which belongs to the compiler, else that of this computer."""
    asked = subprocess.run([*tools.compiler, "-print-prog-name=objdump"], capture_output=True, text=True, check=False)
    program = asked.stdout.strip() or "objdump"
    if shutil.which(program) is None:
        raise CompilerMissing(f"there is no objdump for {tools.compiler[0]}: install it (Debian: apt install binutils)")
    done = subprocess.run([program, *OBJDUMP, str(made)], capture_output=True, text=True, check=False)
    if done.returncode:
        raise CompilationFailed(f"{program}: {done.stderr.strip().splitlines()[0] if done.stderr else 'failed'}")
    return done.stdout
