"""The compiler of a processor: generated C compiled to an object file, which objdump lists."""

from __future__ import annotations

import shlex
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from symoro_elastic.codegen.compile import (
    STANDARD,
    CompilationFailed,
    CompilerMissing,
    compile_object,
    find_compiler,
    run_program,
    words,
)
from symoro_elastic.foundation.input_files import is_plain_file, read_file
from symoro_elastic.foundation.output_files import temporary_folder

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
    """A compiler with its options, as a command that compiles one file."""

    compiler: tuple[str, ...]
    flags: tuple[str, ...]

    @property
    def command(self) -> str:
        """The command as one types it."""
        return shlex.join([*self.compiler, *self.flags])


@dataclass(frozen=True)
class Compiled:
    """Output of a compiler: the listing of the object file, and the stack of functions."""

    listing: str
    stack: str


def tool_chain(compiler: str = "", flags: str = "") -> ToolChain:
    """Return the named compiler, else that of this computer, with options after -std=c99 -O2.

    Raises `CompilerMissing` that names the package, `ValueError` that is the text with an open quotation mark.
    """
    command = words(compiler) or find_compiler()
    if shutil.which(command[0]) is None:
        package = PACKAGES.get(Path(command[0]).name)
        remedy = f"install it (Debian: apt install {package})" if package else "install it, or name another"
        raise CompilerMissing(f"there is no program {command[0]!r}: {remedy}")
    return ToolChain(command, (*STANDARD, "-O2", *words(flags)))


def compile_file(files: Mapping[str, str], source: str, tools: ToolChain) -> Compiled:
    """Compile one of the files (name to text) and return its listing and stack usage.

    Raises `CompilerMissing` without an objdump, `CompilationFailed`.
    """
    with temporary_folder() as folder:
        flags = [*tools.flags, "-g1", "-fstack-usage"]  # lines of code only: all of -g takes gcc a third longer
        target = compile_object(files, Path(folder), tools.compiler, flags, source)
        usage = target.with_suffix(".su")
        if not is_plain_file(usage):
            raise CompilationFailed(f"{tools.compiler[0]}: does not report the stack of functions (-fstack-usage)")
        return Compiled(_listing(target, tools), read_file(usage).decode("utf-8"))


def _listing(made: Path, tools: ToolChain) -> str:
    """The output of objdump for an object file; the compiler's objdump if it has one, else that of the system."""
    answer = run_program([*tools.compiler, "-print-prog-name=objdump"])
    program = answer.stdout.strip() or "objdump"
    if shutil.which(program) is None:
        raise CompilerMissing(f"there is no objdump for {tools.compiler[0]}: install it (Debian: apt install binutils)")
    done = run_program([program, *OBJDUMP, str(made)])
    if done.returncode:
        raise CompilationFailed(f"{program}: {done.stderr.strip().splitlines()[0] if done.stderr else 'failed'}")
    return done.stdout
