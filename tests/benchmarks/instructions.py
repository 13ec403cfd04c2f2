"""Instructions of a call of generated C, counted by callgrind: a figure that a busy machine does not move."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Mapping
from typing import Protocol

from tests.benchmarks.contest import compiled

FLAGS = ("-O2", "-mavx2", "-mfma", "-fno-math-errno", "-fno-trapping-math")
CALLS = 100
PROGRAM = """
#include <stdlib.h>
@HEADER@

int main(int count, char **words)
{
    double row[@INPUTS@], result[@RESULTS@];
    @SETUP@
    for (int k = 0; k < @INPUTS@; ++k) row[k] = @FIRST@ + 0.07*k;
    for (int call = atoi(words[count - 1]); call > 0; --call) {
        @CALL@
    }
    return 0;
}
"""


def available() -> bool:
    """Whether there is what counts."""
    return bool(shutil.which("valgrind"))


class Called(Protocol):
    """C of a function, and of a call of it at the state `row`, results in `result`."""

    @property
    def files(self) -> dict[str, str]: ...
    @property
    def header(self) -> str: ...
    @property
    def setup(self) -> str: ...
    @property
    def call(self) -> str: ...
    @property
    def inputs(self) -> list[int]: ...
    @property
    def results(self) -> list[int]: ...


def per_call(code: Called, compiler: str, first: float = 0.1) -> float:
    """Instructions of one call, the loop around it included; the inputs are `first` and numbers from there upwards."""
    words = {
        "HEADER": code.header,
        "SETUP": code.setup,
        "CALL": code.call,
        "INPUTS": str(sum(code.inputs)),
        "RESULTS": str(sum(code.results)),
        "FIRST": repr(first),
    }
    text = re.sub(r"@(\w+)@", lambda found: words[found[1]], PROGRAM)
    program = compiled([compiler, *FLAGS], {**code.files, "main.c": text}, ["-lm"], product="main")
    return (_instructions(str(program), 1 + CALLS) - _instructions(str(program), 1)) / CALLS


def counted(files: Mapping[str, str], compiler: str, word: str) -> int:
    """Instructions of a program that is given one word."""
    return _instructions(str(compiled([compiler, *FLAGS], dict(files), ["-lm"], product="main")), word)


def _instructions(program: str, word: int | str) -> int:
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", program, str(word)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found = re.search(r"Collected : (\d+)", done.stderr)
    assert found, done.stderr
    return int(found[1])
