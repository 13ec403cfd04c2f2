"""The one reader of units: of files, of columns of tables, of labels and of the command line.

A unit is a factor, a rational number times a power of pi, times powers of SI units, so that "30 deg" stays pi/6. What
is not read here is refused, with its nearest spelling. pint is not used: it reads Nm as 1000 m/kg, and "deg C" as
degrees times coulombs; it knows neither m2, rev nor min-1, has a decimal pi, and loads in 0.3 s, this in 7 ms.

Where an angle per time is needed, minutes alone below a slash, and Hz, are turns: 3000 min-1 is 100 pi rad/s. Seconds
alone may be radians or turns there, and are refused. Beside units of force the rad may be left out.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache

Powers = Mapping[str, Fraction]
"""Exponents of units, none of them zero."""

CYCLE = "cycle"
SI = {
    **{base: {base: 1} for base in ("kg", "m", "s", "rad", "A")},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "Hz": {CYCLE: 1, "s": -1},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
}
"""Units of mechanics and of motors, as exponents of kg, m, s, rad and A, and of cycles, which are not SI."""
PREFIXES = {"n": -9, "u": -6, "m": -3, "c": -2, "d": -1, "k": 3, "M": 6, "G": 9}
IMPLAUSIBLE = frozenset(prefix + name for prefix in "MG" for name in ("m", "s", "g", "rad", "A"))
"""Words that a label in capitals does not mean: MM is mm."""
NEAR, NEAR_SHORT = 0.65, 0.7
"""Likeness by difflib of words that may have been meant, and of two letters: rpn and rpm have 0.67, as EU and U."""
LARGEST = 10**40  # of factors
LONGEST = 100
"""Characters of a number with its unit, and of a unit: longer texts are formulas, or none."""


class UnitError(ValueError):
    """A unit that is not known, has two meanings, or is of another dimension; the message says the way out."""


@dataclass(frozen=True)
class ScaledUnit:
    """A unit: `factor` times pi to the power `pi` times a product of powers of SI units.

    `turns` and `rates` are powers of groups of minutes alone and of seconds alone, as in V/min-1 and 1/s; `times` are
    its words where all are times, None where others are among them.
    """

    factor: Fraction = Fraction(1)
    si: Powers = field(default_factory=dict)
    pi: int = 0
    turns: int = 0
    rates: int = 0
    times: frozenset[str] | None = field(default=None, compare=False)

    @property
    def text(self) -> str:
        """The SI unit: `N m/rad`."""
        return unit_text(self.si)

    @property
    def is_si(self) -> bool:
        """Whether nothing has to be converted."""
        return self.factor == 1 and not self.pi

    @property
    def number(self) -> float:
        """The factor in double precision, rounded once."""
        return float(self.factor * Fraction(math.pi) ** self.pi)

    @property
    def base(self) -> dict[str, Fraction]:
        """Exponents of kg, m, s, rad, A and cycles."""
        units = {name: {base: Fraction(power) for base, power in SI.get(name, {name: 1}).items()} for name in self.si}
        return product(*((units[name], power) for name, power in self.si.items()))

    def power(self, exponent: Fraction) -> ScaledUnit:
        """A power of it; raises `UnitError` for a root of a factor."""
        n = int(exponent)
        if n != exponent and not self.is_si:
            raise UnitError("roots are of SI units only")
        si = product((self.si, exponent))
        return ScaledUnit(self.factor**n, si, self.pi * n, self.turns * n, self.rates * n, self.times)

    def __mul__(self, other: ScaledUnit) -> ScaledUnit:
        factor, si = self.factor * other.factor, product((self.si, 1), (other.si, 1))
        times = None if self.times is None or other.times is None else self.times | other.times
        return ScaledUnit(factor, si, self.pi + other.pi, self.turns + other.turns, self.rates + other.rates, times)

    @property
    def as_group(self) -> ScaledUnit:
        """The unit as a factor of its own: if of times alone, 1/min counts turns, another rate turns or radians."""
        if not self.times:
            return self
        is_rate, by_minutes = self.si.get("s", 0) < 0, not self.times.isdisjoint(MINUTES)
        return replace(self, turns=int(is_rate and by_minutes), rates=int(is_rate and not by_minutes))


# Texts of units


def unit_text(powers: Powers) -> str:
    """The text of a product of powers of units: `kg m/s2`."""
    above = [_power(name, power) for name, power in powers.items() if power > 0]
    below = [_power(name, -power) for name, power in powers.items() if power < 0]
    if not below:
        return " ".join(above)
    return f"{' '.join(above) or '1'}/{below[0] if len(below) == 1 else '(' + ' '.join(below) + ')'}"


def _power(name: str, power: Fraction) -> str:
    return name if power == 1 else f"{name}{power}" if power.denominator == 1 else f"{name}^({power})"


def product(*factors: tuple[Powers, Fraction | int]) -> dict[str, Fraction]:
    """The product of powers of units, each raised to an exponent."""
    powers_of: dict[str, Fraction] = {}
    for powers, exponent in factors:
        for name, power in powers.items():
            powers_of[name] = powers_of.get(name, Fraction(0)) + power * exponent
    return {name: power for name, power in powers_of.items() if power}


# Words


def _one(si: str, factor: Fraction | int = 1, pi: int = 0) -> ScaledUnit:
    return ScaledUnit(Fraction(factor), {si: Fraction(1)}, pi)


INCH, POUND, G = Fraction(254, 10**4), Fraction(45359237, 10**8), Fraction(980665, 10**5)
"""m, kg and m/s2, exact by definition (international yard and pound, 1959; standard gravity, CGPM 1901)."""
CUSTOMARY = {
    "kg": _one("kg"), "t": _one("kg", 1000), "lbm": _one("kg", POUND), "ozm": _one("kg", POUND / 16),
    "slug": _one("kg", POUND * G / (12 * INCH)), "daN": _one("N", 10), "kgf": _one("N", G), "kp": _one("N", G),
    "gf": _one("N", G / 1000), "lbf": _one("N", POUND * G), "ozf": _one("N", POUND * G / 16),
    "psi": _one("Pa", POUND * G / INCH**2), "bar": _one("Pa", 10**5), "in": _one("m", INCH), "ft": _one("m", 12 * INCH),
    "min": _one("s", 60), "h": _one("s", 3600), "deg": _one("rad", Fraction(1, 180), 1),
    "mdeg": _one("rad", Fraction(1, 180_000), 1), "arcmin": _one("rad", Fraction(1, 10_800), 1),
    "arcsec": _one("rad", Fraction(1, 648_000), 1), "rev": _one("rad", 2, 1), "cycle": _one(CYCLE),
    "%": ScaledUnit(Fraction(1, 100)),
    **{word: ScaledUnit(Fraction(2, t), {"rad": Fraction(1), "s": Fraction(-1)}, 1)
       for word, t in {"rpm": 60, "rps": 1}.items()},
    "krpm": ScaledUnit(Fraction(2000, 60), {"rad": Fraction(1), "s": Fraction(-1)}, 1),
}  # fmt: skip
NAMES = {
    "N": "newton", "m": "metre meter", "s": "sec second", "g": "gram", "kg": "kilogram", "rad": "radian", "J": "joule",
    "A": "amp ampere", "W": "watt", "Pa": "pascal", "Hz": "hertz", "V": "volt", "Ohm": "ohm", "H": "henry",
    "mm": "millimetre millimeter", "cm": "centimetre centimeter", "um": "micrometre micrometer micron",
    "deg": "degree", "rev": "revolution turn r U tr", "min": "minute", "h": "hour", "%": "percent",
    "in": "inch inches", "ft": "foot feet", "lb": "pound", "oz": "ounce", "cycle": "cycle",
}  # fmt: skip
"""Other names of units; those of more than two letters may have an s behind them."""


def _words() -> dict[str, ScaledUnit]:
    """Units by the words that are written for them; lb and oz are masses."""
    plain = {**{name: _one(name) for name in SI if name != "kg"}, "g": _one("kg", Fraction(1, 1000))}
    words = {
        prefix + name: replace(unit, factor=unit.factor * Fraction(10) ** exponent)
        for name, unit in plain.items()
        for prefix, exponent in {"": 0, **PREFIXES}.items()
    }
    words |= CUSTOMARY | {"lb": CUSTOMARY["lbm"], "lbs": CUSTOMARY["lbm"], "oz": CUSTOMARY["ozm"]}
    for word, names in NAMES.items():
        words |= {name + end: words[word] for name in names.split() for end in ("", "s")[: 1 + (len(name) > 2)]}
    return words


WORDS = _words()
BY_WEIGHT = {
    "g": ScaledUnit(G, {"m": Fraction(1), "s": Fraction(-2)}),
    **dict.fromkeys(("lb", "lbs", "pound", "pounds"), WORDS["lbf"]), **dict.fromkeys(("oz", "ounce"), WORDS["ozf"]),
}  # fmt: skip
BY_WEIGHT |= {prefix + "g": replace(BY_WEIGHT["g"], factor=G * Fraction(10) ** PREFIXES[prefix]) for prefix in "mu"}
"""What words for a mass mean where a mass is not what is needed: forces, and the acceleration of gravity."""
FORCES = ("N", "uN", "mN", "cN", "daN", "kN", "MN", "kgf", "gf")
COMPACT: dict[str, tuple[str, ...]] = {
    **{force + length: (force, length) for force in FORCES for length in ("m", "cm", "mm")},
    **{f"{force}ms": (force, "m", "s") for force in FORCES},
    **{force + length: (force, length) for force in ("lbf", "ozf", "lb", "oz") for length in ("in", "ft")},
    **{mass + length: (mass, length) for mass in ("kg", "g") for length in ("m", "cm", "mm") if mass + length != "gm"},
    **{f"{word}s": (word, "s") for word in ("V", "mV", "A", "W", "J")},
}
"""Words side by side without a space, as in kgcm2: an exponent is that of the last."""


def _spellings() -> dict[str, list[str]]:
    spellings: dict[str, list[str]] = {}
    for word in (*WORDS, *COMPACT):
        spellings.setdefault(word.lower(), []).append(word)
    return spellings


SPELLINGS = _spellings()
"""Words by their spelling in lower case."""
UNPREFIXED = frozenset((*SI, *CUSTOMARY, *(name for names in NAMES.values() for name in names.split())))


def _spelling(word: str, text: str) -> str:
    """The word of a unit as the tables spell it; raises `UnitError` that names the nearest ones.

    Case counts, but for words without a prefix that have one meaning in any case.
    """
    near = SPELLINGS.get(word.lower(), [])
    is_plain = len(word) > 1 and any(name in UNPREFIXED for name in near)
    return _only([word] if word in near else near if is_plain else [], word, text, near)


def spelled_label(text: str) -> str:
    """Return the unit in a label of any case, with its words spelled as in the tables; raises `UnitError`."""

    def spelling(word_found: re.Match[str]) -> str:
        word, near = word_found[0], SPELLINGS.get(word_found[0].lower(), [])
        is_exact = word in near and text.upper() != text
        return _only([word] if is_exact else [name for name in near if name not in IMPLAUSIBLE], word, text, near)

    return re.sub("[A-Za-z]+", spelling, _with_plain_signs(text))


def _only(choices: Sequence[str], word: str, text: str, near: Sequence[str]) -> str:
    if not choices or len({_meaning(name) for name in choices}) > 1:
        place = "" if word == text else f" in {_in_quotes(text)}"
        raise UnitError(f"{_in_quotes(word)}{place} is not a known unit{_nearest(word, near)}")
    return choices[0]


def _meaning(word: str) -> tuple[Fraction, str] | str:
    return word if word in COMPACT else (WORDS[word].factor, WORDS[word].text)


def _nearest(word: str, spellings: Sequence[str]) -> str:
    import difflib

    near = difflib.get_close_matches(word, [*WORDS, *COMPACT], 3, NEAR if len(word) > 2 else NEAR_SHORT)
    near.sort(key=lambda name: (sorted(name) != sorted(word), name not in UNPREFIXED))
    choices = sorted(spellings, key=lambda name: name in IMPLAUSIBLE) or near
    return f"; did you mean {' or '.join(map(repr, choices[: len(spellings) or 1]))}?" if choices else ""


# Reading

_SIGNS = {
    **dict.fromkeys("\u00b7\u22c5\u2022\u2219\u00d7", "*"), **dict.fromkeys("\u2212\u2013", "-"),
    **dict.fromkeys("\u2032\u2019", "'"), **dict.fromkeys(("\u2033", "\u201d", "''"), '"'), "'": " arcmin ",
    '"': " arcsec ", "μ": "u", "Ω": "Ohm", "°": "deg", "{": "(", "}": ")",
}  # fmt: skip
"""Signs of products, dashes, primes, and others, as they are read."""
_SUPERSCRIPT = re.compile("[⁻⁰¹²³⁴-⁹]+")
_FACTOR = re.compile(r"\s*[A-Za-z%(]", re.ASCII)
_WORD = re.compile(r"\s*([A-Za-z]+|%)(?:(?:\^|\*\*)?(-?\d{1,2})|(?:\^|\*\*)\((-?\d{1,2}(?:/\d)?)\))?(?!\d)", re.ASCII)
_SIGN = re.compile(r"\s*([/()]|[*.-](?=\s*[A-Za-z%(1])|10*(?!\d))?\s*", re.ASCII)
_POWER = re.compile(r"(?:\^|\*\*)?(-?\d{1,2})(?!\d)", re.ASCII)
MINUTES = {"min", "minute", "minutes"}


def _with_plain_signs(text: str) -> str:
    plain = unicodedata.normalize("NFKC", _SUPERSCRIPT.sub(lambda power: f"^{power[0]}", text))
    for sign, word in _SIGNS.items():
        plain = plain.replace(sign, word)
    return plain.strip()


class _Reader:
    """Reads `N m/(rad s)`: products by a space or a sign, one factor or brackets below a slash."""

    def __init__(self, text: str, words: Mapping[str, ScaledUnit]) -> None:
        self.given, self.text, self.words, self.position = text, _with_plain_signs(text), words, 0

    def read(self) -> ScaledUnit:
        unit = self.quotient()
        if self.position < len(self.text):
            raise self.error()
        return unit

    def error(self) -> UnitError:
        return UnitError(f"{_in_quotes(self.given)} is not a product of known units, such as N m/rad")

    def sign(self, wanted: str) -> str:
        """Read a sign that is one of `wanted`, with the spaces about it, and return it; empty for another one."""
        match = _SIGN.match(self.text, self.position)
        if match is None or not match[1] or match[1][0] not in wanted:
            return ""
        self.position = match.end()
        return match[1]

    def quotient(self) -> ScaledUnit:
        unit = self.factor()
        while self.is_product():
            unit *= self.factor()
        while self.sign("/"):
            unit *= self.factor(is_below=True).as_group.power(Fraction(-1))
            if self.is_product():
                raise UnitError(f"{_in_quotes(self.given)}: put what is below the slash into brackets, as in N/(m s)")
        return unit.as_group

    def is_product(self) -> bool:
        """Whether a factor follows, after a sign of multiplication or a space."""
        return bool(self.sign("*.-") or _FACTOR.match(self.text, self.position))

    def factor(self, is_below: bool = False) -> ScaledUnit:
        if number := self.sign("1"):
            unit = ScaledUnit(Fraction(number), times=frozenset())
            return unit * self.factor() if is_below and _FACTOR.match(self.text, self.position) else unit
        if self.sign("("):
            unit = self.quotient()
            if not self.sign(")"):
                raise self.error()
            power = _POWER.match(self.text, self.position)
            self.position = power.end() if power else self.position
            return unit.power(Fraction(power[1])) if power else unit
        match = _WORD.match(self.text, self.position)
        if match is None:
            raise self.error()
        self.position = match.end()
        return self.word(_spelling(match[1], self.given), Fraction(match[2] or match[3] or 1))

    def word(self, spelled: str, exponent: Fraction) -> ScaledUnit:
        *before, last = COMPACT.get(spelled, (spelled,))
        unit = self.words[last].power(exponent)
        for name in before:
            unit = self.words[name] * unit
        return replace(unit, times=frozenset([spelled]) if unit.si.keys() == {"s"} else None)


def _in_quotes(text: str) -> str:
    return repr(text if len(text) <= 60 else f"{text[:57]}...")


@lru_cache(maxsize=4096)
def readings(text: str) -> tuple[ScaledUnit, ...]:
    """Return the possible meanings of a unit: one, or two where lb and the like are masses or weights.

    Raises `UnitError`.
    """
    if len(text) > LONGEST:
        raise UnitError(f"{_in_quotes(text)} is not a product of known units, such as N m/rad")
    mass, weight = (_Reader(text, words).read() for words in (WORDS, WORDS | BY_WEIGHT))
    return (mass,) if mass == weight else (mass, weight)


def is_unit(text: str, needed: str | None = None) -> bool:
    """Whether a text is a unit that is known, and of the dimension that is needed, if any."""
    try:
        return bool(readings(text) if needed is None else conversion(text, needed))
    except UnitError:
        return False


def read_unit(text: str) -> ScaledUnit:
    """Return a unit of any dimension; raises `UnitError` for one that is not known, or has two meanings."""
    unit, *alternatives = readings(text)
    if alternatives and re.search("lb|oz|pound|ounce", text):
        raise UnitError(f"{_in_quotes(text)} may be a mass or a force: write lbf or ozf, lbm or ozm")
    if not unit.turns:
        return unit
    if unit.si.keys() == {"s"}:
        raise UnitError(f"{_in_quotes(text)} may be turns or a rate: write rpm, rev/min2, or 1/s")
    return _in_radians(unit, unit.turns)


def conversion(text: str, needed: str, number: str = "") -> ScaledUnit:
    """Return the factor from a unit to the needed one; of several ("rad or m"), to the one of its dimension.

    Raises `UnitError`, with the `number` that has the unit.
    """
    meanings = readings(text)
    wanted = alternatives(needed)
    factors = [x for unit in meanings for x in (_factor_to(unit, other, text) for other in wanted) if x is not None]
    if factors and not 1 / LARGEST < factors[0].factor < LARGEST:
        raise UnitError(f"{_in_quotes(text)} is out of range")
    if not factors:
        units = " or ".join(wanted) or "a number without unit"
        if not number:
            raise UnitError(f"{_in_quotes(text)} cannot be converted to {units}")
        raise UnitError(f"{_in_quotes(f'{number} {text}')} is in {meanings[0].text or '1'}, where {units} is needed")
    return factors[0]


def alternatives(units: str) -> list[str]:
    """Return the units in a text such as "rad or m", those that are products of SI units."""
    parts = units.replace(" and ", " or ").replace(" for ", " or ").replace(", or ", " or ").split(" or ")
    return [unit for unit in parts if dimension(unit) is not None] if units else [""]


def _factor_to(unit: ScaledUnit, needed: str, text: str) -> ScaledUnit | None:
    """Return the factor to one unit, None where dimensions differ; raises `UnitError` where turns may be meant."""
    both = unit.base, dimension(needed) or {}
    rad, cycles, wanted_rad, wanted_cycles = (x.get(name, 0) for x in both for name in ("rad", CYCLE))
    has, wants = ({name: power for name, power in x.items() if name not in ("rad", CYCLE)} for x in both)
    if has == wants and (rad, cycles) == (wanted_rad, wanted_cycles):
        return unit
    if has != wants or (rad and cycles):
        return None
    if not wanted_rad and not wanted_cycles:
        if has.keys() == {"s"} and (cycles or unit.pi):
            raise UnitError(f"{_in_quotes(text)} counts turns or degrees: write it in {needed}")
        return unit if has.keys() == {"s"} else None
    if wanted_cycles and rad:
        return _in_radians(unit, -wanted_cycles) if rad == wanted_cycles else None
    turns = cycles + unit.turns
    if turns and turns not in (wanted_rad, wanted_cycles):
        return None
    if turns:
        return _in_radians(unit, wanted_rad) if wanted_rad else unit
    if rad or (wanted_rad and not unit.rates and wants.keys() & {"kg", "A"}):
        return None if rad else unit
    choices = needed, needed.replace("rad", "rev").replace("Hz", "rad/s")
    raise UnitError(f"{_in_quotes(text)} may be radians or turns: write {' or '.join(choices)}")


def _in_radians(unit: ScaledUnit, turns: Fraction | int) -> ScaledUnit:
    """Return the unit times (2 pi rad)^turns."""
    n = int(turns)
    return ScaledUnit(unit.factor * Fraction(2) ** n, product((unit.si, 1), ({"rad": Fraction(1)}, n)), unit.pi + n)


@lru_cache(maxsize=4096)
def dimension(unit: str) -> Powers | None:
    """Exponents of kg, m, s, rad, A and cycles in a product of SI units; None for any other text."""
    try:
        scaled = readings(unit)[0] if unit else ScaledUnit()
    except UnitError:
        return None
    return scaled.base if scaled.is_si else None


def in_base_units(unit: str) -> dict[str, Fraction] | None:
    """Exponents of kg, m, s, rad and A in a product of SI units, `kg*m^2`, `N m/rad`; None for any other text."""
    powers = dimension(unit) if unit else None
    return None if powers is None else {name: power for name, power in powers.items() if name != CYCLE}


# Numbers with units

NUMBER_AND_UNIT = re.compile(
    r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,2})?)(?![eE][-+]?\d)"
    r"(?:\s*(?=[^\W\d_]|[%'\"]|[^\x00-\x7f])|\s+(?=1\s*/))(.*?)\s*"
)


def in_two(text: str) -> tuple[str, str] | None:
    """Return the number and the unit of a text such as "120 N/um" or "30 1/s"; None for any other text.

    No formula is a number and a word, so none is taken for one.
    """
    match = NUMBER_AND_UNIT.fullmatch(text) if len(text) <= LONGEST else None
    return (match[1], match[2]) if match else None


def in_si(text: str, needed: str) -> str:
    """Return a number with a unit as a number or formula in the SI unit that is needed; other texts as they are.

    Raises `UnitError` for a unit that is not known, or of another dimension.
    """
    parts = in_two(text)
    if parts and parts[1] in ("pi", "Pi"):
        raise UnitError(f"{_in_quotes(text)}: a product has a sign, {'*'.join(parts)}")
    return text if parts is None else number_in_si(*parts, needed)


def number_in_si(number: str, unit: str, needed: str) -> str:
    """Return a number of some unit as a number or formula in the SI unit that is needed; raises `UnitError`."""
    factor = conversion(unit, needed, number)
    return _text(Fraction(number) * factor.factor, factor.pi)


def _text(value: Fraction, pi: int) -> str:
    """A number, times pi to a power: a decimal where it is one, else a quotient."""
    if not value:
        return "0"
    plain = repr(float(value)) if Fraction(repr(float(value))) == value else f"{value.numerator}/{value.denominator}"
    plain = plain.removesuffix(".0")
    if not pi:
        return plain
    exponent = "pi" if abs(pi) == 1 else f"pi^{abs(pi)}"
    if pi < 0:
        return f"{plain}/{exponent}"
    above, below = abs(value.numerator), value.denominator
    sign = "-" if value < 0 else ""
    if above > 10**6 or below > 10**6:
        return f"{plain}*{exponent}"
    return f"{sign}{exponent if above == 1 else f'{above}*{exponent}'}" + (f"/{below}" if below > 1 else "")
