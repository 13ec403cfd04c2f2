"""Units that parameters declare, and those of joint variables, are held against the formulas that they stand in."""

from __future__ import annotations

import math
import random
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import assume, event, given, settings
from hypothesis import strategies as st

from symoro_elastic.formats.reading import read_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.constants import with_free_numbers
from symoro_elastic.machine.formula import Formula, text_of
from symoro_elastic.machine.formula_units import mismatches
from symoro_elastic.quantities.unit_reader import Powers, in_base_units, product
from tests.closed_chains.machines import FILES, machine
from tests.command_line import EXAMPLES

ARM = """
joints = [
  {{ name = "turn", antecedent = 0, kind = "motor", sigma = 0, theta = "q1", d = "{d}" }},
  {{ name = "slide", antecedent = "turn", kind = "elastic", sigma = 1, r = "z" }},
  {{ name = "tool", antecedent = 0, kind = "coupled", sigma = {sigma}, {cell} }},
]
[parameters]
L1 = {{ value = 0.3, unit = "m" }}
M1 = {{ value = 3, unit = "kg" }}
N = {{ value = 3, unit = "rad" }}
pitch = {{ value = 0.01, unit = "m/turn" }}
teeth = {{ value = 0.01, unit = "rad/m" }}
R = 0.2
[springs]
slide = {{ stiffness = "{k}" }}
"""


def said(cell: str = 'r = "R*q1"', d: str = "L1", k: str = "K/(0.1 + z)") -> str:
    """The warnings of a machine with these cells, or why it is refused."""
    text = ARM.format(cell=cell, sigma=int(cell.startswith("r ")), d=d, k=k).replace("R = 0.2", "R = 0.2\nK = 800")
    try:
        return "\n".join(f"warning: {line}" for line in check(toml.read(text, "arm.toml")))
    except InputError as error:
        return str(error).removeprefix("arm.toml: ")


END = ": correct the formula, or a unit in [parameters]"
MISSING = ": a radius or a pitch is missing, as in R*q1"


@pytest.mark.parametrize(
    ("cell", "what"),
    [
        ('r = "N*q1"', f"r: N*q1 is in rad2 in 'N*q1', where m is needed{END}"),
        ('r = "M1*q1"', f"r: M1*q1 is in kg rad in 'M1*q1', where m is needed{END}"),
        ('r = "M1 + L1*q1"', f"r: M1 is in kg in 'M1 + L1*q1', where m is needed{END}"),
        ('r = "L1*sin(z)"', f"r: z is in m in sin(z), where an angle is needed{END}"),
        ('r = "L1*(q1 - z)"', f"r: q1 is an angle, added to a length in 'L1*(q1 - z)'{MISSING}"),
        ('theta = "z"', f"theta: z is a length, added to an angle in 'z'{MISSING}"),
        ('theta = "q1 - L1/2 + L1"', f"theta: L1 is a length, added to an angle in 'q1 - L1/2 + L1'{MISSING}"),
        ('theta = "atan2(z, M1*q1)"', f"theta: M1*q1 is in kg rad in 'atan2(z, M1*q1)', where m is needed{END}"),
    ],
)
def test_units_that_contradict_are_refused(cell: str, what: str) -> None:
    assert said(cell) == f"joint 3 (tool), {what}"


@pytest.mark.parametrize(
    ("d", "what"),
    [
        ("L1 + M1", f"M1 is in kg in 'L1 + M1', where m is needed{END}"),
        ("sqrt(L1^2 + M1^2)", f"M1^2 is in kg2 in 'sqrt(L1^2 + M1^2)', where m2 is needed{END}"),
        ("R*tan(L1)", f"L1 is in m in tan(L1), where an angle is needed{END}"),
    ],
)
def test_sums_and_functions_that_contradict_are_refused_in_every_cell(d: str, what: str) -> None:
    assert said(d=d) == f"joint 1 (turn), d: {what}"


