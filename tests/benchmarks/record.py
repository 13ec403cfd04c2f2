"""The batch record: inverse model of a 7R arm, 1024 states, ns a state: `python -m tests.benchmarks.record`.

Calls and batches of generated C in each precision, on one core and on all, and peers that are installed: the same
numbers first, then medians of rounds in which all take turns.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from symoro_elastic.codegen.precision import DOUBLE, MIXED, SINGLE
from symoro_elastic.machine.machine import Machine
from tests.benchmarks.contest import Array, BuildFailed, Contestant, contest, difference
from tests.benchmarks.machines import arm_7, with_base_parameters
from tests.benchmarks.match import builds_of
from tests.benchmarks.ours import AVX2, NATIVE, Code, batch, code, scalar
from tests.benchmarks.tables import print_table, save_json

MODEL = "inverse_dynamics"
STATES = 1024
WIDTHS = {"AVX2": AVX2, "the processor's vectors": NATIVE}
OPENMP = "-fopenmp"


class Shared(Code):
    """The C of a model whose batch is shared among threads."""

    @property
    def batch(self) -> str:
        return super().batch.replace("_batch(", "_batch_threads(")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.record", description=__doc__)
    parser.add_argument("--rounds", type=int, default=401, help="rounds in which all take turns")
    parser.add_argument("--json", type=Path, help="save the figures")
    asked = parser.parse_args()
    x = states()
    contestants = [*peers(x), *ours(with_base_parameters(arm_7()), x)]
    apart = differences(contestants)
    times = contest(contestants, asked.rounds)
    first = min(builds_of(times.names), key=times.median)
    rows = [
        [name, f"{times.median(name):.3g}", f"{times.ratio(first, name):.3g}", f"{apart[name]:.0e}"]
        for name in times.names
    ]
    title = f"Inverse model of a 7R arm, {STATES} states, {os.cpu_count()} cores"
    print_table(title, ["", "ns a state", f"times faster than {first}", "difference"], rows)
    if asked.json:
        save_json(asked.json, {name: times.median(name) for name in times.names})


def states() -> Array:
    """q, qd and accelerations, a row a state."""
    rng = np.random.default_rng(7)
    return np.hstack([rng.uniform(-size, size, (STATES, 7)) for size in (np.pi, 2, 5)])


def ours(machine: Machine, x: Array) -> list[Contestant]:
    folded = code(machine, MODEL)
    found = [scalar(folded, x, "call, double", "gcc")]
    for precision in (DOUBLE, SINGLE, MIXED):
        of = code(machine, MODEL, precision=precision)
        found += [batch(of, x, f"batch, {precision.name}, {width}", "gcc", flags) for width, flags in WIDTHS.items()]
        shared = Shared(of.package, of.function, of.precision)
        found.append(batch(shared, x, f"batch, {precision.name}, on all cores", "gcc", (*NATIVE, OPENMP)))
    return found


def peers(x: Array) -> list[Contestant]:
    """Pinocchio, and C that CasADi generates from it, where they are installed with Eigen."""
    if not find_spec("cmeel") or not find_spec("pinocchio"):
        return []
    from tests.benchmarks.peers import casadi_c, pinocchio_cpp

    try:
        file = pinocchio_cpp.model_file(arm_7())
        found = pinocchio_cpp.contestants(file, MODEL, x, 7)
        if find_spec("casadi"):
            generated = casadi_c.generated(file, MODEL)
            found.append(replace(casadi_c.contestant(generated, x, "gcc"), name="C by CasADi from Pinocchio"))
    except BuildFailed as error:
        print(f"no peers: {error}")
        return []
    return found


def differences(contestants: list[Contestant]) -> dict[str, float]:
    """How far each is from the call in double precision; stops where that is more than rounding."""
    wanted = next(c for c in contestants if c.name == "call, double").results()[:, :7]
    found = {c.name: difference(c.results()[:, :7], wanted) for c in contestants}
    wrong = {name: x for name, x in found.items() if x > (1e-4 if "single" in name or "mixed" in name else 1e-11)}
    if wrong:
        raise SystemExit(f"not the same numbers: {wrong}")
    return found


if __name__ == "__main__":
    main()
