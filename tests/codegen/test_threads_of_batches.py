"""Batches shared among threads: the bits of one thread, whatever their number and that of the states."""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.codegen.compile import compile_library
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, MIXED, SINGLE, Precision
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.scene import ALL, Scene
from tests.benchmarks.machines import chain
from tests.generated_code import STRICT

COUNTS = (0, 1, 31, 33, 64, 100, 777)
MATRIX = "inertia_matrix"
CASES = {
    "prepared": (4, "direct_dynamics", (), DOUBLE),
    "folded, single": (4, "direct_dynamics", ALL, SINGLE),
    "mixed": (4, "direct_dynamics", (), MIXED),
    "in rows": (14, MATRIX, ALL, DOUBLE),
}
pytestmark = pytest.mark.skipif(not shutil.which("gcc"), reason="OpenMP of gcc")


def made(case: str) -> tuple[Package, Precision, dict[str, str]]:
    n, model, fold, precision = CASES[case]
    package = programs(chain(n), Scene(models=(model,), fold=fold)).package
    return package, precision, render_c_batch(package, precision)


def called(entry: Callable[..., None], package: Package, precision: Precision, states: int) -> bytes:
    """The results at states that are drawn."""
    (function,), real = package.functions, np.float32 if precision is SINGLE else np.float64
    rng = np.random.default_rng(states)
    given = [rng.uniform(-2, 2, (max(argument.size, 1), states)).astype(real) for argument in function.arguments]
    p = np.array([*(one.value for one in package.parameters), 0.0], real)
    results = [np.zeros((max(int(np.prod(r.shape)), 1), states), real) for r in function.results]
    entry(ctypes.c_size_t(states), *(ctypes.c_void_p(array.ctypes.data) for array in (*given, p, *results)))
    assert states == 0 or any(result.any() for result in results)
    return b"".join(result.tobytes() for result in results)


@pytest.mark.parametrize(
    "case", [name if name == "in rows" else pytest.param(name, marks=pytest.mark.thorough) for name in CASES]
)
def test_threads_give_the_bits_of_one(case: str, tmp_path: Path) -> None:
    package, precision, files = made(case)
    library = ctypes.CDLL(str(compile_library(files, tmp_path, ("gcc",), (*STRICT, "-O1", "-fopenmp"))))
    name = precision.function(package.name, package.functions[0].name)
    alone, shared = (getattr(library, f"{name}_{end}") for end in ("batch", "batch_threads"))
    for states in COUNTS:
        wanted = called(alone, package, precision, states)
        for threads in (1, 2, 3, 7):
            library.omp_set_num_threads(threads)
            assert called(shared, package, precision, states) == wanted


@pytest.mark.thorough
def test_without_openmp_one_thread_does_it_all(tmp_path: Path) -> None:
    package, precision, files = made("prepared")
    library = ctypes.CDLL(str(compile_library(files, tmp_path, ("gcc",), (*STRICT, "-O1"))))
    name = precision.function(package.name, package.functions[0].name)
    alone, shared = (getattr(library, f"{name}_{end}") for end in ("batch", "batch_threads"))
    assert called(shared, package, precision, 100) == called(alone, package, precision, 100)
