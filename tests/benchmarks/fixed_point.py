"""Fixed point beside single precision on Cortex-M processors in QEMU: `python -m tests.benchmarks.fixed_point`.

Instructions, stack and code of an inverse dynamic model, and the worst error at some states; the results are those of
this computer bit by bit. The Cortex-M7 has a unit for floating point, the Cortex-M3 has none. Needs gcc-arm-none-eabi
and qemu-system-arm.
"""

from __future__ import annotations

import re
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from symoro_elastic.codegen.precision import SINGLE
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.codegen.targets.c_fixed import render_c_fixed
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.described import DescribedMachine
from tests.benchmarks.embedded import CORTEX_M7, NANOSECONDS_PER_TICK, QEMU, on_board, on_host
from tests.benchmarks.machines import example
from tests.benchmarks.tables import print_table, progress
from tests.numerics.guarantees.fixed import FixedCase

MACHINES = ("planar_2r", "puma560_measured")
MODEL = "inverse_dynamics"
STATES, CALLS = 50, 100
CORTEX_M3 = "-mcpu=cortex-m3"
BOARDS = {"Cortex-M7": (CORTEX_M7, "mps2-an500", "cortex-m7"), "Cortex-M3": (CORTEX_M3, "mps2-an385", "cortex-m3")}
"""Flags of the compiler, board and processor of QEMU."""
CONVERSIONS = ("_of_angle", "_of_number", "_si", "_in_box")
"""Functions that a call does not need."""

PROGRAM = """
#include <stdint.h>
#include <string.h>
#include "@NAME@.h"

void put(const char *text);
uint32_t ticks(void);
void paint(void);
uint32_t painted(void);

static const @TYPE@ inputs[@STATES@][@WIDTH@] = {
@ROWS@
};
static @TYPE@ results[64];

static void hex(uint32_t word)
{
    char text[10] = "00000000 ";
    for (int k = 7; k >= 0; k--, word >>= 4) text[k] = "0123456789abcdef"[word & 15U];
    put(text);
}

static void nothing(const @TYPE@ *x) { (void)x; __asm__ volatile("" ::: "memory"); }
static void call(const @TYPE@ *x) { @CALL@; }

int main(void)
{
    for (size_t s = 0; s < @STATES@; s++) {
        call(inputs[s]);
        for (size_t k = 0; k < @SIZE@; k++) {
            uint32_t word;
            memcpy(&word, &results[k], sizeof word);
            hex(word);
        }
    }
    const uint32_t before = ticks();
    for (int k = 0; k < @CALLS@; k++) call(inputs[k % @STATES@]);
    const uint32_t between = ticks();
    for (int k = 0; k < @CALLS@; k++) nothing(inputs[k % @STATES@]);
    hex(between - before - (ticks() - between));
    paint();
    call(inputs[0]);
    hex(painted());
    put("\\n");
    return 0;
}
"""


@dataclass(frozen=True)
class Build:
    """One way to build the model of a machine: its files, and how its numbers are written and read."""

    kind: str
    case: FixedCase

    @property
    def is_fixed(self) -> bool:
        return self.kind == "fixed"

    @property
    def name(self) -> str:
        return self.case.name if self.is_fixed else f"{self.case.package.name}_single"

    @cached_property
    def files(self) -> dict[str, str]:
        return render_c_fixed(self.case.package) if self.is_fixed else render_c(self.case.package, SINGLE)

    def program(self, states: Array) -> str:
        rows, arguments = self.rows(states), self.case.text.arguments
        starts = np.cumsum([0, *(len(a.bits) for a in arguments)])
        given = [f"x + {start}" for start in starts[:-1]] + ([] if self.is_fixed else ["0"])
        ends = np.cumsum([0, *(len(a.bits) for a in self.case.text.results)])
        called = self.case.text.name if self.is_fixed else SINGLE.function(self.case.package.name, MODEL)
        suffix = "" if self.is_fixed else "f"
        words = {
            "NAME": self.name,
            "TYPE": "int32_t" if self.is_fixed else "float",
            "STATES": str(len(states)),
            "CALLS": str(CALLS),
            "WIDTH": str(rows.shape[1]),
            "SIZE": str(ends[-1]),
            "CALL": f"{called}({', '.join([*given, *(f'results + {start}' for start in ends[:-1])])})",
            "ROWS": ",\n".join(f"{{{', '.join(f'{x}{suffix}' for x in row)}}}" for row in rows.tolist()),
        }
        return re.sub(r"@(\w+)@", lambda found: words[found[1]], PROGRAM)

    def rows(self, states: Array) -> Array:
        """The states as the code takes them: angles in single precision are rounded."""
        rounded: Array = (states * self.case.argument_units).astype(np.float32)
        return states if self.is_fixed else rounded

    def results(self, words: list[int]) -> Array:
        found = np.array(words, np.uint32)
        if self.is_fixed:
            return found.view(np.int32).astype(float) * np.tile(self.case.units, STATES)
        return found.view(np.float32).astype(float)


def _code(file: Path) -> int:
    """Bytes of the functions in an object file that a call may need, without those of libraries."""
    listed = subprocess.run(["arm-none-eabi-nm", "-S", str(file)], capture_output=True, text=True, check=True).stdout
    rows = [line.split() for line in listed.splitlines()]
    return sum(int(row[1], 16) for row in rows if len(row) == 4 and row[2] in "tT" and not row[3].endswith(CONVERSIONS))


def rows_of(name: str) -> list[list[str]]:
    machine = example(f"{name}.toml")
    case = FixedCase(machine, DescribedMachine.of(machine).limits, MODEL)
    states = case.states(STATES, np.random.default_rng(0))
    exact = case.exact(states)
    largest = np.abs(case.exact(case.states(100_000, np.random.default_rng(1)))).max(axis=0)
    moved = largest > 0
    rows = []
    for build in (Build("fixed", case), Build("single", case)):
        with tempfile.TemporaryDirectory() as folder:
            made = build.name, build.files, build.program(states), Path(folder)
            (here,) = on_host(*made)
            boards = {}
            for board, (flags, *words_of_qemu) in BOARDS.items():
                given = dict(zip(("mps2-an500", "cortex-m7"), words_of_qemu, strict=True))
                (words,) = on_board(*made, flags, qemu=[given.get(word, word) for word in QEMU])
                boards[board] = words, _code(Path(folder) / f"{build.name}.o")
        found = build.results(here[:-2]).reshape(exact.shape)
        error = (np.abs(found - exact).max(axis=0)[moved] / largest[moved]).max()
        equal = all(words[:-2] == here[:-2] for words, _ in boards.values())
        rows.append([name, build.kind, f"{error:.1e}", "equal" if equal else "differ"])
        for words, code in boards.values():
            executed = words[-2] * NANOSECONDS_PER_TICK / CALLS
            rows[-1] += [f"{executed:.0f}", str(words[-1]), str(code)]
    return rows


def main() -> None:
    rows = [row for name in progress(list(MACHINES), "compile, run") for row in rows_of(name)]
    of_boards = [f"{board}: {x}" for board in BOARDS for x in ("executed", "stack", "code")]
    columns = ["machine", "numbers", "error", "bits", *of_boards]
    print_table(f"{MODEL} on Cortex-M processors in QEMU, fixed point and single precision", columns, rows)


if __name__ == "__main__":
    main()
