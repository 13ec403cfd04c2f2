"""Time a call of generated C against peers: `python -m tests.benchmarks.speed [--json FILE] [--picture FILE]`."""

from __future__ import annotations

import argparse
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from symoro_elastic.codegen.precision import DOUBLE, SINGLE, Precision
from symoro_elastic.machine.machine import Machine
from tests.benchmarks import picture
from tests.benchmarks.arithmetic_limit import limit
from tests.benchmarks.contest import BUILD, COMPILERS, Array, Contestant, contest
from tests.benchmarks.machines import MACHINES, rigid, with_base_parameters
from tests.benchmarks.match import Match, matched, require_pinocchio, show, states
from tests.benchmarks.ours import AVX2, AVX512, NATIVE, PAIRS, batch, code, scalar
from tests.benchmarks.tables import print_table, progress, save_json
from tests.benchmarks.targets import Figures, unmet

MODELS = ("inverse_dynamics", "direct_dynamics", "inertia_matrix")
SMALL = 12
"""Joints up to which the direct model is also found by A^-1."""
WIDTHS = {"AVX-512": AVX512, "AVX2": AVX2}
BATCHES = {**WIDTHS, "AVX-512 in pairs": PAIRS}
BYTES = {"AVX-512": 64, "AVX2": 32}
"""Of a vector."""
OF_SINES = {DOUBLE.name: 45 / 2, SINGLE.name: 33 / 2}
"""Products and sums of a sine or cosine: for both 22 and 23 in `templates/c/sincos_double.c.j2`, else 16 and 17."""


def main() -> None:
    arguments = parser().parse_args()
    require_pinocchio(compiled=True)
    limits = limits_of_this_machine(arguments.rounds)
    found: list[Match] = []
    wanted = [(title, model) for title in MACHINES for model in MODELS]
    for title, model in progress(wanted, "compile and time"):
        found.append(match(title, model, arguments.rounds))
    figures: Figures = [figure for one in found for figure in one.figures()]
    for model in MODELS:
        show(model, figures, list(MACHINES))
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


RECURSION = "CasADi, recursion in three-vectors"


def match(title: str, model: str, rounds: int) -> Match:
    """Peers and ours on the same states."""
    machine = MACHINES[title]()
    machine = rigid(machine) if model == "inverse_dynamics" else machine
    x = states(machine, model)
    theirs = peers(machine, model, x)
    based = with_base_parameters(machine)
    mine, operations = ours(based, model, x)
    sines = code(based, model).operations.sincos
    return matched(title, model, [*theirs, *mine], operations, rounds, sines=sines)


def peers(machine: Machine, model: str, x: Array) -> list[Contestant]:
    """Pinocchio first, then those that are installed."""
    from tests.benchmarks.peers import casadi_c, mujoco_c, pinocchio_cpp

    file = pinocchio_cpp.model_file(machine)
    n = len(machine.independent)
    results = n * n if model == "inertia_matrix" else n
    with_rates = np.hstack([x, np.zeros_like(x)]) if model == "inertia_matrix" else x
    found = pinocchio_cpp.contestants(file, model, with_rates, results)
    if find_spec("casadi"):
        generated = casadi_c.generated(file, model)
        found += [casadi_c.contestant(generated, x, compiler) for compiler in COMPILERS]
        if model == "inverse_dynamics":
            recursion = casadi_c.recursion(machine)
            found += [casadi_c.contestant(recursion, x, compiler, RECURSION) for compiler in COMPILERS]
    if find_spec("mujoco") and model in mujoco_c.FUNCTIONS:
        found.append(mujoco_c.contestant(BUILD / f"{machine.name}.mjb", machine, model, x))
    return found


def ours(machine: Machine, model: str, x: Array) -> tuple[list[Contestant], dict[str, int]]:
    """Calls and batches, and the operations of each."""
    folded = code(machine, model)
    found = [scalar(folded, x, f"call, {compiler}", compiler) for compiler in COMPILERS]
    in_p = code(machine, model, fold=False)
    found += [scalar(in_p, x, f"call, {compiler}, parameters in p", compiler) for compiler in COMPILERS]
    if folded.package.limbs:
        plain = (*NATIVE, "-DNO_VECTORS")
        found += [scalar(folded, x, f"call without vectors, {compiler}", compiler, plain) for compiler in COMPILERS]
    for precision in (DOUBLE, SINGLE):
        narrow = folded if precision is DOUBLE else code(machine, model, precision=precision)
        for width, flags in BATCHES.items():
            for compiler in COMPILERS:
                found.append(batch(narrow, x, batch_name(precision, width, compiler), compiler, flags))
    counted = dict.fromkeys((c.name for c in found), folded.operations)
    if model == "direct_dynamics" and len(machine.independent) <= SMALL:
        by_matrix = code(machine, f"{model}_by_inertia_matrix")
        for compiler in COMPILERS:
            found.append(scalar(by_matrix, x, f"call by A^-1, {compiler}", compiler))
            counted[found[-1].name] = by_matrix.operations
    return found, {name: count.products + count.add for name, count in counted.items()}


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


def show_limits(limits: dict[str, float], figures: Figures) -> None:
    """Counted operations of gcc's batches, in pairs or not, in parts of what the processor can do, unfused."""
    kinds = list(dict.fromkeys(name.rpartition(", ")[0] for name in limits))
    rows = [
        [f"limit, {how}, 10^9 a second", *(f"{1 / limits[f'{kind}, {how}']:.3g}" for kind in kinds)]
        for how in ("unfused", "fused")
    ]
    for machine in MACHINES:
        for model in MODELS[:2]:
            chosen = {str(f["contestant"]): f for f in figures if (f["machine"], f["model"]) == (machine, model)}
            batches = {kind: fastest(chosen, f"batch, {kind}") for kind in kinds}
            shares = [share(f, kind, limits[f"{kind}, unfused"]) for kind, f in batches.items()]
            rows.append([f"{machine}, {model}", *shares])
    title = "Limit of products and sums, and the part of it that gcc's batches reach, without and with those of sines"
    print_table(title, ["", *kinds], rows)


def share(figure: dict[str, str | float], kind: str, ns: float) -> str:
    """The operations of a batch in parts of the limit, `ns` each, without and with those of its sines and cosines."""
    operations, sines = float(figure["operations"]), float(figure["sines"])
    whole = operations + sines * OF_SINES[kind.partition(",")[0]]
    return f"{operations * ns / float(figure['ns']):.0%}, {whole * ns / float(figure['ns']):.0%}"


def fastest(chosen: dict[str, dict[str, str | float]], name: str) -> dict[str, str | float]:
    """The figure of the fastest of gcc's contestants whose names begin so."""
    some = (figure for other, figure in chosen.items() if other.startswith(name) and other.endswith("gcc"))
    return min(some, key=lambda figure: float(figure["ns"]))


if __name__ == "__main__":
    main()
