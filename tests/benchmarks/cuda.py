"""CUDA: registers, rounding, and times on a device: `python -m tests.benchmarks.cuda compile | rounding | speed`.

`compile` and `rounding` need no device.
"""

from __future__ import annotations

import argparse
import ctypes
import itertools
import os
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from symoro_elastic.codegen.compile import TYPES, compile_library
from symoro_elastic.codegen.local_names import of_own_results
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.precision import DOUBLE, DOUBLE_DOUBLE, PRECISIONS, Precision
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.codegen.targets.cuda import THREADS, render_cuda
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.verification.implementations import import_package
from tests.benchmarks import nvrtc
from tests.benchmarks.cuda_driver import Device, DriverError
from tests.benchmarks.machines import arm_6, arm_7, chain, example, two_axis
from tests.benchmarks.ours import FAST
from tests.benchmarks.tables import print_table, progress
from tests.codegen.cuda_on_host import FLAGS, on_host
from tests.models.test_creep import creeping
from tests.models.test_floating_base import on

MODELS = ("direct_dynamics", "inverse_dynamics", "inertia_matrix")
MACHINES: dict[str, Callable[[], Machine]] = {
    "6R arm": arm_6,
    "two-axis machine": two_axis,
    "SR400, a closed loop": lambda: creeping(example("sr400.par")),
    "7R arm on a floating base": lambda: on(arm_7()),
}
LONG = "chain of 30 joints"
"""Its parameters are free: what depends on them only can be done in a launch of its own."""
ARCHITECTURES = (70, 75, 80, 86, 89, 90, 100, 120)
FUSED = ("-O2", "-ffp-contract=fast", "-march=native")
SEEN = (1_000, 10_000, 100_000, 1_000_000)
STATES, SECONDS = 2_000, 0.2


@dataclass(frozen=True)
class Case:
    """A machine with its numbers folded into the models, in a precision."""

    title: str
    precision: Precision
    steps: tuple[str, ...] = ()

    @cached_property
    def package(self) -> Package:
        if self.title == LONG:
            return trace_models(chain(30), Scene(models=MODELS[:2])).package
        return trace_models(MACHINES[self.title](), Scene(models=MODELS, steps=self.steps, fold=ALL)).package

    @property
    def dtype(self) -> Any:
        return TYPES[self.precision.state]

    @property
    def files(self) -> dict[str, str]:
        return render_cuda(self.package, self.precision)

    @property
    def stem(self) -> str:
        return self.package.name + self.precision.suffix

    def functions(self) -> Iterator[Function]:
        """The models that are asked for."""
        yield from (of_own_results(f) for f in self.package.functions if f.name in MODELS)

    def name(self, function: Function) -> str:
        return self.precision.function(self.package.name, function.name)

    def inputs(self, function: Function, states: int) -> list[Array]:
        """Columns of random states, then p."""
        rng = np.random.default_rng(0)
        found = [rng.uniform(-1, 1, (argument.size, states)) for argument in function.arguments]
        p = [parameter.value for parameter in self.package.parameters]
        return [np.ascontiguousarray(x, self.dtype) for x in (*found, [*p, 0.0])]

    def results(self, function: Function, states: int) -> list[Array]:
        return [np.zeros((int(np.prod(r.shape)), states), self.dtype) for r in function.results]


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.cuda", description=__doc__)
    tasks = {"compile": registers, "rounding": rounding, "speed": speed}
    parser.add_argument("task", choices=tasks)
    parser.add_argument("--precision", choices=["double", "single", "mixed"], default="double")
    arguments = parser.parse_args()
    tasks[arguments.task](PRECISIONS[arguments.precision])


# Compiled by NVRTC


def registers(precision: Precision) -> None:
    """Registers of a thread and bytes that it spills, by kernel and architecture."""
    known = [one for one in ARCHITECTURES if one in nvrtc.architectures()]
    cells: dict[tuple[str, str], list[str]] = {}
    for title in progress([*MACHINES, LONG], "compile"):
        case = Case(title, precision, ("w3",))
        files = case.files
        for architecture in known:
            found = nvrtc.compiled(files[f"{case.stem}.cu"], files, architecture)
            for kernel in found.kernels:
                spilled = kernel.stored + kernel.loaded
                name = kernel.name.removeprefix(f"{case.stem}_").removesuffix("_kernel")
                text = f"{kernel.registers}{f' ({spilled})' if spilled else ''}"
                cells.setdefault((title, name), []).append(text)
    columns = ["machine, kernel", *(f"sm_{one}" for one in known)]
    rows = [[f"{title}, {name}", *texts] for (title, name), texts in cells.items()]
    print_table("registers of a thread (bytes that it spills and reads back)", columns, rows)


