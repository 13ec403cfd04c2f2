"""Time closed chains against Pinocchio, with errors and operations: `python -m tests.benchmarks.closed_chains`.

The direct model against Pinocchio's `constraintDynamics` in C++: the tree, its loops closed at a point by multipliers
found in proximal steps; forces of all joints are given to it. Errors are those of 70-digit multipliers, relative to a
state's largest acceleration. All are compiled by GCC with -O3 -march=native.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np

from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Kind, Machine
from tests.benchmarks.contest import Array, Contestant, contest
from tests.benchmarks.machines import with_base_parameters
from tests.benchmarks.match import require_pinocchio
from tests.benchmarks.ours import NATIVE, code, scalar
from tests.benchmarks.tables import print_table, progress, save_json
from tests.closed_chains.machines import machine, reordered, situations
from tests.references.closed_chains import Chain, State
from tests.references.constraint_multipliers import Multipliers, free_tree

SR400 = "sr400"
TIMED = (machine(SR400), reordered(machine("five_bar")))
"""In depth-first order, which Pinocchio wants."""
MODELS = ("direct_dynamics_by_inertia_matrix", "direct_dynamics")
STATES = 16
SAME_FLAGS = (*NATIVE, "-fmath-errno", "-ftrapping-math")
"""The compiler's defaults, as for Pinocchio."""
DISTANCES = (0.5, 1e-2, 1e-4, 1e-6, 0.0)
"""th7 - th2 of the SR400, whose parallelogram is flat where they are equal."""
PROXIMAL = ((1e-14, 1), (1e-12, 1), (1e-10, 2), (1e-10, 10))
"""mu, and steps for multipliers: few, of which the result is still exact to many digits."""
PROXIMAL_WHERE_FLAT = ((1e-6, 10), (1e-8, 100), (1e-10, 1000))
Pair = tuple[int, int]
ASKED: dict[tuple[str, str], Pair] = {
    (SR400, "direct_dynamics_by_inertia_matrix"): (562, 551),
    (SR400, "inverse_dynamics"): (371, 374),
    ("parallelogram", "direct_dynamics_by_inertia_matrix"): (300, 312),
    ("parallelogram", "inverse_dynamics"): (242, 247),
    ("five_bar", "direct_dynamics_by_inertia_matrix"): (205, 164),
    ("geared_6r", "direct_dynamics_by_inertia_matrix"): (531, 493),
    ("geared_6r", "direct_dynamics"): (716, 657),
    ("geared_6r", "inverse_dynamics"): (352, 346),
    ("ball_screw", "direct_dynamics"): (30, 23),
}
"""Products with divisions, and sums, of a prototype: general bodies, no base parameters."""


@dataclass(frozen=True)
class Sample:
    """States of a machine, a row each: q, qd, tau; those of its tree, with forces of all joints; qdd in 70 digits."""

    machine: Machine
    tree: Machine
    met: list[Pair]
    x: Array
    x_of_tree: Array
    wanted: Array
    independent: list[int]
    """Entries of q among the joints of the tree."""

    def ours(self, model: str, base_parameters: bool) -> Contestant:
        described = with_base_parameters(self.machine) if base_parameters else self.machine
        name = f"{model}, base parameters" if base_parameters else model
        return scalar(code(described, model), self.x, name, "gcc", SAME_FLAGS)

    def theirs(self, mu: float, steps: int) -> list[Contestant]:
        from tests.benchmarks.peers import pinocchio_loops as peer

        files = peer.written(self.tree, self.met)
        return peer.contestants(files, self.x_of_tree, peer.Proximal(mu, steps))

    def all(self, proximal: Sequence[tuple[float, int]]) -> list[Contestant]:
        return [
            *(build for settings in proximal for build in self.theirs(*settings)),
            *(self.ours(*how) for how in product(MODELS, (False, True))),
        ]

    def errors(self, contestant: Contestant) -> Array:
        """Of each state, relative to its largest acceleration."""
        found = contestant.results()
        found = found if found.shape[1] == self.wanted.shape[1] else found[:, self.independent]
        errors: Array = np.abs(found - self.wanted).max(axis=1) / np.abs(self.wanted).max(axis=1)
        return errors


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.closed_chains", description=__doc__)
    parser.add_argument("--rounds", type=int, default=401, help="rounds in which all take turns")
    parser.add_argument("--json", type=Path, help="save the figures")
    arguments = parser.parse_args()
    require_pinocchio(compiled=True)
    operations = list(counted())
    show_operations(operations)
    times = [row for one in progress(TIMED, "compile and time") for row in timed(one, arguments.rounds)]
    columns = ["machine", "contestant", "ns", "ratio", "error"]
    print_table("Direct model of closed chains: a state, how many times faster, largest error", columns, told(times))
    flat = errors_where_flat()
    print_table(
        "SR400: error at th7 - th2", ["", *map(str, DISTANCES)], [[n, *map("{:.1e}".format, e)] for n, e in flat]
    )
    if arguments.json:
        save_json(arguments.json, {"times": times, "flat": dict(flat), "operations": operations})


