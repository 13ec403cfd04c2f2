"""Allowed errors of the results of a tape, from tolerances by output and entry."""

from __future__ import annotations

import math

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.within import Tolerance
from symoro_elastic.numerics.within.results import Reserved, Tolerances
from symoro_elastic.numerics.within.tape import Tape
from symoro_elastic.symbolic.program import Output, Program


def allowed_errors(program: Program, tape: Tape, tolerances: Tolerances, largest: Array) -> Array:
    """Return the allowed error of each result, the least where it is several entries.

    `largest` are the largest values of the results. Raises `ValueError` for an output without a tolerance.
    """
    sizes = dict(zip(tape.results, largest, strict=True))
    allowed = dict.fromkeys(tape.results, math.inf)
    for output, places in zip(program.outputs, tape.entries, strict=True):
        for place, tolerance in zip(places, _of_entries(output, tolerances), strict=True):
            if place in allowed:
                scale = sizes[place] if tolerance.relative else 1.0
                allowed[place] = min(allowed[place], tolerance.value * scale)
    return np.array([allowed[place] for place in tape.results])


def reserved_of(program: Program, tape: Tape, reserved: Reserved) -> Array:
    """Return what is reserved of the allowed error of each result, the most where it is several entries."""
    found = dict.fromkeys(tape.results, 0.0)
    for output, places in zip(program.outputs, tape.entries, strict=True):
        for place, x in zip(places, reserved.get(output.name, [0.0] * len(places)), strict=True):
            if place in found:
                found[place] = max(found[place], x)
    return np.array([found[place] for place in tape.results])


def _of_entries(output: Output, tolerances: Tolerances) -> list[Tolerance]:
    if output.name not in tolerances:
        raise ValueError(f"no tolerance for {output.name}: give one for each of the results")
    found = tolerances[output.name]
    entries = [found] * len(output.entries) if isinstance(found, Tolerance) else list(found)
    if len(entries) != len(output.entries):
        raise ValueError(f"{len(entries)} tolerances for the {len(output.entries)} entries of {output.name}")
    for tolerance in entries:
        if not 0 <= tolerance.value < math.inf:
            raise ValueError(f"{tolerance.value} is not a tolerance of {output.name}: a number from 0 on")
    return entries