@pytest.mark.parametrize(
    ("cells", "what"),
    [
        ({"cell": 'r = "2*q1"'}, f"joint 3 (tool), r: 2*q1 is an angle, added to a length in '2*q1'{MISSING}"),
        ({"cell": 'theta = "20*z"'}, f"joint 3 (tool), theta: 20*z is a length, added to an angle in '20*z'{MISSING}"),
        ({"cell": 'r = "sin(q1)"'}, f"joint 3 (tool), r: sin(q1) has no unit in 'sin(q1)', where m is needed{END}"),
        (
            {"cell": 'theta = "N*q1"'},
            f"joint 3 (tool), theta: N*q1 is in rad2 in 'N*q1', where an angle is needed{END}",
        ),
        (
            {"cell": 'r = "L1*cos(20*z)"'},
            f"joint 3 (tool), r: 20*z is in m in cos(20*z), where an angle is needed{END}",
        ),
        ({"d": "M1"}, f"joint 1 (turn), d: M1 is in kg in 'M1', where m is needed{END}"),
        ({"d": "2*M1"}, f"joint 1 (turn), d: 2*M1 is in kg in '2*M1', where m is needed{END}"),
        ({"k": "L1"}, f"joint 2 (slide), stiffness: L1 is in m in 'L1', where kg/s2 is needed{END}"),
    ],
)
def test_what_a_number_with_a_unit_could_make_right_is_a_warning(cells: dict[str, str], what: str) -> None:
    assert said(**cells) == f"warning: {what}"


@pytest.mark.parametrize(
    "cells",
    [
        *(
            {"cell": cell}
            for cell in (
                *('r = "L1*q1"', 'r = "R*q1 + z/2"', 'r = "0.05*q1"', 'r = "0.01/(2*pi)*q1"', 'r = "pitch/(2*pi)*q1"'),
                *(
                    'r = "q1/teeth"',
                    'r = "L1*sin(z/L1)"',
                    'r = "R*sin(0.5*z)"',
                    'r = "sqrt(L1^2 + z^2 - 2*L1*z*cos(q1))"',
                ),
                *('theta = "z/R"', 'theta = "teeth*z - q1/3 + pi"', 'theta = "atan2(L1*sin(q1), 0.4 + L1*cos(q1))"'),
                *('theta = "q1*N/N"', 'theta = "R*q1^2"'),
            )
        ),
        *({"d": d} for d in ("L1/2 + 0.1", "-(L1 + 1)", "R*M1", "0.5*M1", "L1*M1/M1", "sqrt(2)*L1")),
        *({"k": k} for k in ("8e4", "R", "3e4/(1 + z^2)", "K*(1 - 0.3*sin(q1))", "M1*9.81/L1")),
    ],
)
def test_what_may_be_meant_is_read_without_a_word(cells: dict[str, str]) -> None:
    assert said(**cells) == ""


@pytest.mark.parametrize("name", FILES)
def test_machines_that_are_right_have_no_doubtful_units(name: str) -> None:
    """The pusher of the cam moves by `tan(d_hand)/3`, a third of a metre: said, as a whole number is a ratio."""
    lines = [line for line in check(machine(name)) if "needed" in line or "missing" in line]
    assert [line.split(":")[0] for line in lines] == (["joint 4 (pusher), r"] if name == "cam" else [])


@pytest.mark.parametrize("path", sorted(p for p in EXAMPLES.iterdir() if p.suffix in (".toml", ".par")), ids=str)
def test_examples_have_no_doubtful_units(path: Path) -> None:
    _, lines = read_machine(path)
    assert not [line for line in lines if "needed" in line or "missing" in line]


def test_numbers_that_become_parameters_have_the_units_of_their_cells() -> None:
    """Those of a rotor behind a ratio too, where the joint slides."""
    text = ARM.format(cell='r = "R*q1"', sigma=1, d="L1", k="8e4")
    rotor = "[motors]\nslide = { rotor_inertia = 2e-4, ratio = 600 }\n"
    whole = with_free_numbers(toml.read(text + rotor, "arm.toml"), ("springs", "motors"))
    assert not [line for line in check(whole) if "needed" in line]
    assert {"kg m2", "rad/m", "N/m"} <= {parameter.unit for parameter in whole.parameters}


