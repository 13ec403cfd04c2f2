"""CUDA text compiled for the processor, where kernels run one thread after another."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
SYSTEM = ("limits.h", "stdio.h", "stdlib.h", "time.h", "unistd.h", "sys/timex.h")
"""Headers with macros that CUDA includes on Linux."""
FLAGS = ("-std=c++17", "-O0", "-ffp-contract=off", "-Wall", "-Wextra", "-Wno-unknown-pragmas", "-Werror")


@dataclass(frozen=True)
class HostKernels:
    """Functions that launch kernels, by name; their names in the library are those of C++."""

    library: ctypes.CDLL
    symbols: Mapping[str, str]

    def launch(self, name: str, *arguments: Any) -> None:
        """Run a kernel for all states."""
        assert self.library[self.symbols[name]](*arguments, None) == 0


def on_host(
    files: Mapping[str, str], folder: Path, sources: Sequence[str], flags: Sequence[str] = FLAGS
) -> HostKernels:
    """Files of a folder as a library, compiled without a warning."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text)
    included = [word for name in SYSTEM for word in ("-include", name)]
    command = ["g++", *flags, *included, "-shared", "-fPIC", "-I", str(HERE), "-x", "c++", *sources, "-o", "kernels.so"]
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[:2000]
    listed = subprocess.run(
        ["nm", "-D", "-C", "--defined-only", "kernels.so"], cwd=folder, capture_output=True, text=True, check=True
    )
    mangled = subprocess.run(
        ["nm", "-D", "--defined-only", "kernels.so"], cwd=folder, capture_output=True, text=True, check=True
    )
    pairs = zip(listed.stdout.splitlines(), mangled.stdout.splitlines(), strict=True)
    symbols = {line.split()[2].split("(")[0]: other.split()[2] for line, other in pairs}
    return HostKernels(ctypes.CDLL(str(folder / "kernels.so")), symbols)
