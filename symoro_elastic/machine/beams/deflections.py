"""Frequencies of a beam with rigid bodies at its end and its root: of joints between rigid pieces, and of the beam.

Deflections are sums of shapes over x/L: those of joints at x_i, (x - x_i)_+ of bending, steps of torsion and tension;
those of the beam, integrals of Legendre polynomials on its pieces as curvature, strain and shear strain (Ritz). Both
have mass matrices by the same integrals. Lengths are in beam lengths, masses in those of a uniform beam with the
section of the root, and squares of frequencies in EI/(m L^3) there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.polynomial import legendre

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.beams.sections import AREA, AXIAL, TORSION, Profile

Rule = tuple[tuple[float, ...], tuple[float, ...]]
"""Places of joints as fractions of the length, and fractions w of the compliance that it would have if uniform."""
NO_JOINTS: Rule = ((), ())
POLYNOMIALS, FEWEST = 16, 8
"""Terms on the piece of a beam of one, which give four frequencies within 1e-11, and on each of several pieces."""
Body = tuple[float, float, float]
"""Mass, first moment along the beam, and inertia about the point that holds it, by those of the beam."""


@dataclass(frozen=True)
class Line:
    """Distribution of stiffness, mass and shear along a beam in one kind of deflection, by names of section quantities.

    `softness` is EI/(kGA L^2) at the root, 0 without shear, and `gyration` the inertia of the section when it turns,
    m r^2/(m L^2), there.
    """

    profile: Profile = Profile()
    stiffness: str = ""
    mass: str = AREA
    shear: str = ""
    softness: float = 0.0
    gyration: float = 0.0

    @property
    def is_uniform(self) -> bool:
        """Whether the section is constant along the beam, and the beam has no shear compliance."""
        return not self.profile.pieces and not self.softness

    @cached_property
    def mean_mass(self) -> float:
        """Mass, or inertia about the axis in torsion, relative to that of a beam with the root section throughout."""
        return self.profile.moments(self.mass, 0.0, 1.0)[0]

    @cached_property
    def moments(self) -> tuple[float, float, float]:
        """Moments of order 0, 1, 2 of the compliance along the beam; shear compliance is added to the last one."""
        x, weights = self.profile.nodes((0.0, 1.0), 2 * POLYNOMIALS)
        over = weights / self.profile.ratio(self.stiffness, x)
        of_shear = self.softness * float(np.sum(weights / self.profile.ratio(self.shear, x))) if self.softness else 0.0
        return float(over.sum()), float(over @ x), float(over @ x**2) + of_shear


@dataclass(frozen=True)
class Joints:
    """Hinges of one kind of deflection, and slides that have the compliance of shear: their places and compliances."""

    bent: Rule
    slides: Rule = NO_JOINTS

    @property
    def moments(self) -> tuple[float, float, float]:
        """Moments of order 0, 1, 2 of the compliances of the joints, as `moments` of a `Line`."""
        c, cx, cxx = (sum(w * x**k for x, w in zip(*self.bent, strict=True)) for k in range(3))
        return c, cx, cxx + sum(self.slides[1])


UNIFORM = Line()


@dataclass(frozen=True)
class Bending:
    """One kind of deflection of a beam with a rigid body at its end.

    The root is clamped, or moves freely with another body, `hub`. `hertz` is the unit of frequencies,
    sqrt(EI/(m L^3))/(2 pi) with the section of the root.
    """

    kind: str
    hertz: float
    tip: Body
    hub: Body | None = None
    line: Line = UNIFORM

    @property
    def is_bar(self) -> bool:
        """Whether the deflection is torsion or tension, whose equation is of second order."""
        return self.kind in (TORSION, AXIAL)

    @cached_property
    def exact(self) -> Array:
        """Frequencies of the beam by its differential equation, Hz."""
        return self._frequencies(moving_beam(self.line, self.is_bar))

    def of_joints(self, joints: Joints) -> Array:
        """Frequencies of the beam as rigid pieces between joints, Hz."""
        return self._frequencies(moving_joints(self.line, self.is_bar, joints))

    def error(self, joints: Joints, highest: float) -> float:
        """Largest relative error of the tip's compliance, and of the frequencies up to `highest`, Hz."""
        ours, exact = self.of_joints(joints), self.exact[self.exact <= highest]
        if len(ours) < len(exact):
            return math.inf
        compliance = _at_tip(joints.moments, self.is_bar) / _at_tip(self.line.moments, self.is_bar)
        return float(np.max(np.abs([compliance - 1, *(ours[: len(exact)] / exact - 1)])))

    def _frequencies(self, moving: Moving) -> Array:
        """Natural frequencies, Hz, of the beam with the mass matrix `moving`, and the bodies at both ends.

        Rigid motions of a free root have no momentum in a mode: they leave the Schur complement of the mass matrix.
        """
        free = 0 if self.hub is None else moving.rigid
        M = with_tip(moving, self.tip)[moving.rigid - free :, moving.rigid - free :]
        if self.hub is not None:
            M[:free, :free] += np.array([self.hub[:2], self.hub[1:]])[:free, :free]
            M = M[free:, free:] - M[free:, :free] @ np.linalg.solve(M[:free, :free], M[:free, free:])
        squares = np.linalg.eigvalsh(moving.root @ M @ moving.root.T)[::-1]
        return np.asarray(self.hertz / np.sqrt(squares[squares > 0]))


