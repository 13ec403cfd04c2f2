"""Time a call of generated C against peers: `python -m tests.benchmarks.speed [--json FILE] [--picture FILE]`."""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from symoro_elastic.codegen.precision import DOUBLE, SINGLE, Precision
from symoro_elastic.machine.machine import Kind, Machine
from tests.benchmarks import picture
from tests.benchmarks.arithmetic_limit import limit
from tests.benchmarks.contest import BUILD, Array, Contestant, Times, contest, difference
from tests.benchmarks.machines import MACHINES, rigid, with_base_parameters
from tests.benchmarks.ours import AVX2, AVX512, batch, code, scalar
from tests.benchmarks.tables import print_table, progress, save_json
from tests.benchmarks.targets import Figures, unmet

STATES = 64
MODELS = ("inverse_dynamics", "direct_dynamics", "inertia_matrix")
COMPILERS = tuple(name for name in ("gcc", "clang") if shutil.which(name))
WIDTHS = {"AVX-512": AVX512, "AVX2": AVX2}
BYTES = {"AVX-512": 64, "AVX2": 32}
"""Of a vector."""


@dataclass(frozen=True)
class Match:
    """A model of a machine: times of all who compute it, and how far their numbers are from Pinocchio's."""

    machine: str
    model: str
    times: Times
    differences: dict[str, float]
    operations: dict[str, int]

    @property
    def reference(self) -> str:
        """Pinocchio's, to which all are compared."""
        return self.times.names[0]

    def figures(self) -> Iterator[dict[str, str | float]]:
        for name, apart in self.differences.items():
            yield {
                "machine": self.machine,
                "model": self.model,
                "contestant": name,
                "ns": self.times.median(name),
                "ratio": self.times.ratio(self.reference, name),
                "difference": apart,
                "operations": self.operations.get(name, 0),
            }


def main() -> None:
    arguments = parser().parse_args()
    if not find_spec("cmeel") or not find_spec("pinocchio"):
        raise SystemExit("Pinocchio, to which all are compared, is not installed: pip install -e '.[benchmarks]'")
    limits = limits_of_this_machine(arguments.rounds)
    found: list[Match] = []
    wanted = [(title, model) for title in MACHINES for model in MODELS]
    for title, model in progress(wanted, "compile and time"):
        found.append(match(title, model, arguments.rounds))
    figures: Figures = [figure for one in found for figure in one.figures()]
    for model in MODELS:
        show(model, figures)
    show_limits(limits, figures)
    unmet(figures)
    if arguments.json:
        save_json(arguments.json, {"figures": figures, "limits_ns": limits})
    if arguments.picture:
        picture.draw(figures, arguments.picture)


def parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.speed", description=__doc__)
    parser.add_argument("--rounds", type=int, default=401, help="rounds in which all take turns")
    parser.add_argument("--json", type=Path, help="save the figures")
    parser.add_argument("--picture", type=Path, help="draw the ratios, SVG")
    return parser


def match(title: str, model: str, rounds: int) -> Match:
    """Check that all give the same numbers, then time them."""
    machine = MACHINES[title]()
    machine = rigid(machine) if model == "inverse_dynamics" else machine
    x = states(machine, model)
    theirs = peers(machine, model, x)
    mine, operations = ours(with_base_parameters(machine), model, x)
    contestants = [*theirs, *mine]
    wanted = contestants[0].results()
    differences = {c.name: difference(c.results(), wanted) for c in contestants}
    wrong = {name: apart for name, apart in differences.items() if apart > (1e-4 if "single" in name else 1e-11)}
    if wrong:
        raise SystemExit(f"{title}, {model}: not the same numbers: {wrong}")
    return Match(title, model, contest(contestants, rounds), differences, operations)


def states(machine: Machine, model: str, seed: int = 0) -> Array:
    """q, qd and the third argument of every state; springs are within 1 mm or 1 mrad of rest."""
    rng = np.random.default_rng([seed, len(machine.joints)])
    moving = [machine.joints[j - 1] for j in machine.moving]
    reach = [1e-3 if joint.kind is Kind.ELASTIC else 0.4 if joint.sigma else np.pi for joint in moving]
    q = rng.uniform(-1, 1, (STATES, len(moving))) * reach
    qd = rng.uniform(-2, 2, (STATES, len(moving)))
    motors = sum(joint.kind is Kind.MOTOR for joint in moving)
    if model == "inertia_matrix":
        return q
    return np.hstack([q, qd, rng.uniform(-1, 1, (STATES, motors)) * (20 if model == "direct_dynamics" else 5)])


