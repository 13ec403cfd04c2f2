"""The description of an FMU, `modelDescription.xml`."""

from __future__ import annotations

import math
from dataclasses import dataclass

from symoro_elastic.codegen.templates import render
from symoro_elastic.fmu.start import Start
from symoro_elastic.fmu.structure import Structure
from symoro_elastic.fmu.variables import Layout, unit_powers

TOLERANCE = "1e-7"
"""Of importers that are given none: what solvers with numerical Jacobians keep on stiff machines."""
STEPS = 1000
"""Communication steps over the duration that is offered."""


@dataclass(frozen=True)
class Unit:
    """A unit and its exponents of base units."""

    name: str
    powers: list[tuple[str, int]]


def description_of(
    name: str,
    summary: str,
    layout: Layout,
    structure: Structure,
    start: Start,
    sources: list[str],
    version: int,
    token: str,
) -> str:
    """Return modelDescription.xml of a version of FMI."""
    tags = {
        2: ("Outputs", "Derivatives", "InitialUnknowns"),
        3: ("Output", "ContinuousStateDerivative", "InitialUnknown"),
    }
    unknowns = (structure.outputs, structure.derivatives, structure.initial)
    duration = _round_number(start.duration)
    return render(
        f"fmu/modelDescription{version}.xml.j2",
        name=name,
        description=summary,
        token=token,
        sources=sources,
        units=[Unit(unit, powers) for unit, powers in unit_powers(layout.variables).items()],
        variables=layout.variables,
        numbers={one.reference: k for k, one in enumerate(layout.variables, start=1)},
        structure=list(zip(tags[version], unknowns, strict=True)),
        stop_time=f"{duration:g}",
        step_size=f"{duration / STEPS:g}",
        tolerance=TOLERANCE,
    )


def _round_number(x: float) -> float:
    """Return 1, 2 or 5 times a power of ten, at least x."""
    power = 10.0 ** math.floor(math.log10(x))
    return next(digit * power for digit in (1, 2, 5, 10) if digit * power >= x * (1 - 1e-9))
