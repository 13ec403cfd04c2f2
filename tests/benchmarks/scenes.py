"""What time steps and the ladder promise, measured: `python -m tests.benchmarks.scenes SECTION [--json FILE]`.

`predictions`: errors of springs left out, at all rungs, locked and static, and errors of methods and steps, as the
linear model along the motion predicts them, against the nonlinear machine: Pinocchio's A and H, integrated by DOP853;
generated steps. Errors below those that integration leaves are not compared.
`steps`: time of a step by method. `stiffness`: cost of an error at any stiffness. `ladder`: what the chosen rung saves,
and the time of the command. `energy`: what free motions lose or make of it. `libraries`: scipy, CVODE and MuJoCo on
the same motion; `--picture` draws them.
"""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.ladder.greedy import backward_greedy
from symoro_elastic.analysis.simulation.prediction.path import LinearPath
from symoro_elastic.analysis.simulation.prediction.resolution import resolved_path
from symoro_elastic.analysis.simulation.prediction.spring_errors import Deviations
from symoro_elastic.analysis.simulation.prediction.step_error import StepErrors, largest_stable_step, poles
from symoro_elastic.codegen.integration.tableaus import METHODS
from tests.analysis.ladder.generated_steps import stepped_motion, with_steps
from tests.analysis.ladder.scenes import Scene, many
from tests.analysis.ladder.truth import Truth, pinocchio_dynamics
from tests.benchmarks.match import require_pinocchio
from tests.benchmarks.scene_picture import draw
from tests.benchmarks.tables import met, print_table, progress, save_json

TIMES, PRECISION = 240, 1e-9
SMALLEST_MODEL, SMALLEST_STEP = 1e-11, 2e-9
"""Errors that are compared, m."""
LARGEST = 0.25
"""Deviation up to which predictions are asked for, m."""
SECTIONS = ("steps", "stiffness", "ladder", "energy", "libraries")
STEPS = (60, 120, 240)
NAMES = ("w2", "w3", "rk4", "rodas4", "midpoint")
EXCEPT_FAR, CLOSE = 2.0, 1.1


@dataclass(frozen=True)
class Compared:
    """Measured errors over predicted ones in a scene, and how far its outputs are from the reference, m."""

    scene: str
    deviation: float
    springs: tuple[float, ...]
    steps: tuple[float, ...]


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.scenes", description=__doc__)
    parser.add_argument("what", choices=["predictions", *SECTIONS])
    parser.add_argument("--only", default="", help="scenes whose name holds this")
    parser.add_argument("--json", type=Path, help="save the figures")
    parser.add_argument("--picture", type=Path, help="draw those of libraries into this .svg")
    arguments = parser.parse_args()
    if arguments.what in SECTIONS:
        figures = importlib.import_module(f"tests.benchmarks.scene_{arguments.what}").show()
        if arguments.json:
            save_json(arguments.json, figures)
        if arguments.picture and arguments.what == "libraries":
            draw(figures, arguments.picture)
        return
    require_pinocchio()
    wanted = [(name, scene) for name, scene in many().items() if arguments.only in name]
    found = [compared(name, scene) for name, scene in progress(wanted, "simulate")]
    show(found)
    if arguments.json:
        save_json(arguments.json, [vars(one) for one in found])


def compared(name: str, make: Callable[[], Scene]) -> Compared:
    scene = make()
    path = resolved_path(scene.reference, scene.tolerances)
    rungs = backward_greedy([path], scene.tolerances)
    sets = [[path.joints.index(spring) for spring in rung.left_out] for rung in rungs]
    t = np.linspace(0.0, scene.reference.duration, TIMES + 1)
    truth = Truth(scene.reference, sets, t, pinocchio_dynamics(scene.reference.machine), PRECISION)
    springs = []
    for rung, locked, static in zip(rungs, *truth.errors(scene.outputs), strict=True):
        for predicted, measured in ((rung.locked, locked), (rung.static, static)):
            springs += ratios(list(predicted.values()), measured.tolist(), SMALLEST_MODEL)
    deviation = float(np.abs(Deviations(path).outputs).max())
    return Compared(name, deviation, tuple(springs), tuple(step_ratios(scene, path, truth)))


def step_ratios(scene: Scene, path: LinearPath, truth: Truth) -> Iterator[float]:
    """Errors of generated steps with all springs, of methods that are stable, over predicted ones."""
    reference, errors = scene.reference, StepErrors(path)
    module = with_steps(reference.loaded, *NAMES)
    exact = truth.outputs(scene.outputs, truth.q)[:, 0]
    limit = largest_stable_step(METHODS["rk4"], poles(path))
    for name in NAMES:
        for steps in STEPS:
            if name == "rk4" and reference.duration / steps > limit:
                continue
            q = stepped_motion(module, METHODS[name], reference, steps)
            measured = np.abs(truth.outputs(scene.outputs, q[:, None])[:, 0] - exact[:: TIMES // steps]).max(axis=0)
            predicted = errors.errors(METHODS[name], steps)
            yield from ratios(list(predicted.values()), measured.tolist(), SMALLEST_STEP)


def ratios(predicted: Sequence[float], measured: Sequence[float], smallest: float) -> list[float]:
    pairs = zip(predicted, measured, strict=True)
    return [error / guess for guess, error in pairs if error > smallest and guess > 0]


def share(found: Sequence[float], within: float) -> float:
    """The part of ratios within a factor."""
    return float(np.mean([1 / within <= x <= within for x in found])) if found else 1.0


def show(found: Sequence[Compared]) -> None:
    columns = ("scene", "deviation, mm", "rung errors", "least", "most", "within 1.1", "step errors", "least", "most")
    rows = [
        (one.scene, f"{1e3 * one.deviation:.3g}", *_figures(one.springs), f"{share(one.springs, CLOSE):.0%}",
         *_figures(one.steps))
        for one in found
    ]  # fmt: skip
    print_table("measured over predicted errors", columns, rows)
    springs = [x for one in found if one.deviation <= LARGEST for x in one.springs]
    steps = [x for one in found for x in one.steps]
    asked = (
        ("rung errors within a factor 2", len(springs), share(springs, EXCEPT_FAR), 1.0),
        ("rung errors within 1.1", len(springs), share(springs, CLOSE), 0.9),
        ("step errors within a factor 2", len(steps), share(steps, EXCEPT_FAR), 0.95),
    )
    kept = [(what, str(n), f"{x:.1%}", f"{goal:.0%}", met(x >= goal)) for what, n, x, goal in asked]
    print_table("promises", ("promise", "errors", "share", "asked", ""), kept)


def _figures(found: Sequence[float]) -> tuple[str, str, str]:
    return (str(len(found)), f"{min(found):.3f}", f"{max(found):.3f}") if found else ("0", "-", "-")


if __name__ == "__main__":
    main()
