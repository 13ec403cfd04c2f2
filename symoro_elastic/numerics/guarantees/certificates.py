"""The certificates of the models that a scene asks of a machine, in some precisions.

Errors and ranges are the smaller ones by intervals and, on request, by polynomials.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from symoro_elastic.codegen.compile import TYPES
from symoro_elastic.codegen.package import Function
from symoro_elastic.codegen.precision import PRECISIONS
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.limits import Limits
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.models.packaging import Traced
from symoro_elastic.models.programs.linear_system import linear_system
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.guarantees.box import Box, box_of, parameter_box
from symoro_elastic.numerics.guarantees.certificate import MOST_SUB_BOXES, Certificate, EntryBound, Subject, certify
from symoro_elastic.numerics.guarantees.largest_value import WORK, largest
from symoro_elastic.numerics.guarantees.linear_solver import Solver, by_rotors
from symoro_elastic.numerics.guarantees.pivots import PivotKnowledge, own_inertias
from symoro_elastic.numerics.guarantees.polynomial_rounding import rounding_bound
from symoro_elastic.numerics.guarantees.running_error import Rounding
from symoro_elastic.symbolic.arithmetic import evaluate
from symoro_elastic.symbolic.expression import Expression, Operand

LARGEST = 1e300
"""Placeholder of infinite bounds where certificates are compared."""
DRAWN = 500
"""Number of random states from which the middle of a range is estimated."""


@dataclass(frozen=True)
class Effort:
    """Effort of certification: maximum number of sub-boxes, seed of random states, report of progress.

    With `polynomials` errors and ranges of polynomial results (inverse models, inertia matrices) are also proven by
    their coefficients: up to half a minute for six joints.
    """

    most_sub_boxes: int = MOST_SUB_BOXES
    seed: int = 0
    progress: Progress = no_progress
    polynomials: bool = False


@dataclass(frozen=True, repr=False)
class Certificates(Result):
    """Certificates of the models of a machine, by model and precision."""

    machine: str
    certificates: tuple[Certificate, ...]

    @property
    def headline(self) -> str:
        """Machine and models, as text."""
        models = dict.fromkeys(certificate.model for certificate in self.certificates)
        return f"Certificates of {self.machine}: {', '.join(models)}"

    @property
    def doubt(self) -> tuple[int, float]:
        """Number of entries without proven error, and mean logarithm of confident errors: lower is better."""
        entries = [entry for certificate in self.certificates for entry in certificate.entries]
        likely = [min(entry.likely, LARGEST) for entry in entries if entry.likely > 0]
        unproven = sum(not math.isfinite(entry.error) for entry in entries)
        return unproven, sum(map(math.log, likely)) / max(1, len(likely))

    def of(self, model: str) -> tuple[Certificate, ...]:
        """The certificates of a model, by precision."""
        return tuple(certificate for certificate in self.certificates if certificate.model == model)


def certify_models(
    traced: Traced, physical: Machine, limits: Limits, roundings: Sequence[Rounding], effort: Effort = Effort()
) -> Certificates:
    """The certificates of the models of a scene within the limits of the machine; raises `InputError`.

    `physical` is the machine with parameters of bodies, from which those of the models may be grouped.
    """
    functions = traced.package.functions
    certificates = [
        certificate_of(subject_of(traced, physical, limits, function, rounding), traced.whole.name, effort)
        for function in functions
        for rounding in roundings
    ]
    return Certificates(traced.whole.name, tuple(certificates))


def subject_of(
    traced: Traced, physical: Machine | None, limits: Limits, function: Function, rounding: Rounding
) -> Subject:
    """A function with its box and bounds of its pivots from the bodies of a machine; raises `InputError`.

    Pivots have bounds only with a `physical` machine; reduced programs have none, as their pivots differ.
    """
    arrays = TYPES[PRECISIONS[rounding.name].state]
    box = box_of(traced.machine, limits, function.program.inputs, function.program.used).rounded(arrays)
    if physical is None:
        return Subject(function, box, rounding)
    parameters = parameter_box(physical, limits)
    knowledge = PivotKnowledge(traced, physical, parameters, function)
    return Subject(function, box, rounding, knowledge, _solver(traced, physical, parameters, function, box))


def _solver(traced: Traced, physical: Machine, parameters: Box, function: Function, box: Box) -> Solver | None:
    """The error bounds of the linear system that a direct model solves; None for other models."""
    system = linear_system(traced.machine, function.program)
    if system is None:
        return None
    rotors = own_inertias(restrict(physical, traced.scene), parameters.whole, ())
    return Solver(system, box, by_rotors(rotors, system.joints))


def certificate_of(subject: Subject, machine: str = "", effort: Effort = Effort()) -> Certificate:
    """The certificate of a subject."""
    if effort.polynomials and subject.solver:
        subject = replace(subject, solver=replace(subject.solver, polynomials=True))
    certificate = certify(subject, machine, effort.most_sub_boxes, effort.seed, effort.progress)
    return by_polynomials(certificate, subject, effort.progress) if effort.polynomials else certificate


def by_polynomials(certificate: Certificate, subject: Subject, progress: Progress = no_progress) -> Certificate:
    """Return the certificate of a subject with the errors and ranges that polynomials prove, where these are smaller.

    Other results, as those of direct models, are unchanged. `progress` is called after every result.
    """
    subject = subject.as_printed()
    entries: list[EntryBound] = []
    proven: dict[int, tuple[float, float, float]] = {}
    for k, (entry, x) in enumerate(zip(certificate.entries, subject.results, strict=True)):
        if type(x) is Expression:
            if x.positive.id not in proven:
                proven[x.positive.id] = _proven(x.positive, subject)
            entry = _smaller(entry, proven[x.positive.id], x is not x.positive)  # noqa: PLW2901
        entries.append(entry)
        progress(k + 1, len(certificate.entries))
    return replace(certificate, entries=tuple(entries))


def _proven(x: Operand, subject: Subject) -> tuple[float, float, float]:
    """Return error and range of an expression by polynomials; infinite if it is not a polynomial."""
    error = rounding_bound(x, subject.box, subject.rounding).bound
    if not math.isfinite(error):
        return math.inf, -math.inf, math.inf
    values = evaluate([x], subject.box.states(DRAWN, np.random.default_rng(0)), arithmetic(np.float64))(x)
    middle = float(np.min(values) / 2 + np.max(values) / 2)
    half = largest((x, Fraction(middle)), subject.box, work=WORK).bound
    return error, float(np.nextafter(middle - half, -math.inf)), float(np.nextafter(middle + half, math.inf))


def _smaller(entry: EntryBound, proven: tuple[float, float, float], is_negative: bool) -> EntryBound:
    error, low, high = proven
    low, high = (-high, -low) if is_negative else (low, high)
    error, low, high = min(entry.error, error), max(entry.low, low), min(entry.high, high)
    return replace(entry, error=error, likely=min(entry.likely, error), low=low, high=high)
