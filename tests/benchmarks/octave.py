"""All models of five machines in GNU Octave, `.m` and MEX, beside numpy: `python -m tests.benchmarks.octave`.

Units in the last place by which an entry of a result differs at most from that of the numpy package, one state a call.
Then how long a state takes in Octave, as ratios: one a call, and a thousand side by side.
"""

from __future__ import annotations

import argparse
import re
import tempfile
from pathlib import Path

from symoro_elastic.codegen.targets.matlab import render_matlab
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.formats.reading import read
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import reserved_words, trace_models
from symoro_elastic.models.programs.catalogue import MODELS
from symoro_elastic.numerics.verification.implementations import import_package
from tests.benchmarks.tables import print_table
from tests.octave import calls_of, octave, run_octave, ulps, written

EXAMPLES = Path(__file__).parents[2] / "examples"
MACHINES = ("two_axis.toml", "flex4.par", "puma560.par", "sr400.par", "floating_arm.toml")
STATES = 20


def models_of(machine: Machine) -> tuple[str, ...]:
    """The models that a machine has."""
    found = []
    for name in MODELS:
        try:
            trace_models(machine, Scene(models=(name,)))
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
    print(f"{len(rows)} models, {sum(row[2:] == ['0', '0'] for row in rows)} of them the same to the last bit")
    print_table("Time a state", ["two_axis, direct_dynamics", "one a call", "1000 a call"], times())


TIMES = """
addpath code
two_axis.build();
q = rand(12, 1000); tau = rand(2, 1000); p = two_axis.parameters();
best = inf(2, 2);
for round = 1:15
    tic; for k = 1:40, two_axis.direct_dynamics(q(:, k), q(:, k), tau(:, k), p); end
    best(1, 1) = min(best(1, 1), toc/40);
    tic; for k = 1:400, two_axis_mex('direct_dynamics', q(:, k), q(:, k), tau(:, k), p); end
    best(2, 1) = min(best(2, 1), toc/400);
    tic; two_axis.direct_dynamics(q, q, tau, p); best(1, 2) = min(best(1, 2), toc/1000);
    tic; two_axis_mex('direct_dynamics', q, q, tau, p); best(2, 2) = min(best(2, 2), toc/1000);
end
fprintf('%g ', best'/best(2, 2))
"""
"""The least of 15 interleaved rounds."""


def times() -> list[list[str]]:
    """Times a state of `.m` and MEX, that of MEX with many states a call being 1."""
    package = trace_models(
        read(EXAMPLES / "two_axis.toml", reserved_words()), Scene(models=("direct_dynamics",))
    ).package
    with tempfile.TemporaryDirectory() as folder:
        written(render_matlab(package), Path(folder) / "code")
        found = [f"{float(x):.0f}" for x in re.findall(r"[\d.e+]+", run_octave(TIMES, Path(folder)))]
    return [[".m", *found[:2]], ["MEX", *found[2:]]]


def figures(machine: Machine) -> list[list[str]]:
    """A row for each model."""
    found = trace_models(machine, Scene(models=models_of(machine)))
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
