"""Time of a generated step by method, of the two-axis machine and an arm, over that of RK4.

Steps are carried out in one compiled loop; the shortest of several rounds counts, methods take turns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from symoro_elastic.analysis.simulation.compiled_steps import CompiledSteps
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.analysis.simulation.simulate import StepCost
from symoro_elastic.codegen.integration.tableaus import METHODS
from symoro_elastic.models.steps.implicit_steps import Motors
from tests.analysis.ladder.scenes import arm, moving
from tests.benchmarks.scene_machines import stiffer_tool, tool_moves
from tests.benchmarks.tables import met, print_table

STEPS, ROUNDS = 400, 60
FLAGS = {
    "-O2": ("-O2",),
    "-O3, native, vectors of 128 bits": ("-O3", "-march=native", "-mprefer-vector-width=128", "-fno-math-errno"),
}
GOALS = {"w2": 1.1, "w3": 1.6}
NAMES = ("rk4", "w2", "w3", "midpoint", "rodas4")


def show() -> list[Any]:
    """Print the table and return its figures."""
    references = {
        "two-axis machine, servos": (tool_moves(stiffer_tool(1, 0.02).numbers), NAMES),
        "rx90 with springs, driven": (moving("", arm("rx90.par", (40, 60), 0.01), 0.2, 0.2, 1e-5).reference, NAMES[:3]),
    }
    figures, rows = [], []
    for title, (reference, names) in references.items():
        cost = StepCost(reference.machine, Motors.DRIVEN if reference.servo is None else Motors.SERVO)
        operations = {name: cost.of(METHODS[name]) for name in names}
        for flags, words in FLAGS.items():
            seconds = fastest(reference, names, words)
            for name in names:
                ratio = seconds[name] / seconds["rk4"]
                counted = operations[name] / operations["rk4"]
                figures.append(
                    {"machine": title, "flags": flags, "method": name, "ns": 1e9 * seconds[name], "ratio": ratio}
                )
                goal = _goal(name, ratio)
                numbers = f"{1e9 * seconds[name]:.0f}", f"{ratio:.2f}", f"{counted:.2f}"
                rows.append((f"{title}, {flags}", name, *numbers, goal))
    print_table("a step", ("machine, compiler", "method", "ns", "over rk4", "operations over rk4", "goal"), rows)
    return figures


def _goal(method: str, ratio: float) -> str:
    if method not in GOALS:
        return ""
    return f"{GOALS[method]:g}: {met(ratio <= GOALS[method])}"


def fastest(reference: Reference, names: Sequence[str], flags: Sequence[str]) -> Mapping[str, float]:
    """Seconds of a step by method."""
    kind = type("WithFlags", (CompiledSteps,), {"flags": tuple(flags)})
    with TemporaryDirectory() as folder:
        runner: CompiledSteps = kind(reference.machine, names, Path(folder))
    found = dict.fromkeys(names, float("inf"))
    for _ in range(ROUNDS):
        for name in names:
            found[name] = min(found[name], runner.run(reference, name, STEPS).seconds)
    return found
