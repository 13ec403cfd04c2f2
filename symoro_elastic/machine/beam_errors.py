"""Errors of beams as rigid pieces with elastic joints: frequencies with the root clamped, and the tip's compliance.

Deflections are sums of shapes over x/L: those of joints at x_i, (x - x_i)_+ of bending, steps of torsion and tension;
those of the beam, integrals of Legendre polynomials as its curvature or strain (Ritz). Both have mass matrices by the
same integrals. Lengths are in beam lengths, masses in beam masses, and squares of frequencies in EI/(m L^3).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.beams import AXIAL, FITTED, FITTED_BENDING, MOST_JOINTS, TORSION, Beam, Rule
from symoro_elastic.machine.formula import Formula

POLYNOMIALS = 16
"""Of the beam itself: eight frequencies within 1e-9 of Bernoulli's."""


@dataclass(frozen=True, eq=False)
class Carried:
    """A rigid body at the end of a beam: mass, kg, first moments (3,), kg m, inertia about the end (3, 3), kg m2."""

    mass: float
    moments: Array
    inertia: Array


@dataclass(frozen=True)
class Clamped:
    """One kind of deflection of a beam that is clamped at its root, with a rigid body at its end.

    `hertz` is the unit of frequencies, sqrt(EI/(m L^3))/(2 pi), `gyration` the section's inertia m r^2/(m L^2), `tip`
    mass, first moment along the beam and inertia of the body at the end, by those of the beam.
    """

    is_bar: bool
    hertz: float
    gyration: float
    tip: tuple[float, float, float]

    @cached_property
    def exact(self) -> Array:
        """Frequencies of the beam by its differential equation, Hz."""
        x, weights = (np.array(column) for column in legendre.leggauss(2 * POLYNOMIALS))
        at = np.append((1 + x) / 2, 1.0)
        strain = np.eye(POLYNOMIALS)
        slope = legendre.legint(strain, lbnd=-1, scl=0.5, axis=1)
        shapes = slope if self.is_bar else legendre.legint(slope, lbnd=-1, scl=0.5, axis=1)
        values = [legendre.legval(2 * at - 1, c.T) for c in ((shapes, 0 * slope) if self.is_bar else (shapes, slope))]
        return self._frequencies(values, weights / 2, 2.0 * np.arange(POLYNOMIALS) + 1)

    def of_joints(self, rule: Rule) -> Array:
        """Frequencies of the beam with joints at the places of a rule, Hz."""
        places, shares = (np.array(x)[:, None] for x in rule)
        edges = np.array([0.0, *rule[0], 1.0])
        sides = np.array([-1.0, 1.0]) / math.sqrt(3)
        halves = np.diff(edges)[:, None] / 2
        at = np.append((edges[:-1, None] + halves * (1 + sides)).reshape(-1), 1.0)
        slope = (at > places) * 1.0
        values = [slope, 0 * slope] if self.is_bar else [np.maximum(at - places, 0.0), slope]
        return self._frequencies(values, np.repeat(halves, 2), shares[:, 0])

    def error(self, rule: Rule, highest: float) -> float:
        """Largest relative error of the tip's compliance, and of the frequencies up to `highest`, Hz."""
        found, exact = self.of_joints(rule), self.exact[self.exact <= highest]
        if len(found) < len(exact):
            return math.inf
        compliance = sum(w * (1 if self.is_bar else 3 * (1 - x) ** 2) for x, w in zip(*rule, strict=True))
        return float(np.max(np.abs([compliance - 1, *(found[: len(exact)] / exact - 1)])))

    def _frequencies(self, values: Iterable[Any], weights: Any, compliance: Any) -> Array:
        """Frequencies, Hz, by deflections and slopes (K, N + 1) at N nodes and at the end, compliances (K,)."""
        (w, end), (slope, turn) = ((x[:, :-1], x[:, -1]) for x in values)
        mass, moment, inertia = self.tip
        M = (w * weights) @ w.T + self.gyration * (slope * weights) @ slope.T + mass * np.outer(end, end)
        M += moment * (np.outer(end, turn) + np.outer(turn, end)) + inertia * np.outer(turn, turn)
        root = np.sqrt(compliance)
        squares = np.linalg.eigvalsh(root[:, None] * M * root)[::-1]
        return np.asarray(self.hertz / np.sqrt(squares[squares > 0]))


def kinds_of(beam: Beam, values: Mapping[str, float], carried: Carried) -> list[Clamped] | None:
    """The kinds of deflection of a beam by values of parameters; None where a name has no value."""
    length, mass = (Formula.parse(x).known_value(values) for x in (beam.length, beam.mass))
    stiffness, inertia = (
        {kind: Formula.parse(cells[kind]).known_value(values) for kind in beam.bends if kind in cells}
        for cells in (beam.stiffness, beam.inertia)
    )
    if not length or not mass or None in (*stiffness.values(), *inertia.values()):
        return None
    numbers = {kind: (length, mass, stiffness[kind] or 0.0, inertia.get(kind) or 0.0) for kind in beam.bends}
    return [_kind(beam, kind, *numbers[kind], carried) for kind in beam.bends]


def _kind(
    beam: Beam, kind: str, length: float, mass: float, stiffness: float, inertia: float, carried: Carried
) -> Clamped:
    """One kind by its numbers: mass and inertia of the section per length."""
    u, sign = "xyz".index(beam.along[-1]), -1 if beam.along[0] == "-" else 1
    if kind in (TORSION, AXIAL):
        line, own = (inertia, float(carried.inertia[u, u])) if kind == TORSION else (mass, carried.mass)
        hertz = math.sqrt(stiffness / line) / (2 * math.pi * length)
        return Clamped(True, hertz, 0.0, (own / (line * length), 0.0, 0.0))
    about = 3 - u - "xyz".index(kind)
    moment, turning = sign * float(carried.moments[u]), float(carried.inertia[about, about])
    own = mass * length
    tip = carried.mass / own, moment / (own * length), turning / (own * length**2)
    hertz = math.sqrt(stiffness / mass) / (2 * math.pi * length**2)
    return Clamped(False, hertz, inertia / (mass * length**2), tip)


@dataclass(frozen=True)
class Choice:
    """A rule and a number of joints, with the predicted error, and that of fewer joints; infinite without any."""

    rule: str
    joints: int
    error: float
    of_fewer: float


def fewest_joints(
    beam: Beam, kinds: Sequence[Clamped], rules: Iterable[str], highest: float, tolerance: float
) -> Choice | None:
    """The fewest joints, and of these the best rule, whose errors up to `highest`, Hz, are within a tolerance."""
    of_fewer, rules = math.inf, tuple(rules)
    for joints in range(1, MOST_JOINTS + 1):
        errors = {
            rule: max(kind.error(places, highest) for kind, places in zip(kinds, by_kind, strict=True))
            for rule in rules
            if rule != FITTED or joints in FITTED_BENDING
            for by_kind in ([*map(replace(beam, rule=rule, joints=joints).places, beam.bends)],)
        }
        best = min(errors, key=lambda rule: round(errors[rule], 9), default="")
        if best and errors[best] <= tolerance:
            return Choice(best, joints, errors[best], of_fewer)
        of_fewer = min(errors.values(), default=math.inf)
    return None
