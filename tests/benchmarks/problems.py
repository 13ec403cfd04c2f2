"""Time the direct models of published problems beside Pinocchio: `python -m tests.benchmarks.problems`.

Loops against its `constraintDynamics` as in `closed_chains`. Ratios are to the fastest of its settings whose error
is below 1e-12 of the state's largest acceleration by multipliers in 70 digits.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import symoro_elastic as se
from tests.benchmarks.closed_chains import MODELS, PROXIMAL, SAME_FLAGS, STATES, Sample, sampled
from tests.benchmarks.contest import contest
from tests.benchmarks.match import require_pinocchio
from tests.benchmarks.ours import code, scalar
from tests.benchmarks.tables import print_table, progress, save_json
from tests.closed_chains.machines import reordered
from tests.closed_chains.problems import START, TORQUE, bricard, governor, squeezer, windows
from tests.references.closed_chains import State
from tests.references.constraint_multipliers import Multipliers

Row = dict[str, Any]
EXACT = 1e-12
LOOPS: dict[str, tuple[Any, list[float], dict[str, float], float]] = {
    "Andrews' squeezer": (squeezer(), [START["beta"]], START, TORQUE),
    "2 four-bars": (windows(2), [1.5], {}, 5.0),
    "governor": (governor(1e3, 5.0, -1.5), [0.0, -1.7], {}, 1.0),
}
"""A table, independent variables and guesses of the others, the size of motor torques."""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.problems", description=__doc__)
    parser.add_argument("--rounds", type=int, default=401, help="rounds in which all take turns")
    parser.add_argument("--json", type=Path, help="save the figures")
    arguments = parser.parse_args()
    require_pinocchio(compiled=True)
    rows = [row for name in progress(list(LOOPS), "compile and time") for row in of_loops(name, arguments.rounds)]
    rows += of_bricard(arguments.rounds)
    shown = [
        [r["problem"], r["contestant"], f"{r['ns']:.4g}", _or(r["ratio"], ".3g"), _or(r["error"], ".1e")] for r in rows
    ]
    heads = ["problem", "contestant", "ns", "ratio", "error"]
    print_table("Direct model of published problems: a state, how many times faster, largest error", heads, shown)
    if arguments.json:
        save_json(arguments.json, rows)


def _or(x: float | None, form: str) -> str:
    return "-" if x is None else format(x, form)


def of_loops(problem: str, rounds: int) -> Iterator[Row]:
    """Ours by articulated bodies and by the inertia matrix, Pinocchio's with four settings of multipliers."""
    sample = near(problem)
    builds = [build for how in PROXIMAL for build in sample.theirs(*how)]
    found = [*builds, *(sample.ours(model, False) for model in MODELS)]
    errors = {one.name: float(sample.errors(one).max()) for one in found}
    times = contest(found, rounds)
    exact = [one.name for one in builds if errors[one.name] < EXACT]
    reference = min(exact, key=times.median) if exact else None
    for name, error in errors.items():
        ratio = times.ratio(reference, name) if reference else None
        yield {"problem": problem, "contestant": name, "ns": times.median(name), "ratio": ratio, "error": error}


def near(problem: str) -> Sample:
    """Positions within 0.05 rad or m of the start, loops closed in 70 digits."""
    table, start, guess, size = LOOPS[problem]
    described, rng = reordered(se.read(table)), np.random.default_rng(0)
    given = {name: x for loop in table["loops"].values() for name, x in loop["start"].items()} | guess
    names = [str(described.joint(j).variable) for j in described.independent]
    first = dict(zip(names, start, strict=True))
    references, torques = [], []
    for _ in range(STATES):
        u = [first[name] + rng.uniform(-0.05, 0.05) for name in names]
        torques.append(rng.uniform(-size, size, len(described.motors)))
        state = State(u, list(rng.uniform(-1, 1, len(u))), given)
        references.append((state, Multipliers(described, state)))
    return sampled(described, described, references, torques)


def of_bricard(rounds: int) -> Iterator[Row]:
    """Its loop is assembled: the call that closes it, and the direct model."""
    machine = se.read(bricard())
    theta = np.linspace(0.2, 1.5, STATES)
    other = np.arccos(-np.cos(theta) / (1 + np.cos(theta)))
    others = np.column_stack([other, theta, other, theta])
    rest = np.column_stack([np.ones(STATES), np.zeros(STATES)])
    rows = {"assemble": [theta, others + 0.01], "direct_dynamics": [theta, others, rest]}
    found = [scalar(code(machine, m), np.column_stack(x), m, "gcc", SAME_FLAGS) for m, x in rows.items()]
    times = contest(found, rounds)
    for one in found:
        yield {"problem": "Bricard", "contestant": one.name, "ns": times.median(one.name), "ratio": None, "error": None}


if __name__ == "__main__":
    main()
