"""Implementations of a model that can be run: generated C, generated numpy, the traced program on floats."""

from __future__ import annotations

import importlib.util
import itertools
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from symoro_elastic.codegen.compile import CompiledPackage
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.output_files import fill_folder, temporary_folder
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.bound.state import State
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.models.programs.catalogue import TracedModel
from symoro_elastic.numerics.linear.grouping import grouping_by_rank
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate_nodes
from symoro_elastic.symbolic.program import Program

ResultArrays = dict[str, Array]
Implementation = Callable[[TracedModel, State], ResultArrays]

_numbers = itertools.count()


def c_code(compiled: CompiledPackage, p: Array, batch: bool = False) -> Implementation:
    """Return the compiled functions: state by state, or all states by one call where a model depends on the state."""

    def run(traced: TracedModel, states: State) -> ResultArrays:
        call = compiled.call_batch if batch and traced.model.arguments else compiled.call
        return _spread(traced, call(traced.model.name, p=p, **states.only(traced.model.arguments)), len(states))

    return run


def numpy_code(module: ModuleType, p: Array, stacked: bool) -> Implementation:
    """Return the generated package: all states in one call, or one at a time on plain floats."""

    def run(traced: TracedModel, states: State) -> ResultArrays:
        function = getattr(module, traced.model.name)
        if stacked:
            return _spread(traced, _by_name(traced, function(**states.only(traced.model.arguments), p=p)), len(states))
        some = (states[k].only(traced.model.arguments) for k in range(len(states)))
        rows = [_by_name(traced, function(**arguments, p=p)) for arguments in some]
        return {name: np.stack([results[name] for results in rows]) for name in traced.rows}

    return run


def equations_on_floats(values: Mapping[str, float]) -> Implementation:
    """Return the traced program in double precision, without code; NaN where it has no value."""

    def run(traced: TracedModel, states: State) -> ResultArrays:
        rows = [_evaluate(traced.program, _symbols(traced, states[k], values)) for k in range(len(states))]
        results = zip(traced.program.outputs, zip(*rows, strict=True), strict=True)
        return {output.name: np.array(column, dtype=float) for output, column in results}

    return run


def numpy_model(
    machine: Machine, models: Sequence[str] = ("direct_dynamics",), outputs: Mapping[str, tuple[str, ...]] | None = None
) -> ModuleType:
    """Return the generated numpy package of a machine as a module; `outputs` names parts of models, as a scene does."""
    scene = Scene(models=tuple(models), outputs=dict(outputs or {}))
    files = render_numpy(trace_models(machine, scene, grouping_by_rank).package)
    with temporary_folder() as folder:
        return import_package(files, Path(folder))


def import_package(files: Mapping[str, str], folder: Path) -> ModuleType:
    """Write a generated numpy package to a folder and return it as a module with a unique name."""
    fill_folder(folder, files)
    name = f"symoro_elastic_generated_{next(_numbers)}"
    places = [str(folder)]
    spec = importlib.util.spec_from_file_location(name, folder / "__init__.py", submodule_search_locations=places)
    if spec is None or spec.loader is None:
        raise ImportError(f"{folder} holds no package")
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    finally:
        for loaded in [loaded for loaded in sys.modules if loaded == name or loaded.startswith(f"{name}.")]:
            del sys.modules[loaded]
    return module


def _by_name(traced: TracedModel, results: Any) -> ResultArrays:
    names = tuple(traced.rows)
    return dict(zip(names, results if len(names) > 1 else (results,), strict=True))


def _spread(traced: TracedModel, results: ResultArrays, states: int) -> ResultArrays:
    """Return the results for each state, repeated where they depend on parameters only."""
    shapes = {output.name: output.shape for output in traced.program.outputs}
    return {name: np.broadcast_to(array, (states, *shapes[name])) for name, array in results.items()}


def _symbols(traced: TracedModel, state: State, values: Mapping[str, float]) -> dict[str, float]:
    symbols = dict(values)
    for argument in traced.program.inputs:
        symbols |= zip(argument.symbols, getattr(state, argument.name).tolist(), strict=True)
    return symbols


def _evaluate(program: Program, symbols: Mapping[str, float]) -> list[Sequence[float]]:
    try:
        value = evaluate_nodes(program.nodes, symbols, FLOATS)
        return [[float(value(x)) for x in output.entries] for output in program.outputs]
    except (ArithmeticError, ValueError):
        return [[math.nan] * len(output.entries) for output in program.outputs]
