"""Time and count derivatives of the models against peers: `python -m tests.benchmarks.derivatives [--json FILE]`.

Those of the inverse model by q, qd and qdd, of the direct model by q, qd and tau. Pinocchio's are analytic, CasADi's
automatic. All ten inertial parameters of every body are kept, in ours as in theirs, but for the rows with base
parameters; where these are in p, repeated limbs share functions.
"""

from __future__ import annotations

import argparse
from importlib.util import find_spec
from pathlib import Path

from symoro_elastic.machine.machine import Machine
from tests.benchmarks.contest import COMPILERS, Array, Contestant
from tests.benchmarks.machines import MACHINES, with_base_parameters
from tests.benchmarks.match import Match, matched, require_pinocchio, show, states
from tests.benchmarks.ours import Code, code, scalar
from tests.benchmarks.peers import casadi_c, pinocchio_cpp
from tests.benchmarks.tables import print_table, progress, save_json
from tests.benchmarks.targets import ARM, ARM_7, CASADI, QUADRUPED, TREE, Counts, Figures, unmet_of_derivatives

MODELS = ("inverse_dynamics_derivatives", "direct_dynamics_derivatives")
TITLES = (ARM, ARM_7, TREE, QUADRUPED)
"""Machines with a motor at every joint and no springs: Pinocchio differentiates no law of a spring."""
BY = 3
"""Matrices that a model gives."""
LONGEST = 100_000
"""Operations of CasADi's C beyond which gcc takes more than six minutes; clang compiles them all."""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.derivatives", description=__doc__)
    parser.add_argument("--rounds", type=int, default=401, help="rounds in which all take turns")
    parser.add_argument("--json", type=Path, help="save the figures")
    arguments = parser.parse_args()
    require_pinocchio(compiled=True)
    figures: Figures = []
    counts: Counts = []
    wanted = [(title, model) for title in TITLES for model in MODELS]
    for title, model in progress(wanted, "compile and time"):
        found, counted = match(title, model, arguments.rounds)
        figures += found.figures()
        counts.append({"machine": title, "model": model, **counted})
    for model in MODELS:
        show(model, figures, TITLES)
    show_counts(counts)
    unmet_of_derivatives(figures, counts)
    if arguments.json:
        save_json(arguments.json, {"figures": figures, "operations": counts})


def match(title: str, model: str, rounds: int) -> tuple[Match, dict[str, int]]:
    """Times, and operations of ours and of CasADi's."""
    machine = MACHINES[title]()
    file, x, n = pinocchio_cpp.model_file(machine), states(machine, model), len(machine.independent)
    contestants = pinocchio_cpp.contestants(file, model, x, BY * n * n)
    folded = code(machine, model)
    counts = {"ours": folded.operations.products + folded.operations.add}
    if find_spec("casadi"):
        generated = casadi_c.generated(file, model)
        counts[CASADI] = generated.operations
        contestants += of_casadi(generated, x)
    mine, operations = ours(machine, folded, model, x)
    return matched(title, model, [*contestants, *mine], operations, rounds, BY), counts


def ours(machine: Machine, folded: Code, model: str, x: Array) -> tuple[list[Contestant], dict[str, int]]:
    """Calls with all parameters in the code, with base parameters there or in p, and the operations of each."""
    based = with_base_parameters(machine)
    found = {"": folded, ", base": code(based, model), ", base, parameters in p": code(based, model, fold=False)}
    names = {f"call{how}, {name}": (one, name) for how, one in found.items() for name in COMPILERS}
    counts = {name: one.operations.products + one.operations.add for name, (one, _) in names.items()}
    return [scalar(one, x, name, compiler) for name, (one, compiler) in names.items()], counts


def of_casadi(generated: casadi_c.Generated, x: Array) -> list[Contestant]:
    compilers = [name for name in COMPILERS if name != "gcc" or generated.operations <= LONGEST]
    return [casadi_c.contestant(generated, x, compiler) for compiler in compilers]


def show_counts(counts: Counts) -> None:
    """A row a model, CasADi's and ours."""
    rows = [[f"{c['machine']}, {c['model']}", str(c["ours"]), str(c.get(CASADI, "-"))] for c in counts]
    print_table("Operations (products, divisions, sums, differences)", ["", "ours", CASADI], rows)


if __name__ == "__main__":
    main()
