"""Errors of beams as rigid pieces with elastic joints: of frequencies with a held or free root, of tip compliance.

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
"""Terms of the beam itself: they give four frequencies of its differential equation within 1e-11."""


Body = tuple[float, float, float]
"""Mass, first moment along the beam, and inertia about the point that holds it, by those of the beam."""


@dataclass(frozen=True)
class Bending:
    """One kind of deflection of a beam with a rigid body at its end.

    The root is clamped, or moves freely with another body, `hub`. `hertz` is the unit of frequencies,
    sqrt(EI/(m L^3))/(2 pi), and `gyration` the section's inertia m r^2/(m L^2).
    """

    kind: str
    hertz: float
    gyration: float
    tip: Body
    hub: Body | None = None

    @property
    def is_bar(self) -> bool:
        """Whether it is torsion or tension."""
        return self.kind in (TORSION, AXIAL)

    @cached_property
    def exact(self) -> Array:
        """Frequencies of the beam by its differential equation, Hz."""
        x, weights = legendre.leggauss(2 * POLYNOMIALS)
        slope = legendre.legint(np.eye(POLYNOMIALS), lbnd=-1, scl=0.5, axis=1)
        shapes = slope if self.is_bar else legendre.legint(slope, lbnd=-1, scl=0.5, axis=1)
        values = [legendre.legval(np.append(x, 1.0), c.T) for c in (shapes, slope)]
        return self._frequencies([*values, np.append(1 + x, 2.0) / 2], weights / 2, 2.0 * np.arange(POLYNOMIALS) + 1)

    def of_joints(self, rule: Rule) -> Array:
        """Frequencies of the beam with joints at the places of a rule, Hz."""
        places, edges = np.array(rule[0])[:, None], np.array([0.0, *rule[0], 1.0])
        halves = np.diff(edges)[:, None] / 2
        at = np.append(edges[:-1, None] + halves * (1 + np.array([-1, 1]) / math.sqrt(3)), 1.0)
        slope = (at > places) * 1.0
        values = [slope if self.is_bar else np.maximum(at - places, 0.0), slope, at]
        return self._frequencies(values, np.repeat(halves, 2), np.array(rule[1]))

    def error(self, rule: Rule, highest: float) -> float:
        """Largest relative error of the tip's compliance, and of the frequencies up to `highest`, Hz."""
        ours, exact = self.of_joints(rule), self.exact[self.exact <= highest]
        if len(ours) < len(exact):
            return math.inf
        compliance = sum(w * (1 if self.is_bar else 3 * (1 - x) ** 2) for x, w in zip(*rule, strict=True))
        return float(np.max(np.abs([compliance - 1, *(ours[: len(exact)] / exact - 1)])))

    def _frequencies(self, values: Sequence[Any], weights: Any, compliance: Any) -> Array:
        """Frequencies, Hz, by deflections and slopes (K, N + 1) at N nodes and at the end, compliances (K,).

        Rigid motions of a free root have no momentum in a mode: they leave the Schur complement of the mass matrix.
        """
        at = values[2]
        rigid = [] if self.hub is None else [(at**0, 0 * at)] if self.is_bar else [(at**0, 0 * at), (at, at**0)]
        free = len(rigid)
        both = (np.array([*(pair[k] for pair in rigid), *values[k]]) for k in (0, 1))
        (w, end), (slope, turn) = ((x[:, :-1], x[:, -1]) for x in both)
        mass, moment, inertia = self.tip
        M = (w * weights) @ w.T + self.gyration * (slope * weights) @ slope.T + mass * np.outer(end, end)
        M += moment * (np.outer(end, turn) + np.outer(turn, end)) + inertia * np.outer(turn, turn)
        if self.hub is not None:
            M[:free, :free] += np.array([self.hub[:2], self.hub[1:]])[:free, :free]
            M = M[free:, free:] - M[free:, :free] @ np.linalg.solve(M[:free, :free], M[:free, free:])
        root = np.sqrt(compliance)
        squares = np.linalg.eigvalsh(root[:, None] * M * root)[::-1]
        return np.asarray(self.hertz / np.sqrt(squares[squares > 0]))


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
        kinds += [Bending(kind, hertz, gyration, tip or (0.0, 0.0, 0.0), x) for x in dict.fromkeys((None, root))]
    return kinds


def _body(beam: Beam, kind: str, integral: Array, own: float, length: float) -> Body:
    """A body by that of a beam, `own` its mass, or inertia about its axis in torsion."""
    u, squares, mass = "xyz".index(beam.along[-1]), np.diag(integral), float(integral[3, 3])
    if kind in (TORSION, AXIAL):
        return (float(squares[:3].sum() - squares[u]) if kind == TORSION else mass) / own, 0.0, 0.0
    moment = float(integral[u, 3]) * (-1 if beam.along[0] == "-" else 1)
    turning = float(squares[u] + squares["xyz".index(kind)])
    return mass / own, moment / (own * length), turning / (own * length**2)


def errors_by_joints(
    beam: Beam, kinds: Sequence[Bending], rules: Sequence[str], highest: float
) -> Iterator[tuple[Beam, float]]:
    """Yield the beam with 1, 2, 3 ... joints of the best of these rules, and its largest error up to `highest`, Hz."""
    for joints in range(1, MOST_JOINTS + 1):
        possible = [rule for rule in rules if rule != FITTED or joints in FITTED_BENDING]
        trials = [replace(beam, rule=rule, joints=joints) for rule in possible]
        errors = [max(x.error(trial.places(x.kind), highest) for x in kinds) for trial in trials]
        yield from sorted(zip(trials, errors, strict=True), key=lambda trial: round(trial[1], 9))[:1]
