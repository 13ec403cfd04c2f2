"""Single-precision C on a Cortex-M7 in QEMU against this computer: `python -m tests.benchmarks.embedded`.

Bits of the results, instructions that are executed and stack that is used, beside what `generate --report` says.
Needs gcc-arm-none-eabi and qemu-system-arm.
"""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from symoro_elastic.codegen.embedded.report import code_report
from symoro_elastic.codegen.embedded.tool_chain import tool_chain
from symoro_elastic.codegen.local_names import with_own_results
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import SINGLE
from symoro_elastic.codegen.targets.c import render_c, source_text
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.evaluation.values import parameter_values
from tests.benchmarks.machines import example
from tests.benchmarks.tables import print_table, progress

CORTEX_M7 = "-mcpu=cortex-m7 -mfpu=fpv5-sp-d16 -mfloat-abi=hard"
QEMU = ("qemu-system-arm", "-M", "mps2-an500", "-cpu", "cortex-m7", "-nographic", "-semihosting", "-icount", "shift=0")
MACHINES = {"planar_2r": ("planar_2r.toml", ("w3",)), "two_axis": ("two_axis.toml", ("w2",)), "rx90": ("rx90.par", ())}
"""Files and methods of time steps."""
STATES, CALLS, H = 50, 100, 1e-4
LARGE, EXTRA = 5, 3
"""The last states, whose angles are beyond the range of the code's own sines; words after the results: time, stack."""
NANOSECONDS_PER_TICK = 40
"""Of the timer at 25 MHz; an instruction takes one nanosecond (`-icount shift=0`)."""

PROGRAM = """
#include <stdint.h>
#include <string.h>
#include "@NAME@.h"

void put(const char *text);
uint32_t ticks(void);
void paint(void);
uint32_t painted(void);

static const float inputs[@STATES@][@WIDTH@] = {
@ROWS@
};
static const float p[@PARAMETERS@ + 1] = {@P@};
static float results[256];

static void hex(uint32_t word)
{
    char text[10] = "00000000 ";
    for (int k = 7; k >= 0; k--, word >>= 4) text[k] = "0123456789abcdef"[word & 15U];
    put(text);
}

static void nothing(const float *x) { (void)x; __asm__ volatile("" ::: "memory"); }
@FUNCTIONS@

static void run(void (*call)(const float *), size_t size)
{
    for (size_t s = 0; s < @STATES@; s++) {
        memset(results, 0, sizeof results);
        call(inputs[s]);
        for (size_t k = 0; k < size; k++) {
            uint32_t word;
            memcpy(&word, &results[k], sizeof word);
            hex(word);
        }
    }
    const uint32_t before = ticks();
    for (int k = 0; k < @CALLS@; k++) call(inputs[0]);
    const uint32_t between = ticks();
    for (int k = 0; k < @CALLS@; k++) nothing(inputs[0]);
    hex(between - before - (ticks() - between));
    for (int s = 0; s < @STATES@; s += @STATES@ - 1) {
        paint();
        call(inputs[s]);
        hex(painted());
    }
    put("\\n");
}

int main(void)
{
@RUNS@
    return 0;
}
"""
HOST = """
#include <stdint.h>
#include <stdio.h>
void put(const char *text) { fputs(text, stdout); }
uint32_t ticks(void) { return 0; }
void paint(void) { }
uint32_t painted(void) { return 0; }
"""
BOARD = """
#include <stdint.h>
extern uint32_t stack_top[], data_start[], data_end[], data_from[], bss_start[], bss_end[];
int main(void);
#define UNUSED 0xa5a5a5a5U
static uint32_t *lowest;

static void host(int what, const void *with)
{
    register int r0 __asm__("r0") = what;
    register const void *r1 __asm__("r1") = with;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

void put(const char *text) { host(4, text); }
uint32_t ticks(void) { return 0xffffffU - *(volatile uint32_t *)0xe000e018U; }

/* The 8 kB below the caller's frame are marked; what is still marked afterwards was not used. */
__attribute__((noinline)) void paint(void)
{
    lowest = (uint32_t *)__builtin_frame_address(0) - 2048;
    for (volatile uint32_t *word = lowest; word < (uint32_t *)__builtin_frame_address(0) - 16; word++) *word = UNUSED;
}
__attribute__((noinline)) uint32_t painted(void)
{
    uint32_t *word = lowest;
    while (*(volatile uint32_t *)word == UNUSED) word++;
    return (uint32_t)(2048 - (word - lowest))*4U;
}

void reset(void)
{
    *(volatile uint32_t *)0xe000ed88U |= 0xf00000U; /* the floating-point unit */
    __asm__ volatile("dsb\\nisb");
    for (uint32_t *to = data_start, *from = data_from; to < data_end;) *to++ = *from++;
    for (uint32_t *to = bss_start; to < bss_end;) *to++ = 0U;
    *(volatile uint32_t *)0xe000e014U = 0xffffffU; /* the timer, from its largest number downwards */
    *(volatile uint32_t *)0xe000e018U = 0U;
    *(volatile uint32_t *)0xe000e010U = 5U;
    main();
    host(0x18, (void *)0x20026);
    for (;;) { }
}

static void stop(void) { put("fault\\n"); host(0x18, (void *)0x20023); for (;;) { } }

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    stack_top, (void *)reset, (void *)stop, (void *)stop, (void *)stop, (void *)stop, (void *)stop};
"""
LAYOUT = """
MEMORY { CODE (rx) : ORIGIN = 0, LENGTH = 4M  DATA (rw) : ORIGIN = 0x20000000, LENGTH = 4M }
SECTIONS {
    .text : { KEEP(*(.vectors)) *(.text* .rodata*) *(.ARM.ex*) . = ALIGN(4); data_from = .; } > CODE
    .data : AT (data_from) { data_start = .; *(.data*) . = ALIGN(4); data_end = .; } > DATA
    .bss : { bss_start = .; *(.bss* COMMON) . = ALIGN(4); bss_end = .; } > DATA
    stack_top = ORIGIN(DATA) + LENGTH(DATA);
}
"""