def _at_tip(moments: Sequence[float], is_bar: bool) -> float:
    """Deflection of the tip under a unit force there, from the moments of the compliance."""
    return moments[0] if is_bar else moments[0] - 2 * moments[1] + moments[2]


@dataclass(frozen=True)
class Moving:
    """Mass matrix (K, K) of shapes, the first `rigid` of them rigid motions, and their motion at the end of the beam.

    `root` is one of the inverse of the stiffness of the others.
    """

    M: Array
    end: Array
    turn: Array
    rigid: int
    root: Array

    @classmethod
    def of(cls, line: Line, is_bar: bool, shapes: tuple[Array, Array], nodes: tuple[Array, Array], root: Array) -> Self:
        """Return the matrices of shapes: deflections and turns (K, N + 1) at N nodes with weights, and at the end."""
        x, weights = nodes
        at = np.append(x, 1.0)
        rigid = ([at**0], [0 * at]) if is_bar else ([at**0, at], [0 * at, at**0])
        w, turn = (np.vstack(pair) for pair in zip(rigid, shapes, strict=True))
        M = (w[:, :-1] * weights * line.profile.ratio(line.mass, x)) @ w[:, :-1].T
        if line.gyration:
            M += line.gyration * (turn[:, :-1] * weights * line.profile.ratio(line.stiffness, x)) @ turn[:, :-1].T
        return cls(M, w[:, -1], turn[:, -1], len(rigid[0]), root)


def with_tip(moving: Moving, tip: Body) -> Array:
    """The mass matrix (K, K) of the beam with a body at its end."""
    mass, moment, inertia = tip
    end, turn = moving.end, moving.turn
    both = np.outer(end, turn)
    return np.asarray(moving.M + mass * np.outer(end, end) + moment * (both + both.T) + inertia * np.outer(turn, turn))


def moving_joints(line: Line, is_bar: bool, joints: Joints) -> Moving:
    """Mass matrix and shapes of a beam that consists of rigid pieces between joints and slides."""
    nodes = line.profile.nodes((0.0, *joints.bent[0], *joints.slides[0], 1.0), 4)
    at = np.append(nodes[0], 1.0)
    places, slides = (np.array(rule[0])[:, None] for rule in (joints.bent, joints.slides))
    turned, moved = (at > places) * 1.0, (at > slides) * 1.0
    shapes = np.vstack([turned if is_bar else np.maximum(at - places, 0.0), moved]), np.vstack([turned, 0 * moved])
    return Moving.of(line, is_bar, shapes, nodes, np.diag(np.sqrt([*joints.bent[1], *joints.slides[1]])))


@lru_cache(maxsize=64)
def moving_beam(line: Line, is_bar: bool) -> Moving:
    """Mass matrix and shapes of a continuous beam, by polynomials on each of its pieces."""
    pieces = list(pairwise(line.profile.edges))
    terms = POLYNOMIALS if len(pieces) == 1 else FEWEST
    x, weights = nodes = line.profile.nodes((0.0, 1.0), 2 * terms)
    parts = [_on_piece(x, terms, *ends) for ends in pieces]
    strain, once, twice = (np.vstack(own) for own in zip(*parts, strict=True))
    root = _root(strain, weights * line.profile.ratio(line.stiffness, x))
    if not line.softness:
        return Moving.of(line, is_bar, (once if is_bar else twice, once), nodes, root)
    of_shear, none = _root(strain, weights * line.profile.ratio(line.shear, x) / line.softness), np.zeros_like(root)
    shapes = np.vstack([twice, once]), np.vstack([once, 0 * once])
    return Moving.of(line, is_bar, shapes, nodes, np.block([[root, none], [none, of_shear]]))


def _root(strain: Array, weights: Array) -> Array:
    """R with R^T R the inverse of the stiffness matrix of strain shapes (K, N), by Cholesky."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky((strain * weights) @ strain.T)))


@lru_cache(maxsize=64)
def slowness(line: Line, is_bar: bool) -> float:
    """First frequency of the beam, clamped at the root and free at its end, relative to that of a uniform beam."""
    kind = AXIAL if is_bar else ""
    first, uniform = (
        Bending(kind, 1.0, (0.0, 0.0, 0.0), line=x).exact[0] for x in (replace(line, gyration=0.0), UNIFORM)
    )
    return float(first / uniform)


def _on_piece(x: Array, terms: int, start: float, end: float) -> tuple[Array, Array, Array]:
    """Legendre polynomials on a piece, at nodes; their first and second integrals, at nodes and the end of the beam."""
    middle, half, at = (start + end) / 2, (end - start) / 2, np.append(x, 1.0)
    t = np.clip((at - middle) / half, -1, 1)
    slope = legendre.legint(np.eye(terms), lbnd=-1, scl=half, axis=1)
    strain, once, twice = (
        legendre.legval(t, c.T) for c in (np.eye(terms), slope, legendre.legint(slope, lbnd=-1, scl=half, axis=1))
    )
    inside = (start < x) & (x < end)
    return (
        np.asarray(strain[:, :-1] * inside),
        np.asarray(once),
        twice + np.outer(once[:, -1], np.maximum(at - end, 0.0)),
    )
