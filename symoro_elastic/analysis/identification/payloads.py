"""Payloads of which only ranges are known: the ends of the ranges, between which torques are."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

from symoro_elastic.analysis.identification.regression import geometry_of, nominal_body
from symoro_elastic.foundation.errors import InputError, among
from symoro_elastic.machine.checks import parameter_values
from symoro_elastic.machine.machine import Machine

OPTION = "--payload"
MOST_RANGES = 6
EXACT = 1e-9


def corners(
    machine: Machine, values: Mapping[str, float], payloads: Mapping[str, tuple[float, float]]
) -> list[dict[str, float]]:
    """Return values of parameters at the corners of ranges; torques anywhere between them are means of those there.

    Raises `InputError` for names that are no parameters, ranges without room, and parameters in which torques are not
    linear: of the geometry, distances of centers of mass.
    """
    among(tuple(payloads), tuple(p.name for p in machine.parameters), OPTION)
    if len(payloads) > MOST_RANGES:
        raise InputError("symoro-elastic", OPTION, f"{len(payloads)} ranges, {MOST_RANGES} is the limit")
    for name, (low, high) in payloads.items():
        if not low < high:
            raise InputError("symoro-elastic", OPTION, f"{name}: no room between {low:g} and {high:g}")
    given = {**parameter_values(machine), **values}
    for name, ends in payloads.items():
        _refuse_curved(machine, name, ends, given)
    each = itertools.product(*payloads.values()) if payloads else []
    return [{**given, **dict(zip(payloads, ends, strict=True))} for ends in each]


def _refuse_curved(machine: Machine, name: str, ends: tuple[float, float], given: Mapping[str, float]) -> None:
    """Raise `InputError` for a parameter in which what torques are made of is not linear."""
    for j, joint in enumerate(machine.joints, start=1):
        place = f"joint {j} ({joint.name})"
        if any(name in formula.names for formula in geometry_of(joint)):
            raise InputError(
                "symoro-elastic", OPTION, f"{name}: {place} has it in its geometry: give a mass or an inertia"
            )
        bodies = [nominal_body(joint.body, {**given, name: x}) for x in (*ends, sum(ends) / 2)]
        for low, high, middle in zip(*(x.values() for x in bodies), strict=True):
            within = EXACT * (abs(low) + abs(high))
            if math.isfinite(middle) and not math.isclose(middle, (low + high) / 2, rel_tol=EXACT, abs_tol=within):
                what = f"{name}: the inertia of {place} is not linear in it, so ends of a range do not bound torques"
                raise InputError("symoro-elastic", OPTION, f"{what}: give a range of a mass")
