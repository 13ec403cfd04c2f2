"""Numbers with a unit in a file, such as "120 kg" or "30 deg": converted to SI units, exactly."""

from __future__ import annotations

import re
from fractions import Fraction

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.names import quote
from symoro_elastic.quantities.scaled_units import Scaled, alternatives, scaled

NUMBER_AND_UNIT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-zµμ°].*?)\s*")


def unit_in(text: str) -> Scaled | None:
    """Return the unit of a text that is a number and a unit; None for any other text."""
    found = NUMBER_AND_UNIT.fullmatch(text)
    return scaled(found[2]) if found else None


def in_si(text: str, units: str, source: str, place: str) -> str:
    """Return a text whose number has a unit as a number or formula in SI units; other texts as they are.

    `units` are those that the value may have. No formula is a number and a word, so none changes its meaning. Raises
    `InputError` for a unit of another dimension.
    """
    found = NUMBER_AND_UNIT.fullmatch(text)
    unit = scaled(found[2]) if found else None
    if found is None or unit is None:
        return text
    known = alternatives(units)
    if not unit.fits(units):
        needed = " or ".join(known) or "a number without unit"
        raise InputError(source, place, f"{quote(text)} is in {unit.text}, where {needed} is needed")
    return _text(Fraction(found[1]) * unit.factor, unit.pi)


def _text(value: Fraction, pi: Fraction) -> str:
    """A number, times pi to a power: a decimal where it is one, else a quotient."""
    if not value:
        return "0"
    plain = repr(float(value)) if Fraction(repr(float(value))) == value else _quotient(value)
    plain = plain.removesuffix(".0")
    if not pi:
        return plain
    exponent = f"pi^{pi}" if abs(pi) != 1 else "pi"
    if pi < 0:
        return f"{plain}/{exponent.replace('-', '')}"
    above, below = abs(value.numerator), value.denominator
    sign = "-" if value < 0 else ""
    if above > 10**6 or below > 10**6:
        return f"{plain}*{exponent}"
    return f"{sign}{exponent if above == 1 else f'{above}*{exponent}'}" + (f"/{below}" if below > 1 else "")


def _quotient(value: Fraction) -> str:
    return f"{value.numerator}/{value.denominator}"
