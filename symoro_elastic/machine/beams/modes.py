"""Uniform beams by modes: polynomials that the clamped root allows, and their integrals over the mass.

Shapes are the static deflections under force and moment at the tip, xi^2 and xi^3 (xi of torsion and tension), and
polynomials that vanish at both ends with their slopes, in place of the fixed-interface modes of Craig and Bampton.
Combinations that are orthogonal in mass and stiffness are the modes, phi_k = 1 at the tip. Sections stay plane and
turn by phi_k' without shear. With shear sections turn by p' of a shape p, and the axis moves by p - c (p'' - p''(0)),
c = EI/(kGA L^2), as at rest. With stiffening a bent beam is shorter by s_kl = -int phi_k' phi_l' dx, so that tension
stiffens it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Legendre, Polynomial

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.beams.beam import Beam
from symoro_elastic.machine.beams.sections import AXIAL, TORSION
from symoro_elastic.machine.flexible import FlexibleBody, integrals_of, without_rounding
from symoro_elastic.machine.formula import Formula

ALONG = np.array([1.0, 0.0, 0.0])
"""The axis of a beam in its own frame."""
NODES = 32
"""Of Gauss and Legendre along the beam: exact for products of three shapes."""


@dataclass(frozen=True, eq=False)
class Mode:
    """A mode of deflection by the polynomial of xi = x/L, in its own direction (3,); stiffness and damping.

    `slope` is that of the turn of sections, by the length.
    """

    kind: str
    shape: Polynomial
    slope: Polynomial
    direction: Array
    stiffness: float
    damping: float

    def turn(self, xi: Array, length: float) -> Array:
        """Rotations (n, 3) of sections at xi = x/length per unit of the modal coordinate."""
        if self.kind in (TORSION, AXIAL):
            return np.outer(self.shape(xi) * (self.kind == TORSION), ALONG)
        return np.outer(self.slope(xi) / length, np.cross(ALONG, self.direction))

    def shift(self, xi: Array) -> Array:
        """Displacements (n, 3) of the beam's axis at xi = x/length per unit of the modal coordinate."""
        return np.outer(self.shape(xi) * (self.kind != TORSION), self.direction)


@dataclass(frozen=True, eq=False)
class ModalBeam:
    """A beam by modes, in its own frame, x along it: a body of points, m modes, and how its tip moves.

    The tip moves by `tip` (m, 3) and turns by `turn` (m, 3) per unit of e, and comes nearer to the root by
    e^T `shortening` e/2.
    """

    modes: tuple[Mode, ...]
    length: float
    mass: Array
    points: Array
    phi: Array
    foreshortening: Array

    @property
    def tip(self) -> Array:
        """Displacements (m, 3) of the tip per unit deflection of each of the m modes."""
        return np.array([mode.direction * (mode.kind != TORSION) for mode in self.modes])

    @property
    def turn(self) -> Array:
        """Rotations (m, 3) of the tip per unit deflection of each of the m modes, rad."""
        return np.array([mode.turn(np.ones(1), self.length)[0] for mode in self.modes])

    @property
    def shortening(self) -> Array:
        """Foreshortening (m, m) at the tip, with its sign reversed."""
        return -self.foreshortening[:, :, -1]

    @property
    def rigid(self) -> tuple[float, Array, Array]:
        """Mass, first moments (3,) and inertia (3, 3) about the root of the beam at rest."""
        P = np.einsum("i,ia,ib->ab", self.mass, self.points, self.points)
        moments, inertia = self.mass @ self.points, np.trace(P) * np.eye(3) - P
        return float(self.mass.sum()), without_rounding(moments), without_rounding(inertia)

    def body(self, joint: str, names: Sequence[str]) -> FlexibleBody:
        """The flexible body of a row, its modes the rows of these names."""
        s = self.foreshortening[:, :, :-1, None] * ALONG
        return FlexibleBody.of(joint, names, integrals_of(self.mass, self.points, self.phi, s))


def modal_beam(beam: Beam, values: Mapping[str, float], directions: Mapping[str, Array]) -> ModalBeam:
    """Return a beam by modes, from the values of names; `directions` (3,) are those of bending in its own frame.

    Raises `FormulaError` for a name without a value.
    """
    length, line_mass = (Formula.parse(x).value(values) for x in (beam.length, beam.mass))
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    squares = {kind: Formula.parse(beam.inertia[kind]).value(values) / line_mass for kind in (TORSION, *directions)}
    section = list(_section(squares, directions))
    places, offsets = np.repeat((nodes + 1) / 2, len(section)), np.tile(section, (NODES, 1))
    mass = np.repeat(line_mass * length * weights / 2, len(section)) / len(section)
    modes = [x for kind in beam.bends for x in _modes(beam, kind, length, values, (mass, places, offsets), directions)]
    phi = [_displacements(mode, places, offsets, length) for mode in modes]
    s = _foreshortening(modes, np.append(places, 1.0), length, beam.stiffening)
    return ModalBeam(tuple(modes), length, mass, np.outer(length * places, ALONG) + offsets, np.array(phi), s)


