"""How exact the models are, at ordinary and extreme states, beside Pinocchio and the effect of one ulp of the inputs.

`python -m tests.benchmarks.accuracy [arm] [chains] [peers] [corpus] [brackets] [detector]` measures all or some of
these; `--states` for the arm and the rounding modes, `--links` for the chains, `--json FILE` keeps the figures.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.codegen.compile import TYPES
from symoro_elastic.codegen.precision import DOUBLE, SINGLE
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.checks.degenerate import degeneracies
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.evaluation.arrays import evaluate_arrays
from symoro_elastic.numerics.evaluation.values import given_values
from symoro_elastic.numerics.verification.accuracy import Errors, Reference, measure, round_states, rounded_values
from symoro_elastic.numerics.verification.states import States, extreme_states, moderate_states
from tests.extremes import states as at
from tests.extremes.brackets import bracketed
from tests.extremes.code import AS_RECOMMENDED, BOTH, compiled
from tests.extremes.corpus import DIRECT, REFUSED, corpus
from tests.extremes.machines import EXAMPLES, MASSES, QUARTER_TURNS, elastic_arm, general_alphas, links, six_axes
from tests.references.random_machines import random_machine

Row = dict[str, Any]
TURNS: dict[str, Callable[[int], Sequence[str]]] = {
    "quarter turns": lambda n: QUARTER_TURNS,
    "general angles": general_alphas,
}


def row(what: str, found: Errors) -> Row:
    print(f"{what}: {found.worst:.3g} u", file=sys.stderr, flush=True)
    return {
        "what": what,
        "worst, u": found.worst,
        "typical, u": found.typical,
        "one ulp of inputs, u": found.input_effect,
        "typical effect, u": found.typical_input_effect,
        "worst, relative": found.relative,
        "states": found.judged,
    }


def arm(asked: argparse.Namespace) -> list[Row]:
    """The RX90 as compiled C."""
    rows = []
    for name, machine in (("base parameters", six_axes()), ("all parameters", six_axes(base_parameters=False))):
        for precision in (DOUBLE, SINGLE):
            with compiled(machine, AS_RECOMMENDED, precision=precision) as code:
                rows += [
                    row(
                        f"RX90, {name}, {kind}, {precision.name}: {model}",
                        code.errors(model, draw(machine, asked.states)),
                    )
                    for kind, draw in (("moderate", at.moderate), ("extreme", at.extreme))
                    for model in BOTH
                ]
    return rows


def chains(asked: argparse.Namespace) -> list[Row]:
    """Programs in numpy's double and single precision: the operations of the generated code, one by one."""
    rows = []
    for masses, mass in MASSES.items():
        for turns, alphas in TURNS.items():
            machine = links(asked.links, mass, alphas(asked.links))
            for model in BOTH if asked.links <= 100 else (DIRECT,):
                traced = trace(machine, model)
                for precision in (DOUBLE, SINGLE):
                    states = round_states(at.gentle(machine, asked.few), precision)
                    values = rounded_values(given_values(machine), precision)
                    results = evaluate_arrays(traced, states, values, TYPES[precision.state])
                    found = measure(Reference(traced, states, values), results, precision)
                    rows.append(row(f"{asked.links} links, {masses}, {turns}, {precision.name}: {model}", found))
    return rows


def peers(asked: argparse.Namespace) -> list[Row]:
    """Pinocchio's recursions on the same chains, double precision."""
    rows = []
    for masses, mass in MASSES.items():
        for turns, alphas in TURNS.items():
            machine = links(asked.links, mass, alphas(asked.links))
            states, values = at.gentle(machine, asked.few), given_values(machine)
            for model in BOTH if asked.links <= 100 else (DIRECT,):
                traced = trace(machine, model)
                ours = measure(Reference(traced, states, values), evaluate_arrays(traced, states, values, np.float64))
                theirs = measure(Reference(traced, states, values), of_pinocchio(machine, model, states))
                what = f"{asked.links} links, {masses}, {turns}: {model}"
                worst: dict[str, str | float] = {"ours, u": ours.worst, "Pinocchio, u": theirs.worst}
                typical: dict[str, str | float] = {"ours, typical": ours.typical, "Pinocchio, typical": theirs.typical}
                rows.append({"what": what} | worst | typical)
    return rows


