"""CUDA text compiled by NVRTC, the compiler of NVIDIA that is a library: no toolkit and no device are needed."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from ctypes.util import find_library
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path

MISSING = "no NVRTC: pip install nvidia-cuda-nvrtc-cu12 (Linux, Windows; it needs no device)"
USED = re.compile(r"Used (\d+) registers")
STACK = re.compile(r"(\d+) bytes stack frame, (\d+) bytes spill stores, (\d+) bytes spill loads")


class CompilationFailed(Exception):
    """NVRTC refused; the message is its log."""


@dataclass(frozen=True)
class KernelUse:
    """Registers of a thread of a kernel, its stack and what it writes to and reads from there in place of registers."""

    name: str
    registers: int
    stack: int
    stored: int
    loaded: int


@dataclass(frozen=True)
class Compiled:
    """Machine code for one architecture, and what the compiler tells of its kernels."""

    cubin: bytes
    log: str

    @property
    def kernels(self) -> Iterator[KernelUse]:
        """The use of each kernel; spills of the functions that it calls count as its own."""
        for text in self.log.split("Compiling entry function '")[1:]:
            rows = [tuple(map(int, found)) for found in STACK.findall(text)]
            stack, stored, loaded = (sum(column) for column in zip(*rows, strict=True))
            registers = USED.search(text)
            assert registers is not None
            yield KernelUse(text.partition("'")[0], int(registers[1]), stack, stored, loaded)


@cache
def library() -> ctypes.CDLL | None:
    """The library from the package index, else that of a toolkit; None where there is none."""
    found = find_spec("nvidia") and find_spec("nvidia.cuda_nvrtc")
    folders = list(found.submodule_search_locations or ()) if found else []
    files = sorted(file for folder in folders for file in Path(folder).glob("lib/libnvrtc.so.*"))
    name = str(files[0]) if files else find_library("nvrtc")
    return ctypes.CDLL(name) if name else None


def architectures() -> list[int]:
    """The architectures that the library compiles for: 70 stands for sm_70."""
    nvrtc, count = _library(), ctypes.c_int()
    nvrtc.nvrtcGetNumSupportedArchs(ctypes.byref(count))
    found = (ctypes.c_int * count.value)()
    nvrtc.nvrtcGetSupportedArchs(found)
    return list(found)


def compiled(text: str, headers: Mapping[str, str], architecture: int, options: Sequence[str] = ()) -> Compiled:
    """Return a text compiled that may include files of these names; raises `CompilationFailed`."""
    nvrtc, program = _library(), ctypes.c_void_p()
    texts, names = _strings(headers.values()), _strings(headers)
    created = nvrtc.nvrtcCreateProgram(ctypes.byref(program), text.encode(), b"main.cu", len(headers), texts, names)
    _done(created)
    given = [f"--gpu-architecture=sm_{architecture}", "--ptxas-options=-v", *options]
    result = nvrtc.nvrtcCompileProgram(program, len(given), _strings(given))
    log = _read(program, "ProgramLog").decode().rstrip("\0")
    try:
        if result:
            raise CompilationFailed(log)
        return Compiled(_read(program, "CUBIN"), log)
    finally:
        nvrtc.nvrtcDestroyProgram(ctypes.byref(program))


def _library() -> ctypes.CDLL:
    found = library()
    if found is None:
        raise SystemExit(MISSING)
    return found


def _read(program: ctypes.c_void_p, what: str) -> bytes:
    size = ctypes.c_size_t()
    _done(_library()[f"nvrtcGet{what}Size"](program, ctypes.byref(size)))
    text = ctypes.create_string_buffer(size.value)
    _done(_library()[f"nvrtcGet{what}"](program, text))
    return text.raw


def _strings(texts: Iterable[str]) -> ctypes.Array[ctypes.c_char_p]:
    encoded = [text.encode() for text in texts]
    return (ctypes.c_char_p * len(encoded))(*encoded)


def _done(result: int) -> None:
    if result:
        nvrtc = _library()
        nvrtc.nvrtcGetErrorString.restype = ctypes.c_char_p
        raise CompilationFailed(nvrtc.nvrtcGetErrorString(result).decode())
