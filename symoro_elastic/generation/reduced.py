"""Models within tolerances: what results allow is left out of programs, and the code says what is left out.

Terms of a program are left out by `numerics/within`; errors are those from the whole model while joints are within
their limits, the rounding of the reduced program among them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symoro_elastic.codegen.package import Function
from symoro_elastic.foundation.progress import Announce, Progress, announce_nothing, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.generation.from_energies import NoEnergyForm, from_energies
from symoro_elastic.generation.solved_exactly import can_be_solved, solved_direct
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.freed import with_free_numbers
from symoro_elastic.machine.limits import Limits
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.names import did_you_mean, quote
from symoro_elastic.machine.scene import ALL, INERTIA, Scene
from symoro_elastic.machine.within import ALL_RESULTS, FREQUENCIES, Guaranteed, Keep, Tolerance, Within
from symoro_elastic.models.catalogue import TracedModel, in_form
from symoro_elastic.models.inertia_form import DIRECT
from symoro_elastic.models.packaging import reserved_words
from symoro_elastic.models.traced import Traced
from symoro_elastic.numerics.guarantees.box import LIMITED, POSITION, Box, box_of
from symoro_elastic.numerics.guarantees.certificate import MOST_SUB_BOXES, Certificate, EntryBound, Subject, labels
from symoro_elastic.numerics.guarantees.certificates import Certificates, Effort, certificate_of, subject_of
from symoro_elastic.numerics.guarantees.fixed_point import FIXED_ROUNDING, Total, in_fixed_point, refuse_impossible
from symoro_elastic.numerics.guarantees.of_reduced import ReducedErrors
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS, Rounding
from symoro_elastic.numerics.quantile_bound import CONFIDENCE, share_beyond
from symoro_elastic.numerics.within.frequencies import POSITIONS, NaturalFrequencies
from symoro_elastic.numerics.within.reduction import MOST_SEARCHES, MOST_UNPROVEN, reduce_program, without_parameters
from symoro_elastic.numerics.within.results import EntryError, Reduction
from symoro_elastic.numerics.within.structure import STATES, LostStructure, lost_structure
from symoro_elastic.symbolic.expression import is_constant
from symoro_elastic.symbolic.program import Names, Program

ARE_POSITIONS = tuple(name for name, quantity in LIMITED.items() if quantity == POSITION)
FREED = ("bodies", "motors")
"""Tables whose numbers may become zero."""
ENDED = "the search was ended before anything was found that keeps the tolerance: nothing is written"
Trace = Callable[[Machine, Scene], Traced]


@dataclass(frozen=True, repr=False)
class ReducedModel(Result):
    """A model within a tolerance: what was left out, and its errors; certificates have the total, rounding included.

    `lost` is what an inverse model has lost of its structure, where single terms were left out. A direct model is
    `solved` if they were left out of its inverse model, which is solved exactly.
    """

    model: str
    within: Within
    reduction: Reduction
    certificates: tuple[Certificate, ...]
    lost: LostStructure | None = None
    solved: bool = False

    @property
    def operations(self) -> tuple[int, int]:
        """Products, quotients and sums of a call: of the whole model, and of this one."""
        before, after = self.reduction.before, self.reduction.after
        return before.products + before.add, after.products + after.add

    @property
    def headline(self) -> str:
        """The model, and how much is left of it."""
        whole, left = self.operations
        tolerances = ", ".join(f"{name} {x}".strip() for name, x in self.within.tolerances.items())
        return f"{self.model} within {tolerances}: {left} of {whole} operations"


def reduced_models(
    machine: DescribedMachine,
    scene: Scene,
    trace: Trace,
    roundings: Sequence[Rounding],
    progress: Progress = no_progress,
    announce: Announce = announce_nothing,
) -> tuple[Traced, list[ReducedModel]]:
    """The models of a scene within its tolerances, as programs, and what was left out; raises `InputError`."""
    _refuse(machine, scene)
    scene = replace(scene, fold=ALL)
    asked = trace(machine, scene)
    _refuse_unknown(asked, scene.within, machine)
    if scene.within.keep is Keep.PARAMETERS:
        return _without_parameters(machine, scene, trace, asked, roundings, announce, progress)
    search = _Searched(asked, machine, scene.within, roundings, announce, progress)
    try:
        made = [search.of(*pair) for pair in zip(asked.models, asked.package.functions, strict=True)]
    except KeyboardInterrupt:
        raise machine.error("scene, within", ENDED) from None
    reduced = replace(asked, models=[one.model for one in made])
    return reduced, _reports(asked, reduced, made, scene.within, machine, roundings)


@dataclass(frozen=True)
class _Made:
    """A reduced model; `subject` is what a certificate needs of it if terms are left out of its inverse model."""

    model: TracedModel
    reduction: Reduction
    subject: Subject | None = None


@dataclass(frozen=True)
class _Searched:
    """Looks for what may be left out of the models of a scene."""

    asked: Traced
    machine: DescribedMachine
    within: Within
    roundings: Sequence[Rounding]
    announce: Announce
    progress: Progress

    def of(self, model: TracedModel, function: Function) -> _Made:
        """The program of a model without the terms that its tolerances allow to leave out; raises `InputError`."""
        whole = subject_of(
            self.asked, _physical(self.machine), self.machine.limits, function, _of_search(self.roundings)
        )
        is_proven = self.within.guaranteed is Guaranteed.PROVEN
        if self.within.keep is Keep.INERTIA:
            return self._from_energies(model, whole, is_proven)
        other = is_proven and not self.within.frequencies and can_be_solved(self.asked, model)
        try:
            found = self._reduced(whole, is_proven, 1 if other else MOST_UNPROVEN)
            if other and not found.left_out and found.unproven:
                solved = self._solved(model, whole)
                if solved:
                    return solved
                found = self._reduced(whole, is_proven, MOST_UNPROVEN)
        except ValueError as error:
            raise self.machine.error("scene, within", f"{function.name}: {error}") from None
        return _Made(replace(model, program=found.reduced), found)

    def _reduced(self, whole: Subject, is_proven: bool, most_unproven: int) -> Reduction:
        """Terms left out of the program as it is."""
        program = whole.function.program
        return reduce_program(
            program,
            whole.box.ranges,
            tolerances_of(whole.function, self.within),
            names=_names(program),
            positions=ARE_POSITIONS,
            confident=not is_proven,
            bound=ReducedErrors(whole, self.progress) if is_proven else None,
            frequencies=_frequencies(self.asked, self.within),
            reserved=_reserved(self.asked, self.machine, whole.function, self.roundings),
            watched=self.announce,
            most_unproven=most_unproven,
        )

    def _from_energies(self, model: TracedModel, whole: Subject, is_proven: bool) -> _Made:
        """Terms left out of the inertia matrix and the potential; raises `InputError`."""
        try:
            found = from_energies(
                self.asked,
                model,
                whole,
                self.machine.limits,
                tolerances_of(whole.function, self.within),
                positions=ARE_POSITIONS,
                proven=is_proven,
                frequencies=_frequencies(self.asked, self.within),
                reserved=_reserved(self.asked, self.machine, whole.function, self.roundings),
                announce=self.announce,
                progress=self.progress,
            )
        except NoEnergyForm as error:
            raise self.machine.error("scene, keep", f"{Keep.INERTIA} {error}: choose another way") from None
        except ValueError as error:
            raise self.machine.error("scene, within", f"{whole.function.name}: {error}") from None
        return _Made(replace(model, program=found.reduced), found)

    def _solved(self, model: TracedModel, whole: Subject) -> _Made | None:
        """Terms left out of the inverse model, which is solved exactly; None where nothing is proven of that, too."""
        tolerances = tolerances_of(whole.function, self.within)
        found = solved_direct(
            self.asked, model, whole, self.machine.limits, tolerances, ARE_POSITIONS, self.announce, self.progress
        )
        if not found or not found[0].reduction.left_out:
            return None
        reduction = found[0].reduction
        return _Made(replace(model, model=in_form(DIRECT, INERTIA), program=reduction.reduced), reduction, found[1])


def _refuse(machine: Machine, scene: Scene) -> None:
    if scene.steps:
        raise machine.error("scene, within", "time steps are those of the whole model: leave out steps, or within")
    missing = [parameter.name for parameter in machine.parameters if parameter.value is None]
    if missing:
        what = f"{missing[0]} has no value: what may be left out depends on the values of all parameters"
        raise machine.error("scene, within", what)


def _refuse_unknown(asked: Traced, within: Within, machine: Machine) -> None:
    """Raise `InputError` for a tolerance of what is neither a result nor a joint."""
    results = [result.name for function in asked.package.functions for result in function.results]
    known = [*dict.fromkeys(results), *(joint.name for joint in machine.joints), FREQUENCIES]
    for name in within.tolerances:
        if name != ALL_RESULTS and name not in known:
            what = f"there is no result or joint {quote(name)}{did_you_mean(name, known)}"
            raise machine.error("scene, within", what)
    if {*within.tolerances} == {FREQUENCIES}:
        what = 'they limit what results allow: give these a tolerance, too, as in { qdd = "1 %", frequencies = 2 }'
        raise machine.error(f"scene, within, {FREQUENCIES}", what)


def _frequencies(asked: Traced, within: Within) -> NaturalFrequencies | None:
    """What is asked of natural frequencies."""
    return NaturalFrequencies(within.frequencies, asked.machine.motor_entries) if within.frequencies else None


def _physical(machine: DescribedMachine) -> Machine:
    return machine.origin.ungrouped or machine


def tolerances_of(function: Function, within: Within) -> dict[str, list[Tolerance]]:
    """The tolerance of each entry of each result: that of its joint, of the result, or of all; else none."""
    found: dict[str, list[Tolerance]] = {result.name: [] for result in function.results}
    for name, entry in labels(function):
        found[name].append(within.of(name, entry.partition(",")[0]) or Tolerance(0.0))
    return found


def _names(program: Program) -> Names:
    """The names of the quantities of a program, and the order of its sections."""
    names = Names()
    for statement in (*program.once, *program.statements):
        names.reserve(statement.section)
        if statement.name in program.quantities:
            names.give(-statement.node if statement.negative else statement.node, statement.name, statement.section)
    return names


def _reports(
    asked: Traced,
    reduced: Traced,
    made: Sequence[_Made],
    within: Within,
    machine: DescribedMachine,
    roundings: Sequence[Rounding],
) -> list[ReducedModel]:
    """What was left out of each function, and its errors in the box of the whole one."""
    found, physical, limits = [], _physical(machine), machine.limits
    for whole, function, one in zip(asked.package.functions, reduced.package.functions, made, strict=True):
        reduction = one.reduction
        wholes = [_subject(asked, physical, limits, whole, rounding) for rounding in roundings]
        boxes = [_box_of_both(each, function, asked, limits) for each in wholes]
        subjects = wholes
        if one.subject:
            subjects = [replace(one.subject, function=function, rounding=rounding) for rounding in roundings]
        elif reduction.left_out:
            pairs = zip(wholes, boxes, strict=True)
            subjects = [Subject(function, box, each.rounding) for each, box in pairs]  # pivots are others
        certificates = tuple(_total(_certificate(each, asked.whole.name), reduction) for each in subjects)
        is_measured = reduction.left_out and asked.machine.moves_by_motors
        lost = lost_structure(reduction.program, reduction.reduced, boxes[0]) if is_measured else None
        found.append(ReducedModel(function.name, within, reduction, certificates, lost, bool(one.subject)))
        _refuse_rounding(found[-1], reduced.whole)
    return found


def _box_of_both(whole: Subject, function: Function, asked: Traced, limits: Limits) -> Box:
    """The box of a whole function, and of what its reduced one depends on beside that.

    Derivatives of energies may have velocities that cancel in the equations of motion.
    """
    box, more = whole.box, function.program.used - whole.box.ranges.keys()
    if not more:
        return box
    found = box_of(asked.machine, limits, function.program.inputs, more)
    return Box({**box.ranges, **found.ranges}, box.positions | found.positions)


def _subject(asked: Traced, physical: Machine, limits: Limits, function: Function, rounding: Rounding) -> Subject:
    """What a certificate of a whole function is made of."""
    if rounding is not FIXED_ROUNDING:
        return subject_of(asked, physical, limits, function, rounding)
    return Subject(function, box_of(asked.machine, limits, function.program.inputs, function.program.used), rounding)


def _certificate(subject: Subject, machine: str, most_sub_boxes: int = MOST_SUB_BOXES) -> Certificate:
    """What a function guarantees; raises `OverflowError` for one that has no bounds in fixed point."""
    if subject.rounding is not FIXED_ROUNDING:
        return certificate_of(subject, machine, Effort(most_sub_boxes))
    own = subject.box.of(name for name in subject.box.ranges if name in subject.function.program.used)
    found, _ = in_fixed_point(subject.function, own, machine, most_sub_boxes)
    return replace(found, box=subject.box)


def _of_search(roundings: Sequence[Rounding]) -> Rounding:
    """The rounding in which terms are searched, which are left out in exact arithmetic."""
    return ROUNDINGS["double"] if roundings[0] is FIXED_ROUNDING else roundings[0]


def _reserved(
    asked: Traced, machine: DescribedMachine, function: Function, roundings: Sequence[Rounding]
) -> dict[str, list[float]]:
    """The part of each tolerance that low precisions need: the rounding errors of the whole function."""
    found: dict[str, list[float]] = {result.name: [] for result in function.results}
    coarse = [rounding for rounding in roundings if rounding is not ROUNDINGS["double"]]
    subjects = [_subject(asked, _physical(machine), machine.limits, function, rounding) for rounding in coarse]
    certificates = [_certificate(each, machine.name, most_sub_boxes=1) for each in subjects]
    for k, (name, _) in enumerate(labels(function)):
        errors = [one.entries[k].likely for one in certificates]
        found[name].append(max((x for x in errors if math.isfinite(x)), default=0.0))
    return found


def _total(certificate: Certificate, reduction: Reduction) -> Certificate:
    """The certificate of a reduced program with the errors from the whole one."""
    errors = {(one.output, one.index): one for one in reduction.errors}
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
    """The rounding error of an entry, and what terms left out add to it."""
    if left_out is None:
        return entry
    proven = math.inf if left_out.bounded is None else left_out.bounded
    likely = min(proven, math.inf if left_out.confident is None else left_out.confident)
    return replace(entry, error=_up(entry.error + proven), likely=_up(entry.likely + likely))


def _up(x: float) -> float:
    return float(np.nextafter(x, np.inf)) if x else 0.0


SHARE_OF_ROUNDING = 1e-3
"""Of the tolerance: what rounding may add to it, as it does in double precision."""


def _refuse_rounding(one: ReducedModel, machine: Machine) -> None:
    """Raise `InputError` where rounding and what is left out are more than the tolerance together."""
    errors = {(error.output, error.index): error for error in one.reduction.errors}
    names = [(output.name, k) for output in one.reduction.program.outputs for k in range(len(output.entries))]
    for certificate in one.certificates:
        for entry, place in zip(certificate.entries, names, strict=True):
            allowed = errors[place].tolerance if place in errors else math.inf
            is_proven = one.within.guaranteed is Guaranteed.PROVEN
            total = entry.error if is_proven else min(entry.error, entry.likely)
            if allowed and total == math.inf:
                what = f"nothing is proven of the rounding of {entry.name}[{entry.entry}] without the terms left out"
                raise machine.error("scene, within", f'{what}: choose guaranteed = "confident", or a smaller box')
            if allowed and total > allowed * (1 + SHARE_OF_ROUNDING):
                off = f"{entry.name}[{entry.entry}] would be {total:.2g} off in {certificate.precision} precision"
                raise machine.error("scene, within", f"{off}, {allowed:.2g} is allowed: choose a higher precision")


def _without_parameters(
    machine: DescribedMachine,
    scene: Scene,
    trace: Trace,
    asked: Traced,
    roundings: Sequence[Rounding],
    announce: Announce,
    progress: Progress,
) -> tuple[Traced, list[ReducedModel]]:
    """The models of the machine with those parameters zero that its tolerance allows."""
    if len(asked.models) != 1:
        what = 'parameters are left out of one model at a time: ask for one, or keep = "terms"'
        raise machine.error("scene, keep", what)
    freed = with_free_numbers(machine, FREED, reserved_words())
    try:
        reduction = _without_zeros(machine, freed, scene, trace, asked, roundings, announce, progress)
    except KeyboardInterrupt:
        raise machine.error("scene, within", ENDED) from None
    except ValueError as error:
        raise machine.error("scene, within", str(error)) from None
    zero = {one.term for one in reduction.left_out}
    if not zero:
        same = replace(reduction, program=asked.models[0].program, reduced=asked.models[0].program)
        return asked, _reports(asked, asked, [_Made(asked.models[0], same)], scene.within, machine, roundings)
    parameters = tuple(replace(p, value=ZERO) if p.name in zero else p for p in freed.parameters)
    reduced = trace(replace(freed, parameters=parameters), scene)
    counted = replace(reduction, program=asked.models[0].program, reduced=reduced.models[0].program)
    return reduced, _reports(asked, reduced, [_Made(reduced.models[0], counted)], scene.within, machine, roundings)


def _without_zeros(
    machine: DescribedMachine,
    freed: DescribedMachine,
    scene: Scene,
    trace: Trace,
    asked: Traced,
    roundings: Sequence[Rounding],
    announce: Announce,
    progress: Progress,
) -> Reduction:
    """The program of a machine whose numbers are parameters, without as many of these as its tolerance allows."""
    free = trace(freed, replace(scene, fold=()))
    (function,) = free.package.functions
    used = function.program.used
    values = {p.name: p.value.value() for p in freed.parameters if p.value is not None and p.name in used}
    inertia = trace(freed, replace(scene, models=("inertia_matrix",), outputs={}, fold=()))
    whole = subject_of(free, _physical(machine), machine.limits, function, _of_search(roundings))
    bound = ReducedErrors(whole, progress) if scene.within.guaranteed is Guaranteed.PROVEN else None
    return without_parameters(
        function.program,
        {name: found for name, found in whole.box.ranges.items() if name not in values},
        tolerances_of(function, scene.within),
        {name: x for name, x in values.items() if x},
        inertia=inertia.package.functions[0].program,
        names=_names(function.program),
        positions=ARE_POSITIONS,
        confident=bound is None,
        bound=bound,
        frequencies=_frequencies(free, scene.within),
        reserved=_reserved(asked, machine, asked.package.functions[0], roundings),
        watched=announce,
    )


def models_in_fixed_point(
    machine: DescribedMachine, scene: Scene, trace: Trace, announce: Announce, progress: Progress
) -> tuple[Traced, list[ReducedModel]]:
    """The models as `reduced_models` gives them, with the errors of fixed point in the total; raises `InputError`."""
    asked = trace(machine, replace(scene, fold=ALL))
    for function in asked.package.functions:
        refuse_impossible(asked.machine, function)
    try:
        return reduced_models(machine, scene, trace, [FIXED_ROUNDING], progress, announce)
    except OverflowError as error:
        raise machine.error("--target c-fixed", str(error)) from None


def fixed_totals(found: Sequence[ReducedModel]) -> dict[str, Total]:
    """Remarks on functions in fixed point that have terms left out."""
    return {one.model: (one.certificates[0], said(one)) for one in found}


def certificates_of(found: Sequence[ReducedModel], machine: str) -> Certificates:
    """The certificates of reduced models, with the errors from the whole ones."""
    return Certificates(machine, tuple(each for one in found for each in one.certificates))


PASSIVE = "The inertia matrix stays symmetric and positive definite, and nothing is made from nothing"
KEPT = {
    Keep.PARAMETERS: f"{PASSIVE}: this is the whole model of another machine.",
    Keep.INERTIA: f"{PASSIVE}: all forces of inertia and gravity are derivatives of the energies that are left.",
}
"""What is kept of the structure."""


def _constant(one: ReducedModel) -> str:
    """Return which entries of results no longer depend on the state, in words."""
    pairs = zip(one.reduction.program.outputs, one.reduction.reduced.outputs, strict=True)
    entries = [(x, y) for whole, left in pairs for x, y in zip(whole.entries, left.entries, strict=True)]
    named = zip(one.certificates[0].entries, entries, strict=True)
    lost = [f"{bound.name}[{bound.entry}]" for bound, (x, y) in named if is_constant(y) and not is_constant(x)]
    return ", ".join(lost)


def said(one: ReducedModel) -> str:
    """What is left out of a model, and how, in sentences."""
    reduction, changes = one.reduction, len(one.reduction.left_out)
    kept = "whole parameters" if one.within.keep is Keep.PARAMETERS else "terms"
    of = " of its inverse model, which is solved exactly" if one.solved else ""
    of = " of the inertia matrix and the potential" if one.within.keep is Keep.INERTIA else of
    sentences = [
        f"{one.headline}; {changes} {kept if changes != 1 else kept.removesuffix('s')} left out{of}.",
        "Errors are those from the whole model, rounding among them.",
    ]
    if constant := _constant(one):
        sentences.append(f"Nothing but a constant is left of {constant}.")
    if changes and one.within.guaranteed is Guaranteed.CONFIDENT:
        beyond = math.ceil(1e6 * share_beyond(reduction.states, MOST_SEARCHES))
        sentences.append(
            f"With {CONFIDENCE:.0%} confidence what is left out makes larger ones at most at {beyond} of a million "
            "drawn states, whatever the distribution."
        )
    if not changes and reduction.unproven:
        sentences.append(f"It stays whole: {reduction.unproven}.")
    if reduction.shift is not None and one.within.frequencies:
        allowed = one.within.frequencies
        most = allowed.value * reduction.shift
        shift = f"{100 * most:.2g} %" if allowed.relative else f"{most:.2g} Hz"
        share = 1 - share_beyond(POSITIONS, MOST_SEARCHES)
        sentences.append(
            f"Natural frequencies shift by at most {shift} at {POSITIONS} drawn positions; with {CONFIDENCE:.0%} "
            f"confidence at {share:.1%} of all, and by the tail of the shifts at as many more."
        )
    if reduction.ended:
        sentences.append("The search was ended by hand.")
    if changes and (structure := KEPT.get(one.within.keep)):
        sentences.append(structure)
    if one.lost is not None:
        lost = one.lost
        asymmetry, power = f"{lost.asymmetry:.1g}", f"{lost.power:.2g} of {lost.largest_power:.2g} W"
        sentences.append(
            f"Measured at {STATES} drawn states: asymmetry {asymmetry} of the largest entry, {power}."
            if one.within.keep in KEPT
            else f"The inertia matrix is asymmetric by {asymmetry} of its largest entry, and up to {power} are made "
            f"from nothing, at {STATES} drawn states."
        )
    return " ".join(sentences)
