"""Generated C as contestants: the call of one state and the batch, in any precision, parameters folded or not."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.precision import DOUBLE, SINGLE, Precision
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.symbolic.program import OperationCount
from tests.benchmarks.contest import MARCH, Array, Contestant, compiled, entry, timed, timed_batch

FAST = ("-O3", "-fPIC", "-shared", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math")
NATIVE = (MARCH,)
AVX512 = NATIVE
PAIRS = (*AVX512, "-DVECTOR_BYTES=128")
"""Two vectors side by side."""
AVX2 = ("-mavx2", "-mfma")


@dataclass(frozen=True)
class Code:
    """The C of one model of a machine, and the pieces of calls to it."""

    package: Package
    function: Function
    precision: Precision

    @property
    def name(self) -> str:
        return self.precision.function(self.package.name, self.function.name)

    @property
    def files(self) -> dict[str, str]:
        return render_c(self.package, self.precision)

    @property
    def batch_files(self) -> dict[str, str]:
        return render_c_batch(self.package, self.precision)

    @property
    def header(self) -> str:
        return f'#include "{self.package.name}{self.precision.suffix}.h"'

    @property
    def batch_header(self) -> str:
        return f'{self.header}\n#include "{self.package.name}{self.precision.suffix}_batch.h"'

    @property
    def inputs(self) -> list[int]:
        return [argument.size for argument in self.function.arguments]

    @property
    def results(self) -> list[int]:
        return [int(np.prod(result.shape)) for result in self.function.results]

    @property
    def operations(self) -> OperationCount:
        return self.function.program.count

    @property
    def setup(self) -> str:
        """C of the work that depends on parameters only."""
        if not self.has_constants:
            return ""
        real, count = self.precision.type_of_real(self.package.name), f"{self.name.upper()}_CONSTANTS"
        return f"{real} c[{count}]; {self.name}_prepare({self.parameters}, c);"

    @property
    def has_constants(self) -> bool:
        return bool(self.function.program.once)

    @property
    def parameters(self) -> str:
        return f"{self.package.name}{self.precision.suffix}_defaults" if self.package.parameters else "NULL"

    @property
    def call(self) -> str:
        """C of the model at the state `row`."""
        prepared, c = ("_prepared", ["c"]) if self.has_constants else ("", [])
        inputs, results = places("row", self.inputs), places("result", self.results)
        return f"{self.name}{prepared}({', '.join([*inputs, self.parameters, *c, *results])});"

    @property
    def batch(self) -> str:
        """C of the model at all states, entry k of state s at [k*states + s]."""
        inputs = places("x", self.inputs, "*states")
        results = places("y", self.results, "*states")
        return f"{self.name}_batch({', '.join(['states', *inputs, self.parameters, *results])});"


def places(array: str, sizes: Sequence[int], times: str = "") -> list[str]:
    """C of the place of each of these parts of an array, one after another."""
    return [f"{array} + {start}{times}" for start in np.cumsum([0, *sizes[:-1]])]


def code(machine: Machine, model: str, *, fold: bool = True, precision: Precision = DOUBLE) -> Code:
    """One model; with all parameters folded, or with parameters as an argument."""
    package = programs(machine, Scene(models=(model,), fold=ALL if fold else ())).package
    return Code(package, package.functions[0], precision)


def scalar(code: Code, x: Array, name: str, compiler: str, flags: Sequence[str] = NATIVE) -> Contestant:
    """A call for each state."""
    text = timed(code.header, code.call, sum(code.inputs), sum(code.results), code.setup)
    y = np.empty((len(x), sum(code.results)))
    return Contestant(name, _entry(code.files, text, compiler, flags), x, y, lambda y: y, len(x))


def batch(code: Code, x: Array, name: str, compiler: str, flags: Sequence[str] = AVX512) -> Contestant:
    """One call for all states."""
    text = timed_batch(code.batch_header, code.batch, scalar=code.precision.state)
    dtype = np.float32 if code.precision is SINGLE else np.float64
    y = np.empty((sum(code.results), len(x)), dtype)
    columns = np.ascontiguousarray(x.T, dtype)
    run = _entry(code.batch_files, text, compiler, flags)
    return Contestant(name, run, columns, y, lambda y: y.T, len(x))


def _entry(files: dict[str, str], text: str, compiler: str, flags: Sequence[str]) -> Callable[..., float]:
    library = compiled([compiler, *FAST, *flags], {**files, "contest.c": text}, ["-lm"])
    return entry(ctypes.CDLL(str(library)))
