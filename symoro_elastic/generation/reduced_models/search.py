"""Models within tolerances: programs without the terms that the tolerances of results allow to omit.

Terms of a program are omitted by `numerics/within`; errors are relative to the full model while joints are within their
limits, the rounding of the reduced program included.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from symoro_elastic.codegen.package import Function
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.generation.reduced_models.model import ReducedModel
from symoro_elastic.generation.reduced_models.other_forms import (
    FullModel,
    NoEnergyForm,
    can_be_solved,
    from_energies,
    solved_direct,
)
from symoro_elastic.machine.constants import with_free_numbers
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.limits import Limits
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.machine.scene import ALL, INERTIA, Scene
from symoro_elastic.machine.within import ALL_RESULTS, FREQUENCIES, Evidence, Keep, Tolerance, Within
from symoro_elastic.models.packaging import Traced, reserved_words
from symoro_elastic.models.programs.catalogue import TracedModel, in_form
from symoro_elastic.models.programs.forms import DIRECT
from symoro_elastic.numerics.guarantees.box import LIMITED, POSITION, Box, box_of
from symoro_elastic.numerics.guarantees.certificate import MOST_SUB_BOXES, Certificate, EntryBound, Subject, labels
from symoro_elastic.numerics.guarantees.certificates import Effort, certificate_of, subject_of
from symoro_elastic.numerics.guarantees.dropped_terms import ReducedErrors
from symoro_elastic.numerics.guarantees.fixed_point import (
    FIXED_ROUNDING,
    box_in_units,
    in_fixed_point,
    refuse_impossible,
)
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, Rounding
from symoro_elastic.numerics.within.frequencies import NaturalFrequencies
from symoro_elastic.numerics.within.reduction import reduce_program, without_parameters
from symoro_elastic.numerics.within.results import EntryError, Reduction
from symoro_elastic.numerics.within.structure import lost_structure
from symoro_elastic.numerics.within.trials import Requirements
from symoro_elastic.symbolic.program import Names, Program

ARE_POSITIONS = tuple(name for name, quantity in LIMITED.items() if quantity == POSITION)
FREED = ("bodies", "motors")
"""Tables whose numbers may become zero."""
ENDED = "the search was ended before a model within the tolerance was reached: nothing is written"
Trace = Callable[[Machine, Scene], Traced]


def reduced_models(
    machine: DescribedMachine,
    scene: Scene,
    trace: Trace,
    roundings: Sequence[Rounding],
    progress: Progress = no_progress,
    announce: Announce = announce_nothing,
) -> tuple[Traced, list[ReducedModel]]:
    """The models of a scene within its tolerances, as programs, and their reductions; raises `InputError`."""
    _refuse(machine, scene)
    search = _Search(machine, replace(scene, fold=ALL), trace, roundings, announce, progress)
    _refuse_unknown(search.full_models, scene.within, machine)
    try:
        if scene.within.keep is Keep.PARAMETERS:
            return search.without_parameters()
        full = search.full_models
        parts = [search.of(*pair) for pair in zip(full.models, full.package.functions, strict=True)]
    except KeyboardInterrupt:
        raise machine.error("scene, within", ENDED) from None
    reduced = replace(full, models=[part.model for part in parts])
    return reduced, search.reports(reduced, parts)


@dataclass(frozen=True)
class _ReducedProgram:
    """A reduced model; `subject` is that of its certificate if terms of its inverse model are omitted."""

    model: TracedModel
    reduction: Reduction
    subject: Subject | None = None


@dataclass(frozen=True)
class _Search:
    """The search for reduced models of a scene."""

    machine: DescribedMachine
    scene: Scene
    trace: Trace
    roundings: Sequence[Rounding]
    announce: Announce
    progress: Progress

    @cached_property
    def full_models(self) -> Traced:
        """The full models."""
        return self.trace(self.machine, self.scene)

    @property
    def is_proven(self) -> bool:
        """Whether errors are proven."""
        return self.scene.within.guaranteed is Evidence.PROVEN

    def of(self, model: TracedModel, function: Function) -> _ReducedProgram:
        """The program of a model without the terms that its tolerances allow to leave out; raises `InputError`."""
        full = self._full(self.full_models, model, function)
        required = self._requirements(self.full_models, full.subject, function)
        if self.scene.within.keep is Keep.INERTIA:
            return self._from_energies(full, required)
        other = self.is_proven and not self.scene.within.frequencies and can_be_solved(self.full_models, model)
        try:
            first = replace(required, most_unproven=1) if other else required
            reduction = reduce_program(full.program, full.subject.box.ranges, full.tolerances, first)
            if other and not reduction.left_out and reduction.unproven:
                solved = self._solved_exactly(full, required)
                if solved:
                    return solved
                reduction = reduce_program(full.program, full.subject.box.ranges, full.tolerances, required)
        except ValueError as error:
            raise self.machine.error("scene, within", f"{function.name}: {error}") from None
        return _ReducedProgram(replace(model, program=reduction.reduced), reduction)

    def without_parameters(self) -> tuple[Traced, list[ReducedModel]]:
        """The models of the machine with those parameters zero that its tolerance allows."""
        full = self.full_models
        if len(full.models) != 1:
            what = 'parameters are left out of one model at a time: ask for one, or keep = "terms"'
            raise self.machine.error("scene, keep", what)
        freed = with_free_numbers(self.machine, FREED, reserved_words())
        try:
            reduction = self._without_zeros(freed)
        except ValueError as error:
            raise self.machine.error("scene, within", str(error)) from None
        zero, program = {change.term for change in reduction.left_out}, full.models[0].program
        parameters = tuple(replace(p, value=ZERO) if p.name in zero else p for p in freed.parameters)
        reduced = self.trace(replace(freed, parameters=parameters), self.scene) if zero else full
        program_left = reduced.models[0].program
        if program_left.count.products + program_left.count.add >= program.count.products + program.count.add:
            same = replace(reduction, program=program, reduced=program, left_out=())
            return full, self.reports(full, [_ReducedProgram(full.models[0], same)])
        counted = replace(reduction, program=program, reduced=program_left)
        return reduced, self.reports(reduced, [_ReducedProgram(reduced.models[0], counted)])

    def reports(self, reduced: Traced, programs: Sequence[_ReducedProgram]) -> list[ReducedModel]:
        """The reductions of functions, with their errors in the box of the full ones."""
        full, physical, limits = self.full_models, _physical(self.machine), self.machine.limits
        reports = []
        for whole, function, program in zip(full.package.functions, reduced.package.functions, programs, strict=True):
            reduction = program.reduction
            full_subjects = [_subject(full, physical, limits, whole, x) for x in self.roundings]
            boxes = [_box_of_both(subject, function, full, limits) for subject in full_subjects]
            subjects = full_subjects
            if program.subject:
                subjects = [replace(program.subject, function=function, rounding=x) for x in self.roundings]
            elif reduction.left_out:
                pairs = zip(full_subjects, boxes, strict=True)
                subjects = [Subject(function, box, subject.rounding) for subject, box in pairs]  # pivots are others
            certificates = tuple(_total(_certificate(subject, full.whole.name), reduction) for subject in subjects)
            is_measured = reduction.left_out and full.machine.moves_by_motors
            lost = lost_structure(reduction.program, reduction.reduced, boxes[0]) if is_measured else None
            solved = bool(program.subject)
            reports.append(ReducedModel(function.name, self.scene.within, reduction, certificates, lost, solved))
            _refuse_rounding(reports[-1], reduced.whole)
        return reports

    def _full(self, traced: Traced, model: TracedModel, function: Function) -> FullModel:
        """A full model with its tolerances, and the function whose terms are searched, in exact arithmetic."""
        in_fixed = self.roundings[0] is FIXED_ROUNDING
        rounding = ROUNDINGS["double"] if in_fixed else self.roundings[0]
        subject = subject_of(traced, _physical(self.machine), self.machine.limits, function, rounding)
        subject = replace(subject, box=box_in_units(function, subject.box)) if in_fixed else subject
        tolerances = tolerances_of(subject, self.scene.within, self.machine)
        return FullModel(traced, model, subject, self.machine.limits, tolerances)

    def _requirements(self, traced: Traced, whole: Subject, function: Function) -> Requirements:
        """The requirements of a reduced model; rounding of `function` is reserved."""
        allowed = self.scene.within.frequencies
        return Requirements(
            names=_names(whole.function.program),
            positions=ARE_POSITIONS,
            confident=not self.is_proven,
            bound=self._prove(whole) if self.is_proven else None,
            frequencies=NaturalFrequencies(allowed, traced.machine.motor_entries) if allowed else None,
            reserved=_rounding_parts(self.full_models, self.machine, function, self.roundings),
            announce=self.announce,
        )

    def _prove(self, whole: Subject) -> ReducedErrors:
        return ReducedErrors(whole, self.progress)

    def _from_energies(self, full: FullModel, required: Requirements) -> _ReducedProgram:
        """Terms left out of the inertia matrix and the potential; raises `InputError`."""
        try:
            reduction = from_energies(full, required, self._prove if self.is_proven else None)
        except NoEnergyForm as error:
            raise self.machine.error("scene, keep", f"{Keep.INERTIA} {error}: choose another way") from None
        except ValueError as error:
            raise self.machine.error("scene, within", f"{full.subject.function.name}: {error}") from None
        return _ReducedProgram(replace(full.model, program=reduction.reduced), reduction)

    def _solved_exactly(self, full: FullModel, required: Requirements) -> _ReducedProgram | None:
        """Omit terms of the inverse model, and solve it exactly; None if none can be omitted, or nothing is proven."""
        solution = solved_direct(full, required, self._prove)
        if not solution or not solution[0].reduction.left_out:
            return None
        reduction = solution[0].reduction
        return _ReducedProgram(
            replace(full.model, model=in_form(DIRECT, INERTIA), program=reduction.reduced), reduction, solution[1]
        )

    def _without_zeros(self, freed: DescribedMachine) -> Reduction:
        """The program of a machine whose numbers are parameters, as many of them zero as its tolerance allows."""
        free = self.trace(freed, replace(self.scene, fold=()))
        (model,), (function,) = free.models, free.package.functions
        used = function.program.used
        values = {p.name: p.value.value() for p in freed.parameters if p.value is not None and p.name in used}
        inertia = self.trace(freed, replace(self.scene, models=("inertia_matrix",), outputs={}, fold=()))
        full = self._full(free, model, function)
        return without_parameters(
            full.program,
            {name: interval for name, interval in full.subject.box.ranges.items() if name not in values},
            full.tolerances,
            {name: x for name, x in values.items() if x},
            inertia.package.functions[0].program,
            self._requirements(free, full.subject, self.full_models.package.functions[0]),
        )


def _refuse(machine: Machine, scene: Scene) -> None:
    if scene.steps:
        raise machine.error("scene, within", "time steps are those of the whole model: leave out steps, or within")
    machine.refuse_missing_values("scene, within")


def _refuse_unknown(asked: Traced, within: Within, machine: Machine) -> None:
    """Raise `InputError` for a tolerance of what is neither a result nor a joint."""
    results = [result.name for function in asked.package.functions for result in function.results]
    names = [*dict.fromkeys(results), *(joint.name for joint in machine.joints), FREQUENCIES]
    for name in within.tolerances:
        if name != ALL_RESULTS and name not in names:
            what = f"no result or joint is called {quote(name)}{did_you_mean(name, names)}"
            raise machine.error("scene, within", what)
    if {*within.tolerances} == {FREQUENCIES}:
        what = 'they limit what results allow: give these a tolerance, too, as in { qdd = "1 %", frequencies = 2 }'
        raise machine.error(f"scene, within, {FREQUENCIES}", what)


def _physical(machine: DescribedMachine) -> Machine:
    return machine.origin.ungrouped or machine


def tolerances_of(whole: Subject, within: Within, machine: Machine) -> dict[str, list[Tolerance]]:
    """The tolerances of the entries by result: that of the joint, of the result, or of all; else zero."""
    exact = _certificate(replace(whole, rounding=ROUNDINGS["double"]), machine.name, most_sub_boxes=1)
    tolerances: dict[str, list[Tolerance]] = {result.name: [] for result in whole.function.results}
    for (name, entry), bound in zip(labels(whole.function), exact.entries, strict=True):
        tolerance = within.of(name, entry.partition(",")[0]) or Tolerance(0.0)
        tolerances[name].append(replace(tolerance, rounding=bound.likely if math.isfinite(bound.likely) else 0.0))
    return tolerances


def _names(program: Program) -> Names:
    """The names of the quantities of a program, and the order of its sections."""
    names = Names()
    for statement in (*program.once, *program.statements):
        names.reserve(statement.section)
        if statement.name in program.quantities:
            names.give(-statement.node if statement.negative else statement.node, statement.name, statement.section)
    return names


def _box_of_both(whole: Subject, function: Function, asked: Traced, limits: Limits) -> Box:
    """The box of a full function and of all other variables that its reduced one depends on.

    Derivatives of energies may have velocities that cancel in the equations of motion.
    """
    box, more = whole.box, function.program.used - whole.box.ranges.keys()
    if not more:
        return box
    box_of_more = box_of(asked.machine, limits, function.program.inputs, more)
    return Box({**box.ranges, **box_of_more.ranges}, box.positions | box_of_more.positions)


def _subject(asked: Traced, physical: Machine, limits: Limits, function: Function, rounding: Rounding) -> Subject:
    """The subject of the certificate of a full function."""
    if rounding is not FIXED_ROUNDING:
        return subject_of(asked, physical, limits, function, rounding)
    box = box_of(asked.machine, limits, function.program.inputs, function.program.used)
    return Subject(function, box_in_units(function, box), rounding)


def _certificate(subject: Subject, machine: str, most_sub_boxes: int = MOST_SUB_BOXES) -> Certificate:
    """The certificate of a function; raises `OverflowError` where it has no bounds in fixed point."""
    if subject.rounding is not FIXED_ROUNDING:
        return certificate_of(subject, machine, Effort(most_sub_boxes))
    own_box = subject.box.of(name for name in subject.box.ranges if name in subject.function.program.used)
    certificate, _ = in_fixed_point(subject.function, own_box, machine, most_sub_boxes)
    return replace(certificate, box=subject.box)


def _rounding_parts(
    asked: Traced, machine: DescribedMachine, function: Function, roundings: Sequence[Rounding]
) -> dict[str, list[float]]:
    """The parts of tolerances that low precisions need: the rounding errors of the full function."""
    parts: dict[str, list[float]] = {result.name: [] for result in function.results}
    coarse = [rounding for rounding in roundings if rounding is not ROUNDINGS["double"]]
    subjects = [_subject(asked, _physical(machine), machine.limits, function, rounding) for rounding in coarse]
    certificates = [_certificate(subject, machine.name, most_sub_boxes=1) for subject in subjects]
    for k, (name, _) in enumerate(labels(function)):
        errors = [certificate.entries[k].likely for certificate in certificates]
        parts[name].append(max((x for x in errors if math.isfinite(x)), default=0.0))
    return parts


def _total(certificate: Certificate, reduction: Reduction) -> Certificate:
    """The certificate of a reduced program with the errors from the whole one."""
    errors = {(error.output, error.index): error for error in reduction.errors}
    pairs = zip(reduction.program.outputs, reduction.reduced.outputs, strict=True)
    places = [
        (whole.name, k, whole.entries[k] is left.entries[k]) for whole, left in pairs for k in range(len(whole.entries))
    ]
    entries = [
        entry if same else _with_left_out(entry, errors.get((name, k)))
        for entry, (name, k, same) in zip(certificate.entries, places, strict=True)
    ]
    return replace(certificate, entries=tuple(entries))


def _with_left_out(entry: EntryBound, left_out: EntryError | None) -> EntryBound:
    """The rounding error of an entry plus its error by omitted terms."""
    if left_out is None:
        return entry
    proven = math.inf if left_out.bounded is None else left_out.bounded
    likely = min(proven, math.inf if left_out.confident is None else left_out.confident)
    return replace(entry, error=_up(entry.error + proven), likely=_up(entry.likely + likely))


def _up(x: float) -> float:
    return float(np.nextafter(x, np.inf)) if x else 0.0


SHARE_OF_ROUNDING = 1e-3
"""Of the tolerance: what rounding may add to it, as it does in double precision."""


def _refuse_rounding(model: ReducedModel, machine: Machine) -> None:
    """Raise `InputError` where errors by rounding and by omitted terms exceed the tolerance together."""
    errors = {(error.output, error.index): error for error in model.reduction.errors}
    names = [(output.name, k) for output in model.reduction.program.outputs for k in range(len(output.entries))]
    for certificate in model.certificates:
        for entry, place in zip(certificate.entries, names, strict=True):
            if place not in errors or errors[place].is_rounding or not errors[place].tolerance:
                continue
            allowed, is_proven = errors[place].tolerance, model.within.guaranteed is Evidence.PROVEN
            total = entry.error if is_proven else min(entry.error, entry.likely)
            if total == math.inf:
                what = f"nothing is proven of the rounding of {entry.name}[{entry.entry}] without the terms left out"
                raise machine.error("scene, within", f'{what}: choose guaranteed = "confident", or a smaller box')
            if total > allowed * (1 + SHARE_OF_ROUNDING):
                off = f"{entry.name}[{entry.entry}] would be {total:.2g} off in {certificate.precision} precision"
                is_double = certificate.precision == "double"
                way = f"give {entry.entry} a tolerance above it" if is_double else "choose a higher precision"
                raise machine.error("scene, within", f"{off}, {allowed:.2g} is allowed: {way}")


def models_in_fixed_point(
    machine: DescribedMachine, scene: Scene, trace: Trace, announce: Announce, progress: Progress
) -> tuple[Traced, list[ReducedModel]]:
    """The models as `reduced_models` gives them, with the errors of fixed point in the total; raises `InputError`."""
    traced = trace(machine, replace(scene, fold=ALL))
    for function in traced.package.functions:
        refuse_impossible(traced.machine, function)
    try:
        return reduced_models(machine, scene, trace, [FIXED_ROUNDING], progress, announce)
    except OverflowError as error:
        raise machine.error("--target c-fixed", str(error)) from None
