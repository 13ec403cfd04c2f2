"""What C and C++ compilers make, stored by content: the same text is compiled once for all tests, workers and runs.

Keys are digests of the preprocessed text, of the options and of the compiler with its version. A command is run as it
is where it may make more than its output file, and in tests marked `compiled_anew`; what prints something or fails is
not stored.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

COMPILERS = ("cc", "gcc", "clang", "c++", "g++", "clang++")
SOURCES = (".c", ".cc", ".cpp", ".cxx")
OBJECTS = (".o", ".a", ".so")
MORE_FILES = re.compile(
    r"-E|-S|-M.*|-x|-|@.*|--coverage|-save-temps.*|-fstack-usage|-fcallgraph-info.*|-fdump.*|-fprofile.*"
)
"""Options with which a compiler reads or writes other files than its sources, their headers and one output."""
OPTIONS_OF_RUN = {"check", "capture_output", "text", "cwd", "encoding", "errors", "stdin", "timeout"}
UNUSED = 14 * 24 * 3600
"""Time after which an entry that no run has read is deleted, s: two weeks of changes."""


class CompiledOnce:
    """A function in the place of `subprocess.run`, and the folder of what compilers have made."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.hits = 0
        self.run = subprocess.run
        """What runs commands that are not answered from the folder."""

    def __call__(self, command: Any, **options: Any) -> subprocess.CompletedProcess[Any]:
        """Return what `subprocess.run` does; the output file of a compiler is copied where it is stored."""
        output = output_of(command, options)
        key = output and self._key(command, output, options)
        if not output or not key:
            return self.run(command, **options)
        entry = self.folder / key[:2] / key
        made = Path(options.get("cwd") or ".", output)
        if _copied(entry, made):
            self.hits += 1
            empty = "" if options.get("text") or options.get("encoding") else b""
            printed = empty if options.get("capture_output") else None
            return subprocess.CompletedProcess(command, 0, printed, printed)
        done = self.run(command, **options)
        if not done.returncode and not done.stdout and not done.stderr and made.is_file():
            _store(made, entry)
        return done

    def _key(self, command: Sequence[Any], output: str, options: Mapping[str, Any]) -> str:
        """Digest of all that the output depends on; empty where the text cannot be preprocessed."""
        words, folder = [*map(str, command)], Path(options.get("cwd") or ".")
        digest = hashlib.sha256(repr((version(words[0]), processor())).encode())
        names = [word for word in words[1:] if word.endswith((*SOURCES, *OBJECTS)) and word != output]
        for name in names:
            digest.update((folder / name).read_bytes() if (folder / name).is_file() else b"")
        others, skip = [], False
        for word in words[1:]:
            skip, is_path = (
                word in ("-o", "-I", "-isystem"),
                skip or word in names or word.startswith(("-I", "-isystem")),
            )
            if not is_path and not skip:
                others.append(word)
        digest.update(repr((others, [Path(name).suffix for name in names])).encode())
        if any(name.endswith(SOURCES) for name in names):
            text = self._preprocessed(words, output, folder)
            if text is None:
                return ""
            digest.update(text)
        return digest.hexdigest()

    def _preprocessed(self, words: Sequence[str], output: str, folder: Path) -> bytes | None:
        kept = [
            word for word in words if not word.startswith(("-W", "-l", "-o")) and word not in (output, "-shared", "-c")
        ]
        kept = [word for word in kept if not word.endswith(OBJECTS)]
        done = self.run([*kept, "-E", "-P"], cwd=folder, capture_output=True, check=False)
        return None if done.returncode else done.stdout


def output_of(command: Any, options: Mapping[str, Any]) -> str:
    """The output file of a command that compiles files to this one file and does nothing else, or nothing."""
    if not isinstance(command, (list, tuple)) or len(command) < 3 or not options.keys() <= OPTIONS_OF_RUN:
        return ""
    words = [*map(str, command)]
    if words[0] not in COMPILERS or "-o" not in words[:-1] or any(map(MORE_FILES.fullmatch, words)):
        return ""
    return words[words.index("-o") + 1]


@cache
def version(compiler: str) -> str:
    """The path and all that a compiler says of its version."""
    path = shutil.which(compiler) or compiler
    run = subprocess.run([path, "--version"], capture_output=True, text=True, check=False)
    return f"{os.path.realpath(path)} {run.stdout}"


@cache
def processor() -> str:
    """What code for the native processor depends on."""
    found = re.search(r"^flags\s*:.*$", _cpuinfo(), re.MULTILINE)
    return f"{platform.machine()} {platform.processor()} {found[0] if found else ''}"


def _cpuinfo() -> str:
    path = Path("/proc/cpuinfo")
    return path.read_text(encoding="utf-8") if path.is_file() else ""


def delete_unused(folder: Path) -> None:
    """Delete entries that have not been read for long."""
    for path in folder.glob("*/*"):
        if path.stat().st_mtime < time.time() - UNUSED:
            path.unlink(missing_ok=True)


def _copied(entry: Path, made: Path) -> bool:
    """Copy an entry, if there is one, to a file of its own, as linkers do: a library of that name may be loaded."""
    whole = made.with_name(f"{made.name}.copied")
    try:
        shutil.copy(entry, whole)
        os.utime(entry)
    except FileNotFoundError:
        return False
    os.replace(whole, made)
    return True


def _store(made: Path, entry: Path) -> None:
    """Store a file as a whole or not at all, whatever other workers do."""
    entry.parent.mkdir(parents=True, exist_ok=True)
    descriptor, name = tempfile.mkstemp(dir=entry.parent)
    os.close(descriptor)
    shutil.copy(made, name)
    os.replace(name, entry)
