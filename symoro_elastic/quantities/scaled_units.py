"""Units that people write, as multiples of SI units: mm, deg, kN, rpm."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from symoro_elastic.quantities.units import SI, Powers, factors_of, in_base_units, product, unit_text

PREFIXES = {"n": -9, "u": -6, "m": -3, "c": -2, "d": -1, "k": 3, "M": 6, "G": 9}
SIGNS = {"µ": "u", "μ": "u", "°": "deg"}
ANGLE: Powers = {"rad": Fraction(1)}


@dataclass(frozen=True)
class Scaled:
    """A unit: `factor` times pi to the power `pi` times a product of SI units."""

    factor: Fraction
    si: Powers
    pi: Fraction = Fraction(0)

    @property
    def text(self) -> str:
        """The SI unit: `N m/rad`."""
        return unit_text(self.si)

    @property
    def is_si(self) -> bool:
        """Whether nothing has to be converted."""
        return self.factor == 1 and not self.pi

    def fits(self, units: str) -> bool:
        """Whether it is of the dimension of one of these units ("rad or m"), the rad beside others left out."""
        own = in_base_units(self.text)
        needed = [in_base_units(unit) for unit in alternatives(units)]
        return own is not None and any(own == one or _without_rad(own) == _without_rad(one) != {} for one in needed)


def alternatives(units: str) -> list[str]:
    """Return the units in a text such as "rad or m", those that are products of SI units."""
    found = units.replace(" and ", " or ").replace(" for ", " or ").split(" or ")
    return [unit for unit in found if in_base_units(unit) is not None]


@lru_cache
def scaled(unit: str) -> Scaled | None:
    """Return what a unit stands for; None where it is not a product of known units."""
    for sign, word in SIGNS.items():
        unit = unit.replace(sign, word)
    factors = factors_of(unit)
    if not factors or not factors.keys() <= WORDS.keys() or any(x.denominator != 1 for x in factors.values()):
        return None
    whole = Scaled(Fraction(1), {})
    for word, power in factors.items():
        one, n = WORDS[word], int(power)
        whole = Scaled(whole.factor * one.factor**n, product((whole.si, 1), (one.si, n)), whole.pi + one.pi * n)
    return whole


def _without_rad(powers: Powers | None) -> Powers:
    return {name: power for name, power in (powers or {}).items() if name != "rad"}


def _words() -> dict[str, Scaled]:
    """The known words."""
    named = {"g": ("kg", Fraction(1, 1000)), **{name: (name, Fraction(1)) for name in SI if name != "kg"}}
    words = {name: Scaled(factor, {si: Fraction(1)}) for name, (si, factor) in named.items()}
    words |= dict(_prefixed(words))
    words |= {
        "kg": _one("kg"),
        "t": _one("kg", Fraction(1000)),
        "min": _one("s", Fraction(60)),
        "h": _one("s", Fraction(3600)),
        "inch": _one("m", Fraction(254, 10000)),
        "deg": Scaled(Fraction(1, 180), ANGLE, Fraction(1)),
        "rev": Scaled(Fraction(2), ANGLE, Fraction(1)),
        "rpm": Scaled(Fraction(2, 60), {"rad": Fraction(1), "s": Fraction(-1)}, Fraction(1)),
    }
    newton_metre = {"N": Fraction(1), "m": Fraction(1)}
    milli, kilo = Fraction(1, 1000), Fraction(1000)
    return words | {
        "Nm": Scaled(Fraction(1), newton_metre),
        "Nmm": Scaled(milli, newton_metre),
        "kNm": Scaled(kilo, newton_metre),
    }


def _prefixed(words: dict[str, Scaled]) -> Iterator[tuple[str, Scaled]]:
    for name, one in words.items():
        for prefix, exponent in PREFIXES.items():
            yield prefix + name, Scaled(one.factor * Fraction(10) ** exponent, one.si)


def _one(si: str, factor: Fraction = Fraction(1)) -> Scaled:
    return Scaled(factor, {si: Fraction(1)})


WORDS = _words()
"""Units by the words that are written for them."""
