"""A state of a batch beside a single call: `python -m tests.benchmarks.batches [--states N] [--model NAME]`.

Every golden machine and those of `speed`, constants folded, by gcc: vectors of AVX-512 (one, and in pairs), AVX2 and
SSE2, each beside single calls with the same instructions, and in parts of the products and sums that the processor can
do with them, unfused. Those of `speed` are as there: base parameters, rigid in the inverse model. Medians of rounds in
which all take turns.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.states import moderate_states
from tests.benchmarks.arithmetic_limit import limit
from tests.benchmarks.contest import Array, contest
from tests.benchmarks.machines import MACHINES, example, rigid, with_base_parameters
from tests.benchmarks.ours import AVX2, AVX512, PAIRS, Code, batch, code, scalar
from tests.benchmarks.tables import print_table, progress

MODELS = ("direct_dynamics", "inverse_dynamics", "inertia_matrix", "inertia_matrix_packed")
GOLDEN = ("ball_screw.toml", "flex4.par", "planar_2r.toml", "puma560.par", "rx90.par", "sr400.par")
CALLS = {"AVX-512": AVX512, "AVX2": AVX2, "SSE2": ()}
BATCHES = {"AVX-512": AVX512, "AVX-512 in pairs": PAIRS, "AVX2": AVX2, "SSE2": ()}
BYTES = {"AVX-512": 64, "AVX2": 32, "SSE2": 16}
"""Of a vector."""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.batches", description=__doc__)
    parser.add_argument("--states", type=int, default=1000, help="states of a batch")
    parser.add_argument("--rounds", type=int, default=21, help="rounds in which all take turns")
    parser.add_argument("--only", default="", help="machines whose name holds this")
    parser.add_argument("--model", action="append", help="model to time; may be repeated")
    asked = parser.parse_args()
    made = [(title, make) for title, make in machines() if asked.only in title]
    wanted = [(title, make, model) for title, make in made for model in asked.model or MODELS]
    rows = [row(title, make(), model, asked) for title, make, model in progress(wanted, "compile and time")]
    title = (
        f"ns a state of a batch of {asked.states} states, parts of a single call and of the limit of products and sums"
    )
    print_table(title, ["", "entries", *BATCHES], [cells for cells, _ in rows])
    slower = [f"{cells[0]} ({name})" for cells, ratios in rows for name, ratio in ratios.items() if ratio > 1]
    print(f"slower than a single call: {', '.join(slower) or 'none'}")


def machines() -> Iterator[tuple[str, Callable[[], Machine]]]:
    yield from MACHINES.items()
    yield from ((name, lambda name=name: valued(example(name))) for name in GOLDEN)


def valued(machine: Machine) -> Machine:
    """The machine with plausible values where it gives none."""
    values = parameter_values(machine, 0)
    return replace(
        machine, parameters=tuple(replace(p, value=Formula.parse(values[p.name])) for p in machine.parameters)
    )


def row(title: str, machine: Machine, model: str, asked: argparse.Namespace) -> tuple[list[str], dict[str, float]]:
    if title in MACHINES:
        machine = with_base_parameters(rigid(machine) if model == "inverse_dynamics" else machine)
    of = code(machine, model)
    x = inputs(of, machine, asked.states)
    calls = [scalar(of, x, f"call, {name}", "gcc", flags) for name, flags in CALLS.items()]
    many = [batch(of, x, name, "gcc", flags) for name, flags in BATCHES.items()]
    limits = [limit(f"limit, {name}", CALLS[name], bytes_=size, fused=False) for name, size in BYTES.items()]
    times = contest([*calls, *many, *limits], asked.rounds)
    found = {name: times.median(name) for name in BATCHES}
    ratios = {name: times.ratio(name, f"call, {name.removesuffix(' in pairs')}") for name in BATCHES}
    count = of.operations.products + of.operations.add
    shares = {name: count * times.ratio(f"limit, {name.removesuffix(' in pairs')}", name) for name in BATCHES}
    cells = [f"{ns:.3g}  x{ratios[name]:.2f}  {shares[name]:.0%}" for name, ns in found.items()]
    return [f"{title}, {model}", str(sum(of.results)), *cells], ratios


def inputs(of: Code, machine: Machine, count: int) -> Array:
    states = moderate_states(machine, count)
    return np.hstack([getattr(states, argument.name) for argument in of.function.arguments])


if __name__ == "__main__":
    main()
