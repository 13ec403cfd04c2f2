"""Models of which terms of the inertia matrix and of the potential are left out: all else follows from these two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.progress import Announce, Progress
from symoro_elastic.machine.limits import Limits, Range
from symoro_elastic.machine.within import Tolerance
from symoro_elastic.models.catalogue import TracedModel
from symoro_elastic.models.energy_form import OFFERED, EnergyForm, energy_form, has_energy_form
from symoro_elastic.models.traced import Traced
from symoro_elastic.numerics.arrays import arithmetic
from symoro_elastic.numerics.guarantees.box import Box, box_of
from symoro_elastic.numerics.guarantees.certificate import Subject
from symoro_elastic.numerics.guarantees.of_reduced import ReducedErrors
from symoro_elastic.numerics.within.frequencies import NaturalFrequencies
from symoro_elastic.numerics.within.left_out import left_out_of
from symoro_elastic.numerics.within.reduction import without_parameters
from symoro_elastic.numerics.within.results import EntryError, Reduction, Reserved
from symoro_elastic.numerics.within.switches import Switched, switched
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Operand, reachable
from symoro_elastic.symbolic.program import Input, Names, Output, Program, Pruned, build, schedule

STATES, SAME = 100, 1e-9
"""States at which a model is compared with what its energies give, and how far both may be apart, of the largest."""
LONGER = "its derivatives take more operations than are left out"


class NoEnergyForm(ValueError):
    """A model is not given by energies here."""


def from_energies(
    asked: Traced,
    model: TracedModel,
    whole: Subject,
    limits: Limits,
    tolerances: Mapping[str, Sequence[Tolerance]],
    *,
    positions: Sequence[str],
    proven: bool,
    frequencies: NaturalFrequencies | None,
    reserved: Reserved,
    announce: Announce,
    progress: Progress,
) -> Reduction:
    """The reduction of a model: terms of A and V left out, the rest derived; whole where that takes more operations.

    Raises `NoEnergyForm` for a model that does not follow from A and V.
    """
    form, program = _form(asked, model, whole.function.program), whole.function.program
    switches = switched(form.program, positions)
    derived = _derived(form, model, switches.entries, program.inputs)
    values = dict.fromkeys(switches.changes, 1.0)
    box = box_of(asked.machine, limits, program.inputs, program.used | derived.used - values.keys())
    with_switches = Box({**box.ranges, **{name: Range(1.0, 1.0) for name in values}}, box.positions)
    function = replace(whole.function, program=derived)
    found = without_parameters(
        derived,
        box.ranges,
        tolerances,
        values,
        inertia=_inertia(form, switches),
        positions=positions,
        confident=not proven,
        bound=ReducedErrors(Subject(function, with_switches, whole.rounding), progress) if proven else None,
        frequencies=frequencies,
        reserved=reserved,
        watched=announce,
    )
    return _result(form, model, switches, found, program)


def _form(asked: Traced, model: TracedModel, program: Program) -> EnergyForm:
    """A and V of a machine; raises `NoEnergyForm` where its model is another one than they give."""
    if model.model.name not in OFFERED or not model.whole:
        raise NoEnergyForm(f"is kept of {' and '.join(OFFERED)} with all joints")
    if not has_energy_form(asked.machine):
        raise NoEnergyForm("is kept of trees on a fixed base, without external wrenches")
    form = energy_form(asked.machine, asked.folded)
    derived = _derived(form, model, [x for output in form.program.outputs for x in output.entries], program.inputs)
    exact, found = _values(program), _values(derived)
    if not (np.abs(found - exact) <= SAME * np.abs(exact).max(axis=1, keepdims=True)).all():
        raise NoEnergyForm("is kept where all forces of inertia and gravity come from energies, on a base at rest")
    return form


def _values(program: Program) -> Array:
    """The results (entries, states) at random states, those of another program of the same arguments alike."""
    rng = np.random.default_rng(0)
    states = {name: rng.uniform(-1, 1, STATES) for argument in program.inputs for name in argument.symbols}
    entries = [x for output in program.outputs for x in output.entries]
    value = evaluate(entries, states, arithmetic(np.float64))
    return np.array([np.broadcast_to(value(x), STATES) for x in entries], dtype=float)


def _derived(form: EnergyForm, model: TracedModel, entries: Sequence[Operand], inputs: Sequence[Input]) -> Program:
    """The program of a model from the entries of A and V, as they stand."""
    results = form.results(model.model.name, entries, Names())
    outputs = tuple(Output(name, (len(found),), found) for name, found in results.items())
    nodes = reachable(x for output in outputs for x in output.entries)
    return schedule(inputs, Pruned(outputs, Names(), nodes))


def _inertia(form: EnergyForm, switches: Switched) -> Program:
    """The program of the whole matrix A."""
    A, joints = form.matrix(switches.entries[:-1]), form.joints
    output = Output("A", (len(joints), len(joints)), tuple(A[i][j] for i in joints for j in joints))
    return schedule(form.program.inputs, Pruned((output,), Names(), reachable(output.entries)))


def _result(form: EnergyForm, model: TracedModel, switches: Switched, found: Reduction, program: Program) -> Reduction:
    """The reduction of the program of a model, as A and V with these switches off give it."""
    off = [one.term for one in found.left_out]
    outputs = switches.without(off)
    names = form.names.moved(switches.values_without(off))
    results = form.results(model.model.name, [x for output in outputs for x in output.entries], names)
    made = tuple(Output(name, (len(entries),), entries) for name, entries in results.items())
    reduced = build(program.inputs, made, names)
    if not off or _operations(reduced) >= _operations(program):
        return _whole(found, program, LONGER if off else found.unproven)
    terms = left_out_of(form.program, switches.tape, [switches.changes[name] for name in off])
    return replace(found, program=program, reduced=reduced, outputs=reduced.outputs, left_out=terms)


def _whole(found: Reduction, program: Program, why: str) -> Reduction:
    """The reduction that leaves nothing out."""
    errors = tuple(EntryError(one.output, one.index, one.largest, one.tolerance, 0.0, 0.0, 0.0) for one in found.errors)
    outputs = program.outputs
    return replace(
        found, program=program, reduced=program, outputs=outputs, left_out=(), errors=errors, shift=None, unproven=why
    )


def _operations(program: Program) -> int:
    return program.count.products + program.count.add
