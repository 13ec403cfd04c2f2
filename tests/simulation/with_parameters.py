"""Compiled steps that take the numbers of a machine when they run: one compilation for many stiffnesses."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.codegen.c_steps import Run, render_runs
from symoro_elastic.codegen.compile import compile_library, load_library
from symoro_elastic.codegen.local_names import with_own_results
from symoro_elastic.codegen.precision import DOUBLE
from symoro_elastic.codegen.targets.c import render_c, source_text
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.simulation import compiled_steps
from symoro_elastic.simulation.compiled_steps import FLAGS, CompiledSteps
from symoro_elastic.traced import traced


class StepsWithParameters(CompiledSteps):
    """Set `p`, in the order of the parameters, before each run."""

    def __init__(
        self, machine: Machine, methods: Sequence[str], folder: Path, flags: Sequence[str] = FLAGS
    ) -> None:
        self.machine, self.p = machine, np.zeros(len(machine.parameters))
        self.package = traced(machine, Scene(models=("inverse_dynamics",), steps=tuple(methods))).package
        assert [p.name for p in self.package.parameters] == [p.name for p in machine.parameters]
        text = source_text(with_own_results(self.package), DOUBLE)
        library: ctypes.CDLL = load_library(
            compile_library(render_c(self.package) | render_runs(self.package, text.steps), folder, flags=flags)
        )
        self._runs = {run.name: run for run in text.steps.runs()}
        self._entries = {name: compiled_steps._entry(library, run) for name, run in self._runs.items()}

    def _call(self, run: Run, count: int, read: Sequence[Array], h: float, written: Sequence[Array]) -> None:
        held = [np.ascontiguousarray(array) for array in read]
        pointers = (array.ctypes.data for array in held)
        self._entries[run.name](count, *pointers, h, self.p.ctypes.data, *(array.ctypes.data for array in written))
