"""Errors of beams as rigid pieces with elastic joints: frequencies with the root clamped, and the tip's compliance.

Deflections are sums of shapes over x/L: those of joints at x_i, (x - x_i)_+ of bending, steps of torsion and tension;
those of the beam, integrals of Legendre polynomials as its curvature or strain (Ritz). Both have mass matrices by the
same integrals. Lengths are in beam lengths, masses in beam masses, and squares of frequencies in EI/(m L^3).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.beams import AXIAL, FITTED, FITTED_BENDING, MOST_JOINTS, TORSION, Beam, Rule
from symoro_elastic.machine.formula import Formula

POLYNOMIALS = 16
"""Of the beam itself: four frequencies within 1e-12 of those of its differential equation."""


@dataclass(frozen=True)
class Clamped:
    """One kind of deflection of a beam that is clamped at its root, with a rigid body at its end.

    `hertz` is the unit of frequencies, sqrt(EI/(m L^3))/(2 pi), `gyration` the section's inertia m r^2/(m L^2), `tip`
    mass, first moment along the beam and inertia of the body about the end, by those of the beam.
    """

    is_bar: bool
    hertz: float
    gyration: float
    tip: tuple[float, float, float]

    @cached_property
    def exact(self) -> Array:
        """Frequencies of the beam by its differential equation, Hz."""
        x, weights = legendre.leggauss(2 * POLYNOMIALS)
        slope = legendre.legint(np.eye(POLYNOMIALS), lbnd=-1, scl=0.5, axis=1)
        shapes = slope if self.is_bar else legendre.legint(slope, lbnd=-1, scl=0.5, axis=1)
        values = [legendre.legval(np.append(x, 1.0), c.T) for c in (shapes, slope)]
        return self._frequencies(values, weights / 2, 2.0 * np.arange(POLYNOMIALS) + 1)

    def of_joints(self, rule: Rule) -> Array:
        """Frequencies of the beam with joints at the places of a rule, Hz."""
        places, edges = np.array(rule[0])[:, None], np.array([0.0, *rule[0], 1.0])
        halves = np.diff(edges)[:, None] / 2
        at = np.append(edges[:-1, None] + halves * (1 + np.array([-1, 1]) / math.sqrt(3)), 1.0)
        slope = (at > places) * 1.0
        values = [slope if self.is_bar else np.maximum(at - places, 0.0), slope]
        return self._frequencies(values, np.repeat(halves, 2), np.array(rule[1]))

    def error(self, rule: Rule, highest: float) -> float:
        """Largest relative error of the tip's compliance, and of the frequencies up to `highest`, Hz."""
        ours, exact = self.of_joints(rule), self.exact[self.exact <= highest]
        if len(ours) < len(exact):
            return math.inf
        compliance = sum(w * (1 if self.is_bar else 3 * (1 - x) ** 2) for x, w in zip(*rule, strict=True))
        return float(np.max(np.abs([compliance - 1, *(ours[: len(exact)] / exact - 1)])))

    def _frequencies(self, values: Sequence[Any], weights: Any, compliance: Any) -> Array:
        """Frequencies, Hz, by deflections and slopes (K, N + 1) at N nodes and at the end, compliances (K,)."""
        (w, end), (slope, turn) = ((x[:, :-1], x[:, -1]) for x in values)
        mass, moment, inertia = self.tip
        M = (w * weights) @ w.T + self.gyration * (slope * weights) @ slope.T + mass * np.outer(end, end)
        M += moment * (np.outer(end, turn) + np.outer(turn, end)) + inertia * np.outer(turn, turn)
        root = np.sqrt(compliance)
        squares = np.linalg.eigvalsh(root[:, None] * M * root)[::-1]
        return np.asarray(self.hertz / np.sqrt(squares[squares > 0]))


def kinds_of(beam: Beam, values: Mapping[str, float], carried: Array) -> list[Clamped]:
    """The kinds of deflection of a beam with a rigid body at its end; none where a name has no value.

    `carried` (4, 4) is the integral of (x, y, z, 1) times itself over the mass of the body, in the frame of the end.
    """
    u, sign = "xyz".index(beam.along[-1]), -1 if beam.along[0] == "-" else 1
    kinds, squares, own = list[Clamped](), np.diag(carried), float(carried[3, 3])
    for kind in beam.bends:
        texts = (beam.length, beam.mass, beam.stiffness[kind], beam.inertia.get(kind, "0"))
        numbers = [x for x in (Formula.parse(text).known_value(values) for text in texts) if x is not None]
        if len(numbers) < len(texts):
            return []
        length, mass, stiffness, inertia = numbers
        if kind in (TORSION, AXIAL):
            line, body = (inertia, squares[:3].sum() - squares[u]) if kind == TORSION else (mass, own)
            hertz = math.sqrt(stiffness / line) / (2 * math.pi * length)
            kinds.append(Clamped(True, hertz, 0.0, (float(body) / (line * length), 0.0, 0.0)))
            continue
        turning = float(squares[u] + squares["xyz".index(kind)]) / length**2
        tip = (own / (mass * length), sign * float(carried[u, 3]) / (mass * length**2), turning / (mass * length))
        hertz = math.sqrt(stiffness / mass) / (2 * math.pi * length**2)
        kinds.append(Clamped(False, hertz, inertia / (mass * length**2), tip))
    return kinds


def errors_by_joints(
    beam: Beam, kinds: Sequence[Clamped], rules: Sequence[str], highest: float
) -> Iterator[tuple[Beam, float]]:
    """Yield the beam with 1, 2, 3 ... joints of the best of these rules, and its largest error up to `highest`, Hz."""
    for joints in range(1, MOST_JOINTS + 1):
        possible = [rule for rule in rules if rule != FITTED or joints in FITTED_BENDING]
        trials = [replace(beam, rule=rule, joints=joints) for rule in possible]
        errors = [max(x.error(y.places(kind), highest) for kind, x in zip(y.bends, kinds, strict=True)) for y in trials]
        yield from sorted(zip(trials, errors, strict=True), key=lambda trial: round(trial[1], 9))[:1]
