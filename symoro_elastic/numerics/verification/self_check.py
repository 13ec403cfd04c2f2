"""`check --self`: digits of the results of generated C that survive rounding, by rounding modes alone.

The generated C runs in the four rounding modes of the processor, without a reference. The modes push every rounding,
each its own way, so results that agree in all of them hold few rounding errors. Sines and cosines are those of the C
library, which rounds to nearest in any mode (the branch-free ones of the generated code reduce angles by rounding to
nearest), moved by an ulp. The generated code as it is is run too.

Five runs are samples of what rounding does, not its limits: the largest difference between two of them is taken
`SAFETY` times, and `WIDENING` ulps of the largest entry are added for errors that no mode shows, such as those of
constants. So it covers the true error at 99.9 % of random states (`python -m tests.benchmarks.accuracy brackets`).
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symoro_elastic.codegen.c.calls import wrapper_context
from symoro_elastic.codegen.compile import compile_library, compile_package, load_library
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.precision import DOUBLE
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.codegen.templates import render
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.output_files import temporary_folder
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.linear.grouping import grouping_by_rank
from symoro_elastic.numerics.verification.states import States, extreme_states, moderate_states

MODES = ("to nearest", "upward", "downward", "towards zero")
SHIM = "rounding_modes.c"
ROUNDING_FLAGS = ("-O0", "-frounding-math")
SAFETY = 2
WIDENING = 1
DOUBLE_ULP = 2.0**-52

CHECKED_STATES = 1000


@dataclass(frozen=True)
class Surviving:
    """The spread of a result over some states: worst, median, decimal digits that survive at worst, and where."""

    worst: float
    typical: float
    digits: float
    at: str


@dataclass(frozen=True)
class ResultCheck:
    """The check of a result of a model, at moderate and at extreme states."""

    model: str
    result: str
    moderate: Surviving
    extreme: Surviving


@dataclass(frozen=True, repr=False)
class SelfCheck(Result):
    """The checks of all results of the models of a machine, by its name."""

    name: str
    checks: Sequence[ResultCheck]

    @property
    def least_digits(self) -> float:
        """Digits that agree in the worst result at the worst moderate state."""
        return min((check.moderate.digits for check in self.checks), default=0.0)


def self_check(
    machine: Machine, scene: Scene, *, states: int = CHECKED_STATES, seed: int = 0, progress: Progress = no_progress
) -> list[ResultCheck]:
    """Return the check of every result of the models of a scene, run in the four rounding modes.

    `states` moderate and as many extreme states; parameters without value get a plausible one. Raises `NoValues`,
    `CompilerMissing`, `CompilationFailed`.
    """
    programs = trace_models(machine, scene, grouping_by_rank)
    restricted = programs.machine
    values = parameter_values(restricted, seed)
    p = np.array([values[parameter.name] for parameter in programs.package.parameters], dtype=float)
    drawn = [draw(restricted, states, seed, values) for draw in (moderate_states, extreme_states)]
    checks = []
    with temporary_folder() as folder:
        modes = RoundingModes(programs.package, Path(folder))
        for k, model in enumerate(programs.models, start=1):
            own, arguments = model.model.name, model.model.arguments
            spreads = [modes.run(own, len(some), some.only(arguments) | {"p": p}) for some in drawn]
            for name in model.results:
                survive = (_surviving(spread[name], some) for spread, some in zip(spreads, drawn, strict=True))
                checks.append(ResultCheck(own, name, *survive))
            progress(k, len(programs.models))
    return checks


def _surviving(spread: Spread, states: States) -> Surviving:
    worst = int(np.argmax(spread.spread))
    return Surviving(
        float(spread.spread[worst]),
        float(np.median(spread.spread)),
        float(spread.digits[worst]),
        f"state {worst + 1} ({states.titles[worst]})",
    )


@dataclass(frozen=True)
class Spread:
    """A result of generated code, `results` (states, entries), and by state its `spread` over the rounding modes.

    The spread is `SAFETY` times the largest difference between two runs, over the largest entry, plus `WIDENING`
    ulps: an estimate of the error of the result, not a bound. Infinite where a run gives no finite number.
    """

    results: Array
    spread: Array

    @property
    def digits(self) -> Array:
        """Decimal digits that survive, by state."""
        with np.errstate(divide="ignore"):
            return np.maximum(0.0, -np.log10(self.spread))


class RoundingModes:
    """The functions of a package, compiled so that they can be run in each rounding mode."""

    def __init__(self, package: Package, folder: Path) -> None:
        """Compile in a folder. Raises `CompilerMissing`, `CompilationFailed`."""
        self.package = package
        self._functions = {function.name: function for function in package.functions}
        files = render_c(package)
        self._plain = compile_package(package, folder / "plain", files)
        included = {**files, SHIM: _shim(package)}
        library = compile_library(included, folder / "modes", flags=ROUNDING_FLAGS, sources=[SHIM])
        self._library = load_library(library)

    def run(self, function: str, states: int, arguments: Mapping[str, Array]) -> dict[str, Spread]:
        """Return results of a function and their spread; `arguments` by name, (states, entries), and p (entries)."""
        signature = self._functions[function]
        runs = [self._as_generated(signature, states, arguments)]
        runs += [self._in_mode(signature, mode, states, arguments) for mode in range(len(MODES))]
        return {result.name: _spread([run[result.name] for run in runs]) for result in signature.results}

    def _as_generated(self, signature: Function, states: int, arguments: Mapping[str, Array]) -> dict[str, Array]:
        results = self._plain.call(signature.name, **self._inputs(signature, arguments))
        spread = {x.name: np.broadcast_to(results[x.name], (states, *x.shape)) for x in signature.results}
        return {x.name: spread[x.name].reshape(states, math.prod(x.shape)) for x in signature.results}

    def _inputs(self, signature: Function, arguments: Mapping[str, Array]) -> dict[str, Array]:
        names = self.package.inputs(signature)
        return {name: np.ascontiguousarray(arguments[name], dtype=float) for name in names}

    def _in_mode(self, signature: Function, mode: int, states: int, arguments: Mapping[str, Array]) -> dict[str, Array]:
        results = {result.name: np.empty((states, math.prod(result.shape))) for result in signature.results}
        arrays = [*self._inputs(signature, arguments).values(), *results.values()]
        entry = self._library[f"{self.package.name}_{signature.name}_in_mode"]
        entry.argtypes = [ctypes.c_int, ctypes.c_size_t] + [ctypes.c_void_p] * len(arrays)
        if entry(mode, states, *(array.ctypes.data for array in arrays)):
            raise ArithmeticError(f"this processor cannot round {MODES[mode]}")
        return results


def _spread(runs: list[Array]) -> Spread:
    stacked = np.stack(runs)
    with np.errstate(all="ignore"):
        width = (stacked.max(axis=0) - stacked.min(axis=0)).max(axis=1, initial=0.0)
        scale = np.abs(runs[0]).max(axis=1, initial=0.0)
        relative = SAFETY * width / np.where(scale > 0, scale, 1.0) + WIDENING * DOUBLE_ULP
    return Spread(runs[0], np.where(np.isfinite(relative), relative, np.inf))


def _shim(package: Package) -> str:
    """Return C code that runs each function in a rounding mode."""
    return render(
        "c/rounding_modes.c.j2",
        name=package.name,
        macro=package.name.upper(),
        functions=[wrapper_context(package, f, DOUBLE) for f in package.functions],
    )
