"""Stiffnesses of machine elements from numbers of catalogues, as formulas that keep the names of their parameters.

Elements in series add compliances, in parallel stiffnesses, for the preload of the catalogue and on rigid surfaces.
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
class CatalogueSpring:
    """The spring of an elastic joint whose stiffness, N/m or N m/rad, comes from the numbers of a catalogue."""

    joint: str
    stiffness: Formula
    source: str
    tolerance: str


ELEMENTS = {
    "guides": ("Gross, Hamann, Wiegaertner 2001", "20 %, on rigid surfaces"),
    "bearings": ("Harris, Kotzalas 2006", "20 %, by preload and fits"),
    "screws": ("ISO 3408-4; Altintas 2012", "20 % of the nut, 5 % of the rod"),
    "belts": ("Gates Mectrol 2006", "10 %, without teeth of pulleys"),
    "couplings": ("springs in series", "15 %, without clamps"),
}
"""Source and tolerance by table. Tolerances are estimates of what preload, mounting and load change."""


def formula_of(template: str, **cells: Formula | int | Fraction) -> Formula:
    """The formula with cells in place of the names in braces."""
    texts = {name: str(cell) for name, cell in cells.items()}
    return Formula.parse(template.format(**{name: x if ATOM.fullmatch(x) else f"({x})" for name, x in texts.items()}))


def guide(
    blocks: int, distance: tuple[Formula, Formula], radial: Formula, lateral: Formula, moments: Sequence[Formula]
) -> dict[str, Formula]:
    """Stiffnesses of a carriage on profiled rails about the middle of its blocks: lateral, normal, roll, pitch, yaw.

    n blocks of stiffness k_z normal to the plane of the rails (`radial`) and k_y across them (`lateral`), N/m, are
    evenly spaced over the distance a along each of two rails at a distance b, or along one where b is zero. Each has
    stiffnesses k_m about the rail, the lateral and the normal direction (`moments`), N m/rad:

        n k_y,  n k_z,  n (k_z (b/2)^2 + k_m),  n (k_z x^2 + k_m),  n (k_y x^2 + k_m)

    where x^2 = (a/2)^2 (m + 1)/(3 (m - 1)) with m blocks along a rail. Within 20 % of a block's stiffness on rigid
    surfaces; others may halve it. Source: Gross, Hamann, Wiegaertner, Electrical feed drives in automation, 2001.
    """
    a, b = distance
    in_row = blocks if b.is_zero else blocks // 2
    spread = Fraction(in_row + 1, 3 * (in_row - 1)) if in_row > 1 else Fraction(0)
    stiffnesses = {name: formula_of("{n}*{k}", n=blocks, k=k) for name, k in (("lateral", lateral), ("normal", radial))}
    turns = (("roll", radial, b, Fraction(1)), ("pitch", radial, a, spread), ("yaw", lateral, a, spread))
    for (name, k, arm, factor), k_m in zip(turns, moments, strict=True):
        template = "{n}*{k}*({arm}/2)^2" + "*{factor}" * (factor != 1) + " + {n}*{k_m}" * (not k_m.is_zero)
        stiffnesses[name] = formula_of(template, n=blocks, k=k, arm=arm, factor=factor, k_m=k_m)
    return stiffnesses


def bearing_pair(
    radial: Formula, axial: Formula, distance: Formula, arrangement: str, contact_angle: Formula, pitch: Formula
) -> dict[str, Formula]:
    """Stiffnesses of a preloaded pair of ball bearings about the middle between them: radial, axial, tilt.

    Each bearing, of stiffnesses k_r and k_a, N/m, acts at its pressure centre, where its lines of contact meet and no
    moment is left. With the distance l of the bearings, the pitch diameter D and the contact angle alpha

        2 k_r,  2 k_a,  2 k_r (s/2)^2,  s = l + D tan(alpha) (O, back to back),  l - D tan(alpha) (X, face to face)

    Within 20 %, by preload, speed and fits. Source: Harris, Kotzalas, Rolling bearing analysis, 2006.
    """
    spread = "({l} + {D}*tan({alpha}))" if arrangement == "O" else "({l} - {D}*tan({alpha}))"
    return {
        "radial": formula_of("2*{k}", k=radial),
        "axial": formula_of("2*{k}", k=axial),
        "tilt": formula_of(f"2*{{k}}*({spread}/2)^2", k=radial, l=distance, D=pitch, alpha=contact_angle),
    }


def screw(
    nut: Formula, rod: tuple[Formula, Formula], position: Formula, length: Formula | None = None,
    bearing: Formula | None = None, torsional: tuple[Formula, Formula] | None = None,
) -> Formula:  # fmt: skip
    """Axial stiffness, N/m, of a ball screw at the distance x of its nut from a fixed bearing.

    The rod has the core diameter d, m, and the modulus E, Pa: A = pi d^2/4. In series are the nut, the rod to each
    fixed bearing with that bearing, the second at the distance L - x where a length L is given, and the torsional
    stiffness k_t, N m/rad, of what drives the screw, by its lead h, m:

        1/k = 1/k_nut + 1/(1/(1/k_b + x/(EA)) + 1/(1/k_b + (L - x)/(EA))) + (h/(2 pi))^2/k_t

    Within 20 % of the nut, 5 % of the rod. Sources: ISO 3408-4; Altintas, Manufacturing automation, 2012.
    """
    k_b = "1/{k_b} + " if bearing else ""
    path, other = (f"({k_b}4*{x}/({{E}}*pi*{{d}}^2))" for x in ("{x}", "({L} - {x})"))
    to_bearings = f"1/(1/{path} + 1/{other})" if length else path
    template = f"1/(1/{{nut}} + {to_bearings}" + " + ({h}/(2*pi))^2/{k_t}" * bool(torsional) + ")"
    k_t, h = torsional or (nut, nut)
    cells = {"nut": nut, "d": rod[0], "E": rod[1], "x": position, "L": length or nut, "k_b": bearing or nut}
    return formula_of(template, **cells, k_t=k_t, h=h)


def belt(specific: Formula, strands: tuple[Formula, Formula]) -> Formula:
    """Stiffness, N/m, of a preloaded belt whose strands of lengths L1, L2, m, both pull: c (1/L1 + 1/L2).

    `specific` is c = EA, N: force over relative elongation. Within 10 %, without the teeth of pulleys. Source: Gates
    Mectrol, Timing belt theory, 2006.
    """
    return formula_of("{c}*(1/{a} + 1/{b})", c=specific, a=strands[0], b=strands[1])


def coupling(torsional: Sequence[Formula]) -> Formula:
    """Torsional stiffness, N m/rad, of couplings and shafts in series: 1/k = sum 1/k_i. Within 15 %, without clamps."""
    compliances = [formula_of("1/{k}", k=k).text for k in torsional]
    return Formula.parse(f"1/({' + '.join(compliances)})")


def about_axis(stiffness: Formula, radius: Formula) -> Formula:
    """A stiffness k along a line as k r^2, N m/rad, about an axis whose turning moves the line by r per rad."""
    return formula_of("{k}*{r}^2", k=stiffness, r=radius)