@dataclass(frozen=True)
class Called:
    """A function and what it is given: names and entries of its inputs, entries of what it writes, in order."""

    name: str
    read: tuple[tuple[str, int], ...]
    written: tuple[tuple[str, int], ...]
    in_place: int = 0
    takes_step: bool = False

    def wrapper(self) -> str:
        """A function that calls it for a row of inputs; states that it changes are copied first."""
        places, offset = [], 0
        for name, size in self.read:
            places.append("p" if name == "p" else f"x + {offset}")
            offset += 0 if name == "p" else size
        if self.takes_step:
            places.insert(-1, f"{H}f")
        to = [f"results + {sum(size for _, size in self.written[:k])}" for k in range(len(self.written))]
        copy = f"memcpy(results, x + {offset}, {self.in_place}*sizeof *x); " if self.in_place else ""
        return f"static void call_{self.name}(const float *x) {{ {copy}{self.name}({', '.join([*places, *to])}); }}"

    @property
    def size(self) -> int:
        return sum(size for _, size in self.written)


class Case:
    """A machine in single precision, and its functions at some states."""

    def __init__(self, name: str) -> None:
        file, steps = MACHINES[name]
        self.machine: Machine = example(file)
        scene = Scene(models=("direct_dynamics", "inverse_dynamics"), steps=steps)
        self.package: Package = trace_models(self.machine, scene).package
        self.files = render_c(self.package, SINGLE)
        self.name = f"{self.package.name}{SINGLE.suffix}"

    @cached_property
    def called(self) -> list[Called]:
        made = []
        for function in self.package.functions[:2]:
            results = tuple((r.name, int(np.prod(r.shape))) for r in function.results)
            name = SINGLE.function(self.package.name, function.name)
            made.append(Called(name, tuple(self.package.inputs(function).items()), results))
        for step in source_text(with_own_results(self.package), SINGLE).steps.steps:
            if not step.with_error and step.variant.suffix in ("", "_servo"):
                read = (*((a.name, a.entries) for a in step.read), ("p", 0))
                written = tuple((a.name, a.entries) for a in step.written)
                made.append(Called(step.name, read, written, sum(size for _, size in written), True))
        return made

    def rows(self) -> Array:
        """Inputs: angles and positions, velocities, torques; the last ones with angles that are large."""
        width = max(sum(size for name, size in one.read if name != "p") + one.in_place for one in self.called)
        drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (STATES, width))
        drawn[-LARGE:] *= 5000.0
        return drawn.astype(np.float32)

    def program(self) -> str:
        values = parameter_values(self.machine)
        rows = self.rows()
        words = {
            "NAME": self.name,
            "STATES": str(STATES),
            "CALLS": str(CALLS),
            "WIDTH": str(rows.shape[1]),
            "PARAMETERS": str(len(self.package.parameters)),
            "P": ", ".join([*(f"{float(values[one.name])!r}f" for one in self.package.parameters), "0.0f"]),
            "ROWS": ",\n".join(f"{{{', '.join(f'{float(x)!r}f' for x in row)}}}" for row in rows),
            "FUNCTIONS": "\n".join(one.wrapper() for one in self.called),
            "RUNS": "\n".join(f"    run(call_{one.name}, {one.size});" for one in self.called),
        }
        return re.sub(r"@(\w+)@", lambda found: words[found[1]], PROGRAM)


