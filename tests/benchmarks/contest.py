"""Compiled code that takes turns: contestants, their times, and how far their numbers are apart."""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import statistics
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

BUILD = Path(__file__).parents[2] / "build" / "benchmarks"
MARCH = f"-march={os.environ.get('BENCHMARK_MARCH', 'native')}"
"""Processor that everything is compiled for, ours and peers: `x86-64-v3` is AVX2 on a processor with AVX-512."""
ROUND_NS = 2e5
LINE = 64
"""Bytes of a cache line, and of the widest vector."""
TIMED = r"""
#define _POSIX_C_SOURCE 199309L
#include <stddef.h>
#include <time.h>

@PREAMBLE@

double contest(long passes, size_t states, const @SCALAR@ *x, @SCALAR@ *y)
{
    struct timespec start, end;
    @SETUP@
    clock_gettime(CLOCK_MONOTONIC, &start);
    for (long pass = 0; pass < passes; ++pass) {
        @PASS@
    }
    clock_gettime(CLOCK_MONOTONIC, &end);
    return 1e9 * (double)(end.tv_sec - start.tv_sec) + (double)(end.tv_nsec - start.tv_nsec);
}
"""
EACH_STATE = r"""for (size_t s = 0; s < states; ++s) {
            const @SCALAR@ *row = x + s * @INPUTS@;
            @SCALAR@ *result = y + s * @RESULTS@;
            (void)result;
            @CALL@
        }"""


NEWEST_CLANG = 22
"""The newest version that is looked for."""


def newest(name: str) -> str:
    """Return the name of the newest version of Clang that is installed: `clang-19` for `clang`."""
    return next((f"{name}-{k}" for k in range(NEWEST_CLANG, 13, -1) if shutil.which(f"{name}-{k}")), name)


COMPILERS = tuple(filter(shutil.which, ("gcc", newest("clang"))))
"""Those of generated C, ours and CasADi's."""
CXX_COMPILERS = tuple(filter(shutil.which, ("g++", newest("clang++"))))
"""Those of Pinocchio: which of them makes it faster depends on the model."""


class BuildFailed(Exception):
    """A compiler refused; the message is its first error."""


@dataclass
class Contestant:
    """A function over all states: `run(passes, states, x, y)` gives nanoseconds.

    `x` holds what it reads and `y` what it writes, in the layout it wants, both from the start of a cache line;
    `columns` gives the results of each state, `(states, results)`, first those that all contestants give.
    """

    name: str
    run: Callable[..., float]
    x: Array
    y: Array
    columns: Callable[[Array], Array]
    states: int
    keep: Any = None
    passes: int = field(default=1, init=False)

    def __post_init__(self) -> None:
        self.x, self.y = aligned(self.x), aligned(self.y)

    def results(self) -> Array:
        """The results of every state."""
        self.once(1)
        return self.columns(self.y)

    def once(self, passes: int) -> float:
        """Nanoseconds a state."""
        return self.run(passes, self.states, self.x.ctypes.data, self.y.ctypes.data) / (passes * self.states)

    def settle(self) -> None:
        """Choose a number of passes that makes a round short, not too short for the clock."""
        self.once(1)
        self.passes = max(1, round(ROUND_NS / (min(self.once(1) for _ in range(3)) * self.states)))


@dataclass(frozen=True)
class Times:
    """Nanoseconds a state of every contestant in every round, `(rounds, contestants)`."""

    names: tuple[str, ...]
    ns: Array

    def median(self, name: str) -> float:
        return float(np.median(self.ns[:, self.names.index(name)]))

    def ratio(self, slower: str, faster: str) -> float:
        """Median over the rounds of the time of one over that of the other."""
        return float(statistics.median(self.ns[:, self.names.index(slower)] / self.ns[:, self.names.index(faster)]))


def contest(contestants: Sequence[Contestant], rounds: int) -> Times:
    """Let all take turns, each round in another order."""
    for contestant in contestants:
        contestant.settle()
    ns = np.empty((rounds, len(contestants)))
    rng = np.random.default_rng(0)
    for k in range(rounds):
        for i in rng.permutation(len(contestants)):
            ns[k, i] = contestants[i].once(contestants[i].passes)
    return Times(tuple(c.name for c in contestants), ns)


def difference(found: Array, wanted: Array, parts: int = 1) -> float:
    """Largest difference of a state's results, relative to its largest result; infinite for what is not a number.

    Results of several kinds are so many equal parts, each judged by its own largest.
    """
    if not np.isfinite(found).all():
        return float("inf")
    apart, size = (abs(x).reshape(len(x), parts, -1).max(axis=-1) for x in (found - wanted, wanted))
    return float((apart / size).max())


def aligned(array: Array) -> Array:
    """A copy, row by row, that starts a cache line."""
    room = np.empty(array.nbytes + LINE, np.uint8)
    start = -room.ctypes.data % LINE
    copy = room[start : start + array.nbytes].view(array.dtype).reshape(array.shape)
    copy[...] = array
    return copy


def timed(preamble: str, call: str, inputs: int, results: int, setup: str = "") -> str:
    """C of a contestant that calls a function on `row` and `result` of each state."""
    return timed_batch(preamble, fill(EACH_STATE, INPUTS=inputs, RESULTS=results, CALL=call), setup)


def timed_batch(preamble: str, pass_: str, setup: str = "", scalar: str = "double") -> str:
    """C of a contestant that does all `states` from `x` to `y` in one go, in the layout it likes."""
    return fill(TIMED, PREAMBLE=preamble, PASS=pass_, SETUP=setup).replace("@SCALAR@", scalar)


def fill(template: str, **values: object) -> str:
    for name, value in values.items():
        template = template.replace(f"@{name}@", str(value))
    return template


def compiled(
    command: Sequence[str], files: Mapping[str, str], after: Sequence[str] = (), product: str = "a.so"
) -> Path:
    """Compile texts (name to text; headers are not named to the compiler), or find what was compiled before.

    Raises `BuildFailed`.
    """
    key = hashlib.sha256(repr((command, sorted(files.items()), after, product)).encode()).hexdigest()[:20]
    folder = BUILD / key
    made = folder / product
    if made.exists():
        return made
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    sources = [name for name in files if not name.endswith((".h", ".hpp"))]
    partial = f"{product}.part"
    done = subprocess.run(
        [*command, *sources, "-o", partial, *after], cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode:
        errors = [line for line in done.stderr.splitlines() if "error" in line or "undefined" in line]
        raise BuildFailed(f"{command[0]}: {(errors or [done.stderr])[0][:300]}")
    (folder / partial).rename(made)
    return made


def entry(library: ctypes.CDLL, name: str = "contest") -> Callable[..., float]:
    function: Any = getattr(library, name)
    function.restype = ctypes.c_double
    function.argtypes = [ctypes.c_long, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_void_p]
    return function


def keeping_results(name: str, run: Callable[..., float], x: Array, results: int, keep: Any = None) -> Contestant:
    """A peer that keeps its results where it likes, and copies them only where they are asked for, untimed."""
    asked = aligned(x)

    def without_copies(passes: int, states: int, x_: int, _: int) -> float:
        return run(passes, states, x_, None)

    def columns(y: Array) -> Array:
        run(1, len(x), asked.ctypes.data, y.ctypes.data)
        return y

    return Contestant(name, without_copies, x, np.empty((len(x), results)), columns, len(x), keep)
