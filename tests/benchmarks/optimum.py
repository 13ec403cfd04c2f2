"""How near the search for terms to leave out is to the best selection of its candidates.

    python -m tests.benchmarks.optimum [--within 1%] [--seeds 3]

The best selection has no efficient algorithm. A linear program bounds what any selection saves: changes, and nodes that
nothing needs any more, may be carried out in part (0 to 1), and errors are the sum of their first-order effects at the
states of the search. Each use of a node that is not computed is gone: its user is not computed, is a number, or has
dropped the operand. States join the program until its solution is within the tolerances at all of them.

The bound is one of the first order: effects change with the program, so a search that computes them anew can get below
it. A row: operations of the inverse model (a sine counts as eight), what the search leaves, and what the bound leaves;
base parameters, and how many of them become zero one after another, as they are and with all others fitted again: where
parameters are nearly dependent, the others take over what is left out.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, sparse
from scipy.optimize import linprog

import symoro_elastic as se
from symoro_elastic.cli.output import print_parts
from symoro_elastic.foundation.results import Table
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.generation.reduced_models.search import _Search as ReducedSearch
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.machine.within import ALL_RESULTS, Within, tolerance
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS
from symoro_elastic.numerics.within.liveness import Liveness, _cost
from symoro_elastic.numerics.within.search import Search
from symoro_elastic.numerics.within.tape import SUMS, Change, Kind, Tape
from symoro_elastic.numerics.within.trials import Task
from symoro_elastic.symbolic.operations import MULTIPLY

Array = NDArray[np.float64]
EXAMPLES = Path(__file__).parents[2] / "examples"
MODEL = "inverse_dynamics"
JOINTS = 6
FAR = 6.0
"""Times the tolerance: a change with a larger effect is in no selection."""
JOIN, CLOSE, ROUNDS = 150, 0.01, 40
"""States and results that join in a round, the relative excess that is allowed, rounds at most."""
STATES = 1000
"""Drawn for fits of parameters."""
Term = tuple[int, float]


def drawn_arm(seed: int) -> DescribedMachine:
    """Return an arm of six revolute joints with quarter turns, offsets, and full inertia of every body."""
    rng = np.random.default_rng(seed)
    joints, bodies, limits = [], {}, {}
    for k in range(JOINTS):
        name, mass = f"axis_{k + 1}", 20 * 0.6**k
        alpha = ["0", "pi/2", "-pi/2"][rng.integers(3)] if k else "0"
        row = {"name": name, "kind": "motor", "sigma": 0, "antecedent": k, "theta": f"q{k + 1}", "alpha": alpha}
        joints.append(row | {"d": rng.uniform(0.05, 0.4) if k else 0.0, "r": rng.uniform(-0.2, 0.2)})
        A = 0.1 * rng.normal(size=(3, 3))
        spread = mass * A @ A.T  # second moments, so that the inertia belongs to a body
        inertia = np.trace(spread) * np.eye(3) - spread
        centre = rng.uniform(-0.15, 0.15, 3).tolist()
        bodies[name] = {"mass": mass, "center_of_mass": centre, "inertia": inertia[np.triu_indices(3)].tolist()}
        limits[name] = {"position": [-2.5, 2.5], "velocity": [-3, 3], "acceleration": [-10, 10]}
    table = {"name": f"drawn_{seed}", "gravity": [0, 0, -9.81], "joints": joints, "bodies": bodies, "limits": limits}
    return DescribedMachine.of(se.read(table))


def task_of(machine: DescribedMachine, within: str) -> Task:
    """Return the task of the inverse model of a machine within a tolerance of all results."""
    scene = Scene(models=(MODEL,), fold=ALL, within=Within({ALL_RESULTS: tolerance(within)}))
    search = ReducedSearch(machine, scene, programs, [ROUNDINGS["double"]], lambda *_: None, lambda *_: None)
    traced = search.full_models
    (model,), (function,) = traced.models, traced.package.functions
    full = search._full(traced, model, function)
    required = search._requirements(traced, full.subject, function)
    return Task(full.program, full.subject.box.ranges, full.tolerances, required)


class Relaxation:
    """Linear inequalities A x <= b of changes x, and nodes that are not computed, free, or zero; costs that they save.

    Columns: changes, then three for each node.
    """

    def __init__(self, tape: Tape, changes: Sequence[Change]) -> None:
        self._tape, self._changes, n = tape, changes, tape.count
        self.gone, self.free, self.zero = (len(changes) + k * n for k in range(3))
        self.size = len(changes) + 3 * n
        self._frozen: list[list[tuple[int, float]]] = [[] for _ in range(n)]
        self._straight: list[list[int]] = [[] for _ in range(n)]
        self._dropped: dict[tuple[int, int], int] = {}
        for column, change in enumerate(changes):
            if change.kind is Kind.FREEZE:
                self._frozen[change.place].append((column, change.constant))
            elif change.kind is Kind.DROP:
                self._dropped[change.place, change.operand] = column
            else:
                self._straight[change.place].append(column)
        self.costs = np.zeros(self.size)
        for place in range(n):
            self.costs[[self.gone + place, self.free + place]] = -_cost(tape, place)

    def inequalities(self) -> tuple[sparse.csr_matrix, Array]:
        """Return A and b."""
        pairs = [pair for place in range(self._tape.count) for pair in self._of(place)]
        rows = [row for row, (terms, _) in enumerate(pairs) for _ in terms]
        columns, factors = zip(*(term for terms, _ in pairs for term in terms), strict=True)
        shape = len(pairs), self.size
        return sparse.csr_matrix((factors, (rows, columns)), shape), np.array([limit for _, limit in pairs], float)

    def _of(self, place: int) -> Iterator[tuple[list[Term], float]]:
        """Yield the inequalities of a node: its saving once, why it is zero, why it is free, why it is not computed."""
        tape, frozen = self._tape, [(column, -1.0) for column, _ in self._frozen[place]]
        operands = [x for x in tape.operands[place] if x < tape.count]
        zeros = [(self.zero + x, -1.0) for x in operands]
        yield [(self.gone + place, 1.0), (self.free + place, 1.0)], 1
        yield [(self.gone + place, 1.0), *((column, 1.0) for column, _ in self._frozen[place])], 1
        to_zero = [(column, -1.0) for column, constant in self._frozen[place] if constant == 0]
        yield [(self.zero + place, 1.0), *to_zero, *(zeros if tape.operations[place] == MULTIPLY else [])], 0
        reasons = [*frozen, (self.zero + place, -1.0), *((x, -1.0) for x in self._straight[place])]
        if tape.operations[place] in SUMS:
            reasons += zeros + [(self._dropped[place, k], -1.0) for k in (0, 1) if (place, k) in self._dropped]
        elif tape.operations[place] == MULTIPLY:
            reasons += [(column, -1.0) for x in operands for column, c in self._frozen[x] if abs(c) == 1]
        yield [(self.free + place, 1.0), *reasons], 0
        if any(place in entries for entries in tape.entries):
            yield [(self.gone + place, 1.0)], 0
        for slot, x in enumerate(tape.operands[place]):
            if x < tape.count:
                ends = [*frozen, (self.gone + place, -1.0), (self.zero + place, -1.0)]
                ends += [(self._dropped[place, slot], -1.0)] if (place, slot) in self._dropped else []
                yield [(self.gone + x, 1.0), *ends], 0


def most_saved(task: Task, search: Search) -> float:
    """Return what no selection of changes exceeds, to first order: operations saved."""
    state = search._pass_state([])
    changes = [x for x in task.candidates if state.live.is_possible(x) and state.sizes[x] <= FAR]
    effects = np.array([state.effects.of(change)[0].astype(np.float32).ravel() for change in changes])
    relaxation = Relaxation(task.tape, changes)
    A, b = relaxation.inequalities()
    places: set[int] = set()
    for _ in range(ROUNDS):
        part = sparse.csr_matrix(np.pad(effects[:, sorted(places)].T, ((0, 0), (0, relaxation.size - len(changes)))))
        rows = sparse.vstack([A, part, -part])
        limits = np.concatenate([b, np.ones(2 * len(places))])
        solution = linprog(relaxation.costs, A_ub=rows, b_ub=limits, bounds=(0, 1), method="highs")
        errors = np.abs(effects.T @ solution.x[: len(changes)])
        worst = {int(k) for k in np.argsort(-errors)[:JOIN] if errors[k] > 1 + CLOSE} - places
        if not worst:
            break
        places |= worst
    return -float(solution.fun)


def zero_parameters(task: Task, machine: DescribedMachine) -> tuple[int, int, int]:
    """Return the number of base parameters, and how many become zero within the tolerance, and with the others fitted.

    Torques at drawn states are linear in independent columns of the regressor.
    """
    model = se.load(machine, "regressor")
    states = task.box.draw(STATES, np.random.default_rng(0))
    values_of = dict(zip(task.tape.symbols, states, strict=True))
    still = np.zeros(STATES)
    rows = [np.array([values_of.get(name, still) for name in x.symbols]).T for x in task.program.inputs]
    Y = np.array([np.asarray(model.regressor(*state)) for state in zip(*rows, strict=True)])
    torques = task.tape.values(task.tape.rows(states)).T
    A, tau = (Y / task.allowed[:, None]).reshape(-1, Y.shape[2]), (torques / task.allowed).ravel()
    _, R, order = linalg.qr(A, mode="economic", pivoting=True)
    A = A[:, order[: np.linalg.matrix_rank(R)]]
    values = np.linalg.lstsq(A, tau, rcond=None)[0]

    def left_out(fitted: bool) -> int:
        left = [*range(A.shape[1])]
        while True:
            choices = []
            for k in left:
                kept = [j for j in left if j != k]
                x = np.linalg.lstsq(A[:, kept], tau, rcond=None)[0] if fitted else values[kept]
                choices.append((np.abs(A[:, kept] @ x - tau).max(), k))
            error, k = min(choices)
            if error > 1:
                return A.shape[1] - len(left)
            left.remove(k)

    return A.shape[1], left_out(False), left_out(True)


def main(argv: Sequence[str] | None = None) -> None:
    """Print a row per machine."""
    parser = argparse.ArgumentParser(description="How near the search for terms is to the best selection.")
    parser.add_argument("--within", default="1%")
    parser.add_argument("--seeds", type=int, default=3)
    given = parser.parse_args(argv)
    machines = [DescribedMachine.of(se.read(EXAMPLES / f"{x}.toml")) for x in ("planar_2r", "puma560_measured")]
    table = Table(
        (
            "machine",
            "operations",
            "left by the search",
            "left by the bound",
            "parameters",
            "zero",
            "zero, others fitted",
        ),
        title=f"within {given.within}",
    )
    for machine in [*machines, *map(drawn_arm, range(given.seeds))]:
        task = task_of(machine, given.within)
        sample = task.sample(task.first_sample(), np.ones(len(task.allowed)))
        search = Search(task.tape, task.candidates, sample)
        accepted = search.run().changes
        full = Liveness(task.tape).cost
        left, bound = Liveness(task.tape, accepted).cost, full - most_saved(task, search)
        parameters = map(str, zero_parameters(task, machine))
        table.add_row(machine.name, str(full), f"{left} ({1 - left / full:.1%} less)", f"{bound:.0f}", *parameters)
    print_parts([table])


if __name__ == "__main__":
    main()
