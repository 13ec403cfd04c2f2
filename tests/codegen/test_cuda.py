"""CUDA: the numbers of C to the bit, on the processor; names; compiled by NVRTC where that is installed."""

from __future__ import annotations

import ctypes
import shutil
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

from symoro_elastic.codegen.c.steps import StepText
from symoro_elastic.codegen.compile import TYPES, compile_library
from symoro_elastic.codegen.local_names import with_local_names, with_own_results
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.precision import PRECISIONS
from symoro_elastic.codegen.targets import cuda
from symoro_elastic.codegen.targets.c import OWN as C_WORDS
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.codegen.targets.cuda import render_cuda
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.scene import Scene
from tests.benchmarks import nvrtc
from tests.codegen.cuda_on_host import HostKernels, on_host
from tests.codegen.test_local_names import arm
from tests.codegen.test_time_steps import STATES, STRICT, Generated, H, generated, given, parameters, pointers
from tests.references.random_machines import planar_2r

CASES = ("pushed", "delta", "on_base", "drives")
"""A tree with springs, wrenches and dense systems; loops without closed form; a floating base; limits of drives."""
STEPS, HOLD = 5, 2

pytestmark = [
    pytest.mark.skipif(not shutil.which("g++") or not shutil.which("nm"), reason="no C++ compiler"),
    pytest.mark.sampled(3),
]


@cache
def kernels(name: str) -> HostKernels:
    with TemporaryDirectory() as folder:
        package = generated(name).package
        return on_host(render_cuda(package), Path(folder), [f"{package.name}.cu"])


def cuda_functions(package: Package) -> tuple[cuda.DeviceFunction, ...]:
    return cuda._text(with_local_names(with_own_results(package), cuda.OWN | C_WORDS), PRECISIONS["double"]).functions


def columns(x: Array) -> Array:
    return np.ascontiguousarray(x.T)


def inputs(of: Generated, function: Function) -> list[Array]:
    """A column for each state; the angles of one are beyond the range of the generated sine."""
    rng = np.random.default_rng(4)
    found = [rng.normal(size=(argument.size, STATES)) for argument in function.arguments]
    for argument, x in zip(function.arguments, found, strict=True):
        if argument.name in of.state:
            x[:] = of.state[argument.name].T
        if argument.name == "q":
            x[:, 3] = 3e6
    return found


@pytest.mark.sampled(5)
@pytest.mark.parametrize("name", CASES)
def test_models_have_the_bits_of_c(name: str) -> None:
    of, compared = generated(name), 0
    for function in with_own_results(of.package).functions:
        if not function.arguments:
            continue
        results = [[np.zeros((int(np.prod(r.shape)), STATES)) for r in function.results] for _ in range(2)]
        given_ = pointers([*inputs(of, function), parameters(of.package)])
        batch = f"{of.package.name}_{function.name}_batch"
        of.library[batch](ctypes.c_size_t(STATES), *given_, *pointers(results[0]))
        kernels(name).launch(batch, ctypes.c_size_t(STATES), *given_, *pointers(results[1]))
        for c, ours in zip(*results, strict=True):
            np.testing.assert_array_equal(ours, c, err_msg=function.name)
            compared += np.isfinite(c).all() and c.any()
    assert compared >= 3


@pytest.mark.sampled(5)
@pytest.mark.parametrize("name", CASES)
def test_two_launches_have_the_bits_of_one(name: str) -> None:
    """What depends on parameters only, once for all blocks; it is used: other numbers in its place give others."""
    of, compared = generated(name), 0
    for function in cuda_functions(of.package):
        if not function.first:
            assert not function.constants
            continue
        plain = next(one for one in with_own_results(of.package).functions if function.name.endswith(f"_{one.name}"))
        read, p = inputs(of, plain), parameters(of.package)
        c = np.zeros(function.constant_count)
        kernels(name).launch(f"{function.name}_prepare_batch", *pointers([p, c]))
        found = []
        for suffix, constants in (("", []), ("_prepared", [c]), ("_prepared", [1.5 * c])):
            results = [np.zeros((int(np.prod(r.shape)), STATES)) for r in plain.results]
            arrays = pointers([*read, p, *constants, *results])
            kernels(name).launch(f"{function.name}{suffix}_batch", ctypes.c_size_t(STATES), *arrays)
            found.append(np.concatenate(results))
        np.testing.assert_array_equal(found[1], found[0])
        assert not np.array_equal(found[2], found[0])
        compared += 1
    assert compared or name != "pushed"


