"""Sections of beams: areas, second moments, torsion constants and shear areas, and how sizes change along a beam."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.polynomial import legendre

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.formula import Formula

TORSION, AXIAL = "torsion", "axial"
AREA, POLAR = "area", "polar"
"""Quantities of a section, beside torsion: its area, and the integral of the squares of both coordinates."""
SQUARES, SHEAR = ("first square", "second square"), ("first shear", "second shear")
"""Integrals of the squares of both coordinates, and areas that carry shear along them, in the order of sizes."""
NAMES = ("a", "b", "t")
"""Of the sizes of a section."""
NODES = 16
"""Of Gauss and Legendre between two places: integrals of polynomials of sizes are exact."""
SIZES = {"rod": 1, "tube": 2, "bar": 2, "box": 3}
"""Numbers that describe a section: diameter; outer and inner diameter; two sides; two sides and the wall."""


def product(*factors: str | float, over: Sequence[str | float] = ()) -> str:
    """The text of a product of formulas, divided by others: numbers in it become one.

    A whole number is written times 0.1, since checks of units count whole numbers as ratios.
    """
    number, above, below = 1.0, list[str](), list[str]()
    for parts, names in ((factors, above), (over, below)):
        for formula in map(Formula.parse, parts):
            if formula.names:
                names.append(operand(formula.text))
            else:
                number *= formula.value() if parts is factors else 1 / formula.value()
    if not (above or below):
        return f"{number:.15g}"
    first = f"{10 * number:.15g}*0.1" if number.is_integer() else f"{number:.15g}"
    return "*".join([*([first] if number != 1.0 or not above else []), *above]) + "".join(f"/{name}" for name in below)


def operand(text: str) -> str:
    """A formula as an operand of any operation: names, numbers and roots without brackets."""
    tree = Formula.parse(text).tree
    is_atom = tree[0] in ("name", "sqrt") or (tree[0] == "number" and tree[1] >= 0)
    return text if is_atom else f"({text})"


@dataclass(frozen=True)
class Section:
    """Area, m2, integrals of the squares of both coordinates over it, m4, and torsion constant, m4.

    `shear` are the areas, m2, that carry shear at rest in both directions, the area times Cowper's factor.
    """

    area: str
    squares: tuple[str, str]
    torsion: str
    shear: tuple[str, str]

    @property
    def quantities(self) -> dict[str, str]:
        """Area, second moments, torsion constant and shear areas, as formulas by name."""
        squares, shear = dict(zip(SQUARES, self.squares, strict=True)), dict(zip(SHEAR, self.shear, strict=True))
        return {AREA: self.area, TORSION: self.torsion, POLAR: " + ".join(self.squares), **squares, **shear}


def section_of(kind: str, sizes: Sequence[str], longer: int) -> Section:
    """The section of a kind of `SIZES`; `longer` is the index of the longer side of a bar.

    Torsion of bars by Roark's formula, a b^3 (1/3 - 0.21 b/a (1 - b^4/(12 a^4))) with a > b, within 0.5 %, of boxes by
    Bredt's, 4 A^2 t/s with the area A and the length s of the middle line. Factors of shear by Cowper (The shear
    coefficient in Timoshenko's beam theory, 1966), boxes thin-walled, with Poisson's ratio 0.3.
    """
    a, b, t = map(operand, (*sizes, "0", "0")[:3])
    if kind in ("rod", "tube"):
        square, fourth = (f"({a}^{n} - {b}^{n})" if kind == "tube" else f"{a}^{n}" for n in (2, 4))
        both = f"({a}^2 + {b}^2)^2"
        round_shear = f"7.8*pi/4*{square}*{both}/(8.8*{both} + 23.6*{a}^2*{b}^2)"
        return Section(f"pi/4*{square}", (f"pi/64*{fourth}",) * 2, f"pi/32*{fourth}", (round_shear,) * 2)
    if kind == "bar":
        long, short = (a, b) if longer == 0 else (b, a)
        thin = f"(1/3 - 0.21*{short}/{long}*(1 - {short}^4/{long}^4/12))"
        squares = (f"{a}^3*{b}/12", f"{a}*{b}^3/12")
        return Section(f"{a}*{b}", squares, f"{long}*{short}^3*{thin}", (f"13/15.3*{a}*{b}",) * 2)
    c, d = f"({a} - 2*{t})", f"({b} - 2*{t})"
    squares = (f"({a}^3*{b} - {c}^3*{d})/12", f"({a}*{b}^3 - {c}*{d}^3)/12")
    area, e, f = f"({a}*{b} - {c}*{d})", f"({a} - {t})", f"({b} - {t})"
    shear = (f"{area}*{_factor_of_box(e, f)}", f"{area}*{_factor_of_box(f, e)}")
    return Section(area, squares, f"2*{t}*{e}^2*{f}^2/({a} + {b} - 2*{t})", shear)


def _factor_of_box(h: str, w: str) -> str:
    """Factor of shear along the height h of the middle line of a box of the width w."""
    below = f"(15.3*{h}^4 + 91.8*{h}^3*{w} + 190.5*{h}^2*{w}^2 + 150*{h}*{w}^3 + 30*{w}^4)"
    return f"13*{h}^2*({h} + 3*{w})^2/{below}"


@dataclass(frozen=True)
class Piece:
    """A part of a beam: its end by the length of the beam, its kind of section, and its sizes at both ends, m."""

    end: float
    kind: str
    first: tuple[float, ...]
    last: tuple[float, ...]

    def values(self, quantity: str, part: Array) -> Array:
        """A quantity at fractions of the piece: sizes change linearly."""
        sizes = [a + part * (b - a) for a, b in zip(self.first, self.last, strict=True)]
        if quantity == TORSION and self.kind == "bar":
            sizes = [np.maximum(*sizes), np.minimum(*sizes)]
        names = dict(zip(NAMES, sizes, strict=False))
        return np.asarray(_formula(self.kind, quantity).evaluate({"pi": math.pi, **names}, {}))


@lru_cache(maxsize=64)
def _formula(kind: str, quantity: str) -> Formula:
    """Formula of a quantity of a kind of section by its sizes; of a bar, a is the longer side in torsion."""
    return Formula.parse(section_of(kind, NAMES[: SIZES[kind]], 0).quantities[quantity])


@dataclass(frozen=True)
class Profile:
    """How sections change along a beam, by its pieces; uniform without any."""

    pieces: tuple[Piece, ...] = ()

    @cached_property
    def edges(self) -> tuple[float, ...]:
        """Ends of the pieces, by the length of the beam, and its root."""
        return (0.0, *(piece.end for piece in self.pieces)) if self.pieces else (0.0, 1.0)

    def ratio(self, quantity: str, x: Array) -> Array:
        """A quantity at places x (fractions of the length, within pieces), relative to that at the root."""
        ratio = np.ones_like(x)
        for start, piece in zip(self.edges, self.pieces, strict=False):
            inside = (start < x) & (x < piece.end)
            part = (x[inside] - start) / (piece.end - start)
            ratio[inside] = piece.values(quantity, part) / self.pieces[0].values(quantity, np.zeros(1))
        return ratio

    def nodes(self, breaks: Iterable[float], count: int) -> tuple[Array, Array]:
        """Nodes and weights of Gauss and Legendre on the intervals between breaks, and ends of pieces among them."""
        places = sorted({*breaks})
        ends = np.array(sorted({*places, *(x for x in self.edges if places[0] < x < places[-1])}))
        x, weights = _gauss(count)
        halves = np.diff(ends)[:, None] / 2
        return (ends[:-1, None] + halves * (1 + x)).ravel(), (halves * weights).ravel()

    def moments(self, quantity: str, start: float, end: float) -> tuple[float, float, float]:
        """Integral, centre and spread of a quantity from `start` to `end`, relative to those of a uniform part.

        The centre is by the length of the beam; the spread is the second moment about the centre.
        """
        x, weights = self.nodes((start, end), NODES)
        part, u, more = end - start, x - (start + end) / 2, self.ratio(quantity, x) - 1
        mean = 1 + float(np.sum(weights * more)) / part
        centre = float(np.sum(weights * more * u)) / (part * mean)
        return mean, centre, 1 + 12 * (float(np.sum(weights * more * u**2)) / part - mean * centre**2) / part**2


@lru_cache
def _gauss(count: int) -> tuple[Array, Array]:
    return legendre.leggauss(count)
