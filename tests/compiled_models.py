"""Machines as generated code, C and numpy, ready to be called in tests."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray

from symoro_elastic.codegen.compile import CompiledPackage, compile_library
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine, Vector3
from symoro_elastic.machine.restrict import names_to_fold, restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import package
from symoro_elastic.models.programs.catalogue import trace_scene
from symoro_elastic.numerics.verification.implementations import import_package

Array = NDArray[np.float64]

FIVE = ("direct_dynamics", "inverse_dynamics", "inertia_matrix", "bias_forces", "geometric_model")


def cell(value: float | str) -> Formula:
    return Formula.parse(value)


def vector(*values: float | str) -> Vector3:
    x, y, z = map(cell, values)
    return x, y, z


@dataclass(frozen=True)
class Built:
    """Generated code of a machine, ready to be called."""

    module: ModuleType
    compiled: CompiledPackage
    results: dict[str, tuple[str, ...]]

    def c(self, model: str, **arrays: Any) -> tuple[Array, ...]:
        return tuple(self.compiled.call(model, **arrays).values())

    def numpy(self, model: str, **arrays: Any) -> tuple[Array, ...]:
        found = getattr(self.module, model)(**arrays)
        return found if isinstance(found, tuple) else (found,)

    def both(self) -> tuple[Callable[..., tuple[Array, ...]], ...]:
        return self.c, self.numpy


def built(machine: Machine, folder: Path, scene: Scene | None = None) -> Built:
    scene = replace(scene or Scene(), models=FIVE)
    traced = trace_scene(machine, scene)
    described = package(restrict(machine, scene), traced, names_to_fold(machine, scene))
    library = compile_library(render_c(described), folder / "c", flags=("-O0",))
    module = import_package(render_numpy(described), folder / "numpy")
    results = {model.model.name: tuple(model.rows) for model in traced}
    return Built(module, CompiledPackage(described, library), results)


def worst(found: Any, wanted: Any) -> float:
    """Largest difference over the largest wanted entry; infinite for what is not a number."""
    with mpmath.workdps(50):
        exact = np.array(wanted, dtype=object)
        found = np.asarray(found, dtype=float)
        if not found.size + exact.size:
            return 0.0
        assert found.shape == exact.shape
        if not np.isfinite(found).all():
            return np.inf
        scale = max(map(abs, exact.ravel()))
        difference = max(map(abs, (found.astype(object) - exact).ravel()))
        return float(difference / scale) if scale else float(difference)