def advanced(of: Generated, step: StepText, rows: list[dict[str, Array]]) -> list[Array]:
    """The state by C after a step for each row of inputs; what else a step gives is summed."""
    written = [of.state.get(a.name, np.zeros((STATES, a.entries))).T.copy() for a in step.written]
    sums = {k: np.zeros_like(x) for k, x in enumerate(written) if step.written[k].name not in of.state}
    for row in rows:
        for k in range(STATES):
            one = [np.ascontiguousarray(x[:, k]) for x in written]
            read = pointers(np.ascontiguousarray(x[k]) for x in row.values())
            of.library[step.name](*read, ctypes.c_double(H), *pointers([parameters(of.package), *one]))
            for x, y in zip(written, one, strict=True):
                x[:, k] = y
        for k in sums:
            sums[k] += written[k]
    return [sums.get(k, x) for k, x in enumerate(written)]


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("hold", [HOLD, 0])
@pytest.mark.parametrize("name", CASES)
def test_steps_have_the_bits_of_c(name: str, hold: int) -> None:
    """Each thread takes its own state through many steps; inputs hold for some of them, or for all."""
    of = generated(name)
    for step in of.steps:
        first = given(step, of.package, of.state["q"])
        later = [{k: x if k in step.variant.of_step else x + 0.1 * row for k, x in first.items()} for row in range(3)]
        read = [
            columns(x) if k in step.variant.of_step else np.concatenate([columns(row[k]) for row in later])
            for k, x in first.items()
        ]
        written = [of.state.get(a.name, np.zeros((STATES, a.entries))).T.copy() for a in step.written]
        kernels(name).launch(
            f"{step.name}_batch",
            *map(ctypes.c_size_t, (STATES, STEPS, hold)),
            *pointers(read),
            ctypes.c_double(H),
            *pointers([parameters(of.package), *written]),
        )
        rows = [later[k // hold if hold else 0] for k in range(STEPS)]
        for array, ours, c in zip(step.written, written, advanced(of, step, rows), strict=True):
            np.testing.assert_array_equal(ours, c, err_msg=f"{step.name} {array.name}")
            assert not c.size or c.any()


@pytest.mark.thorough
@pytest.mark.parametrize("precision", ["single", "mixed"])
def test_other_precisions_have_the_bits_of_c(precision: str, tmp_path: Path, monkeypatch: Any) -> None:
    """Without room in shared memory too: then each thread computes what depends on parameters only."""
    monkeypatch.setattr(cuda, "SHARED_BYTES", 0)
    of, chosen = generated("planar"), PRECISIONS[precision]
    files = render_cuda(of.package, chosen)
    assert "__shared__" not in files[f"planar_2r_{precision}.cu"]
    host = on_host(files, tmp_path / "cuda", [f"planar_2r_{precision}.cu"])
    library = ctypes.CDLL(str(compile_library(render_c_batch(of.package, chosen), tmp_path / "c", flags=STRICT)))
    for function in of.package.functions:
        found = []
        for launch in (host.launch, lambda name, *x: library[name](*x)):
            dtype = TYPES[chosen.state]
            results = [np.zeros((int(np.prod(r.shape)), STATES), dtype) for r in function.results]
            read = [np.ascontiguousarray(x, dtype) for x in (*inputs(of, function), parameters(of.package))]
            name = f"{chosen.function(of.package.name, function.name)}_batch"
            launch(name, ctypes.c_size_t(STATES), *pointers([*read, *results]))
            found.append(results)
        for ours, c in zip(*found, strict=True):
            np.testing.assert_array_equal(ours, c)
            assert c.any()


# Code of users


OF_USERS = """
#include "planar_2r.cu"
#include "arm.cu"

/* One state a thread, in arrays of its own. */
static __global__ void own(size_t states, const double *x, const double *p, double *y)
{
    const size_t s = blockIdx.x*blockDim.x + threadIdx.x;
    if (s < states) {
        double qdd[2];
        planar_2r_direct_dynamics(&x[6*s], &x[6*s + 2], &x[6*s + 4], p, qdd);
        y[2*s] = qdd[0];
        y[2*s + 1] = qdd[1];
    }
}

cudaError_t own_batch(size_t states, const double *x, const double *p, double *y, cudaStream_t stream)
{
    void *arguments[] = {&states, &x, &p, &y};
    return cudaLaunchKernel(own, dim3((unsigned int)states), dim3(1), arguments, 0, stream);
}
"""


def hostile() -> dict[str, str]:
    """The files of a machine whose names are words of CUDA and of its headers."""
    taken = ("threadIdx", "blockIdx", "warpSize", "states", "steps", "STA_FLL", "CLOCK_MONOTONIC", "SEEK_END", "NZERO")
    machine = arm(("gridDim", "s", "blockDim", "TIME_UTC", "stream"), taken)
    return render_cuda(programs(machine, Scene(models=("direct_dynamics",))).package)


def planar() -> Package:
    return programs(planar_2r(), Scene(models=("direct_dynamics",))).package


def test_a_kernel_of_the_user_calls_two_machines(tmp_path: Path, monkeypatch: Any) -> None:
    """300 states by the user's kernel and by ours, in one block of 128 threads: threads go on with the next."""
    monkeypatch.setattr(cuda, "BLOCKS", 1)
    files = hostile() | render_cuda(planar())
    host = on_host(files | {"own.cu": OF_USERS}, tmp_path, ("own.cu",))
    states, p = 300, parameters(planar())
    q, qd, tau = (np.random.default_rng(k).normal(size=(2, states)) for k in range(3))
    one, many = np.zeros((states, 2)), np.zeros((2, states))
    host.launch("own_batch", ctypes.c_size_t(states), *pointers([columns(np.vstack([q, qd, tau])), p, one]))
    host.launch("planar_2r_direct_dynamics_batch", ctypes.c_size_t(states), *pointers([q, qd, tau, p, many]))
    np.testing.assert_array_equal(one, many.T)
    assert one.all()


@pytest.mark.sampled(1000)
@pytest.mark.skipif(nvrtc.library() is None, reason=nvrtc.MISSING)
@pytest.mark.parametrize("architecture", [70, 80, 90, 100])
def test_nvrtc_compiles_two_machines_in_one_file(architecture: int) -> None:
    if architecture not in nvrtc.architectures():
        pytest.skip(f"this NVRTC does not know sm_{architecture}")
    of_device = OF_USERS.partition("cudaError_t")[0]
    found = nvrtc.compiled(of_device, hostile() | render_cuda(planar()), architecture)
    kernels = {kernel.name: kernel for kernel in found.kernels}
    assert {"planar_2r_direct_dynamics_kernel", "arm_direct_dynamics_kernel"} <= kernels.keys()
    assert kernels["planar_2r_direct_dynamics_kernel"].stored == 0
    assert found.cubin.startswith(b"\x7fELF")
