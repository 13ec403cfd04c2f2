"""Uniform beams as rigid pieces with elastic joints between them: where joints are, and how stiff.

Of a beam of length L that is clamped at one end, the joint at x_i L has the stiffness k_i = EI/(w_i L). Tip deflection
and slope under force and moment are exact where sum w = 1, sum w x = 1/2, sum w x^2 = 1/3. Every cell is a text over
the names of the file, so that sections and moduli stay parameters.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symoro_elastic.machine.formula import Formula

Rule = tuple[tuple[float, ...], tuple[float, ...]]
"""Places of joints as fractions of the length, and fractions w of the compliance."""
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
"""Fitted places; those of Gauss and Legendre; the middles of equal pieces."""
MOST_JOINTS = 20
"""Of a beam by the rules gauss and equal."""
MOST_MODES = 6
"""Of a direction: three frequencies within 0.04 %, turning up to six times 1/L^2 sqrt(EI/mass_per_length)."""
CLAMPED = 3.5160152685
"""First root of cosh(sqrt(x)) cos(sqrt(x)) = -1: w1 = x sqrt(EI/(m L^3)) of a clamped beam of mass m."""
TRANSVERSE = {"x": ("y", "z"), "y": ("z", "x"), "z": ("x", "y")}
"""Directions across an axis, in cyclic order."""
TORSION, AXIAL = "torsion", "axial"
SIZES = {"rod": 1, "tube": 2, "bar": 2, "box": 3}
"""Numbers that describe a section: diameter; outer and inner diameter; two sides; two sides and the wall."""


def places_of(rule: str, joints: int, is_bar: bool) -> Rule:
    """Places and compliance fractions of so many joints; raises `KeyError` where the rule has none."""
    if rule == FITTED:
        return (FITTED_BARS if is_bar else FITTED_BENDING)[joints]
    if rule == GAUSS:
        nodes, weights = np.polynomial.legendre.leggauss(joints)
        return tuple(((1 + nodes) / 2).tolist()), tuple((weights / 2).tolist())
    return tuple((k + 0.5) / joints for k in range(joints)), (1 / joints,) * joints


def product(*factors: str | float, over: Sequence[str | float] = ()) -> str:
    """The text of a product of formulas, divided by others: numbers in it become one.

    A whole number is written times 0.1, since checks of units count whole numbers as ratios.
    """
    number, above, below = 1.0, list[str](), list[str]()
    for parts, names in ((factors, above), (over, below)):
        for formula in map(Formula.parse, parts):
            if formula.names:
                names.append(_operand(formula.text))
            else:
                number *= formula.value() if parts is factors else 1 / formula.value()
    if not (above or below):
        return f"{number:.15g}"
    first = f"{10 * number:.15g}*0.1" if number.is_integer() else f"{number:.15g}"
    return "*".join([*([first] if number != 1.0 or not above else []), *above]) + "".join(f"/{name}" for name in below)


def _operand(text: str) -> str:
    """A formula as an operand of any operation: names, numbers and roots without brackets."""
    tree = Formula.parse(text).tree
    is_atom = tree[0] in ("name", "sqrt") or (tree[0] == "number" and tree[1] >= 0)
    return text if is_atom else f"({text})"


@dataclass(frozen=True)
class Section:
    """Area, m2, integrals of the squares of both coordinates over it, m4, and torsion constant, m4."""

    area: str
    squares: tuple[str, str]
    torsion: str


def section_of(kind: str, sizes: Sequence[str], longer: int) -> Section:
    """The section of a kind of `SIZES`; `longer` is the index of the longer side of a bar.

    Torsion of bars by Roark's formula, a b^3 (1/3 - 0.21 b/a (1 - b^4/(12 a^4))) with a > b, within 0.5 %, of boxes by
    Bredt's, 4 A^2 t/s with the area A and the length s of the middle line.
    """
    a, b, t = map(_operand, (*sizes, "0", "0")[:3])
    if kind in ("rod", "tube"):
        square, fourth = (f"({a}^{n} - {b}^{n})" if kind == "tube" else f"{a}^{n}" for n in (2, 4))
        return Section(f"pi/4*{square}", (f"pi/64*{fourth}",) * 2, f"pi/32*{fourth}")
    if kind == "bar":
        long, short = (a, b) if longer == 0 else (b, a)
        thin = f"(1/3 - 0.21*{short}/{long}*(1 - {short}^4/{long}^4/12))"
        return Section(f"{a}*{b}", (f"{a}^3*{b}/12", f"{a}*{b}^3/12"), f"{long}*{short}^3*{thin}")
    c, d = f"({a} - 2*{t})", f"({b} - 2*{t})"
    squares = (f"({a}^3*{b} - {c}^3*{d})/12", f"({a}*{b}^3 - {c}*{d}^3)/12")
    return Section(f"({a}*{b} - {c}*{d})", squares, f"2*{t}*({a} - {t})^2*({b} - {t})^2/({a} + {b} - 2*{t})")


@dataclass(frozen=True)
class Beam:
    """A uniform beam along an axis (x, -y ...) of the frame of the row `name`.

    `stiffness` holds EI by the direction of the deflection, N m2, GJ by "torsion", N m2, and EA by "axial", N, of those
    in `bends`. `mass` is per length, kg/m, `inertia` by direction the inertia per length, kg m, of the section about
    the axis at right angles to that direction, and about its own axis by "torsion". `damping` is the ratio of every
    kind of bending at its first frequency with the root clamped and the tip free. `doubts` say what is implausible.
    With `modes` it bends by so many in each direction in place of joints; with `stiffening` tension stiffens it.
    `section` is its kind and its sizes as the file writes them, `choice` which errors led to joints = "auto".
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

    @property
    def cells(self) -> tuple[str, ...]:
        """All its formulas."""
        return (self.length, *self.stiffness.values(), self.mass, *self.inertia.values(), self.damping)

    @property
    def transverse(self) -> tuple[str, str]:
        """The directions across the beam, in cyclic order."""
        return TRANSVERSE[self.along[-1]]

    def places(self, kind: str) -> Rule:
        """Places and compliance fractions of the joints of a kind: half as many of torsion and tension."""
        is_bar = kind in (TORSION, AXIAL)
        joints = (self.joints + 1) // 2 if is_bar else self.joints
        return places_of(self.rule, joints, is_bar)

    def modes_of(self, kind: str) -> int:
        """Number of modes of a kind: half as many of torsion and tension."""
        return (self.modes + 1) // 2 if kind in (TORSION, AXIAL) else self.modes

    def spring(self, kind: str, share: float) -> tuple[str, str]:
        """Stiffness and damping of a joint with this fraction of the compliance: k = EI/(w L), d = 2 zeta k/w1.

        With w1 put in d is 2 zeta L sqrt(EI m)/(3.516 w) of bending with m per length, 4 zeta sqrt(GJ J)/(pi w) of
        torsion with J per length, and 4 zeta sqrt(EA m)/(pi w) of tension.
        """
        stiffness = product(self.stiffness[kind], over=(share, self.length))
        root = f"sqrt({product(self.stiffness[kind], self.inertia[kind] if kind == TORSION else self.mass)})"
        if kind in (TORSION, AXIAL):
            return stiffness, product(4 / (math.pi * share), self.damping, root)
        return stiffness, product(2 / (CLAMPED * share), self.damping, self.length, root)

    def piece(self, start: float, end: float) -> tuple[str, tuple[str, str, str]]:
        """Mass, kg, of the part from `start` to `end` (fractions), and its inertia about its centre, kg m2.

        The inertia is about the axis of the beam, and about the two directions across it.
        """
        part = end - start
        slender = product(part**3 / 12, self.mass, f"{_operand(self.length)}^3")
        first, second = self.transverse
        of_section = {kind: product(part, self.inertia[kind], self.length) for kind in (TORSION, first, second)}
        across = (f"{slender} + {of_section[kind]}" for kind in (second, first))
        about_first, about_second = (x if Formula.parse(x).names else product(x) for x in across)
        return product(part, self.mass, self.length), (of_section[TORSION], about_first, about_second)

    def first_frequencies(self, values: Mapping[str, float]) -> Iterator[tuple[str, float | None]]:
        """Kinds of deflection with the first frequency, Hz, clamped at the root; None where a name has no value."""
        for kind in self.bends:
            numbers = [self.stiffness[kind], self.inertia[kind] if kind == TORSION else self.mass, self.length]
            stiffness, inertia, length = (Formula.parse(x).known_value(values) for x in numbers)
            if not stiffness or not inertia or not length:
                yield kind, None
            elif kind in (TORSION, AXIAL):
                yield kind, math.sqrt(stiffness / inertia) / (4 * length)
            else:
                yield kind, CLAMPED * math.sqrt(stiffness / inertia) / (2 * math.pi * length**2)
