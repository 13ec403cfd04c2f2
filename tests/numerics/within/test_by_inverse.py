"""Direct models whose inverse model has terms left out: never farther off than proven, symmetric, positive definite."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from symoro_elastic.generation.pipeline import prepare, programs
from symoro_elastic.machine.limits import Range
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.machine.within import Tolerance
from symoro_elastic.models.programs.forms import inertia_form
from symoro_elastic.numerics.guarantees.box import Box, box_of
from symoro_elastic.numerics.guarantees.certificate import Subject, certify
from symoro_elastic.numerics.guarantees.dropped_terms import ReducedErrors
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS
from symoro_elastic.numerics.within.by_inverse import residual_of, solved_exactly
from symoro_elastic.numerics.within.trials import Requirements, Task

from .cases import EXAMPLES, results_of

STATES = 20_000


class Direct:
    """The direct model of a machine, and its inertia form, over a part of its box."""

    def __init__(self, file: str, share: float) -> None:
        machine = prepare(EXAMPLES / file, print, base=file.startswith("puma"))
        asked = programs(machine, Scene(models=("direct_dynamics",), fold=ALL))
        self.function = asked.package.functions[0]
        self.joints = machine.independent
        self.form = inertia_form(asked.machine, asked.folded)
        used = self.form.program.used | self.function.program.used
        box = box_of(machine, machine.limits, self.form.program.inputs, used)
        ranges = {name: Range(x.low * share, x.high * share) for name, x in box.ranges.items()}
        self.box = Box(ranges, box.positions)
        self.task = Task(self.function.program, ranges, {"qdd": Tolerance(1.0)}, Requirements())

    def states(self, seed: int) -> dict[str, np.ndarray]:
        return self.box.states(STATES, np.random.default_rng(seed))


@pytest.mark.thorough
@pytest.mark.parametrize(("file", "tolerance", "share", "most"), [
    ("planar_2r.toml", 0.04, 0.3, 41),
    pytest.param("puma560_measured.toml", 0.01, 1.0, 345, marks=pytest.mark.thorough),
])  # fmt: skip
def test_accelerations_are_as_near_as_proven(file: str, tolerance: float, share: float, most: int) -> None:
    direct = Direct(file, share)
    allowed = tolerance * direct.task.largest
    residual = residual_of(direct.form, direct.box, allowed)
    assert residual
    function = replace(direct.function, program=residual.program)
    bound = ReducedErrors(Subject(function, residual.box, ROUNDINGS["double"]))
    tolerances, required = {"qdd": Tolerance(tolerance)}, Requirements(states=STATES)
    task = Task(direct.function.program, direct.box.ranges, tolerances, required)
    found = solved_exactly(task, direct.joints, residual, bound)
    reduced = found.reduction.reduced
    assert found.reduction.left_out
    assert found.reduction.after.products + found.reduction.after.add <= most
    states = direct.states(7)
    errors = np.abs(results_of(reduced, states) - results_of(direct.function.program, states)).max(axis=1)
    for error, worst in zip(found.reduction.errors, errors, strict=True):
        assert error.bounded is not None
        assert worst <= error.bounded <= error.tolerance
    subject = Subject(replace(direct.function, program=reduced), direct.box, ROUNDINGS["double"], found.knowledge())
    certificate = certify(subject, file)
    assert max(entry.error for entry in certificate.entries) < 1e-9
    pivots = {name: results_of_quantity(reduced, name, states) for name in found.pivots}
    assert all((x >= found.pivots[name]).all() for name, x in pivots.items())


def results_of_quantity(program, name, states):
    from symoro_elastic.numerics.evaluation.arrays import arithmetic
    from symoro_elastic.symbolic.arithmetic import evaluate

    x = program.quantities.get(name)
    return np.array([np.inf]) if x is None else np.asarray(evaluate([x], states, arithmetic(np.float64))(x))