# Rounding


def rounding(precision: Precision) -> None:
    """How far results are from those of C and from exact ones, in units in the last place of a state's largest."""
    more = DOUBLE_DOUBLE if precision is DOUBLE else DOUBLE
    rows = []
    for title in progress(list(MACHINES), "compile and compare"):
        case = Case(title, precision)
        with tempfile.TemporaryDirectory() as folder:
            kernels = [
                on_host(case.files, Path(folder) / name, [f"{case.stem}.cu"], flags)
                for name, flags in (("exact", FLAGS), ("fused", ("-std=c++17", *FUSED)))
            ]
            c, exact = (by_c(case.package, one, Path(folder) / one.name) for one in (precision, more))
        for function in case.functions():
            wanted, *ours = (launched(case, function, one) for one in (c, *(one.launch for one in kernels)))
            best = launched(replace(case, precision=more), function, exact)
            from_c = [ulps(found, wanted) for found in ours]
            from_exact = [ulps(found, best) for found in (wanted, ours[1])]
            rows.append([f"{title}, {function.name}", *(f"{x:.1f}" for x in (*from_c, *from_exact))])
    columns = ["machine, model", "-fmad=false: from C", "contracted: from C", "C: error", "contracted: error"]
    print_table("units in the last place", columns, rows)


def by_c(package: Package, precision: Precision, folder: Path) -> Callable[..., Any]:
    """The batches of C, products not contracted into sums, called by name."""
    library = ctypes.CDLL(str(compile_library(render_c_batch(package, precision), folder)))
    return lambda name, *arguments: library[name](*arguments)


def launched(case: Case, function: Function, launch: Callable[..., Any]) -> list[Array]:
    """Results of a batch, by a function that takes its name and arguments."""
    results = case.results(function, STATES)
    arrays = [x.ctypes.data_as(ctypes.c_void_p) for x in (*case.inputs(function, STATES), *results)]
    launch(f"{case.name(function)}_batch", ctypes.c_size_t(STATES), *arrays)
    return results


def ulps(found: Sequence[Array], wanted: Sequence[Array]) -> float:
    """The largest difference of any state."""
    worst = 0.0
    for ours, c in zip(found, wanted, strict=True):
        size, apart = (np.abs(x).max(axis=0, initial=0.0) for x in (c, ours - c))
        unit = np.spacing(size.astype(ours.dtype))
        worst = max(worst, float((apart / unit)[size > 0].max(initial=0.0)))
    return worst


# Times


def speed(precision: Precision) -> None:
    """Nanoseconds a state: kernels, the batch of C on all cores, JAX on its device."""
    try:
        device = Device()
    except DriverError as error:
        raise SystemExit(f"speed is measured on a device only: {error}; `compile` and `rounding` need none") from None
    architecture = device.architecture(nvrtc.architectures())
    cores = len(os.sched_getaffinity(0))
    print(f"{device.name}, sm_{architecture}; {cores} cores; {precision.title}")
    columns = ["machine, model, states", "kernel", "with copies", f"C, {cores} cores", "JAX", "x C", "ulp"]
    rows = []
    for title in ("6R arm", "two-axis machine"):
        case = Case(title, precision)
        module = device.loaded(nvrtc.compiled(case.files[f"{case.stem}.cu"], case.files, architecture).cubin)
        with tempfile.TemporaryDirectory() as folder:
            files = render_c_batch(case.package, precision)
            library = compile_library(files, Path(folder), flags=(*FAST, "-march=native", "-ffp-contract=fast"))
            batches = ctypes.CDLL(str(library))
        for function in case.functions():
            for states in SEEN:
                rows.append(timed(case, function, states, device, module, batches, cores))
    print_table("ns a state", columns, rows)


