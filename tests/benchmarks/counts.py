"""Operations and instructions of a call, beside published ones: `python -m tests.benchmarks.counts [--json FILE]`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from symoro_elastic.machine.machine import Machine
from symoro_elastic.symbolic.program import OperationCount
from tests.benchmarks.contest import COMPILERS
from tests.benchmarks.instructions import available, per_call
from tests.benchmarks.machines import arm_6, chain, example, humanoid, two_axis, with_base_parameters
from tests.benchmarks.ours import code
from tests.benchmarks.tables import print_table, progress, save_json

Pair = tuple[int, int]


@dataclass(frozen=True)
class Case:
    """A model of a machine; what OpenSYMORO and SYMORO+ need, and what is aimed at: products, sums."""

    title: str
    machine: Callable[[], Machine]
    model: str
    open_symoro: Pair | None = None
    symoro_plus: Pair | None = None
    aim: Pair | None = None
    base: bool = True
    fold: bool = False


CASES = (
    Case("RX90", arm_6, "inverse_dynamics", (291, 230), (253, 237), (250, 235)),
    Case("RX90, general", arm_6, "inverse_dynamics", (337, 288), (294, 292), base=False),
    Case("RX90", arm_6, "direct_dynamics", (864, 626), (889, 653), (600, 450)),
    Case("RX90, general", arm_6, "direct_dynamics", (885, 678), base=False),
    Case("RX90", arm_6, "inertia_matrix", (195, 137), None, (180, 125)),
    Case("PUMA 560", lambda: example("puma560.par"), "inverse_dynamics", (319, 257), (279, 261), (276, 258)),
    Case("PUMA 560, general", lambda: example("puma560.par"), "inertia_matrix", (309, 217), base=False),
    Case("flex4", lambda: example("flex4.par"), "inverse_dynamics", (194, 133)),
    Case("flex4", lambda: example("flex4.par"), "direct_dynamics", (209, 143)),
    Case("RX90", arm_6, "regressor", (577, 336)),
    Case("chain of 80", lambda: chain(80), "inverse_dynamics", (6310, 5669), (5599, 5669), (5590, 5450), False),
    Case("chain of 80", lambda: chain(80), "direct_dynamics", (23451, 18950), None, (14000, 12000), False),
    Case("two-axis machine, numbers", two_axis, "direct_dynamics", fold=True, base=False),
    Case("humanoid, 29 joints", humanoid, "inverse_dynamics"),
    Case("humanoid, 29 joints", humanoid, "direct_dynamics"),
)
"""With base inertial parameters and Ia unless the title says general."""
LONGEST = 4000
"""Operations beyond which instructions are not counted: compilation takes too long."""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.counts", description=__doc__)
    parser.add_argument("--json", type=Path, help="save the figures")
    arguments = parser.parse_args()
    figures = [figures_of(case) for case in progress(CASES, "trace, compile, count")]
    columns = ["", "model", "operations", "sin/cos", "once", "OpenSYMORO", "SYMORO+", "aim"]
    rows = [[str(figure[column]) for column in ("title", "model", *columns[2:])] for figure in figures]
    counted = [[_whole(figure.get(f"instructions, {c}")) for c in COMPILERS] for figure in figures]
    print_table(
        "Operations of a call (x: products and divisions), and instructions by callgrind (-O2 -mavx2 -mfma)",
        [*columns, *COMPILERS],
        [[*row, *more] for row, more in zip(rows, counted, strict=True)],
    )
    if arguments.json:
        save_json(arguments.json, figures)


def figures_of(case: Case) -> dict[str, object]:
    machine = with_base_parameters(case.machine()) if case.base else case.machine()
    made = code(machine, case.model, fold=case.fold)
    count, once = made.operations, made.function.program.count_once
    figures: dict[str, object] = {
        "title": case.title,
        "model": case.model,
        "operations": _text((count.products, count.add)),
        "sin/cos": count.sincos,
        "once": _text((once.products, once.add)) if once.products + once.add else "-",
        "OpenSYMORO": _text(case.open_symoro),
        "SYMORO+": _text(case.symoro_plus),
        "aim": _text(case.aim),
    }
    if available() and total(count) <= LONGEST:
        figures |= {f"instructions, {compiler}": per_call(made, compiler) for compiler in COMPILERS}
    return figures


def total(count: OperationCount) -> int:
    return count.products + count.add


def _text(pair: Pair | None) -> str:
    return f"{pair[0]}x {pair[1]}+" if pair else "-"


def _whole(instructions: object) -> str:
    return f"{instructions:.0f}" if isinstance(instructions, float) else "-"


if __name__ == "__main__":
    main()