def of_pinocchio(machine: Machine, model: str, states: States) -> dict[str, np.ndarray]:
    """Accelerations by `aba`; torques by `rnea`, accelerations as given."""
    import pinocchio as pin  # type: ignore[import-untyped, unused-ignore]

    from tests.references.pinocchio_model import model_of

    peer, order, _ = model_of(machine)
    data, recursion = peer.createData(), pin.aba if model == DIRECT else pin.rnea
    given = states.tau if model == DIRECT else states.qdd_motor
    found = np.empty_like(given)
    for k, arrays in enumerate(zip(states.q, states.qd, given, strict=True)):
        placed = np.zeros((3, peer.nv))
        placed[:, order] = arrays
        found[k] = recursion(peer, data, *placed)[order]
    return {"qdd": found} if model == DIRECT else {"tau": found, "qdd": given}


def small_corpus(asked: argparse.Namespace) -> list[Row]:
    """Everything in tests/extremes, as compiled C."""
    rows = []
    for case in corpus(100):
        with compiled(case.machine) as code:
            for model in BOTH:
                found = code.errors(model, case.states)
                bound = max(case.ulps, case.share * found.input_effect)
                rows.append(row(f"{case.name}: {model}", found) | {"bound, u": bound, "ok": found.worst <= bound})
    return rows


def brackets(asked: argparse.Namespace) -> list[Row]:
    """How often the spread over the rounding modes covers the true error, at states that `check` draws."""
    two_axis, _ = read_machine(EXAMPLES / "two_axis.toml")
    machines = {"RX90": six_axes(), "two-axis machine": two_axis, "elastic arm": elastic_arm(1000.0)}
    return [
        {"what": f"{name}, {kind}: {model}", "result": result, "covered": covered, "worst share": share}
        for name, machine in machines.items()
        for kind, draw in (("moderate", moderate_states), ("extreme", extreme_states))
        for model, result, covered, share in bracketed(machine, draw(machine, min(asked.states, 100_000)))
    ]


def detector(asked: argparse.Namespace) -> list[Row]:
    """False alarms on random trees, tables of the corpus, and the time at 13 joints."""
    alarms = sum(
        bool(degeneracies(machine, known_motors))
        for seed in range(asked.trees)
        for machine in [random_machine(seed, joints=2 + seed % 12, symbolic=seed % 3 == 0, massless=0.5)]
        for known_motors in (False, True)
    )
    singular = [make() for name, (make, _) in REFUSED.items() if name != "spring without stiffness"]
    regular = [case.machine for case in corpus(20)]
    wrong = sum(not degeneracies(machine, False) for machine in singular)
    wrong += sum(bool(degeneracies(machine, False)) for machine in regular)
    return [
        {"what": f"false alarms on {asked.trees} random trees, two models each", "count": alarms},
        {"what": f"wrong verdicts on {len(singular) + len(regular)} tables of the corpus", "count": wrong},
        {"what": "median time of 20 trees of 13 joints, ms", "count": _milliseconds()},
    ]


def _milliseconds() -> float:
    times = []
    for seed in range(20):
        machine = random_machine(seed, joints=13, symbolic=True)
        start = time.perf_counter()
        degeneracies(machine, False)
        times.append(time.perf_counter() - start)
    return float(np.median(times)) * 1e3


PARTS: dict[str, Callable[[argparse.Namespace], list[Row]]] = {
    "arm": arm,
    "chains": chains,
    "peers": peers,
    "corpus": small_corpus,
    "brackets": brackets,
    "detector": detector,
}


def show(title: str, rows: Sequence[Row]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(*rows[0], title=title)
    for figures in rows:
        table.add_row(*(f"{x:.3g}" if isinstance(x, float) else str(x) for x in figures.values()))
    Console(width=170).print(table)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"{', '.join(PARTS)}; all unless said")
    parser.add_argument("--states", type=int, default=1_000_000)
    parser.add_argument("--few", type=int, default=4, help="states of a chain")
    parser.add_argument("--links", type=int, default=1000)
    parser.add_argument("--trees", type=int, default=10_000)
    parser.add_argument("--json", metavar="FILE", type=Path)
    asked = parser.parse_args()
    unknown = set(asked.parts) - set(PARTS)
    if unknown:
        parser.error(f"there is no {', '.join(sorted(unknown))}: choose from {', '.join(PARTS)}")
    figures = {}
    for part in asked.parts or PARTS:
        figures[part] = PARTS[part](asked)
        show(part, figures[part])
    if asked.json:
        asked.json.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
