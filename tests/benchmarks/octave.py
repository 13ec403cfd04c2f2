"""All models of five machines in GNU Octave, `.m` and MEX, beside numpy: `python -m tests.benchmarks.octave`.

Units in the last place by which an entry of a result differs at most from that of the numpy package, one state a call.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from symoro_elastic.codegen.targets.matlab import render_matlab
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats.reading import read
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.catalogue import MODELS
from symoro_elastic.numerics.implementations import import_package
from symoro_elastic.packaging import reserved_words
from symoro_elastic.traced import traced
from tests.benchmarks.tables import print_table
from tests.octave import calls_of, octave, ulps, written

EXAMPLES = Path(__file__).parents[2] / "examples"
MACHINES = ("two_axis.toml", "flex4.par", "puma560.par", "sr400.par", "floating_arm.toml")
STATES = 20


def models_of(machine: Machine) -> tuple[str, ...]:
    """The models that a machine has."""
    found = []
    for name in MODELS:
        try:
            traced(machine, Scene(models=(name,)))
        except InputError:
            continue
        found.append(name)
    return tuple(found)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks.octave", description=__doc__)
    parser.add_argument("machines", nargs="*", default=MACHINES)
    rows = []
    for file in parser.parse_args().machines:
        rows += figures(read(EXAMPLES / file, reserved_words()))
    print_table(f"Octave against numpy, {STATES} states", ["machine", "model", ".m [ulp]", "MEX [ulp]"], rows)


def figures(machine: Machine) -> list[list[str]]:
    """A row for each model."""
    found = traced(machine, Scene(models=models_of(machine)))
    package = found.package
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        module = import_package(render_numpy(package), folder / "numpy")
        code = written(render_matlab(package), folder / "code")
        own, mex, wanted = calls_of(package, found.machine, module, STATES)
        answers = octave([*own, *mex], folder / "calls", [code], f"{package.name}.build();")
    rows = []
    for function, by_m, by_mex, arrays in zip(
        package.functions, answers[: len(own)], answers[len(own) :], wanted, strict=True
    ):
        both = [answer.error or f"{max(map(ulps, answer.results, arrays), default=0.0):g}" for answer in (by_m, by_mex)]
        rows.append([machine.name, function.name, *both])
    return rows


if __name__ == "__main__":
    main()
