"""Beams as rigid pieces with elastic joints between them: where joints are, and how stiff.

Of a uniform beam of length L that is clamped at one end, the joint at x_i L has the stiffness k_i = EI/(w_i L). Tip
deflection and slope under force and moment are exact where sum w = 1, sum w x = 1/2, sum w x^2 = 1/3. Of others EI is
that at the root, and sums are the integrals of EI_root/EI. Every cell is a text over the names of the file, so that
moduli, and sections of uniform beams, stay parameters.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from symoro_elastic.machine.beams.deflections import Joints, Line, Rule, slowness
from symoro_elastic.machine.beams.places import joints_along
from symoro_elastic.machine.beams.sections import AREA, AXIAL, POLAR, SHEAR, SQUARES, TORSION, Profile, operand, product
from symoro_elastic.machine.formula import Formula

MOST_MODES = 6
"""Of a direction: three frequencies within 0.04 %, turning up to six times 1/L^2 sqrt(EI/mass_per_length)."""
CLAMPED = 3.5160152685
"""First root of cosh(sqrt(x)) cos(sqrt(x)) = -1: w1 = x sqrt(EI/(m L^3)) of a clamped beam of mass m."""
TRANSVERSE = {"x": ("y", "z"), "y": ("z", "x"), "z": ("x", "y")}
"""Directions across an axis, in cyclic order."""
IN_SHEAR = "shear_"
"""Start of the kind of slides that have the compliance of shear in a direction: shear_y."""


@dataclass(frozen=True)
class Beam:
    """A beam along an axis (x, -y ...) of the frame of the row `name`.

    `stiffness` holds EI by the direction of the deflection, N m2, GJ by "torsion", N m2, and EA by "axial", N, of those
    in `bends`. `mass` is per length, kg/m, `inertia` by direction the inertia per length, kg m, of the section about
    the axis at right angles to that direction, and about its own axis by "torsion". `damping` is the ratio of every
    kind of bending at its first frequency with the root clamped and the tip free. `doubts` say what is implausible.
    With `modes` it bends by so many in each direction in place of joints; with `stiffening` tension stiffens it.
    `section` is its kind and its sizes as the file writes them, `choice` which errors led to joints = "auto".
    All are those at the root where its sections change by `profile`. With shear, `shear` is its stiffness kGA, N, by
    direction, and `softness` EI/(kGA L^2); `gyration` is m r^2/(m L^2) of the section, where it is a number.
    """

    name: str
    along: str
    length: str
    stiffness: Mapping[str, str]
    mass: str
    inertia: Mapping[str, str]
    damping: str
    rule: str
    joints: int
    bends: tuple[str, ...]
    doubts: tuple[str, ...] = ()
    modes: int = 0
    stiffening: bool = False
    section: tuple[str, tuple[str, ...]] = ("", ())
    choice: str = ""
    profile: Profile = Profile()
    shear: Mapping[str, str] = field(default_factory=dict)
    softness: Mapping[str, float] = field(default_factory=dict)
    gyration: Mapping[str, float] = field(default_factory=dict)

    @property
    def cells(self) -> tuple[str, ...]:
        """Formulas of length, mass, damping, stiffnesses and inertias of the beam."""
        numbers = (self.length, self.mass, self.damping)
        return (*numbers, *self.stiffness.values(), *self.inertia.values(), *self.shear.values())

    @property
    def transverse(self) -> tuple[str, str]:
        """The directions across the beam, in cyclic order."""
        return TRANSVERSE[self.along[-1]]

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of joints: those of `bends`, and of slides in shear."""
        return *self.bends, *(IN_SHEAR + kind for kind in self.bends if kind in self.shear)

    def line(self, kind: str) -> Line:
        """Distribution of stiffness, mass and shear along the beam, for one kind of deflection."""
        if kind in (TORSION, AXIAL):
            return Line(self.profile, *((TORSION, POLAR) if kind == TORSION else (AREA, AREA)))
        k = sorted(self.transverse).index(kind)
        softness, gyration = self.softness.get(kind, 0.0), self.gyration.get(kind, 0.0)
        return Line(self.profile, SQUARES[k], AREA, SHEAR[k], softness, gyration)

    def joints_of(self, kind: str) -> Joints:
        """The joints of a kind of deflection; torsion and tension have half as many as bending."""
        is_bar = kind in (TORSION, AXIAL)
        return joints_along(self.rule, (self.joints + 1) // 2 if is_bar else self.joints, is_bar, self.line(kind))

    def places(self, kind: str) -> Rule:
        """Places and compliance fractions of the joints of a kind, in shear by the compliance of a uniform beam."""
        if not kind.startswith(IN_SHEAR):
            return self.joints_of(kind).bent
        direction = kind.removeprefix(IN_SHEAR)
        places, shares = self.joints_of(direction).slides
        return places, tuple(w / self.softness[direction] for w in shares)

    def modes_of(self, kind: str) -> int:
        """Number of modes of a kind of deflection; torsion and tension have half as many as bending."""
        return (self.modes + 1) // 2 if kind in (TORSION, AXIAL) else self.modes

    def spring(self, kind: str, share: float) -> tuple[str, str]:
        """Stiffness and damping of a joint with this fraction of the compliance: k = EI/(w L), d = 2 zeta k/w1.

        With w1 put in d is 2 zeta L sqrt(EI m)/(3.516 w) of bending with m per length, 4 zeta sqrt(GJ J)/(pi w) of
        torsion with J per length, 4 zeta sqrt(EA m)/(pi w) of tension, and of shear the k/w1 of its direction.
        """
        if kind.startswith(IN_SHEAR):
            bent = kind.removeprefix(IN_SHEAR)
            shear, root = self.shear[bent], f"sqrt({product(self.mass, over=(self.stiffness[bent],))})"
            factor = 2 / (CLAMPED * slowness(self.line(bent), is_bar=False) * share)
            return product(shear, over=(share, self.length)), product(factor, self.damping, self.length, shear, root)
        is_bar = kind in (TORSION, AXIAL)
        slow = slowness(self.line(kind), is_bar)
        stiffness = product(self.stiffness[kind], over=(share, self.length))
        root = f"sqrt({product(self.stiffness[kind], self.inertia[kind] if kind == TORSION else self.mass)})"
        if is_bar:
            return stiffness, product(4 / (math.pi * slow * share), self.damping, root)
        return stiffness, product(2 / (CLAMPED * slow * share), self.damping, self.length, root)

    def piece(self, start: float, end: float) -> tuple[str, str, tuple[str, str, str]]:
        """Mass, kg, of the part from `start` to `end` (fractions), its centre from the start, m, and inertia, kg m2.

        The inertia is about the centre and the axis of the beam, and about the two directions across it.
        """
        part, (mean, beyond, spread) = end - start, self.profile.moments(AREA, start, end)
        slender = product(part**3 / 12 * spread, self.mass, f"{operand(self.length)}^3")
        of_section = {
            kind: product(part * self.profile.moments(quantity, start, end)[0], self.inertia[kind], self.length)
            for kind, quantity in zip((TORSION, *sorted(self.transverse)), (POLAR, *SQUARES), strict=True)
        }
        across = (f"{slender} + {of_section[kind]}" for kind in self.transverse[::-1])
        about_first, about_second = (x if Formula.parse(x).names else product(x) for x in across)
        mass, center = product(part * mean, self.mass, self.length), product(part / 2 + beyond, self.length)
        return mass, center, (of_section[TORSION], about_first, about_second)

    def first_frequencies(self, values: Mapping[str, float]) -> Iterator[tuple[str, float | None]]:
        """Kinds of deflection with the first frequency, Hz, clamped at the root; None where a name has no value."""
        for kind in self.bends:
            numbers = [self.stiffness[kind], self.inertia[kind] if kind == TORSION else self.mass, self.length]
            stiffness, inertia, length = (Formula.parse(x).known_value(values) for x in numbers)
            is_bar = kind in (TORSION, AXIAL)
            if not stiffness or not inertia or not length:
                yield kind, None
            elif is_bar:
                yield kind, slowness(self.line(kind), is_bar) * math.sqrt(stiffness / inertia) / (4 * length)
            else:
                unit = math.sqrt(stiffness / inertia) / (2 * math.pi * length**2)
                yield kind, slowness(self.line(kind), is_bar) * CLAMPED * unit
