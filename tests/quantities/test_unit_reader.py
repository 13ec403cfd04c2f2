"""The one reader of units: texts of catalogues by their exact SI values, and that what the program prints is read."""

from __future__ import annotations

import re
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symoro_elastic.formats.toml.keys import SECTIONS
from symoro_elastic.formats.toml.vibration_tests import TESTS
from symoro_elastic.machine.columns import Dimension
from symoro_elastic.machine.limits import UNITS as OF_LIMITS
from symoro_elastic.quantities import INTERMEDIATES, QUANTITIES, PairUnit, Unit
from symoro_elastic.quantities.unit_reader import (
    COMPACT,
    SI,
    SPELLINGS,
    WORDS,
    UnitError,
    alternatives,
    conversion,
    dimension,
    in_si,
    in_two,
    read_unit,
    spelled_label,
    unit_text,
)
from symoro_elastic.quantities.units import DAMPING, STIFFNESS, quotient

F = Fraction
POUND, G0, INCH = F("0.45359237"), F("9.80665"), F("0.0254")
LBF, OZF = POUND * G0, POUND * G0 / 16
K, D, E, W, A = "N m/rad", "N m s/rad", "V s/rad", "rad/s", "rad/s2"

CATALOGUES = [
    # gears and springs
    ("N m/arcmin", K, 10800, -1), ("Nm/arcmin", K, 10800, -1), ("N m/'", K, 10800, -1), ("Nm/\u2032", K, 10800, -1),
    ('N m/"', K, 648000, -1), ("Nm/arcsec", K, 648000, -1), ("Nm/°", K, 180, -1), ("kNm/mrad", K, 10**6, 0),
    ("lbf ft/deg", K, LBF * INCH * 12 * 180, -1), ("lb-in/rad", K, LBF * INCH, 0), ("N m", K, 1, 0),
    ("N/µm", "N/m", 10**6, 0), ("N/μm", "N/m", 10**6, 0), ("kN/mm", "N/m", 10**6, 0), ("N/micron", "N/m", 10**6, 0),
    ("lbf/in", "N/m", LBF / INCH, 0), ("lb/in", "N/m", LBF / INCH, 0), ("kgf/mm", "N/m", G0 * 1000, 0),
    ("arcmin", "rad", F(1, 10800), 1), ("'", "rad", F(1, 10800), 1), ("''", "rad", F(1, 648000), 1),
    ("″", "rad", F(1, 648000), 1), ("°", "rad", F(1, 180), 1), ("mdeg", "rad", F(1, 180000), 1), ("rev", "rad", 2, 1),
    # speeds and what is per speed
    ("min-1", W, F(1, 30), 1), ("min⁻¹", W, F(1, 30), 1), ("min^-1", W, F(1, 30), 1), ("1/min", W, F(1, 30), 1),
    ("rpm", W, F(1, 30), 1), ("krpm", W, F(100, 3), 1), ("rev/min", W, F(1, 30), 1), ("r/min", W, F(1, 30), 1),
    ("U/min", W, F(1, 30), 1), ("tr/min", W, F(1, 30), 1), ("rps", W, 2, 1), ("Hz", W, 2, 1),
    ("deg/s", W, F(1, 180), 1),
    ("1000 min-1", W, F(100, 3), 1), ("rad s-1", W, 1, 0), ("min-1/s", A, F(1, 30), 1), ("1/min/s", A, F(1, 30), 1),
    ("Hz/s", A, 2, 1), ("rev/s2", A, 2, 1), ("rpm/s", A, F(1, 30), 1), ("°/s²", A, F(1, 180), 1),
    ("m/min", "m/s", F(1, 60), 0), ("mm/min", "m/s", F(1, 60000), 0), ("in/s", "m/s", INCH, 0),
    ("N m s", D, 1, 0), ("Nms", D, 1, 0), ("Nms/rad", D, 1, 0), ("N m/min-1", D, 30, -1),
    ("Nm/(rev/s)", D, F(1, 2), -1),
    ("Nm/rpm", D, 30, -1), ("mNm/(1000 rpm)", D, F(3, 10**5), -1), ("oz-in/krpm", D, OZF * INCH * F(3, 100), -1),
    ("mV/min-1", E, F(3, 100), -1), ("V/krpm", E, F(3, 100), -1), ("V/1000 min-1", E, F(3, 100), -1),
    ("V/Hz", E, F(1, 2), -1), ("V s", E, 1, 0), ("Vs/rad", E, 1, 0), ("mm/rev", "m/rad", F(1, 2000), -1),
    ("rev/m", "rad/m", 2, 1),
    # rates and frequencies
    ("1/s", "1/s", 1, 0), ("s-1", "1/s", 1, 0), ("1/min", "1/s", F(1, 60), 0), ("rad/s", "1/s", 1, 0),
    ("m/(min mm)", "1/s", F(50, 3), 0), ("Hz", "Hz", 1, 0), ("kHz", "Hz", 1000, 0), ("rad/s", "Hz", F(1, 2), -1),
    ("rpm", "Hz", F(1, 60), 0), ("1/min", "Hz", F(1, 60), 0),
    # masses, inertias, forces, torques
    ("kgcm2", "kg m2", F(1, 10**4), 0), ("kgcm²", "kg m2", F(1, 10**4), 0), ("gcm2", "kg m2", F(1, 10**7), 0),
    ("g cm²", "kg m2", F(1, 10**7), 0), ("kg·mm²", "kg m2", F(1, 10**6), 0), ("kg*m^2", "kg m2", 1, 0),
    ("kg.m**2", "kg m2", 1, 0), ("Kg m2", "kg m2", 1, 0), ("lb ft2", "kg m2", POUND * (12 * INCH) ** 2, 0),
    ("oz in2", "kg m2", POUND / 16 * INCH**2, 0), ("oz-in-s2", "kg m2", OZF * INCH, 0),
    ("slug ft2", "kg m2", LBF * 12 * INCH, 0), ("lb", "kg", POUND, 0), ("t", "kg", 1000, 0), ("g", "kg", F(1, 1000), 0),
    ("lb", "N", LBF, 0), ("lbf", "N", LBF, 0), ("kgf", "N", G0, 0), ("kp", "N", G0, 0), ("daN", "N", 10, 0),
    ("ozf", "N", OZF, 0), ("oz in", "N m", OZF * INCH, 0), ("lb in", "N m", LBF * INCH, 0),
    ("ozin", "N m", OZF * INCH, 0),
    ("ft lbf", "N m", LBF * 12 * INCH, 0), ("kgf cm", "N m", G0 / 100, 0), ("N-m", "N m", 1, 0),
    ("Ncm", "N m", F(1, 100), 0),
    ("mNm", "N m", F(1, 1000), 0), ("J", "N m", 1, 0), ("N/mm²", "N/m2", 10**6, 0), ("MPa", "N/m2", 10**6, 0),
    ("psi", "N/m2", LBF / INCH**2, 0), ("bar", "Pa", 10**5, 0),
    # lengths, accelerations, times, electrical
    ("in", "m", INCH, 0), ("inches", "m", INCH, 0), ("ft", "m", 12 * INCH, 0), ("millimeters", "m", F(1, 1000), 0),
    ("g", "m/s2", G0, 0), ("m/sec^2", "m/s2", 1, 0), ("in/s2", "m/s2", INCH, 0), ("m·s⁻²", "m/s2", 1, 0),
    ("mg/N", "m/s2/N", G0 / 1000, 0), ("g/lbf", "m/s2 / N", G0 / LBF, 0), ("(m/s^2)/kN", "m/s2/N", F(1, 1000), 0),
    ("ns", "s", F(1, 10**9), 0), ("sec", "s", 1, 0), ("h", "s", 3600, 0), ("ohm", "Ohm", 1, 0), ("Ω", "Ohm", 1, 0),
    ("\u2126", "Ohm", 1, 0), ("mΩ", "Ohm", F(1, 1000), 0), ("mH", "H", F(1, 1000), 0), ("Nm/A", "N m/A", 1, 0),
    ("%", "", F(1, 100), 0), ("1", "", 1, 0), ("rev/rev", "rad/rad", 1, 0),
]  # fmt: skip
REFUSED = [
    ("N m/arcmn", K, "'arcmn' in 'N m/arcmn' is not a known unit; did you mean 'arcmin'?"),
    ("MM", "m", "did you mean 'mm' or 'Mm'?"), ("mn", "m", "did you mean 'mN' or 'MN'?"),
    ("NM", "N m", "'nm' or 'Nm'?"),
    ("milimeter", "m", "did you mean 'millimeter'?"), ("furlong", "m", "'furlong' is not a known unit"),
    ("l/h", "m3/s", "'l' in 'l/h' is not a known unit"), ("deg C", "rad", "'C' in 'deg C' is not a known unit"),
    ("°C", "rad", "'degC' in '°C' is not a known unit"),
    ("Nm/Arms", "N m/A", "'Arms' in 'Nm/Arms' is not a known unit"),
    ("1/s", W, "'1/s' may be radians or turns: write rad/s or rev/s"), ("s-1", W, "write rad/s or rev/s"),
    ("1/s2", A, "write rad/s2 or rev/s2"), ("N m/s-1", D, "write N m s/rad or N m s/rev"),
    ("1/m", "rad/m", "or rev/m"),
    ("1/s", "Hz", "write Hz or rad/s"), ("Hz", "1/s", "counts turns or degrees"), ("rpm", "1/s", "counts turns"),
    ("N m/rad", "N m", "'N m/rad' cannot be converted to N m"), ("kg cm", "N m", "cannot be converted to N m"),
    ("N/m s", "N s/m", "put what is below the slash into brackets, as in N/(m s)"),
    ("nm", "N m", "cannot be converted"),
    *((text, "m", "is not a product of known units") for text in ("", "/m", "m//s", "(m", "kg+m", "m^999", "m 2")),
    ("é", "m", "is not a product of known units"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "needed", "factor", "pi"), CATALOGUES)
