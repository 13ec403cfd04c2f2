"""Units of quantities, by the kinds of joints that an entry belongs to."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

FACTOR = re.compile(r"([A-Za-z]+)(?:\^|\*\*)?(-?\d{1,2})?")
SIGNS = {"²": "2", "³": "3", "·": " ", "⋅": " "}
_TIMES = re.compile(r"(?<!\*)\*(?!\*)|(?<=[A-Za-z\d])\.(?=[A-Za-z])")
SI = {
    **{base: {base: 1} for base in ("kg", "m", "s", "rad", "A")},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "Hz": {"s": -1},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
}
"""Units of mechanics and of motors, as exponents of kg, m, s, rad and A."""
Powers = Mapping[str, Fraction]
"""Exponents of units, none of them zero."""


@dataclass(frozen=True)
class Unit:
    """Unit of an entry that belongs to one joint, or to one component of a screw or wrench.

    `angular` holds for revolute joints and components 4 to 6, `linear` for prismatic joints and components 1 to 3. A
    number without dimension has the unit "".
    """

    angular: str
    linear: str

    def of(self, sigma: int) -> str:
        """The unit for a revolute (0) or a prismatic joint (1)."""
        return self.linear if sigma else self.angular

    @property
    def text(self) -> str:
        """`rad/s or m/s`; one unit where both are the same."""
        return " or ".join(dict.fromkeys((self.angular, self.linear)))

    @property
    def screw(self) -> str:
        """`m/s and rad/s`: in the order of components, linear ones first."""
        return f"{self.linear} and {self.angular}"

    def __truediv__(self, other: Unit) -> PairUnit:
        rows, columns = (self.angular, self.linear), (other.angular, other.linear)
        a, b, c, d = (quotient(row, column) for row in rows for column in columns)
        return PairUnit(a, b, c, d)


@dataclass(frozen=True)
class PairUnit:
    """Unit of an entry that belongs to two joints or components, that of its row and that of its column."""

    angular_angular: str
    angular_linear: str
    linear_angular: str
    linear_linear: str

    def of(self, row: int, column: int) -> str:
        """The unit for rows and columns of revolute (0) or prismatic joints (1)."""
        return self._all[2 * row + column]

    @property
    def _all(self) -> tuple[str, str, str, str]:
        return self.angular_angular, self.angular_linear, self.linear_angular, self.linear_linear

    @property
    def text(self) -> str:
        """`kg m2, kg m or kg`."""
        *others, last = dict.fromkeys(self._all)
        return f"{', '.join(others)} or {last}" if others else last


def same(unit: str) -> Unit:
    """One unit for all kinds of joints."""
    return Unit(unit, unit)


def quotient(over: str, under: str) -> str:
    """Quotient of two units: `N m s/rad` for `N m` over `rad/s`."""
    return unit_text(product((factors_of(over) or {}, 1), (factors_of(under) or {}, -1)))


def unit_text(powers: Powers) -> str:
    """The text of a product of powers of units: `kg m/s2`."""
    above = [_power(name, power) for name, power in powers.items() if power > 0]
    below = [_power(name, -power) for name, power in powers.items() if power < 0]
    if not below:
        return " ".join(above)
    return f"{' '.join(above) or '1'}/{below[0] if len(below) == 1 else '(' + ' '.join(below) + ')'}"


@lru_cache
def in_base_units(unit: str) -> Powers | None:
    """Exponents of kg, m, s, rad and A in a unit as people write it: `kg*m^2`, `N m/rad`; None for any other text."""
    factors = factors_of(unit)
    if factors is None or not factors.keys() <= SI.keys():
        return None
    return product(*((_fractions(SI[name]), power) for name, power in factors.items()))


def product(*factors: tuple[Powers, Fraction | int]) -> Powers:
    """The product of powers of units, each raised to an exponent."""
    found: dict[str, Fraction] = {}
    for powers, exponent in factors:
        for name, power in powers.items():
            found[name] = found.get(name, Fraction(0)) + power * exponent
    return {name: power for name, power in found.items() if power}


def _fractions(powers: Mapping[str, int]) -> Powers:
    return {name: Fraction(power) for name, power in powers.items()}


def factors_of(unit: str) -> Powers | None:
    """Return the exponents of the words of a unit; None where it is not a product and quotient of words."""
    plain = _TIMES.sub(" ", "".join(SIGNS.get(sign, sign) for sign in unit)).strip()
    over, *under = (part.strip() for part in plain.split("/"))
    factors = [(_words(over), 1), *((_below(part), -1) for part in under)]
    known = [(powers, sign) for powers, sign in factors if powers is not None]
    return product(*known) if plain and len(known) == len(factors) else None


def _below(part: str) -> Powers | None:
    """Exponents of what stands behind a slash: one word, or several in brackets."""
    if part.startswith("(") and part.endswith(")"):
        return _words(part[1:-1])
    return None if " " in part else _words(part)


def _words(part: str) -> Powers | None:
    words = [] if part == "1" else part.split()
    found = [FACTOR.fullmatch(word) for word in words]
    if part != "1" and (not words or None in found):
        return None
    return product(*(({match[1]: Fraction(match[2] or 1)}, 1) for match in found if match))


def _power(name: str, power: Fraction) -> str:
    return name if power == 1 else f"{name}{power}" if power.denominator == 1 else f"{name}^({power})"


NUMBER = same("")
POSITION = Unit("rad", "m")
VELOCITY = Unit("rad/s", "m/s")
ACCELERATION = Unit("rad/s2", "m/s2")
FORCE = Unit("N m", "N")
MASS = Unit("kg m2", "kg")
"""Inertia that a joint moves."""
INVERSE_MASS = Unit("1/(kg m2)", "1/kg")
COMPLIANCE = Unit("rad/(N m)", "m/N")
PLACEMENT = Unit("", "m")
"""Entries of a 4 x 4 matrix: direction cosines, and lengths in its last column."""
INERTIA = PairUnit("kg m2", "kg m", "kg m", "kg")
IMPULSE = PairUnit("N m s", "N s", "N m s", "N s")
"""Forces of a joint, its column, over velocities of rotation."""
DAMPING = PairUnit("N m s/rad", "N s", "N s", "N s/m")
STIFFNESS = PairUnit("N m/rad", "N", "N", "N/m")