def timed(
    case: Case, function: Function, states: int, device: Device, module: Any, batches: ctypes.CDLL, cores: int
) -> list[str]:
    """A row of the table."""
    inputs, results = case.inputs(function, states), case.results(function, states)
    given, found = [device.sent(x) for x in inputs], [device.empty(x.shape, x.dtype) for x in results]
    blocks, name = min(4096, (states - 1) // THREADS + 1), case.name(function)
    launch = device.launcher(module, f"{name}_kernel", blocks, THREADS, ctypes.c_size_t(states), *given, *found)
    device.seconds(launch, 3)
    times = max(3, round(SECONDS / device.seconds(launch, 10)))
    kernel = device.seconds(launch, times)

    def with_copies() -> None:
        for array, at in zip(inputs, given, strict=True):
            device.send(array, at)
        launch()
        for at in found:
            device.fetched(at)

    copies = on_clock(with_copies)
    batch = batches[f"{name}_batch"]
    c = on_clock(OnCores(batch, inputs, results, cores))
    apart = ulps([device.fetched(at) for at in found], whole(batch, inputs, results))
    jax = by_jax(case, function, inputs)
    device.free(*given, *found)
    cells = [f"{1e9 * x / states:.3g}" if x else "-" for x in (kernel, copies, c, jax)]
    return [f"{case.title}, {function.name}, {states}", *cells, f"{c / kernel:.1f}", f"{apart:.1f}"]


def on_clock(work: Callable[[], Any]) -> float:
    """Seconds of a call, the least of many in turn."""
    work()
    found: list[float] = []
    while len(found) < 5 or sum(found) < SECONDS:
        start = time.perf_counter()
        work()
        found.append(time.perf_counter() - start)
    return min(found)


class OnCores:
    """Each core computes a part of the states, in arrays of its own."""

    def __init__(self, batch: Any, inputs: Sequence[Array], results: Sequence[Array], cores: int) -> None:
        self.batch, self.pool = batch, ThreadPoolExecutor(cores)
        bounds = np.linspace(0, inputs[0].shape[1], cores + 1).astype(int)
        self.parts = [
            [
                *(np.ascontiguousarray(x[:, first:last]) for x in inputs[:-1]),
                inputs[-1],
                *(np.zeros((len(y), last - first), y.dtype) for y in results),
            ]
            for first, last in itertools.pairwise(bounds)
        ]

    def __call__(self) -> None:
        """Compute all once."""
        list(self.pool.map(lambda part: _run(self.batch, part[0].shape[1], part), self.parts))


def whole(batch: Any, inputs: Sequence[Array], results: Sequence[Array]) -> Sequence[Array]:
    """The results of all states by one call."""
    _run(batch, inputs[0].shape[1], [*inputs, *results])
    return results


def _run(batch: Any, states: int, arrays: Sequence[Array]) -> None:
    batch(ctypes.c_size_t(states), *(x.ctypes.data_as(ctypes.c_void_p) for x in arrays))


def by_jax(case: Case, function: Function, inputs: Sequence[Array]) -> float:
    """Seconds of the numpy functions traced by JAX, on the device that it finds; 0 without JAX."""
    if not find_spec("jax"):
        return 0.0
    import jax

    jax.config.update("jax_enable_x64", case.precision is DOUBLE)
    jnp = jax.numpy
    arithmetic = SimpleNamespace(sin=jnp.sin, cos=jnp.cos, sqrt=jnp.sqrt, sign=jnp.sign, atan2=jnp.arctan2)
    with tempfile.TemporaryDirectory() as folder:
        module = import_package(render_numpy(replace(case.package, functions=(function,))), Path(folder))
    text: Any = getattr(module, f"_{function.name}")
    c = text.constants(arithmetic, tuple(inputs[-1][:-1]))

    def of_states(*arrays: Any) -> Any:
        broadcast = [jnp.broadcast_to(x, arrays[0][0].shape) for r in text.program(arithmetic, *arrays, c) for x in r]
        return jnp.stack(broadcast)

    traced_ = jax.jit(of_states)
    arrays = [jnp.asarray(x) for x in inputs[:-1]]
    return on_clock(lambda: traced_(*arrays).block_until_ready())


if __name__ == "__main__":
    main()
