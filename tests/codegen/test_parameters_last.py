"""Every function of generated C takes p, the last of its inputs, also where a machine leaves no parameter."""

from __future__ import annotations

import ctypes
import math
import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.codegen.compile import TYPES, compile_package, load_library
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.precision import PRECISIONS, Precision
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.verification.implementations import import_package
from tests.generated_code import ALL_MODELS, Array

EXAMPLES = Path(__file__).parents[2] / "examples"
PRECISION = [pytest.param(precision, id=precision.name) for precision in PRECISIONS.values()]
STATES = 5
ROUNDED = 20
"""How many roundings, of the largest entry, a result may be away: the dynamics of two joints."""


@cache
def planar(is_constant: bool) -> Package:
    """All models of the arm with two joints; a constant one has no parameter left."""
    scene = Scene(ALL_MODELS, fold=ALL if is_constant else ())
    return trace_models(read_machine(EXAMPLES / "planar_2r.toml")[0], scene).package


def prototypes(text: str) -> dict[str, list[str]]:
    """The arguments of each function that a header declares."""
    found = re.findall(r"^void (\w+)\(([^)]*)\);", text, re.MULTILINE)
    return {name: [" ".join(argument.split()) for argument in arguments.split(",")] for name, arguments in found}


@pytest.mark.parametrize("precision", PRECISION)
@pytest.mark.parametrize("is_constant", [False, True])
def test_p_is_the_last_input_of_every_function(is_constant: bool, precision: Precision) -> None:
    made, files = planar(is_constant), render_c_batch(planar(is_constant), precision)
    assert bool(made.parameters) != is_constant
    declared = {
        name: arguments
        for file, text in files.items()
        if file.endswith(".h")
        for name, arguments in prototypes(text).items()
        if not name.endswith("_advance")
    }
    for function in made.functions:
        name = precision.function(made.name, function.name)
        assert {name, *([f"{name}_batch"] if function.arguments else [])} <= declared.keys()
    for name, arguments in declared.items():
        arrays = [x for x in arguments if x != "size_t states" and not re.match(r"const \w+ c\[", x)]
        inputs = [x for x in arrays if x.startswith("const ")]
        assert re.fullmatch(rf"const {precision.state} \*?p(\[\w+\])?", inputs[-1]), (name, inputs)
        assert arrays[: len(inputs)] == inputs, (name, arrays)


def test_the_header_says_when_p_is_not_used() -> None:
    said = "No parameter is left: p is not used and may be NULL."
    assert said in render_c_batch(planar(is_constant=True))["planar_2r.h"]
    assert said not in render_c_batch(planar(is_constant=False))["planar_2r.h"]


@pytest.mark.sampled(5)
@pytest.mark.parametrize("precision", PRECISION)
def test_functions_run_without_parameters(precision: Precision, tmp_path: Path) -> None:
    """With p = NULL and with an array without entries, one state and many, they give the numbers of numpy."""
    made, rng = planar(is_constant=True), np.random.default_rng(0)
    compiled = compile_package(made, tmp_path, precision=precision)
    library = load_library(next(tmp_path.glob("*.so")))
    module: Any = import_package(render_numpy(made), tmp_path / "numpy")
    unit = max(2.0**-53, 2.0**-precision.bits)
    for function in made.functions:
        arguments = {a.name: rng.uniform(-1, 1, (STATES, a.size)).astype(np.float32) for a in function.arguments}
        found = module.__dict__[function.name](**{name: x.astype(float) for name, x in arguments.items()})
        wanted = found if len(function.results) > 1 else (found,)
        calls = [compiled.call(function.name, p=[], **arguments)]
        calls += [compiled.call_batch(function.name, p=[], **arguments)] if function.arguments else []
        for results in [*(call.values() for call in calls), without_p(library, made, function, precision, arguments)]:
            for result, right in zip(results, wanted, strict=True):
                apart = np.abs(result.reshape(right.shape) - right).max()
                assert apart <= ROUNDED * unit * np.abs(right).max(), function.name


def without_p(
    library: ctypes.CDLL, made: Package, function: Function, precision: Precision, arguments: dict[str, Array]
) -> list[Array]:
    """Results of all states, a call each with p = NULL."""
    states, dtype = STATES if arguments else 1, TYPES[precision.state]
    rows = [np.ascontiguousarray(x, dtype) for x in arguments.values()]
    results = [np.full((states, math.prod(result.shape)), np.nan, dtype) for result in function.results]
    entry = library[precision.function(made.name, function.name)]
    entry.restype = None
    for k in range(states):
        inputs, outputs = ([ctypes.c_void_p(x[k].ctypes.data) for x in arrays] for arrays in (rows, results))
        entry(*inputs, None, *outputs)
    return results
