"""Whether what `benchmark` promises holds at unseen states: `python -m tests.benchmarks.advice [MACHINE ...]`.

Of each model in single, mixed and double precision: the worst error at 100 000 unseen states, inputs in double, beside
the bounds that 20 000 states give, each from another seed; and how many of these bounds hold.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from symoro_elastic.analysis.trade_off.formulations import formulations
from symoro_elastic.analysis.trade_off.trade import MEASURED_STATES, parameters
from symoro_elastic.codegen.compile import compile_package
from symoro_elastic.codegen.precision import DOUBLE, MIXED, SINGLE
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.accuracy import UNSEEN, Reference, measure
from symoro_elastic.numerics.verification.implementations import c_code
from symoro_elastic.numerics.verification.states import moderate_states

EXAMPLES = Path(__file__).parents[2] / "examples"
MACHINES = ("planar_2r.toml", "two_axis.toml", "rx90.par", "flex4.par")
SEEDS = range(1, 9)
ROW = "{:10} {:17} {:8} {:>14} {:>12} {:>12} {:>6}"


def try_machine(path: Path) -> None:
    """Print a row for each model and precision."""
    machine, _ = read_machine(path)
    values = parameter_values(machine)
    form = formulations(machine, Scene(), values)[0][0]
    unseen = moderate_states(machine, UNSEEN, 0, values)
    seen = [moderate_states(machine, MEASURED_STATES, seed, values) for seed in SEEDS]
    for model, traced in form.traced.items():
        exact = [Reference(traced, states, values) for states in (unseen, *seen)]
        for precision in (SINGLE, MIXED, DOUBLE):
            with tempfile.TemporaryDirectory() as folder:
                compiled = compile_package(form.package, Path(folder), precision=precision)
                code = c_code(compiled, parameters(form, precision), batch=True)
                worst, *bounds = [measure(one, code(traced, one.states), precision) for one in exact]
            low, high = min(one.bound for one in bounds), max(one.bound for one in bounds)
            held = sum(worst.relative <= one.bound for one in bounds)
            figures = (f"{worst.relative:.1e}", f"{low:.1e}", f"{high:.1e}", f"{held}/{len(bounds)}")
            print(ROW.format(machine.name, model, precision.name, *figures))


def main() -> None:
    """Try the machines named, or some of the examples."""
    print(ROW.format("machine", "model", "", f"worst, {UNSEEN}", "least bound", "most", "held"))
    for path in map(Path, sys.argv[1:] or [str(EXAMPLES / name) for name in MACHINES]):
        try_machine(path)


if __name__ == "__main__":
    main()
