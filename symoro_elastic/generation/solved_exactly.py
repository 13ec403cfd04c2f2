"""Direct models of which lemma 3 proves too little: terms are left out of the inverse model; it is solved exactly."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Announce, Progress
from symoro_elastic.machine.limits import Limits
from symoro_elastic.machine.within import Tolerance
from symoro_elastic.models.catalogue import TracedModel
from symoro_elastic.models.inertia_form import DIRECT, has_inertia_form, inertia_form
from symoro_elastic.models.traced import Traced
from symoro_elastic.numerics.guarantees.box import box_of
from symoro_elastic.numerics.guarantees.certificate import Subject
from symoro_elastic.numerics.guarantees.of_reduced import ReducedErrors
from symoro_elastic.numerics.within.by_inverse import SolvedExactly, residual_of, solved_exactly
from symoro_elastic.numerics.within.trials import UNSEEN, Task
from symoro_elastic.symbolic.program import Names


def can_be_solved(asked: Traced, model: TracedModel) -> bool:
    """Whether terms of a model may be left out of its inverse model."""
    return model.model.name == DIRECT and has_inertia_form(asked.machine)


def solved_direct(
    asked: Traced,
    model: TracedModel,
    whole: Subject,
    limits: Limits,
    tolerances: Mapping[str, Sequence[Tolerance]],
    positions: Sequence[str],
    announce: Announce,
    progress: Progress,
) -> tuple[SolvedExactly, Subject] | None:
    """The direct model within its tolerances, and what a certificate needs of it; None where nothing is proven.

    `whole` is the direct model. The program is that through the inertia matrix, of which terms are left out.
    """
    announce("prove: range of the inertia matrix")
    form = inertia_form(asked.machine, asked.folded)
    program = whole.function.program
    box = box_of(asked.machine, limits, form.program.inputs, form.program.used | program.used)
    task = Task(program, box.ranges, tolerances, Names(), positions, seed=0)
    rows = model.results["qdd"].rows or ()
    residual = residual_of(form, box, _most(task, form.joints, rows))
    if residual is None:
        return None
    of_residual = replace(whole, function=replace(whole.function, program=residual.program), box=residual.box)
    bound = ReducedErrors(of_residual, progress)
    found = solved_exactly(task, rows, residual, bound, UNSEEN, announce)
    reduced = replace(whole.function, program=found.reduction.reduced)
    return found, Subject(reduced, box, whole.rounding, found.knowledge())


def _most(task: Task, joints: Sequence[int], rows: Sequence[int]) -> Array:
    """The allowed error of each acceleration, infinite for those that are not asked for."""
    allowed = dict(zip(task.tape.results, task.allowed, strict=True))
    (places,) = task.tape.entries
    by_joint = {j: float(allowed.get(place, np.inf)) for j, place in zip(rows, places, strict=True)}
    return np.array([by_joint.get(j, np.inf) for j in joints])
