"""The certificates of the models that a scene asks of a machine, in some precisions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from symoro_elastic.codegen.compile import TYPES
from symoro_elastic.codegen.package import Function
from symoro_elastic.codegen.precision import PRECISIONS
from symoro_elastic.foundation.progress import Progress, no_progress
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.limits import Limits
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.models.linear_system import linear_system
from symoro_elastic.models.traced import Traced
from symoro_elastic.numerics.guarantees.box import Box, box_of, parameter_box
from symoro_elastic.numerics.guarantees.by_polynomials import by_polynomials
from symoro_elastic.numerics.guarantees.certificate import MOST_SUB_BOXES, Certificate, Subject, certify
from symoro_elastic.numerics.guarantees.knowledge import PivotKnowledge
from symoro_elastic.numerics.guarantees.least_inertia import by_rotors
from symoro_elastic.numerics.guarantees.linear_solver import Solver
from symoro_elastic.numerics.guarantees.own_inertia import own_inertias
from symoro_elastic.numerics.guarantees.running_error import Rounding

LARGEST = 1e300
"""Stands for no bound, where certificates are compared."""


@dataclass(frozen=True)
class Effort:
    """How much is tried: sub-boxes at most, the seed of drawn states, and how progress is reported.

    With `polynomials` errors and ranges of results that are polynomials (inverse models, inertia matrices) are proven
    by their coefficients, too: up to half a minute for six joints.
    """

    most_sub_boxes: int = MOST_SUB_BOXES
    seed: int = 0
    progress: Progress = no_progress
    polynomials: bool = False


@dataclass(frozen=True, repr=False)
class Certificates(Result):
    """What the models of a machine guarantee, a certificate for each model and precision."""

    machine: str
    certificates: tuple[Certificate, ...]

    @property
    def headline(self) -> str:
        """Machine, and how many certificates there are."""
        return f"Certificates of {self.machine}: {', '.join(dict.fromkeys(one.model for one in self.certificates))}"

    @property
    def doubt(self) -> tuple[int, float]:
        """How many entries have no proven error, and the mean logarithm of errors at most draws: less is better."""
        entries = [entry for one in self.certificates for entry in one.entries]
        likely = [min(entry.likely, LARGEST) for entry in entries if entry.likely > 0]
        unproven = sum(not math.isfinite(entry.error) for entry in entries)
        return unproven, sum(map(math.log, likely)) / max(1, len(likely))

    def of(self, model: str) -> tuple[Certificate, ...]:
        """The certificates of one model, by precision."""
        return tuple(one for one in self.certificates if one.model == model)


def certify_models(
    asked: Traced, physical: Machine, limits: Limits, roundings: Sequence[Rounding], effort: Effort = Effort()
) -> Certificates:
    """The certificates of the models that a scene asks of a machine, within its limits; raises `InputError`.

    `physical` is the machine with the inertial parameters of bodies, from which those of the models may be grouped.
    """
    functions = asked.package.functions
    made = [
        certificate_of(subject_of(asked, physical, limits, function, rounding), asked.whole.name, effort)
        for function in functions
        for rounding in roundings
    ]
    return Certificates(asked.whole.name, tuple(made))


def subject_of(
    asked: Traced, physical: Machine | None, limits: Limits, function: Function, rounding: Rounding
) -> Subject:
    """A function with its box, and with what is known of its pivots from the bodies of a machine; raises `InputError`.

    Without a `physical` machine nothing is known, as of reduced programs, whose pivots are others.
    """
    arrays = TYPES[PRECISIONS[rounding.name].state]
    box = box_of(asked.machine, limits, function.program.inputs, function.program.used).rounded(arrays)
    if physical is None:
        return Subject(function, box, rounding)
    parameters = parameter_box(physical, limits)
    knowledge = PivotKnowledge(asked, physical, parameters, function)
    return Subject(function, box, rounding, knowledge, _solver(asked, physical, parameters, function, box))


def _solver(asked: Traced, physical: Machine, parameters: Box, function: Function, box: Box) -> Solver | None:
    """What bounds errors of the linear system that a direct model solves; None where it solves none."""
    system = linear_system(asked.machine, function.program)
    if system is None:
        return None
    rotors = own_inertias(restrict(physical, asked.scene), parameters.whole, ())
    return Solver(system, box, by_rotors(rotors, system.joints))


def certificate_of(subject: Subject, machine: str = "", effort: Effort = Effort()) -> Certificate:
    """What a function guarantees."""
    if effort.polynomials and subject.solver:
        subject = replace(subject, solver=replace(subject.solver, polynomials=True))
    found = certify(subject, machine, effort.most_sub_boxes, effort.seed, effort.progress)
    return by_polynomials(found, subject, effort.progress) if effort.polynomials else found