def peers(machine: Machine, model: str, x: Array) -> list[Contestant]:
    """Pinocchio first, then those that are installed."""
    from tests.benchmarks.peers import casadi_c, mujoco_c, pinocchio_cpp

    BUILD.mkdir(parents=True, exist_ok=True)
    file = BUILD / f"{machine.name}.txt"
    file.write_text(pinocchio_cpp.model_text(machine), encoding="utf-8")
    n = len(machine.moving)
    results = n * n if model == "inertia_matrix" else n
    with_rates = np.hstack([x, np.zeros_like(x)]) if model == "inertia_matrix" else x
    found = [pinocchio_cpp.contestant(file, model, with_rates, results)]
    if find_spec("casadi"):
        generated = casadi_c.generated(file)
        found += [casadi_c.contestant(generated, model, x, n, results, compiler) for compiler in COMPILERS]
    if find_spec("mujoco") and model in mujoco_c.FUNCTIONS:
        found.append(mujoco_c.contestant(BUILD / f"{machine.name}.mjb", machine, model, x))
    return found


def ours(machine: Machine, model: str, x: Array) -> tuple[list[Contestant], dict[str, int]]:
    """Calls and batches, and the operations of each."""
    folded = code(machine, model)
    found = [scalar(folded, x, f"call, {compiler}", compiler) for compiler in COMPILERS]
    found.append(scalar(code(machine, model, fold=False), x, "call, gcc, parameters in p", "gcc"))
    for precision in (DOUBLE, SINGLE):
        narrow = folded if precision is DOUBLE else code(machine, model, precision=precision)
        for width, flags in WIDTHS.items():
            for compiler in COMPILERS:
                found.append(batch(narrow, x, batch_name(precision, width, compiler), compiler, flags))
    counted = folded.operations
    return found, {c.name: counted.products + counted.add for c in found}


def batch_name(precision: Precision, width: str, compiler: str) -> str:
    return f"batch, {precision.name}, {width}, {compiler}"


def limits_of_this_machine(rounds: int) -> dict[str, float]:
    """Nanoseconds of a product or a sum of each kind of vector, unfused and fused."""
    contestants = [
        limit(
            f"{precision.name}, {width}, {'fused' if fused else 'unfused'}",
            WIDTHS[width],
            bytes_=size,
            fused=fused,
            scalar=precision.real,
        )
        for precision in (DOUBLE, SINGLE)
        for width, size in BYTES.items()
        for fused in (False, True)
    ]
    times = contest(contestants, rounds)
    return {name: times.median(name) for name in times.names}


def cell(figure: dict[str, str | float]) -> str:
    return f"{float(figure['ns']):.3g} ns  x{float(figure['ratio']):.3g}"


def show(model: str, figures: Figures) -> None:
    """A row a contestant, a column a machine."""
    chosen = [figure for figure in figures if figure["model"] == model]
    names = dict.fromkeys(str(figure["contestant"]) for figure in chosen)
    rows = []
    for name in names:
        cells = {f["machine"]: cell(f) for f in chosen if f["contestant"] == name}
        apart = max(float(f["difference"]) for f in chosen if f["contestant"] == name)
        rows.append([name, *(cells.get(machine, "-") for machine in MACHINES), f"{apart:.0e}"])
    title = f"{model}: median time of a state, and how many times faster than Pinocchio C++"
    print_table(title, ["", *MACHINES, "difference"], rows)


def show_limits(limits: dict[str, float], figures: Figures) -> None:
    """Counted operations of gcc's batches in parts of what the processor can do, unfused."""
    kinds = list(dict.fromkeys(name.rpartition(", ")[0] for name in limits))
    rows = [
        [f"limit, {how}, 10^9 a second", *(f"{1 / limits[f'{kind}, {how}']:.3g}" for kind in kinds)]
        for how in ("unfused", "fused")
    ]
    for machine in MACHINES:
        for model in MODELS[:2]:
            chosen = {str(f["contestant"]): f for f in figures if (f["machine"], f["model"]) == (machine, model)}
            batches = {kind: chosen[f"batch, {kind}, gcc"] for kind in kinds}
            parts = [float(f["operations"]) / float(f["ns"]) * limits[f"{k}, unfused"] for k, f in batches.items()]
            rows.append([f"{machine}, {model}", *(f"{part:.0%}" for part in parts)])
    title = "Limit of products and sums, and the part of it that counted operations of gcc's batches reach"
    print_table(title, ["", *kinds], rows)


if __name__ == "__main__":
    main()
