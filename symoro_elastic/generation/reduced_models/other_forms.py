"""Models reduced in another form, from which they are derived.

**Energies**: terms of the inertia matrix and of the potential are left out; the model is derived from these two.
**Solved exactly**: where lemma 3 proves too little of a direct model, terms of its inverse model are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.limits import Limits, Range
from symoro_elastic.machine.within import Tolerance
from symoro_elastic.models.packaging import Traced
from symoro_elastic.models.programs.catalogue import TracedModel
from symoro_elastic.models.programs.forms import (
    DIRECT,
    OFFERED,
    EnergyForm,
    energy_form,
    has_energy_form,
    has_inertia_form,
    inertia_form,
)
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.guarantees.box import Box, box_of
from symoro_elastic.numerics.guarantees.certificate import Subject
from symoro_elastic.numerics.within.by_inverse import SolvedExactly, residual_of, solved_exactly
from symoro_elastic.numerics.within.reduction import without_parameters
from symoro_elastic.numerics.within.results import EntryError, ErrorBound, Reduction, left_out_of
from symoro_elastic.numerics.within.tape import SwitchedProgram, with_switches
from symoro_elastic.numerics.within.trials import Requirements, Task
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Operand, reachable
from symoro_elastic.symbolic.program import Input, Names, Output, Program, Pruned, build, schedule

STATES, SAME = 100, 1e-9
"""States at which a model is compared with what its energies give, and how far both may be apart, of the largest."""
LONGER = "its derivatives need more operations than are omitted"


class NoEnergyForm(ValueError):
    """Raised where energies do not give a model."""


Prove = Callable[[Subject], ErrorBound]
"""From a whole program in its box to bounds on the errors of reduced ones."""


@dataclass(frozen=True)
class FullModel:
    """A full model, with the tolerances of the entries of its results."""

    asked: Traced
    model: TracedModel
    subject: Subject
    limits: Limits
    tolerances: Mapping[str, Sequence[Tolerance]]

    @property
    def program(self) -> Program:
        """The program of the full model."""
        return self.subject.function.program

    def box(self, other: Program, used: Set[str]) -> Box:
        """The box of the variables that this program or another one uses."""
        return box_of(self.asked.machine, self.limits, other.inputs, self.program.used | used)


def from_energies(full: FullModel, required: Requirements, prove: Prove | None) -> Reduction:
    """The reduction of a model by terms of inertia matrix A and potential V; full where that saves no operations.

    Raises `NoEnergyForm` for a model that does not follow from A and V.
    """
    form, model, program = _form(full.asked, full.model, full.program), full.model, full.program
    switches = with_switches(form.program, required.positions)
    derived = _from_forms(form, model, switches.entries, program.inputs)
    values = dict.fromkeys(switches.changes, 1.0)
    box = full.box(program, derived.used - values.keys())
    box_of_switches = Box({**box.ranges, **{name: Range(1.0, 1.0) for name in values}}, box.positions)
    function = replace(full.subject.function, program=derived)
    bound = prove(Subject(function, box_of_switches, full.subject.rounding)) if prove else None
    required = replace(required, names=Names(), bound=bound)
    reduction = without_parameters(derived, box.ranges, full.tolerances, values, _inertia(form, switches), required)
    return _result(form, model, switches, reduction, program)


def _form(traced: Traced, model: TracedModel, program: Program) -> EnergyForm:
    """A and V of a machine; raises `NoEnergyForm` where they do not give its model."""
    if model.model.name not in OFFERED or not model.whole:
        raise NoEnergyForm(f"is kept of {' and '.join(OFFERED)} with all joints")
    if not has_energy_form(traced.machine):
        raise NoEnergyForm("is kept of trees on a fixed base, without external wrenches")
    form = energy_form(traced.machine, traced.folded)
    derived = _from_forms(form, model, [x for output in form.program.outputs for x in output.entries], program.inputs)
    exact, derived_values = _values(program), _values(derived)
    if not (np.abs(derived_values - exact) <= SAME * np.abs(exact).max(axis=1, keepdims=True)).all():
        raise NoEnergyForm("is kept where all forces of inertia and gravity come from energies, on a base at rest")
    return form


def _values(program: Program) -> Array:
    """The results (entries, states) at random states, the same for all programs of the same arguments."""
    rng = np.random.default_rng(0)
    states = {name: rng.uniform(-1, 1, STATES) for argument in program.inputs for name in argument.symbols}
    entries = [x for output in program.outputs for x in output.entries]
    value = evaluate(entries, states, arithmetic(np.float64))
    return np.array([np.broadcast_to(value(x), STATES) for x in entries], dtype=float)


def _from_forms(form: EnergyForm, model: TracedModel, entries: Sequence[Operand], inputs: Sequence[Input]) -> Program:
    """The program of a model derived from `entries` of the inertia matrix and the potential, as they are."""
    results = form.results(model.model.name, entries, Names())
    outputs = tuple(Output(name, (len(roots),), roots) for name, roots in results.items())
    nodes = reachable(x for output in outputs for x in output.entries)
    return schedule(inputs, Pruned(outputs, Names(), nodes))


def _inertia(form: EnergyForm, switches: SwitchedProgram) -> Program:
    """The program of the whole matrix A."""
    A, joints = form.matrix(switches.entries[:-1]), form.joints
    output = Output("A", (len(joints), len(joints)), tuple(A[i][j] for i in joints for j in joints))
    return schedule(form.program.inputs, Pruned((output,), Names(), reachable(output.entries)))


def _result(
    form: EnergyForm, model: TracedModel, switches: SwitchedProgram, reduction: Reduction, program: Program
) -> Reduction:
    """The reduction of a model whose reduced program is derived from A and V without the omitted terms."""
    off = [change.term for change in reduction.left_out]
    outputs = switches.without(off)
    names = form.names.moved(switches.values_without(off))
    results = form.results(model.model.name, [x for output in outputs for x in output.entries], names)
    derived_outputs = tuple(Output(name, (len(entries),), entries) for name, entries in results.items())
    reduced = build(program.inputs, derived_outputs, names)
    if not off or _operations(reduced) >= _operations(program):
        return _whole(reduction, program, LONGER if off else reduction.unproven)
    terms = left_out_of(form.program, switches.tape, [switches.changes[name] for name in off])
    return replace(reduction, program=program, reduced=reduced, outputs=reduced.outputs, left_out=terms)


def _whole(reduction: Reduction, program: Program, why: str) -> Reduction:
    """The reduction that omits nothing."""
    errors = tuple(EntryError(x.output, x.index, x.largest, x.tolerance, 0.0, 0.0, 0.0) for x in reduction.errors)
    own = program.outputs
    return replace(
        reduction, program=program, reduced=program, outputs=own, left_out=(), errors=errors, shift=None, unproven=why
    )


def _operations(program: Program) -> int:
    return program.count.products + program.count.add


def can_be_solved(traced: Traced, model: TracedModel) -> bool:
    """Whether a model may be reduced by terms of its inverse model."""
    return model.model.name == DIRECT and has_inertia_form(traced.machine)


def solved_direct(full: FullModel, required: Requirements, prove: Prove) -> tuple[SolvedExactly, Subject] | None:
    """The direct model within its tolerances, and the subject of its certificate; None where nothing is proven.

    The program is that through the inertia matrix without the omitted terms.
    """
    required.announce("prove: range of the inertia matrix")
    form, full_subject = inertia_form(full.asked.machine, full.asked.folded), full.subject
    box = full.box(form.program, form.program.used)
    required = Requirements(positions=required.positions, announce=required.announce)
    task = Task(full.program, box.ranges, full.tolerances, required)
    rows = full.model.results["qdd"].rows or ()
    residual = residual_of(form, box, _most(task, form.joints, rows))
    if residual is None:
        return None
    function = replace(full_subject.function, program=residual.program)
    solution = solved_exactly(task, rows, residual, prove(replace(full_subject, function=function, box=residual.box)))
    reduced = replace(full_subject.function, program=solution.reduction.reduced)
    return solution, Subject(reduced, box, full_subject.rounding, solution.knowledge())


def _most(task: Task, joints: Sequence[int], rows: Sequence[int]) -> Array:
    """The allowed errors of accelerations, infinite for those that are not requested."""
    allowed = dict(zip(task.tape.results, task.allowed, strict=True))
    (places,) = task.tape.entries
    by_joint = {j: float(allowed.get(place, np.inf)) for j, place in zip(rows, places, strict=True)}
    return np.array([by_joint.get(j, np.inf) for j in joints])