def _section(squares: Mapping[str, float], directions: Mapping[str, Array]) -> Iterator[Array]:
    """Points of equal mass with second moments of a section by mass, m2; half the polar each if those across are 0."""
    halved = {} if any(squares[kind] for kind in directions) else dict.fromkeys(directions, squares[TORSION] / 2)
    for kind, axis in directions.items():
        offset = math.sqrt(2 * halved.get(kind, squares[kind]))
        yield from (offset * axis, -offset * axis)


def _displacements(mode: Mode, places: Array, offsets: Array, length: float) -> Array:
    """Displacements (n, 3) of points at `offsets` (n, 3) from the axis."""
    moved: Array = mode.shift(places) + np.cross(mode.turn(places, length), offsets)
    return moved


def _modes(
    beam: Beam,
    kind: str,
    length: float,
    values: Mapping[str, float],
    points: tuple[Array, Array, Array],
    directions: Mapping[str, Array],
) -> list[Mode]:
    """Modes of a kind: K c = w^2 M c for its shapes."""
    mass, places, offsets = points
    is_bar = kind in (TORSION, AXIAL)
    direction = directions.get(kind, ALONG)
    shapes, softness = list(_shapes(is_bar, beam.modes_of(kind))), beam.softness.get(kind, 0.0)
    trial = [
        _displacements(Mode(kind, _deflection(p, softness), p.deriv(), direction, 0.0, 0.0), places, offsets, length)
        for p in shapes
    ]
    M = np.einsum("i,kia,lia->kl", mass, trial, trial)
    strains = [p.deriv(1 if is_bar else 2) for p in shapes]
    scale = Formula.parse(beam.stiffness[kind]).value(values) / length ** (1 if is_bar else 3)
    K = scale * np.array([[_integral(a * b) for b in strains] for a in strains])
    if softness:
        K += scale * softness * np.array([[_integral(a.deriv() * b.deriv()) for b in strains] for a in strains])
    lower = np.linalg.inv(np.linalg.cholesky(M))
    squares, vectors = np.linalg.eigh(lower @ K @ lower.T)
    damping = 2 * Formula.parse(beam.damping).value(values) / math.sqrt(squares[0])
    modes = []
    for square, vector in zip(squares, (lower.T @ vectors).T, strict=True):
        bent = sum((c * p for c, p in zip(vector, shapes, strict=True)), Polynomial([0.0]))
        moved = _deflection(bent, softness)
        tip = moved(1.0)
        stiffness = float(square / tip**2)
        modes.append(Mode(kind, moved / tip, (bent / tip).deriv(), direction, stiffness, damping * stiffness))
    return modes


def _deflection(bent: Polynomial, softness: float) -> Polynomial:
    """Deflection of the axis with shear, from the shape `bent` whose slope is the rotation of the sections."""
    return bent - softness * (bent.deriv(2) - bent.deriv(2)(0.0))


def _shapes(is_bar: bool, count: int) -> Iterator[Polynomial]:
    """Static shapes, then those that vanish at both ends."""
    xi = Polynomial([0.0, 1.0])
    static = [xi] if is_bar else [xi**2, xi**3]
    between = xi * (1 - xi) if is_bar else xi**2 * (1 - xi) ** 2
    yield from static[:count]
    for k in range(count - len(static)):
        yield between * Legendre.basis(k, domain=[0, 1]).convert(kind=Polynomial)


def _integral(x: Polynomial) -> float:
    return float(x.integ()(1.0))


def _foreshortening(modes: Sequence[Mode], places: Array, length: float, stiffening: bool) -> Array:
    """s_kl (m, m, n) along the beam: -int phi_k' phi_l' dx of modes that bend in one direction."""
    s = np.zeros((len(modes), len(modes), len(places)))
    for k, a in enumerate(modes):
        for m, b in enumerate(modes):
            if stiffening and a.kind == b.kind and a.kind not in (TORSION, AXIAL):
                s[k, m] = -(a.shape.deriv() * b.shape.deriv()).integ()(places) / length
    return s