def on_host(name: str, files: Mapping[str, str], program: str, folder: Path) -> list[list[int]]:
    """Words that a program prints on this computer, a list for each line; `name` is the source of the model."""
    _write(folder, {**files, "main.c": program, "host.c": HOST})
    sources = ["main.c", "host.c", f"{name}.c"]
    subprocess.run(["gcc", "-std=c99", "-O2", *sources, "-o", "main", "-lm"], cwd=folder, check=True)
    return _words(subprocess.run([str(folder / "main")], capture_output=True, text=True, check=True).stdout)


def on_board(
    name: str,
    files: Mapping[str, str],
    program: str,
    folder: Path,
    processor: str = CORTEX_M7,
    flags: str = "",
    qemu: Sequence[str] = QEMU,
) -> list[list[int]]:
    """Words that it prints on a board; `processor` and `flags` are those of the compiler."""
    _write(folder, {**files, "main.c": program, "board.c": BOARD, "layout.ld": LAYOUT})
    compiler = ["arm-none-eabi-gcc", "-O2", *processor.split()]
    subprocess.run([*compiler, "-std=c99", *flags.split(), "-c", "main.c", f"{name}.c"], cwd=folder, check=True)
    subprocess.run(
        [*compiler, "-std=gnu99", "-fno-tree-loop-distribute-patterns", "-c", "board.c"], cwd=folder, check=True
    )
    objects = ["main.o", f"{name}.o", "board.o"]
    linked = [*compiler, "-nostartfiles", "--specs=nosys.specs", "-Tlayout.ld", "-Wl,--no-warn-rwx-segments"]
    subprocess.run([*linked, *objects, "-lm", "-o", "board.elf"], cwd=folder, check=True)
    done = subprocess.run(
        [*qemu, "-kernel", str(folder / "board.elf")], capture_output=True, text=True, check=True, timeout=300
    )
    return _words(done.stdout + done.stderr)


def _write(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")


def _words(text: str) -> list[list[int]]:
    if "fault" in text:
        raise RuntimeError(text)
    return [[int(word, 16) for word in line.split()] for line in text.splitlines() if line.strip()]


def ulps(a: list[int], b: list[int]) -> np.ndarray:
    """Distances of single-precision numbers, in units in the last place; NaN is as far from NaN as 0 from 0."""
    bits = np.array([a, b], np.uint32).view(np.int32).astype(np.int64)
    ordered = np.where(bits < 0, -(bits & 0x7FFFFFFF), bits)
    apart: np.ndarray = np.abs(ordered[0] - ordered[1])
    return apart


def rows_of(name: str) -> Iterator[list[str]]:
    case = Case(name)
    with tempfile.TemporaryDirectory() as folder:
        made = case.name, case.files, case.program(), Path(folder)
        host, board, fused = on_host(*made), on_board(*made), on_board(*made, flags="-ffp-contract=fast")
    report = code_report(case.package, case.files, SINGLE, tool_chain("arm-none-eabi-gcc", CORTEX_M7))
    said = {one.name: one.cost for one in report.functions}
    for one, here, there, there_fused in zip(case.called, host, board, fused, strict=True):
        usual = one.size * (STATES - LARGE)
        distance = ulps(here[:-EXTRA], there[:-EXTRA])
        yield [
            one.name,
            str(distance[:usual].max()),
            str(distance[usual:].max()),
            f"{there[-EXTRA] * NANOSECONDS_PER_TICK / CALLS:.0f}",
            f"{there_fused[-EXTRA] * NANOSECONDS_PER_TICK / CALLS:.0f}",
            str(said[one.name].instructions),
            str(there[-2]),
            str(said[one.name].stack),
            str(there[-1]),
            str(said[one.name].code),
        ]


def main() -> None:
    rows = [row for name in progress(list(MACHINES), "compile, run") for row in rows_of(name)]
    columns = [
        "function",
        "ulp",
        "ulp, huge angles",
        "executed",
        "fused",
        "at most",
        "stack used",
        "stack",
        "used with huge angles",
        "code",
    ]
    print_table(f"Cortex-M7 (arm-none-eabi-gcc -O2 {CORTEX_M7}) in QEMU, single precision", columns, rows)


if __name__ == "__main__":
    main()
