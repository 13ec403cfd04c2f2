"""What the ladder saves: the chosen rung against the whole machine with RK4 at the same tolerance, and its own time."""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from symoro_elastic.ladder.rungs import Ladder, ladder
from symoro_elastic.simulation.compiled_steps import CompiledSteps
from symoro_elastic.simulation.reference import Reference
from tests.benchmarks.tables import print_table, progress
from tests.command_line import EXAMPLES
from tests.ladder.scenes import Scene, arm, flex4, moving, random_springs, tool_scene, tuned

MEAN, LEAST, LONGEST = 12.0, 3.0, 15.0
ROUNDS = 5
SCENES: dict[str, Callable[[], Scene]] = {
    "two_axis, 150 ms, 10 um": lambda: tool_scene("", 0.15),
    "two_axis, 60 ms, 100 um": lambda: toleranced(tool_scene("", 0.06), 1e-4),
    "flex4, 300 ms, 100 um": lambda: moving("", tuned(flex4(), (40, 250)), 0.3, 0.3, 1e-4),
    "rx90 with springs, 400 ms, 100 um": lambda: moving("", arm("rx90.par", (40, 120, 300)), 0.3, 0.4, 1e-4),
    "random tree of 9, 300 ms, 100 um": lambda: moving("", random_springs(12, 9, (30, 120, 400), 0.01), 0.2, 0.3, 1e-4),
}


def toleranced(scene: Scene, tolerance: float) -> Scene:
    return Scene(scene.title, scene.reference, scene.outputs, tolerance)


def show() -> list[Any]:
    """Print tables and return their figures."""
    figures: list[dict[str, Any]] = []
    for title, make in progress(list(SCENES.items()), "ladders"):
        scene = make()
        began = time.process_time()
        found = ladder(scene.reference.machine, [scene.reference.prescribed], scene.tolerances)
        figures.append({"scene": title, "ladder_s": time.process_time() - began, **_figures(found, scene.reference)})
    rows = [
        (one["scene"], f"{one['left_out']} of {one['springs']}", one["method"], str(one["steps"]), f"{1e3 * one['ms']:.0f}",
         f"{one['full_steps']}", f"{1e3 * one['full_ms']:.0f}", f"{one['operations']:.1f}", f"{one['saving']:.1f}",
         f"{one['error']:.2f}", f"{one['ladder_s']:.1f}")
        for one in figures
    ]  # fmt: skip
    columns = ("scene", "springs left out", "method", "steps", "us", "rk4 steps of all", "us", "saving, operations",
               "saving, time", "measured error/tolerance", "ladder, s of processor")  # fmt: skip
    print_table("chosen rung against the whole machine with rk4", columns, rows)
    savings = [one["saving"] for one in figures]
    mean = float(np.exp(np.mean(np.log(savings))))
    wall, processor = of_command()
    figures.append({"scene": "command, 12 joints", "wall_s": wall, "processor_s": processor})
    asked = [
        ("saving of time, geometric mean", f"{mean:.1f}", f"{MEAN:g}", _met(mean >= MEAN)),
        ("saving of time, least", f"{min(savings):.1f}", f"{LEAST:g}", _met(min(savings) >= LEAST)),
        ("ladder of 12 joints, s of processor", f"{processor:.1f}", f"{LONGEST:g}", _met(processor <= LONGEST)),
        ("ladder of 12 joints, s", f"{wall:.1f}", f"{LONGEST:g}", _met(wall <= LONGEST)),
    ]
    print_table("goals", ("goal", "found", "asked", ""), asked)
    return figures


def _figures(found: Ladder, reference: Reference) -> dict[str, Any]:
    rung = found.rungs[found.chosen or 0]
    assert rung.chosen is not None and rung.measured is not None
    ms = 1e3 * rung.chosen.steps * rung.measured.seconds
    full_ms = 1e3 * found.full.steps * _seconds(reference, found.full.steps)
    limit = next(iter(found.tolerance.values()))
    wrong = max(rung.measured.model[name] + rung.measured.steps[name] for name in found.tolerance)
    return {"left_out": len(rung.left_out), "springs": len(found.rungs[-1].left_out), "method": rung.chosen.method or "none",
            "steps": rung.chosen.steps, "ms": ms, "full_steps": found.full.steps, "full_ms": full_ms,
            "operations": found.saving, "saving": full_ms / ms if ms else np.inf, "error": wrong / limit}  # fmt: skip


def _seconds(reference: Reference, steps: int) -> float:
    """Of a step of RK4 of the whole machine."""
    with TemporaryDirectory() as folder:
        runner = CompiledSteps(reference.machine, ["rk4"], Path(folder))
    return min(runner.run(reference, "rk4", steps).seconds for _ in range(ROUNDS))


def of_command() -> tuple[float, float]:
    """Seconds, and seconds of processor, of the command, start of Python and compilation included."""
    words = ["ladder", str(EXAMPLES / "two_axis.toml"), "--scene", str(EXAMPLES / "scenes" / "two_axis_move.toml")]
    began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-m", "symoro_elastic", *words], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.perf_counter() - began, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _met(is_met: bool) -> str:
    return "met" if is_met else "NOT MET"
