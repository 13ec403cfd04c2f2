"""Forms of direct_dynamics as predicted and as measured, at unseen states: `python -m tests.benchmarks.forms`.

The ratio of errors of the inertia matrix and the recursion, which 99 of 100 states keep: predicted in single precision,
measured in double precision at other states, for other values of parameters that have none.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import INERTIA, RECURSION, Scene
from symoro_elastic.models.checks.degenerate import SingularPivot
from symoro_elastic.models.programs.catalogue import TracedModel, trace_scene
from symoro_elastic.numerics.evaluation.arrays import EXTENDED, evaluate_arrays
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.forms import WITHIN, Choice, chosen_form
from symoro_elastic.numerics.verification.states import States, moderate_states
from tests.benchmarks.machines import EXAMPLES, MACHINES, chain, example
from tests.benchmarks.tables import print_table, progress
from tests.references.random_machines import random_machine

UNSEEN, SEED = 4000, 77


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.forms", description=__doc__)
    parser.add_argument("--random", type=int, default=40, help="random machines beside the named ones")
    count = parser.parse_args().random
    found = [(name, *one) for name, make in progress(list(named(count)), "compare") if (one := compared(make))]
    rows = [row(name, choice, ratio) for name, choice, ratio in found]
    print_table("direct_dynamics: operations, and error of the inertia matrix over that of the recursion", HEAD, rows)
    taken = [ratio for _, choice, ratio in found if choice.chosen == INERTIA]
    over = sum(ratio > WITHIN for ratio in taken)
    print(f"{len(taken)} of {len(found)} take the inertia matrix, worst ratio {max(taken):.2f}, {over} over {WITHIN:g}")
    doubts = [max(c.ratio / r, r / c.ratio) for _, c, r in found if math.isfinite(c.ratio)]
    print(f"predicted ratios are off by {np.median(doubts):.2f} (median), {max(doubts):.2f} (worst)")


HEAD = ["", "recursion", "inertia", "predicted", "measured", "auto"]


def named(count: int) -> Iterator[tuple[str, Callable[[], Machine]]]:
    yield from MACHINES.items()
    for path in sorted([*EXAMPLES.glob("*.toml"), *EXAMPLES.glob("*.par")]):
        yield path.name, partial(example, path.name)
    for n in (3, 4, 5, 6, 8, 10):
        yield f"chain of {n}", partial(chain, n)
    for k in range(count):
        yield f"random {k + 100}", partial(random_machine, k + 100, joints=3 + k % 6)


def compared(make: Callable[[], Machine]) -> tuple[Choice, float] | None:
    """The choice and the measured ratio; None where the machine has no direct dynamic model."""
    try:
        machine = make()
        choice = chosen_form(machine, Scene(), with_errors=True)
    except (InputError, SingularPivot):
        return None
    return choice, measured(machine)


def measured(machine: Machine) -> float:
    values = parameter_values(machine, SEED)
    states = moderate_states(machine, UNSEEN, SEED, values)
    recursion, inertia = (error(machine, form, states, values) for form in (RECURSION, INERTIA))
    return inertia / recursion


def error(machine: Machine, form: str, states: States, values: dict[str, float]) -> float:
    """Error in double precision that 99 of 100 states keep, at least half a unit of rounding."""
    (traced,) = trace_scene(machine, Scene(("direct_dynamics",), form=form))
    step = max(1, 1_000_000 // len(traced.program.nodes))
    errors = [each(traced, states[k : k + step], values) for k in range(0, len(states), step)]
    return max(float(np.quantile(np.concatenate(errors), 0.99)), 2.0**-54)


def each(traced: TracedModel, states: States, values: dict[str, float]) -> Array:
    exact, found = (evaluate_arrays(traced, states, values, kind) for kind in (EXTENDED, np.float64))
    apart = [abs(found[name] - exact[name]).max(axis=1) / abs(exact[name]).max(axis=1) for name in exact]
    worst: Array = np.maximum.reduce(apart).astype(float)
    return worst


def row(name: str, choice: Choice, ratio: float) -> list[str]:
    counts = [str(one.operations) for one in choice.forms] + ["-"] * (2 - len(choice.forms))
    return [name, *counts, f"{choice.ratio:.2f}", f"{ratio:.2f}", choice.chosen]


if __name__ == "__main__":
    main()
