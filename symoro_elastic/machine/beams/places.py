"""Where the joints of a beam are, and how compliant: places in tables for uniform beams, fitted for others.

Tip deflection and slope under force and moment are exact where sums of 1, x, x^2 over the compliance of joints are
those of the beam. With these three conditions, places and compliances of the rule `fitted` are those of least squares
of the first frequencies, against those of the beam itself, with tip masses of 0, 0.25, 1, 5 beam masses.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.beams.deflections import (
    POLYNOMIALS,
    Joints,
    Line,
    Moving,
    Rule,
    moving_beam,
    moving_joints,
    with_tip,
)

FITTED_BENDING: Mapping[int, Rule] = {
    2: ((0.2113248654052, 0.7886751345948), (0.5, 0.5)),
    3: ((0.1017021329, 0.4373722899, 0.8318182193), (0.2552341369, 0.3687898880, 0.3759759751)),
    4: (
        (0.112778228, 0.4205525736, 0.7061964313, 0.9310567739),
        (0.2621781488244, 0.3079559563428, 0.2637602060327, 0.1661056888),
    ),
    5: (
        (0.0912744646, 0.3388654436, 0.5703285767, 0.7793684133, 0.9485030588),
        (0.2118099518, 0.2469680691, 0.2197426931, 0.1967155080, 0.1247637780),
    ),
}
"""Fitted to the first frequencies with tip masses of 0, 0.25, 1, 5 beam masses, points and with inertia (0.01 m L^2 at
1, 0.1 m L^2 at 5): of 4 joints f1, f2 within 0.02 %, f3 within 0.13 %. A root that moves freely needs other places."""
FITTED_BARS: Mapping[int, Rule] = {
    1: ((0.6055205312,), (1.0,)),
    2: ((0.3952646193, 0.8172839197), (0.6312195538, 0.3687804462)),
    3: ((0.3305955624, 0.6958333117, 0.9397404511), (0.5328896105, 0.3004929254, 0.1666174641)),
}
"""Of torsion and tension, fitted to f1, f2 with the same tip masses: f1 within 1.6, 0.6, 0.001 %."""
FITTED, GAUSS, EQUAL = RULES = ("fitted", "gauss", "equal")
"""Fitted places; those of Gauss, weighted by the compliance; the middles of equal pieces, by compliance."""
MOST_JOINTS = 20
"""Of a beam by the rules gauss and equal."""


def places_of(rule: str, joints: int, is_bar: bool) -> Rule:
    """Places and compliance fractions of so many joints; raises `KeyError` where the rule has none."""
    if rule == FITTED:
        return (FITTED_BARS if is_bar else FITTED_BENDING)[joints]
    if rule == GAUSS:
        nodes, weights = np.polynomial.legendre.leggauss(joints)
        return tuple(((1 + nodes) / 2).tolist()), tuple((weights / 2).tolist())
    return tuple((k + 0.5) / joints for k in range(joints)), (1 / joints,) * joints


TIPS = ((0.0, 0.0), (0.25, 0.0), (1.0, 0.0), (5.0, 0.0), (1.0, 0.01), (5.0, 0.1))
"""Masses, and inertias by the square of the length, of bodies at the end to which places are fitted, in beam masses."""
WEIGHTS = (3.0, 2.0, 1.0, 1.0)
"""Of the errors of the first frequencies."""
STEPS = 40
"""Of the fit, at most."""
FACTOR, TRIALS = 5.0, 8
"""By which damping grows until a step lowers the errors, and how often before the fit ends."""
ENOUGH = 2e-3
"""Part of the errors; a step that lowers them by less is the last."""
LAST_STEPS = 4
"""To exact moments: each squares what is missing."""
DIFFERENCE = 1e-7
"""Step of the differences: of places by the length, and of logarithms of compliances."""


@lru_cache(maxsize=256)
def joints_along(rule: str, joints: int, is_bar: bool, line: Line) -> Joints:
    """Places and compliance fractions of so many joints, and of slides in shear."""
    if line.is_uniform:
        return Joints(places_of(rule, joints, is_bar))
    rule_of = _of_equal_pieces if rule == EQUAL else _of_gauss
    start = Joints(rule_of(line, line.stiffness, joints))
    if line.softness:
        places, fractions = rule_of(line, line.shear, max(1, joints // 2))
        start = replace(start, slides=(places, tuple(line.softness * w for w in fractions)))
    return _of_least_errors(line, is_bar, start) if rule == FITTED else start


def _of_equal_pieces(line: Line, quantity: str, joints: int) -> Rule:
    """Joints with the compliance of equal pieces, the inverse of a quantity, at the centres of that."""
    ends = np.linspace(0, 1, joints + 1)
    parts = [line.profile.nodes(pair, 2 * POLYNOMIALS) for pair in pairwise(ends)]
    over = [weights / line.profile.ratio(quantity, x) for x, weights in parts]
    places = tuple(float(c @ x / c.sum()) for c, (x, _) in zip(over, parts, strict=True))
    return places, tuple(float(c.sum()) for c in over)


def _of_gauss(line: Line, quantity: str, joints: int) -> Rule:
    """Nodes and weights of Gauss for the compliance, the inverse of a quantity, by the recursion of Stieltjes."""
    x, weights = line.profile.nodes((0.0, 1.0), 2 * POLYNOMIALS)
    c = weights / line.profile.ratio(quantity, x)
    T, before, p = np.zeros((joints + 1, joints + 1)), 0 * x, np.sqrt(1 / c.sum()) + 0 * x
    for k in range(joints):
        T[k, k] = np.sum(c * x * p * p)
        after = (x - T[k, k]) * p - T[k, k - 1] * before
        T[k, k + 1] = T[k + 1, k] = np.sqrt(np.sum(c * after * after))
        before, p = p, after / T[k, k + 1]
    places, vectors = np.linalg.eigh(T[:-1, :-1])
    return tuple(places.tolist()), tuple((c.sum() * vectors[0] ** 2).tolist())


@dataclass(frozen=True)
class _Fit:
    """Joints of a beam that are fitted: z holds places and logarithms of compliances, of joints and then of slides."""

    line: Line
    is_bar: bool
    start: Joints

    def joints(self, z: Array) -> Joints:
        """The joints and slides whose places and compliances the vector z holds."""
        k = len(self.start.bent[0])
        bent, slides = (x.reshape(2, -1) for x in (z[: 2 * k], z[2 * k :]))
        return Joints(*((tuple(places.tolist()), tuple(np.exp(shares).tolist())) for places, shares in (bent, slides)))

    @property
    def count(self) -> int:
        """Number of frequencies that are fitted."""
        joints = len(self.start.bent[0])
        return min(joints, 2) if self.is_bar else max(1, joints - 1)

    def frequencies(self, moving: Moving) -> Array:
        """Logarithms of the first natural frequencies of a beam, for each of the masses at the end, `TIPS`."""
        m, n = self.line.mean_mass, moving.rigid
        M = np.array([with_tip(moving, (m * mass, 0.0, m * inertia))[n:, n:] for mass, inertia in TIPS])
        squares = np.linalg.eigvalsh(moving.root @ M @ moving.root.T)
        return np.asarray(-np.log(squares[:, ::-1][:, : self.count]) / 2)

    @cached_property
    def exact(self) -> Array:
        """Logarithms of the first natural frequencies of the continuous beam, for each of the masses at the end."""
        return self.frequencies(moving_beam(self.line, self.is_bar))

    def errors(self, z: Array) -> Array:
        """Weighted relative errors of the natural frequencies with the joints z."""
        ours = self.frequencies(moving_joints(self.line, self.is_bar, self.joints(z)))
        return np.asarray(((ours - self.exact) * WEIGHTS[: self.count]).ravel())

    def moment_errors(self, z: Array) -> Array:
        """Relative errors of the moments of the compliance with the joints z."""
        return (np.divide(self.joints(z).moments, self.line.moments) - 1)[: 1 if self.is_bar else 3]

    def merit(self, z: Array) -> float:
        """Sum of the norms of both kinds of errors; infinite where joints leave the beam or their order."""
        joints = self.joints(z)
        if any(np.any(np.diff([0.0, *places, 1.0]) <= 0) for places, _ in (joints.bent, joints.slides)):
            return math.inf
        return float(np.linalg.norm(self.errors(z)) + np.linalg.norm(self.moment_errors(z)))

    def steps(self, z: Array) -> Callable[[float], Array]:
        """Levenberg-Marquardt step as a function of its damping: exact moments first, then least frequency errors."""
        G, J = _slopes(self.moment_errors, z), _slopes(self.errors, z)
        to_exact = -np.linalg.lstsq(G, self.moment_errors(z), rcond=None)[0]
        free = np.linalg.svd(G)[2][len(G) :].T
        u, s, v = np.linalg.svd(J @ free, full_matrices=False)
        r = u.T @ (self.errors(z) + J @ to_exact)
        return lambda damping: to_exact - free @ (v.T @ (s / (s**2 + damping**2) * r))


def _of_least_errors(line: Line, is_bar: bool, start: Joints) -> Joints:
    """Places and compliances of least errors, by Levenberg and Marquardt; last steps to exact moments."""
    fit, damping = _Fit(line, is_bar, start), 1.0
    z = np.concatenate([x for places, shares in (start.bent, start.slides) for x in (places, np.log(shares))])
    merit = fit.merit(z)
    for _ in range(STEPS):
        step = fit.steps(z)
        trials = ((fit.merit(z + step(d)), d) for d in (damping * FACTOR**k for k in range(-1, TRIALS)))
        lower, damping = next((trial for trial in trials if trial[0] < merit), (merit, damping))
        if lower > (1 - ENOUGH) * merit:
            break
        z, merit = z + step(damping), lower
    for _ in range(LAST_STEPS):
        z = z - np.linalg.lstsq(_slopes(fit.moment_errors, z), fit.moment_errors(z), rcond=None)[0]
    return fit.joints(z)


def _slopes(f: Callable[[Array], Array], z: Array) -> Array:
    """Derivatives (n, m) by differences."""
    return (np.array([f(z + e) for e in DIFFERENCE * np.eye(len(z))]).T - f(z)[:, None]) / DIFFERENCE