def timed(described: Machine, rounds: int) -> Iterator[dict[str, str | float]]:
    """Ratios are to the fastest build of Pinocchio whose error is below 1e-12."""
    sample = near(described)
    contestants = sample.all(PROXIMAL)
    errors = {c.name: float(sample.errors(c).max()) for c in contestants}
    times = contest(contestants, rounds)
    exact = [c.name for c in contestants if c.name.startswith("Pinocchio") and errors[c.name] < 1e-12]
    reference = min(exact, key=times.median)
    for one, error in errors.items():
        figures = {"ns": times.median(one), "ratio": times.ratio(reference, one), "error": error}
        yield {"machine": described.name, "contestant": one, **figures}


def told(times: Sequence[dict[str, str | float]]) -> Iterator[list[str]]:
    for row in times:
        yield [
            str(row["machine"]),
            str(row["contestant"]),
            f"{row['ns']:.4g}",
            f"{row['ratio']:.3g}",
            f"{row['error']:.1e}",
        ]


def errors_where_flat() -> list[tuple[str, list[float]]]:
    sample = flat_parallelogram()
    return [(c.name, sample.errors(c).tolist()) for c in sample.all(PROXIMAL_WHERE_FLAT)]


def counted() -> Iterator[dict[str, object]]:
    """Operations with symbolic parameters."""
    for name in (SR400, "parallelogram", "five_bar", "geared_6r", "ball_screw"):
        for model in (*reversed(MODELS), "inverse_dynamics"):
            count = code(machine(name), model, fold=False).operations
            figures = {"operations": (count.products, count.add), "sin/cos": count.sincos}
            yield {"machine": name, "model": model, **figures, "prototype": ASKED.get((name, model))}


def show_operations(operations: Sequence[dict[str, object]]) -> None:
    rows = [[_text(value) for value in row.values()] for row in operations]
    print_table("Operations of a call (x: products and divisions), and of a prototype", list(operations[0]), rows)


def _text(value: object) -> str:
    if isinstance(value, tuple):
        return f"{value[0]}x {value[1]}+"
    return "-" if value is None else str(value)


def near(described: Machine) -> Sample:
    """Positions within 0.2 rad, deflections within 1 mrad of a known state; loops closed in 70 digits."""
    known, rng = situations(described.name)[0], np.random.default_rng(0)
    variables = dict(zip(Chain(machine(described.name)).independent, known.state.u, strict=True))
    start = [variables[name] for name in Chain(described).independent]
    elastic = [described.joint(j).kind is Kind.ELASTIC for j in described.independent]
    references, taus = [], []
    for _ in range(STATES):
        u = np.where(elastic, 0, start) + rng.uniform(-1, 1, len(elastic)) * np.where(elastic, 1e-3, 0.2)
        taus.append(rng.uniform(-50, 50, len(known.tau)))
        state = State(list(u), list(rng.uniform(-1, 1, len(elastic))), known.state.guess)
        references.append((state, Multipliers(described, state)))
    return sampled(described, described, references, taus)


def flat_parallelogram() -> Sample:
    """The SR400 at `DISTANCES`. The reference has formulas in place of the loop: it holds in the flat position too."""
    described, known = machine(SR400), situations(SR400)[0]
    formulas = {"b3": "th7 - th2 - pi/2", "b8": "th2 - th7"}
    joints = [_coupled(joint, formulas[joint.name]) if joint.name in formulas else joint for joint in described.joints]
    tree = replace(described, joints=tuple(joint for joint in joints if joint.kind is not Kind.CUT), loops=())
    references = []
    for distance in DISTANCES:
        u = [*known.state.u[:-1], known.state.u[1] + distance]
        state = State(u, known.state.ud, {})
        references.append((state, Multipliers(tree, state)))
    return sampled(described, tree, references, [np.array(known.tau)] * len(DISTANCES))


def _coupled(joint: Joint, formula: str) -> Joint:
    return replace(joint, kind=Kind.COUPLED, variable=None, theta=Formula.parse(formula))


def sampled(
    described: Machine, solved: Machine, references: Sequence[tuple[State, Multipliers]], taus: Sequence[Array]
) -> Sample:
    """All of the machine's states; `solved` is the table that the references have."""
    x, x_of_tree, wanted = [], [], []
    independent = [described.articulated.index(j) for j in described.independent]
    own = [described.articulated.index(j) for j in solved.with_variable]
    for (state, found), tau in zip(references, taus, strict=True):
        forces = np.zeros(len(described.articulated))
        forces[own] = found._passive_forces() + found.chain.spread_motors(list(tau))
        moving = found.coupled_entries
        x_of_tree.append(np.concatenate([found.z[moving], found.zd[moving], forces]).astype(float))
        x.append(np.concatenate([state.u, state.ud, tau]))
        accelerations = found.direct(list(tau))
        wanted.append([float(accelerations[solved.with_variable.index(j)]) for j in solved.independent])
    met = [(loop.cut, loop.meets) for loop in described.loops]
    tree = free_tree(Chain(described), cut_joints=False)
    return Sample(described, tree, met, np.array(x), np.array(x_of_tree), np.array(wanted), independent)


if __name__ == "__main__":
    main()