def test_units_of_catalogues_have_their_exact_values(text: str, needed: str, factor: Fraction | int, pi: int) -> None:
    found = conversion(text, needed)
    assert (found.factor, found.pi) == (factor, pi)


@pytest.mark.parametrize(("text", "needed", "said"), REFUSED)
def test_what_is_not_a_unit_or_has_two_meanings_is_refused(text: str, needed: str, said: str) -> None:
    with pytest.raises(UnitError) as error:
        conversion(text, needed)
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("text", "si", "number"),
    [
        ("N m/'", "N m/rad", 34377.467707849394 / 10), ("N m/min-1", "N m s/rad", 9.549296585513721), ("g", "kg", 1e-3),
        ("Hz", "Hz", 1.0), ("1/s", "1/s", 1.0), ("kgcm2", "kg m2", 1e-4), ("mm", "m", 1e-3),
        ("lbf/in", "N/m", 175.126835),
    ],
)  # fmt: skip
def test_a_unit_alone_has_its_si_unit(text: str, si: str, number: float) -> None:
    found = read_unit(text)
    assert found.text == si and found.number == pytest.approx(number, rel=1e-8)


@pytest.mark.parametrize("text", ["lb", "oz in", "lb/in", "min-1", "1/min2"])
def test_a_unit_of_two_meanings_is_refused_alone(text: str) -> None:
    with pytest.raises(UnitError, match="write"):
        read_unit(text)


