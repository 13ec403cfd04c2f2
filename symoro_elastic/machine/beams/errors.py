"""Errors of beams as rigid pieces with elastic joints: of frequencies with a held or free root, of tip compliance."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.beams.beam import Beam
from symoro_elastic.machine.beams.deflections import Bending, Body
from symoro_elastic.machine.beams.places import FITTED, FITTED_BENDING, MOST_JOINTS, TIPS
from symoro_elastic.machine.beams.sections import AXIAL, TORSION
from symoro_elastic.machine.formula import Formula


def bending_of(beam: Beam, values: Mapping[str, float], carried: Array, hub: Array | None = None) -> list[Bending]:
    """The kinds of deflection of a beam, with the root clamped, and free if it has a hub; none without values of names.

    `carried` and `hub` (4, 4) are integrals of (x, y, z, 1) times itself over the mass of the body, in axes of the row
    of the beam about its end and its root.
    """
    kinds = list[Bending]()
    for kind in beam.bends:
        texts = (beam.length, beam.mass, beam.stiffness[kind], beam.inertia.get(kind, "0"))
        numbers = [x for x in (Formula.parse(text).known_value(values) for text in texts) if x is not None]
        if len(numbers) < len(texts):
            return []
        length, mass, stiffness, inertia = numbers
        line, power = (inertia, 1) if kind == TORSION else (mass, 1) if kind == AXIAL else (mass, 2)
        hertz = math.sqrt(stiffness / line) / (2 * math.pi * length**power)
        gyration = inertia / (mass * length**2) if power == 2 else 0.0
        tip, root = (None if x is None else _body(beam, kind, x, line * length, length) for x in (carried, hub))
        along = replace(beam.line(kind), gyration=gyration)
        kinds += [Bending(kind, hertz, tip or (0.0, 0.0, 0.0), x, along) for x in dict.fromkeys((None, root))]
    return kinds


def _body(beam: Beam, kind: str, integral: Array, own: float, length: float) -> Body:
    """The tip body relative to the beam: `own` is the beam's mass, or its inertia about its axis in torsion."""
    u, squares, mass = "xyz".index(beam.along[-1]), np.diag(integral), float(integral[3, 3])
    if kind in (TORSION, AXIAL):
        return (float(squares[:3].sum() - squares[u]) if kind == TORSION else mass) / own, 0.0, 0.0
    moment = float(integral[u, 3]) * (-1 if beam.along[0] == "-" else 1)
    turning = float(squares[u] + squares["xyz".index(kind)])
    return mass / own, moment / (own * length), turning / (own * length**2)


def error_of_first(beam: Beam, kind: str) -> float:
    """Largest relative error of the first frequency of a kind, with the masses at the end that places are fitted to."""
    line, joints = beam.line(kind), beam.joints_of(kind)
    bodies = [(line.mean_mass * mass, 0.0, line.mean_mass * inertia) for mass, inertia in TIPS]
    bendings = (Bending(kind, 1.0, body, line=line) for body in bodies)
    return max(abs(float(x.of_joints(joints)[0] / x.exact[0]) - 1) for x in bendings)


def errors_by_joints(
    beam: Beam, kinds: Sequence[Bending], rules: Sequence[str], highest: float
) -> Iterator[tuple[Beam, float]]:
    """Yield the beam with 1, 2, 3 ... joints of the best of these rules, and its largest error up to `highest`, Hz."""
    for joints in range(1, MOST_JOINTS + 1):
        possible = [rule for rule in rules if rule != FITTED or joints in FITTED_BENDING]
        trials = [replace(beam, rule=rule, joints=joints) for rule in possible]
        errors = [max(x.error(trial.joints_of(x.kind), highest) for x in kinds) for trial in trials]
        yield from sorted(zip(trials, errors, strict=True), key=lambda trial: round(trial[1], 9))[:1]
