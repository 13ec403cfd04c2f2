"""What an error of the tool costs at any stiffness: 50 ms of the two-axis machine under servos, springs x1 to x1e8.

The fewest steps whose error is small enough are searched, and their time taken; the truth is RODAS4 in many steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.foundation.array_types import Array
from tests.analysis.simulation.with_parameters import StepsWithParameters
from tests.benchmarks.scene_machines import Tool, stiffer_tool, tool_moves
from tests.benchmarks.tables import met, print_table, progress

TIMES_STIFFER, DAMPING = (1.0, 1e2, 1e4, 1e6, 1e8), (0.0, 0.02)
TRUTH, FEWEST, MOST, FINER, ROUNDS = 16_384, 10, 8192, 1.06, 25
SPREAD, LONGEST, FINE_LONGEST = 2.5, 0.12e-3, 2e-3
CASES = (("w3", 1e-6), ("w2", 1e-6), ("rk4", 1e-6), ("rodas4", 1e-6), ("rodas4", 1e-10), ("w3", 1e-10))


class Search:
    """Steps of one machine whose springs are parameters."""

    def __init__(self, runner: StepsWithParameters, reference: Reference, tool: Tool) -> None:
        self.runner, self.reference, self.tool = runner, reference, tool
        self.truth, half = self.positions("rodas4", TRUTH), self.positions("rodas4", TRUTH // 2)
        self.doubt = float(np.abs(self.truth - half).max())

    def positions(self, method: str, steps: int) -> Array:
        found = self.runner.run(self.reference, method, steps)
        return self.tool.positions(found.t, found.q, found.qd)

    def error(self, method: str, steps: int) -> float:
        found = np.abs(self.positions(method, steps) - self.truth).max()
        return float(found) if np.isfinite(found) else np.inf

    def fewest(self, method: str, error: float) -> int:
        """The fewest steps that are found, 0 where none are."""
        steps = FEWEST
        while self.error(method, steps) > error:
            steps = int(np.ceil(FINER * steps))
            if steps > MOST:
                return 0
        return steps

    def seconds(self, method: str, steps: int) -> float:
        """Of a whole motion."""
        return steps * min(self.runner.run(self.reference, method, steps).seconds for _ in range(ROUNDS))


def show() -> list[Any]:
    """Print tables and return their figures."""
    tool = Tool()
    with TemporaryDirectory() as folder:
        methods = tuple(dict.fromkeys(method for method, _ in CASES))
        runner = StepsWithParameters(stiffer_tool(1).with_parameters, methods, Path(folder))
    figures: list[dict[str, Any]] = []
    for times, damping in progress([(x, d) for d in DAMPING for x in TIMES_STIFFER], "springs"):
        machine = stiffer_tool(times, damping)
        runner.p[:] = [machine.values[p.name] for p in runner.machine.parameters]
        search = Search(runner, tool_moves(machine.with_parameters, machine.values), tool)
        for method, error in CASES:
            steps = search.fewest(method, error)
            ms = 1e3 * search.seconds(method, steps) if steps else None
            figures.append(
                {
                    "stiffer": times,
                    "damping": damping,
                    "method": method,
                    "error": error,
                    "steps": steps,
                    "ms": ms,
                    "doubt": search.doubt,
                }
            )
    _print(figures)
    return figures


def _print(figures: Sequence[dict[str, Any]]) -> None:
    rows = [
        (
            f"{one['method']}, {one['error']:g} m",
            f"{one['damping']:g}",
            f"{one['stiffer']:g}",
            str(one["steps"] or f"> {MOST}"),
            f"{one['ms']:.3f}" if one["ms"] else "-",
            f"{one['doubt']:.1e}",
        )
        for one in sorted(figures, key=lambda one: (one["method"], -one["error"], one["damping"]))
    ]
    columns = ("method, error", "damping", "springs times", "steps", "ms for 50 ms", "doubt of the truth, m")
    print_table("cost at any stiffness", columns, rows)
    asked = []
    for method, error, limit, spread in (("w3", 1e-6, LONGEST, SPREAD), ("rodas4", 1e-10, FINE_LONGEST, np.inf)):
        ms = [one["ms"] for one in figures if (one["method"], one["error"]) == (method, error)]
        most = max(x or np.inf for x in ms)
        ratio = most / min(x or np.inf for x in ms)
        asked.append(
            (f"{method}, {error:g} m: longest, ms", f"{most:.3f}", f"{1e3 * limit:g}", met(most <= 1e3 * limit))
        )
        if np.isfinite(spread):
            asked.append(
                (f"{method}, {error:g} m: longest over shortest", f"{ratio:.2f}", f"{spread:g}", met(ratio <= spread))
            )
    print_table("goals", ("goal", "found", "asked", ""), asked)