@pytest.mark.parametrize(
    ("label", "needed", "number"),
    [("HERTZ", "Hz", 1.0), ("hz", "Hz", 1.0), ("MM", "m", 1e-3), ("M/SEC^2", "m/s2", 1.0), ("IN/S**2", "m/s2", 0.0254),
     ("G/LBF", "m/s2/N", 9.80665 / 4.4482216152605), ("Newton", "N", 1.0), ("mm/s²", "m/s2", 1e-3), ("MS", "s", 1e-3)],
)  # fmt: skip
def test_labels_are_read_without_case(label: str, needed: str, number: float) -> None:
    assert conversion(spelled_label(label), needed).number == pytest.approx(number, rel=1e-15)


def test_a_label_in_capitals_that_case_decides_is_refused() -> None:
    with pytest.raises(UnitError, match="did you mean 'mN' or 'MN'"):
        spelled_label("MN/MM")
    assert spelled_label("MN/mm") == "MN/mm"


# What is printed is read


def printed_units() -> list[str]:
    """Units of quantities, of keys of files, of columns of the table and of limits."""
    units = [row.unit for row in (*QUANTITIES.values(), *INTERMEDIATES)]
    texts = [unit.text for unit in units if isinstance(unit, Unit | PairUnit)]
    keys = [key.unit for section in (*SECTIONS, TESTS) for key in section.keys]
    cells = [unit for row in Dimension for unit in row.units]
    limits = [unit for pair in OF_LIMITS.values() for unit in pair]
    parts = re.split(r",? (?:or|and) |, ", " or ".join((*texts, *keys, *cells, *limits)))
    return sorted({unit for unit in parts if unit})