@pytest.mark.parametrize(
    ("unit", "same"),
    [
        ("kg m2", "kg*m^2"),
        ("kg m2", "kg·m²"),
        ("kg m2", "kg.m**2"),
        ("N m", "J"),
        ("N m", "Nm"),
        ("N m/rad", "kg m2/(s2 rad)"),
        ("m/s/s", "m s-2"),
        ("Pa", "N/m2"),
        ("W", "J Hz"),
        ("1", "m/m"),
    ],
)
def test_units_are_read_however_they_are_written(unit: str, same: str) -> None:
    assert in_base_units(unit) == in_base_units(same) is not None


@pytest.mark.parametrize("unit", ["", "turns of the rotor", "N/m s", "N m/B", "/s", "m//s", "(m", "m^999", "kg+m", "é"])
def test_other_texts_are_no_units(unit: str) -> None:
    assert in_base_units(unit) is None


NAMES = {"L": "m", "M": "kg", "T": "s", "V": "m/s", "F": "N", "q": "rad", "n": "1"}
R3 = range(-2, 3)
UNITS = {name: in_base_units(unit) or {} for name, unit in NAMES.items()}
LEAVES = st.sampled_from(sorted(NAMES)) | st.builds("{}*{}".format, st.integers(2, 9), st.sampled_from(sorted(NAMES)))
CANDIDATES = [product((UNITS["M"], a), (UNITS["L"], b), (UNITS["T"], c)) for a in R3 for b in R3 for c in R3]
FORMULAS = st.recursive(
    LEAVES,
    lambda part: st.builds("({}){}({})".format, part, st.sampled_from("+-*/"), part) | st.builds("({})^2".format, part),
    max_leaves=6,
)


def size(powers: Powers) -> Fraction:
    """The factor of a value whose unit is this one, where the units m, kg and s are 1/7, 1/3 and 1/5 as large."""
    return math.prod((Fraction({"m": 7, "kg": 3, "s": 5}.get(base, 1)) ** int(x) for base, x in powers.items()))


@pytest.mark.thorough
@given(FORMULAS, st.randoms(use_true_random=False))
@settings(max_examples=150, deadline=None)
def test_what_is_accepted_is_the_same_in_any_units(text: str, rng: random.Random) -> None:
    """In mm, g and the like the value of a formula of some unit changes by the factor of that unit."""
    formula = Formula.parse(text)
    at = {name: Fraction(rng.randint(1, 99), 10) for name in NAMES}
    try:
        before = formula.evaluate(at, {}, Fraction)
        after = formula.evaluate({name: x * size(UNITS[name]) for name, x in at.items()}, {}, Fraction)
    except ZeroDivisionError:
        assume(False)
    found = [unit for unit in CANDIDATES if not mismatches(formula, UNITS, unit)]
    assert all(after == before * size(unit) for unit in found)
    event("accepted" if found else "refused")


@pytest.mark.thorough
@given(FORMULAS)
@settings(max_examples=200, deadline=None)
def test_parts_are_written_as_they_are_read(text: str) -> None:
    tree = Formula.parse(text).tree
    assert Formula.parse(text_of(tree)).tree == tree


@pytest.mark.parametrize(
    "text", ["-(a + b)*c^-2", "sqrt(2)*a", "atan2(a, -b)/pi", "a - (b - c)", "a/(b/c)", "(-3)^2*a", "0.25*a"]
)
def test_signs_functions_and_numbers_are_written_too(text: str) -> None:
    tree = Formula.parse(text).tree
    again = Formula.parse(text_of(tree))
    values = {"a": 0.7, "b": 1.3, "c": -2.1}
    assert again.value(values) == pytest.approx(Formula.parse(text).value(values), rel=1e-15)


def test_products_of_units_cancel() -> None:
    assert product((UNITS["F"], 1), (UNITS["M"], -1), (UNITS["V"], -1), (UNITS["T"], 1)) == {}
