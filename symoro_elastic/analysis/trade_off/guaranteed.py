"""Operations of a call against guaranteed error: terms left out, precision and form on one path.

The tolerance of a result is one budget. A point of the grid is a program: a form of the model, terms omitted for a
share of the tolerance, a precision. Its error is the sum of two, both with their evidence: of rounding, by a
certificate of the very program, and of the omitted terms. From the full model in double precision the path goes to the
point that saves the most time for the error that it adds, as long as the sum is within the tolerance. Time is counted
in operations; the ratio of precisions is that of measured calls of the full model.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

from symoro_elastic.analysis.trade_off.configurations import Measurement
from symoro_elastic.codegen.package import Function
from symoro_elastic.codegen.precision import DOUBLE, MIXED, SINGLE
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.generation.reduced_models.search import reduced_models
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.scene import ALL, AUTO, INERTIA, RECURSION, Scene
from symoro_elastic.machine.within import Evidence
from symoro_elastic.models.packaging import Traced
from symoro_elastic.models.programs.catalogue import BY_INERTIA, DEFAULT_MODELS
from symoro_elastic.numerics.guarantees.certificate import Certificate, Subject
from symoro_elastic.numerics.guarantees.certificates import certificate_of, subject_of
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS
from symoro_elastic.numerics.within.budget import Error, Item, spend
from symoro_elastic.numerics.within.results import EntryError, Reduction
from symoro_elastic.symbolic.program import OperationCount

SHARES = (0.1, 0.3, 0.98)
"""Fractions of the tolerance for omitted terms; the last leaves some for rounding."""
PRECISIONS = (DOUBLE, MIXED, SINGLE)
SINE = 8
"""Operations that a sine and cosine count for, as in the search for terms."""
Entry = tuple[str, int]
Measured = Mapping[str, Sequence[Measurement]]
"""By model."""


@dataclass(frozen=True)
class GuaranteedPoint:
    """A program in a precision: its operations, and the two parts of its error.

    `share` is that of the tolerance which terms may take, `left_out` counts them; `unseen` is the largest error of
    these at a million states that no search has seen, of the tolerance. `time` is that of as many operations in double
    precision.
    """

    form: str
    precision: str
    share: float
    left_out: int
    operations: OperationCount
    rounding: Error
    terms: Error
    unseen: float
    time: float

    @property
    def total(self) -> float:
        """Sum of both errors relative to the tolerance, an upper bound of the error of both together."""
        return self.rounding.value + self.terms.value


@dataclass(frozen=True, repr=False)
class GuaranteedCurve(Result):
    """The points of a model, and the path through them: indices from the full model to the advised one."""

    model: str
    within: str
    points: tuple[GuaranteedPoint, ...]
    path: tuple[int, ...]

    @property
    def advised(self) -> GuaranteedPoint:
        """The advised program, the last point of the path."""
        return self.points[self.path[-1]]

    @property
    def saved(self) -> float:
        """The fraction of the time of the full model in double precision that the advised program saves."""
        return 1 - self.advised.time / self.points[0].time

    @property
    def headline(self) -> str:
        """Model, tolerance, and what is saved."""
        return f"{self.model} within {self.within}: {len(self.path)} steps, {self.saved:.0%} less time"


def grids_of(machine: DescribedMachine, scene: Scene, progress: Progress = no_progress) -> tuple[Grid, ...]:
    """Return the reduced programs of a scene within its tolerances, by recursion and by inertia matrix if faster."""
    scene = replace(scene, models=scene.models or DEFAULT_MODELS, fold=ALL, steps=())
    scene = replace(scene, form=RECURSION) if scene.form == AUTO else scene
    forms = [scene.form, *([INERTIA] if scene.form != INERTIA and _has_forms(machine, scene) else [])]
    grids = tuple(Grid(machine, replace(scene, form=form)) for form in forms)
    for done, (grid, share) in enumerate(product(grids, SHARES), 1):
        grid.add(share)
        progress(done, len(grids) * len(SHARES))
    return grids


def curves_of(grids: Sequence[Grid], measured: Measured) -> tuple[GuaranteedCurve, ...]:
    """Return the curves by model; `measured` are times of calls of the full models."""
    by_model: dict[str, list[GuaranteedPoint]] = {}
    for grid in grids:
        for model, points in grid.points(measured).items():
            by_model.setdefault(model, []).extend(points)
    within = ", ".join(f"{name} {x}".strip() for name, x in grids[0].scene.within.tolerances.items())
    return tuple(GuaranteedCurve(model, within, tuple(x), path_through(x)) for model, x in by_model.items())


def path_through(points: Sequence[GuaranteedPoint]) -> tuple[int, ...]:
    """Return the greedy path from the first point: at each step the most time saved per error, within tolerance.

    What adds no error comes first, the fastest first. The sum of a step is that of the step before where it is less.
    """
    totals = {0: points[0].total}

    def items(k: int) -> Iterator[Item[int]]:
        for following, point in enumerate(points):
            if point.time < points[k].time and point.total <= 1:
                yield Item(following, points[k].time - point.time, max(point.total - totals[k], 0.0))

    def accept(before: int, k: int) -> int:
        totals[k] = max(totals[before], points[k].total)
        return k

    return (0, *spend(0, items, accept))


def _has_forms(machine: DescribedMachine, scene: Scene) -> bool:
    """Whether a model of the scene needs less time by the inertia matrix than by its recursion."""
    if not BY_INERTIA.keys() & {*scene.models}:
        return False
    scenes = [replace(scene, form=form, models=tuple(BY_INERTIA), outputs={}) for form in (scene.form, INERTIA)]
    recursion, inertia = (programs(machine, x).package.functions[0].program.count for x in scenes)
    return _time(inertia) < _time(recursion)


def _time(count: OperationCount) -> int:
    return count.products + count.add + SINE * count.sincos


@dataclass(frozen=True)
class Reduced:
    """A function of a package, with terms omitted within a fraction of the tolerances."""

    asked: Traced
    function: Function
    share: float = 0.0
    reduction: Reduction | None = None


class Grid:
    """The points of all models in one formulation; `programs` by model, the full one first."""

    def __init__(self, machine: DescribedMachine, scene: Scene) -> None:
        self.machine, self.scene = machine, scene
        self._whole = programs(machine, replace(scene, within=replace(scene.within, tolerances={})))
        self.programs: dict[str, list[Reduced]] = {}
        self._allowed: dict[str, dict[Entry, float]] = {}
        for function in self._whole.package.functions:
            self.programs[function.name] = [Reduced(self._whole, function)]

    def add(self, share: float) -> None:
        """Add programs with terms omitted within a fraction of the tolerances."""
        within = self.scene.within
        less = {name: replace(x, value=share * x.value) for name, x in within.tolerances.items()}
        request = replace(self.scene, within=replace(within, tolerances=less))
        reduced, models = reduced_models(self.machine, request, programs, [ROUNDINGS[DOUBLE.name]])
        for function, model in zip(reduced.package.functions, models, strict=True):
            limited = [x for x in model.reduction.errors if x.tolerance and not x.is_rounding]
            self._allowed[function.name] = {(x.output, x.index): x.tolerance / share for x in limited}
            if model.reduction.left_out:
                self.programs[function.name].append(Reduced(reduced, function, share, model.reduction))

    def points(self, measured: Measured) -> dict[str, list[GuaranteedPoint]]:
        """Return the points by model, the full model in double precision first."""
        return {
            name: [
                self._point(program, precision.name, _ratio(measured.get(name, ()), precision.name))
                for program in some
                for precision in PRECISIONS
            ]
            for name, some in self.programs.items()
        }

    def _point(self, reduced: Reduced, precision: str, ratio: float) -> GuaranteedPoint:
        allowed = self._allowed[reduced.function.name]
        errors = {(x.output, x.index): x for x in reduced.reduction.errors} if reduced.reduction else {}
        count = reduced.function.program.count
        left_out = len(reduced.reduction.left_out) if reduced.reduction else 0
        unseen = max((errors[place].unseen / allowed[place] for place in errors if place in allowed), default=0.0)
        terms = _of_terms(errors, allowed, self.scene.within.guaranteed)
        rounding = _of_rounding(self.certificate(reduced, precision), reduced.function, allowed)
        program = (self.scene.form, precision, reduced.share, left_out, count)
        return GuaranteedPoint(*program, rounding, terms, unseen, _time(count) * ratio)

    def certificate(self, program: Reduced, precision: str) -> Certificate:
        """Return the certificate of rounding of a program; for a reduced program it has no bounds on pivots."""
        physical = self.machine.origin.ungrouped or self.machine
        full = next(x for x in self._whole.package.functions if x.name == program.function.name)
        subject = subject_of(self._whole, physical, self.machine.limits, full, ROUNDINGS[precision])
        reduced = subject if program.reduction is None else Subject(program.function, subject.box, ROUNDINGS[precision])
        return certificate_of(reduced, program.asked.whole.name)


def _ratio(measured: Sequence[Measurement], precision: str) -> float:
    """Return the time of the fastest compiled call in a precision relative to double; 1 without measurements."""
    times: dict[str, list[float]] = {DOUBLE.name: [], precision: []}
    for x in measured:
        if x.configuration.build is not None and x.configuration.is_safe:
            times.setdefault(x.configuration.precision.name, []).append(x.ns)
    ratio = min(times[precision], default=math.nan) / min(times[DOUBLE.name], default=math.nan)
    return ratio if math.isfinite(ratio) else 1.0


def _of_terms(errors: Mapping[Entry, EntryError], allowed: Mapping[Entry, float], guaranteed: Evidence) -> Error:
    """The largest error of omitted terms relative to the tolerances, proven or confident as required."""
    if not errors:
        return Error(0.0, Evidence.PROVEN)
    proven = guaranteed is Evidence.PROVEN
    bounds = {place: x.bounded if proven else x.confident for place, x in errors.items() if place in allowed}
    largest = max((math.inf if x is None else x / allowed[place] for place, x in bounds.items()), default=0.0)
    word = Evidence.PROVEN if proven else Evidence.CONFIDENT
    return Error(largest, word if math.isfinite(largest) else Evidence.NONE)


def _of_rounding(certificate: Certificate, function: Function, allowed: Mapping[Entry, float]) -> Error:
    """The largest rounding error relative to the tolerances: proven if within them, else confident from samples."""
    places = [(output.name, k) for output in function.program.outputs for k in range(len(output.entries))]
    pairs = [(x, allowed[place]) for x, place in zip(certificate.entries, places, strict=True) if place in allowed]
    proven = max((entry.error / most for entry, most in pairs), default=0.0)
    likely = max((entry.likely / most for entry, most in pairs), default=0.0)
    if proven <= 1:
        return Error(proven, Evidence.PROVEN)
    return Error(likely, Evidence.CONFIDENT if math.isfinite(likely) else Evidence.NONE)