@pytest.mark.parametrize("unit", printed_units())
def test_every_unit_that_the_program_prints_is_read_back_as_itself(unit: str) -> None:
    if unit in ("rad for a number", "else the unit of the signal"):
        return  # words of a key
    found = read_unit(unit)
    assert found.is_si and dimension(unit) == found.base and conversion(unit, unit).is_si
    assert in_si(f"2.5 {unit}", unit) == "2.5"


def test_quotients_of_units_are_read_back() -> None:
    assert quotient("N m", "rad/s") == DAMPING.angular_angular and quotient("N m", "rad") == STIFFNESS.angular_angular
    for text in (*DAMPING.text.replace(" or ", ", ").split(", "), *STIFFNESS.text.replace(" or ", ", ").split(", ")):
        assert alternatives(text) == [text]


SI_WORDS = st.sampled_from(sorted(SI))
POWERS = st.dictionaries(SI_WORDS, st.integers(-4, 4).filter(bool), min_size=1, max_size=4)


@pytest.mark.thorough
@given(POWERS)
@settings(max_examples=300, deadline=None)
def test_products_of_si_words_are_read_back_exactly(powers: dict[str, int]) -> None:
    exact = {name: Fraction(power) for name, power in powers.items()}
    text = unit_text(exact)
    assert read_unit_or_rate(text) == exact
    for written in (text.replace(" ", "*"), text.replace(" ", "·"), text.replace(" ", "  ")):
        assert read_unit_or_rate(written) == exact


def read_unit_or_rate(text: str) -> dict[str, Fraction]:
    return dict(conversion(text, text).si)


WORDS_TO_COMBINE = sorted({word for word in (*WORDS, *COMPACT) if word.isascii() and word != "%"})


@pytest.mark.thorough
@given(st.lists(st.tuples(st.sampled_from(WORDS_TO_COMBINE), st.integers(-3, 3).filter(bool)), min_size=1, max_size=3))
@settings(max_examples=300, deadline=None)
def test_products_of_known_words_have_the_product_of_their_factors(factors: list[tuple[str, int]]) -> None:
    """The exponent of a compact word is that of its last part. Masses and forces of one word are read as masses."""
    value, pi = Fraction(1), 0
    for word, power in factors:
        *before, last = COMPACT.get(word, (word,))
        for part, exponent in [*((one, 1) for one in before), (last, power)]:
            value, pi = value * WORDS[part].factor ** exponent, pi + WORDS[part].pi * exponent
    text = " ".join(f"{word}^{power}" for word, power in factors)
    try:
        found = read_unit(text)
    except UnitError as error:
        assert "may be" in str(error)
    else:
        turns = found.pi - pi
        assert found.factor == value * Fraction(2) ** turns and abs(turns) <= 1


@pytest.mark.thorough
@given(st.text(max_size=20))
@settings(max_examples=300, deadline=None)
def test_any_text_is_a_unit_or_refused_with_one_line(text: str) -> None:
    try:
        conversion(text, "N m/rad or m")
    except UnitError as error:
        assert "\n" not in str(error) and len(str(error)) < 250


def test_no_word_is_spelled_two_ways_that_case_decides_and_read_in_either() -> None:
    """Of two units that differ by case only, as mN and MN, each is read as it is written, and no other spelling."""
    for spellings in SPELLINGS.values():
        meanings = {(WORDS[word].number, WORDS[word].text) if word in WORDS else word for word in spellings}
        if len(meanings) > 1:
            others = {spellings[0].lower(), spellings[0].upper(), spellings[0].title()} - {*spellings}
            for other in others:
                with pytest.raises(UnitError, match="known unit"):
                    read_unit(other)


@pytest.mark.parametrize("unit", ["Gm^40/m^39", "nm^60/m^59", "Gm^99/Gm^98", "((((((((m))))))))", "m" * 99, "(" * 99])
def test_units_of_any_size_are_read_or_refused(unit: str) -> None:
    try:
        assert 0 < conversion(unit, "m").number < np.inf
    except UnitError as error:
        assert "\n" not in str(error)


@pytest.mark.parametrize(
    "text", ["2e3", "31/s", "1.5E-3", "2*L", "-3/4", "L", "1e999999999 m", "1e400 m", "1" * 200 + " mm"]
)
def test_formulas_are_no_numbers_with_units(text: str) -> None:
    assert in_two(text) is None and in_si(text, "m") == text
