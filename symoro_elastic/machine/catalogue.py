"""Stiffnesses of machine elements from numbers of catalogues, as formulas that keep the names of their parameters.

Elements in series add compliances, elements in parallel stiffnesses; what they are bolted to counts as rigid. Values
of catalogues are for the preload of the catalogue.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from symoro_elastic.machine.formula import Formula

ATOM = re.compile(r"\w+(\.\w*)?", re.ASCII)
"""A text of a formula that needs no brackets: a name, or a number."""


@dataclass(frozen=True)
class Element:
    """A kind of machine element: where its formulas are from, and how far its stiffness may be from them."""

    name: str
    source: str
    tolerance: str


@dataclass(frozen=True)
class Stiffness:
    """A stiffness, N/m or N m/rad, and its formula in symbols."""

    formula: Formula
    rule: str


@dataclass(frozen=True)
class CatalogueSpring:
    """The spring of an elastic joint whose stiffness comes from an element of a catalogue."""

    joint: str
    stiffness: Stiffness
    element: Element


GUIDE = Element(
    "guide",
    "rigid carriage on springs at the blocks (Gross, Hamann, Wiegaertner: Electrical feed drives in automation, 2001)",
    "20 % by preload; mounting surfaces may halve it",
)
BEARING = Element(
    "bearings",
    "springs at the pressure centres (Harris, Kotzalas: Rolling bearing analysis, 2006)",
    "20 % by preload, speed and fits",
)
SCREW = Element(
    "screw",
    "ISO 3408-4: nut, shaft and bearings in series (Altintas: Manufacturing automation, 2012)",
    "20 % of the nut, 5 % of the shaft",
)
BELT = Element("belt", "Gates Mectrol: Timing belt theory, 2006", "10 % by load; teeth of the pulleys are left out")
COUPLING = Element("coupling", "springs in series", "15 % by torque; clamps are left out")
"""Tolerances are estimates of what preload, mounting and load change, not limits that manufacturers state."""


def formula_of(template: str, **cells: Formula | int | Fraction) -> Formula:
    """The formula with cells in place of the names in braces."""
    texts = {name: str(cell) for name, cell in cells.items()}
    return Formula.parse(template.format(**{name: x if ATOM.fullmatch(x) else f"({x})" for name, x in texts.items()}))


def guide(
    blocks: int, distance: tuple[Formula, Formula], radial: Formula, lateral: Formula, moments: Sequence[Formula]
) -> dict[str, Stiffness]:
    """Stiffnesses of a carriage on profiled rails about the middle of its blocks: lateral, normal, roll, pitch, yaw.

    n blocks of stiffness k_z normal to the plane of the rails (`radial`) and k_y across them (`lateral`), N/m, are
    evenly spaced over the distance a along each of two rails at a distance b, or along one where b is zero. Each has
    stiffnesses k_m about the rail, the lateral and the normal direction (`moments`), N m/rad:

        n k_y,  n k_z,  n (k_z (b/2)^2 + k_m),  n (k_z x^2 + k_m),  n (k_y x^2 + k_m)

    where x^2 = (a/2)^2 (m + 1)/(3 (m - 1)) with m blocks along a rail. Source and tolerance: `GUIDE`.
    """
    a, b = distance
    in_row = blocks if b.is_zero else blocks // 2
    spread = Fraction(in_row + 1, 3 * (in_row - 1)) if in_row > 1 else Fraction(0)
    turns = (("roll", radial, b, Fraction(1)), ("pitch", radial, a, spread), ("yaw", lateral, a, spread))
    found = {
        "lateral": Stiffness(formula_of("{n}*{k}", n=blocks, k=lateral), "n k_y"),
        "normal": Stiffness(formula_of("{n}*{k}", n=blocks, k=radial), "n k_z"),
    }
    for (name, k, arm, factor), moment in zip(turns, moments, strict=True):
        template = "{n}*{k}*({arm}/2)^2" + "*{factor}" * (factor != 1) + " + {n}*{k_m}" * (not moment.is_zero)
        formula = formula_of(template, n=blocks, k=k, arm=arm, factor=factor, k_m=moment)
        rule = {"roll": "n k_z (b/2)^2", "pitch": "n k_z x^2", "yaw": "n k_y x^2"}[name]
        found[name] = Stiffness(formula, rule + " + n k_m" * (not moment.is_zero))
    return found


def bearing_pair(
    radial: Formula, axial: Formula, distance: Formula, arrangement: str, contact_angle: Formula, pitch: Formula
) -> dict[str, Stiffness]:
    """Stiffnesses of a preloaded pair of ball bearings about the middle between them: radial, axial, tilt.

    Each bearing, of stiffnesses k_r and k_a, N/m, acts at its pressure centre, where its lines of contact meet and no
    moment is left. With the distance l of the bearings, the pitch diameter D and the contact angle alpha

        2 k_r,  2 k_a,  2 k_r (s/2)^2,  s = l + D tan(alpha) (O, back to back),  l - D tan(alpha) (X, face to face)

    Source and tolerance: `BEARING`.
    """
    sign = "+" if arrangement == "O" else "-"
    tilt = formula_of(
        "2*{k}*(({l} " + sign + " {D}*tan({alpha}))/2)^2", k=radial, l=distance, D=pitch, alpha=contact_angle
    )
    return {
        "radial": Stiffness(formula_of("2*{k}", k=radial), "2 k_r"),
        "axial": Stiffness(formula_of("2*{k}", k=axial), "2 k_a"),
        "tilt": Stiffness(tilt, f"2 k_r ((l {sign} D tan(alpha))/2)^2"),
    }


def screw(
    nut: Formula,
    rod: tuple[Formula, Formula],
    position: Formula,
    *,
    length: Formula | None = None,
    bearing: Formula | None = None,
    torsional: tuple[Formula, Formula] | None = None,
) -> Stiffness:
    """Axial stiffness, N/m, of a ball screw at the distance x of its nut from a fixed bearing.

    The rod has the core diameter d, m, and the modulus E, Pa: A = pi d^2/4. In series are the nut, the rod to each
    fixed bearing with that bearing, the second at the distance L - x where a length L is given, and the torsional
    stiffness k_t, N m/rad, of what drives the screw, by its lead h, m:

        1/k = 1/k_nut + 1/(1/(1/k_b + x/(EA)) + 1/(1/k_b + (L - x)/(EA))) + (h/(2 pi))^2/k_t

    Source and tolerance: `SCREW`.
    """
    diameter, modulus = rod
    compliance = "1/{bearing} + " if bearing else ""
    path = f"({compliance}4*{{x}}/({{E}}*pi*{{d}}^2))"
    other = f"({compliance}4*({{L}} - {{x}})/({{E}}*pi*{{d}}^2))"
    shaft = f"1/(1/{path} + 1/{other})" if length else path
    twist = "({h}/(2*pi))^2/{t}"
    template = f"1/(1/{{nut}} + {shaft}" + (f" + {twist}" if torsional else "") + ")"
    stiffness, lead = torsional or (nut, nut)
    cells = {"nut": nut, "d": diameter, "E": modulus, "x": position, "t": stiffness, "h": lead}
    formula = formula_of(template, **cells, bearing=bearing or nut, L=length or nut)
    rule = "nut, rod to both ends" if length else "nut, rod to one end"
    parts = [rule, *(["bearings"] if bearing else []), *(["torsion"] if torsional else [])]
    return Stiffness(formula, f"{', '.join(parts)} in series")


def belt(specific: Formula, strands: tuple[Formula, Formula]) -> Stiffness:
    """Stiffness, N/m, of a preloaded belt whose strands of lengths L1, L2, m, both pull: c (1/L1 + 1/L2).

    `specific` is c = EA, N: force over relative elongation. Source and tolerance: `BELT`.
    """
    first, second = strands
    return Stiffness(formula_of("{c}*(1/{a} + 1/{b})", c=specific, a=first, b=second), "c (1/L1 + 1/L2)")


def coupling(torsional: Sequence[Formula]) -> Stiffness:
    """Torsional stiffness, N m/rad, of couplings and shafts in series; source and tolerance: `COUPLING`."""
    if len(torsional) == 1:
        return Stiffness(torsional[0], "k")
    names = {f"k{i}": k for i, k in enumerate(torsional, start=1)}
    compliances = " + ".join(f"1/{{{name}}}" for name in names)
    return Stiffness(formula_of(f"1/({compliances})", **names), f"1/({compliances.replace('{', '').replace('}', '')})")


def about_axis(stiffness: Stiffness, radius: Formula) -> Stiffness:
    """A stiffness k along a line as one about an axis, N m/rad, that moves the line by r rad: k r^2."""
    return Stiffness(formula_of("{k}*{r}^2", k=stiffness.formula, r=radius), f"({stiffness.rule}) r^2")
