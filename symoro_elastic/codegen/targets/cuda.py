"""The target `cuda`: functions of device code for one state, kernels for many, and functions that launch them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from symoro_elastic.codegen.c.function import Array, CFunction
from symoro_elastic.codegen.c.lines import INDENT, with_arguments, wrap_lines
from symoro_elastic.codegen.c.printers import Form
from symoro_elastic.codegen.c.steps import CSteps, Qualifiers, StepText
from symoro_elastic.codegen.c.text import Routine, call, head, of_preparing, preparing, working
from symoro_elastic.codegen.local_names import with_local_names, with_own_results
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files, function_context
from symoro_elastic.codegen.partition import LONGEST_WHOLE
from symoro_elastic.codegen.precision import DOUBLE, MIXED, SINGLE, Precision
from symoro_elastic.codegen.target import Target, words
from symoro_elastic.codegen.targets.c import OWN as C_WORDS
from symoro_elastic.codegen.targets.c import C, PackageText, package_text, scalar_form
from symoro_elastic.codegen.templates import render, with_digest

THREADS = 128
"""Threads of a block: with as many each may have all 255 registers that the hardware can address."""
BLOCKS = 4096
"""Maximum number of blocks of a launch: several per multiprocessor on any device, for balanced load."""
SHARED_BYTES = 48 * 1024
"""Shared memory per block on every device, bytes."""
DEVICE = "static __device__ "
QUALIFIERS = Qualifiers(f"{DEVICE}inline ", f"{DEVICE}inline ", f"{DEVICE}__noinline__ ", DEVICE)
"""Accelerations, which every stage of a step needs, are not copied into it: that would fill the instruction cache."""
OWN = words(
    """
    states steps hold stream s k row step first count large size from to blocks arguments
    threadIdx blockIdx blockDim gridDim warpSize dim3 sincos sincosf clock
    MAXFLOAT NZERO BIG_ENDIAN LITTLE_ENDIAN BYTE_ORDER LONG_BIT WORD_BIT PIPE_BUF MAX_INPUT MAX_CANON TIME_UTC NFDBITS
    SEEK_SET SEEK_CUR SEEK_END SEEK_DATA SEEK_HOLE WNOHANG WUNTRACED WSTOPPED WEXITED WCONTINUED WNOWAIT
    STA_CLK STA_DEL STA_FLL STA_INS STA_MODE STA_NANO STA_PLL ADJ_FREQUENCY ADJ_MICRO ADJ_NANO ADJ_OFFSET ADJ_STATUS
    ADJ_TAI ADJ_TICK MOD_CLKA MOD_CLKB MOD_MICRO MOD_NANO MOD_OFFSET MOD_STATUS MOD_TAI CLOCK_MONOTONIC CLOCK_REALTIME
    INT_WIDTH LONG_WIDTH CHAR_WIDTH BOOL_WIDTH
    """
)
"""Identifiers of the templates, and variables and macros of CUDA and of the headers that it includes."""


@dataclass(frozen=True)
class Kernel:
    """A CUDA kernel: its name, its head, the head of its launcher, and the arguments passed on."""

    name: str
    head: str
    launcher: str
    arguments: str


@dataclass(frozen=True)
class DeviceFunction:
    """A model in CUDA: its comment, its device functions, and its kernel; None for a model without state.

    `shares`: parameter-only values fit into the shared memory of a block. `first` is the kernel
    that computes them once for all blocks, `after` the kernel with these as argument; None without such values.
    """

    name: str
    title: str
    counts: str
    documented: tuple[str, ...]
    constants: str
    constant_count: int
    shares: bool
    routines: tuple[Routine, ...]
    prepared: Routine | None
    one: Routine
    kernel: Kernel | None
    first: Kernel | None
    after: Kernel | None
    state_call: str


@dataclass(frozen=True)
class StepKernel:
    """A time step as a kernel: arrays read once, arrays with a row per step, arrays of the state, the error."""

    step: StepText
    kernel: Kernel
    gains: tuple[Array, ...]
    rows: tuple[Array, ...]
    state: tuple[Array, ...]
    error: Array | None
    call: str


@dataclass(frozen=True)
class CudaText(PackageText):
    """Template data of a CUDA file; `called` are the functions that statements need."""

    functions: tuple[DeviceFunction, ...]
    called: frozenset[str]
    steps: CSteps
    step_kernels: tuple[StepKernel, ...]
    shares_steps: bool
    threads: int
    blocks: int


def strided_form(package: Package, precision: Precision) -> Form:
    """Form of numbers in device code, where entry k of an array of one among many states is at `k*states`."""
    form, name = scalar_form(package, precision), package.name + precision.suffix

    def with_stride(text: str) -> str:
        return text.replace("[{k}]", "[{k}*states]")

    return replace(
        form,
        load=with_stride(form.load),
        load_angle=with_stride(form.load_angle),
        store=with_stride(form.store),
        sincos=lambda *_: (f"{name}_sincos(angle, sine, cosine);",),
        states="states",
        part=LONGEST_WHOLE,  # what parts hand on is in the memory of the device
    )


def render_cuda(package: Package, precision: Precision = DOUBLE) -> Files:
    """Return `<name>.cuh` and `<name>.cu`, the precision in their names unless it is double."""
    text = _text(with_local_names(with_own_results(package), OWN | C_WORDS), precision)
    names = {f"{text.name}{suffix}": f"cuda/model{suffix}.j2" for suffix in (".cuh", ".cu")}
    return with_digest({name: wrap_lines(render(template, **vars(text))) for name, template in names.items()})


def _text(package: Package, precision: Precision) -> CudaText:
    form = strided_form(package, precision)
    functions = [CFunction(package, function, precision, form) for function in package.functions]
    steps = CSteps(package, precision, functions, qualifiers=QUALIFIERS)
    return CudaText(
        **vars(package_text(package, precision, functions, form)),
        functions=tuple(map(_function, functions)),
        called=frozenset(name for function in functions for name in function.printer.called),
        steps=steps,
        step_kernels=tuple(_step_kernel(step, steps) for step in steps.steps),
        shares_steps=_fits(steps.constants, precision),
        threads=THREADS,
        blocks=BLOCKS,
    )


def _function(function: CFunction) -> DeviceFunction:
    about, c = function_context(function.function), function.c
    strided = f"{function.name}_strided"
    in_two = c and function.function.arguments
    return DeviceFunction(
        name=function.name,
        title=f"{about['title']} {about['equations']}.",
        counts=about["counts"],
        documented=tuple(about["documented"]),
        constants=c[0].size if c else "",
        constant_count=len(function.constants),
        shares=_fits(len(function.constants), function.precision),
        routines=(*preparing(function), *working(function, strided)),
        prepared=Routine(head(f"{function.name}_prepared", function.arrays), _of_one_state(function)) if c else None,
        one=Routine(head(function.name, function.signature), _body(function)),
        kernel=_kernel(function.name, ["size_t states"], function.signature) if function.function.arguments else None,
        first=_kernel(f"{function.name}_prepare", [], of_preparing(function)) if in_two else None,
        after=_kernel(f"{function.name}_prepared", ["size_t states"], function.arrays) if in_two else None,
        state_call=_state_call(function, strided),
    )


def _fits(constants: int, precision: Precision) -> bool:
    return constants * (4 if precision.real == "float" else 8) <= SHARED_BYTES


def _of_one_state(function: CFunction) -> str:
    """Call of the function for strided arrays with the arrays of a single state."""
    return with_arguments(f"{INDENT}{function.name}_strided", ["1", *(a.name for a in function.arrays)], ");")


def _body(function: CFunction) -> str:
    """Body of the device function for one state, which recomputes parameter-only values."""
    if not function.c:
        return _of_one_state(function)
    c = function.c[0]
    lines = [f"{INDENT}{c.type} {c.name}[{c.size}];", call(f"{function.name}_prepare", [function.p, c])]
    return "\n".join([*lines, _of_one_state(function)])


def _state_call(function: CFunction, name: str) -> str:
    """Call of a function with all arrays advanced to the state `s`."""
    of_states = {a.name for a in (*function.inputs, *function.results) if a.entries}
    arguments = [f"{a.name} + s" if a.name in of_states else a.name for a in function.arrays]
    return with_arguments(f"{INDENT * 2}{name}", ["states", *arguments], ");")


def _kernel(name: str, sizes: Sequence[str], arrays: Sequence[Array | str]) -> Kernel:
    """The kernel that computes a function; `arrays` given as text are numbers."""
    plain = [*sizes, *(a if isinstance(a, str) else a.pointer() for a in arrays)]
    restricted = [*sizes, *(a if isinstance(a, str) else a.pointer().replace("*", "*__restrict__ ") for a in arrays)]
    names = [text.replace("*", " ").split()[-1] for text in plain]
    return Kernel(
        name=f"{name}_kernel",
        head=with_arguments(f"{name}_kernel", restricted),
        launcher=with_arguments(f"cudaError_t {name}_batch", [*plain, "cudaStream_t stream"]),
        arguments=", ".join(f"&{name}" for name in names),
    )


def _step_kernel(step: StepText, steps: CSteps) -> StepKernel:
    error = [array for array in step.written if array.name == "error"]
    gains = [array for array in step.read if array.name in step.variant.of_step]
    arrays: list[Array | str] = [*step.read, f"{steps.precision.state} h", steps.p, *step.written]
    sizes = [f"size_t {name}" for name in ("states", "steps", "hold")]
    return StepKernel(
        step=step,
        kernel=_kernel(step.name, sizes, arrays),
        gains=tuple(gains),
        rows=tuple(array for array in step.read if array not in gains),
        state=tuple(array for array in step.written if array not in error),
        error=error[0] if error else None,
        call=with_arguments(f"{INDENT * 3}{step.name}_stages", list(_step_arguments(step, steps)), ");"),
    )


def _step_arguments(step: StepText, steps: CSteps) -> Iterator[str]:
    yield from (f"{array.name}_one" for array in step.read)
    yield from ("h", "p", *(["c"] if steps.constants else []))
    yield from (f"{array.name}_one" for array in step.written)


CUDA = Target(
    name="cuda",
    title="CUDA: device functions, and kernels with one state a thread",
    suffixes=(".cuh", ".cu"),
    precisions=(DOUBLE, SINGLE, MIXED),
    reserved=C.reserved,
    files=render_cuda,
)
