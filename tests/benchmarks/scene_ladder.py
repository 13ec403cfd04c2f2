"""What the ladder saves: the chosen rung against the whole machine with RK4 at the same tolerance, and its own time."""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from symoro_elastic.analysis.ladder.predicted_rungs import Prediction
from symoro_elastic.analysis.ladder.rung import Rung
from symoro_elastic.analysis.ladder.rungs import Ladder, Measurement, measured_ladder
from symoro_elastic.machine.prescribed_motion import Bandwidth
from tests.analysis.ladder.scenes import Scene, arm, flex4, moving, random_springs, tool_scene, tuned
from tests.benchmarks.tables import met, print_table, progress
from tests.command_line import EXAMPLES

MEAN, LEAST, LONGEST = 12.0, 3.0, 15.0
ROUNDS, TIMED = 40, 1000
SLOW = Bandwidth(8, 0.7)
SCENES: dict[str, Callable[[], Scene]] = {
    "two_axis, 150 ms, 10 um": lambda: tool_scene("", 0.15),
    "two_axis, 150 ms, servos, 10 um": lambda: tool_scene("", 0.15, Bandwidth(25, 0.8)),
    "flex4, 300 ms, servos, 100 um": lambda: moving("", tuned(flex4(), (40, 250)), 0.3, 0.3, 1e-4, SLOW),
    "rx90 with springs, 400 ms, servos, 100 um": lambda: moving(
        "", arm("rx90.par", (40, 120, 300), 0.01), 0.3, 0.4, 1e-4, SLOW
    ),
    "random tree of 9, 300 ms, servos, 100 um": lambda: moving(
        "", random_springs(12, 9, (30, 120, 400), 0.01), 0.2, 0.3, 1e-4, SLOW
    ),
}


def show() -> list[Any]:
    """Print tables and return their figures."""
    figures: list[dict[str, Any]] = []
    for title, make in progress(list(SCENES.items()), "ladders"):
        scene = make()
        began = time.process_time()
        measurement = Measurement(Prediction(scene.reference.machine, (scene.reference,), scene.tolerances))
        found = measured_ladder(measurement, measurement.prediction.rungs())
        figures.append({"scene": title, "ladder_s": time.process_time() - began, **_figures(measurement, found)})
    rows = [
        (
            one["scene"],
            f"{one['left_out']} of {one['springs']}",
            one["method"],
            str(one["steps"]),
            f"{1e3 * one['ms']:.0f}",
            f"{one['full_steps']}",
            f"{1e3 * one['full_ms']:.0f}",
            f"{one['operations']:.1f}",
            f"{one['saving']:.1f}",
            f"{one['error']:.2f}",
            f"{one['ladder_s']:.1f}",
        )
        for one in figures
    ]
    columns = (
        "scene",
        "springs left out",
        "method",
        "steps",
        "us",
        "rk4 steps of all",
        "us",
        "saving, operations",
        "saving, time",
        "measured error/tolerance",
        "ladder, s of processor",
    )
    print_table("chosen rung against the whole machine with rk4", columns, rows)
    savings = [one["saving"] for one in figures]
    mean = float(np.exp(np.mean(np.log(savings))))
    wall, processor = of_command()
    figures.append({"scene": "command, 12 joints", "wall_s": wall, "processor_s": processor})
    asked = [
        ("saving of time, geometric mean", f"{mean:.1f}", f"{MEAN:g}", met(mean >= MEAN)),
        ("saving of time, least", f"{min(savings):.1f}", f"{LEAST:g}", met(min(savings) >= LEAST)),
        ("ladder of 12 joints, s of processor", f"{processor:.1f}", f"{LONGEST:g}", met(processor <= LONGEST)),
        ("ladder of 12 joints, s", f"{wall:.1f}", f"{LONGEST:g}", met(wall <= LONGEST)),
    ]
    print_table("goals", ("goal", "found", "asked", ""), asked)
    return figures


def _figures(measurement: Measurement, found: Ladder) -> dict[str, Any]:
    rung, whole = found.rungs[found.chosen or 0], found.rungs[0]
    assert rung.chosen is not None and rung.measured is not None
    steps, full = rung.chosen, found.full
    ms, full_ms = (
        1e3 * one.steps * _seconds(measurement, of, one.method, one.steps) for of, one in ((rung, steps), (whole, full))
    )
    limit = next(iter(found.tolerance.values()))
    wrong = max(rung.measured.model[name] + rung.measured.steps[name] for name in found.tolerance)
    return {
        "left_out": len(rung.left_out),
        "springs": len(found.rungs[-1].left_out),
        "method": steps.method,
        "steps": steps.steps,
        "ms": ms,
        "full_steps": full.steps,
        "full_ms": full_ms,
        "operations": found.saving,
        "saving": full_ms / ms,
        "error": wrong / limit,
    }


def _seconds(measurement: Measurement, rung: Rung, method: str, steps: int) -> float:
    """Of a step, without the call from Python."""
    simulated = measurement.simulation(rung, 0)
    runner = simulated.steps_by(method)
    return min(runner.run(simulated.reduced, method, max(steps, TIMED)).seconds for _ in range(ROUNDS))


def of_command() -> tuple[float, float]:
    """Seconds, and seconds of processor, of the command, start of Python and compilation included."""
    words = ["ladder", str(EXAMPLES / "two_axis.toml"), "--scene", str(EXAMPLES / "scenes" / "two_axis_move.toml")]
    began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-m", "symoro_elastic", *words], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.perf_counter() - began, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
