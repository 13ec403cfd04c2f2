"""Operations, instructions at two states, and stack of time steps: `python -m tests.benchmarks.steps`.

Real time asks for the same work at every state, and for memory that is known before.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from symoro_elastic.analysis.simulation.simulate import StepCost
from symoro_elastic.codegen.c.steps import Run, runs
from symoro_elastic.codegen.integration.tableaus import METHODS
from symoro_elastic.codegen.local_names import with_own_results
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE
from symoro_elastic.codegen.targets.c import render_c, source_text
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.models.steps.implicit_steps import Motors
from tests.benchmarks.instructions import available, per_call
from tests.benchmarks.machines import two_axis
from tests.benchmarks.ours import places
from tests.benchmarks.tables import print_table

STATES = (0.1, -1.3)
FRAME = re.compile(r'node: \{ title: "([^"]+)" label: "[^"]*?(\d+) bytes \(([\w,]+)\)')
EDGE = re.compile(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"')
BOUNDED = ("static", "dynamic,bounded")


@dataclass(frozen=True)
class StepCode:
    """A time step in C, motors under servos: the pieces of a call at the state `row`."""

    package: Package
    run: Run

    @cached_property
    def files(self) -> dict[str, str]:
        return render_c(self.package)

    @property
    def header(self) -> str:
        return f'#include <string.h>\n#include "{self.package.name}.h"'

    @property
    def setup(self) -> str:
        return ""

    @property
    def inputs(self) -> list[int]:
        return [*self.run.read.values(), sum(self.run.written.values())]

    @property
    def results(self) -> list[int]:
        return [*self.run.written.values()]

    @property
    def call(self) -> str:
        *read, state = places("row", self.inputs)
        arguments = [*read, "1e-3", "NULL", *places("result", self.results)]
        return f"memcpy(result, {state}, sizeof result); {self.run.name}({', '.join(arguments)});"


def step_code(machine: Machine, method: str) -> StepCode:
    """The step of a method with the numbers of the machine in it."""
    package = trace_models(machine, Scene(models=("inverse_dynamics",), steps=(method,), fold=ALL)).package
    steps = source_text(with_own_results(package), DOUBLE).steps
    (run,) = [run for run in runs(steps) if run.name.endswith("_servo")]
    return StepCode(package, run)


def can_measure_stack() -> bool:
    """Whether there is the compiler that says how much each function takes."""
    return bool(shutil.which("gcc"))


def largest_stack(files: Mapping[str, str], function: str) -> int:
    """Bytes of stack that a function and all that it calls take at most, as gcc lays them out at -O2.

    Libraries are not counted. Raises `ValueError` where a size depends on data, or a function calls itself.
    """
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        sources = [name for name in files if name.endswith(".c")]
        command = ["gcc", "-std=c99", "-O2", "-fstack-usage", "-fcallgraph-info=su", "-c", *sources]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        graph = "\n".join(path.read_text(encoding="utf-8") for path in Path(folder).glob("*.ci"))
    frames = {name: (int(size), kind) for name, size, kind in FRAME.findall(graph)}
    calls = EDGE.findall(graph)

    def deepest(name: str, above: tuple[str, ...] = ()) -> int:
        size, kind = frames.get(name, (0, "static"))
        if kind not in BOUNDED or name in above:
            raise ValueError(f"{name}: its stack depends on data")
        called = [to for by, to in calls if by == name]
        return size + max((deepest(to, (*above, name)) for to in called), default=0)

    return deepest(next(name for name in frames if name.rpartition(":")[2] == function))


def main() -> None:
    rows = [_row(name) for name in METHODS]
    columns = ["step of the two-axis machine", "weighted operations", *(f"instructions at {x:g}" for x in STATES)]
    print_table("Steps with servos (gcc -O2 -mavx2 -mfma)", [*columns, "stack, bytes"], rows)


def _row(method: str) -> Sequence[str]:
    machine = two_axis()
    code = step_code(machine, method)
    operations = StepCost(machine, Motors.SERVO).of(METHODS[method])
    instructions = [f"{per_call(code, 'gcc', x):.0f}" if available() else "-" for x in STATES]
    stack = largest_stack(code.files, code.run.name) if can_measure_stack() else "-"
    return [method, str(operations), *instructions, str(stack)]


if __name__ == "__main__":
    main()
