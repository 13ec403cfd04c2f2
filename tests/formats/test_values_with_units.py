"""Values with units in TOML: converted exactly, and checked by dimension."""

from __future__ import annotations

from pathlib import Path

import pytest

import symoro_elastic as se
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula, FormulaError
from symoro_elastic.quantities.unit_reader import WORDS, in_si, in_two
from tests.command_line import EXAMPLES, run

MACHINE = """
name = "u"
gravity = [0, "-981 cm/s^2", 0]
joints = [
  { name = "a", kind = "motor", sigma = 0, alpha = "90 deg", d = "350 mm", theta = "q1" },
  { name = "b", kind = "elastic", sigma = 1, alpha = "-30°", d = 0, r = "q2" },
  { name = "t", kind = "fixed", d = "L", theta = "15deg" },
]
[parameters]
L = "250 mm"
M = { value = "1.5 t", unit = "kg" }
k = "12 kN/mm"
[bodies]
a = { mass = "120 kg", center_of_mass = ["10 mm", 0, "2 cm"], inertia = ["1 kg m2", "2e6 g*mm^2", 1] }
b = { mass = "M" }
[springs]
b = { stiffness = "8 N/um", damping = "3 N s/mm" }
[motors]
a = { rotor_inertia = "12 kg cm^2", ratio = 100 }
[friction]
a = { coulomb = "2 Nm", creep = "1 rpm" }
[motion]
duration = "250 ms"
moves = [{ motor = "a", by = "45 deg", in = "0.1 s" }]
[wanted]
outputs = ["t.x"]
tolerance = "10 um"
"""
IN_SI = {
    '"-981 cm/s^2"': "-9.81",
    '"90 deg"': '"pi/2"',
    '"350 mm"': "0.35",
    '"-30°"': '"-pi/6"',
    '"15deg"': '"pi/12"',
    '"250 mm"': '{ value = 0.25, unit = "m" }',
    '"1.5 t"': "1500",
    '"12 kN/mm"': '{ value = 12000000, unit = "N/m" }',
    '"120 kg"': "120",
    '"10 mm"': "0.01",
    '"2 cm"': "0.02",
    '"1 kg m2"': "1",
    '"2e6 g*mm^2"': "0.002",
    '"8 N/um"': "8000000",
    '"3 N s/mm"': "3000",
    '"12 kg cm^2"': "0.0012",
    '"2 Nm"': "2",
    '"1 rpm"': '"pi/30"',
    '"250 ms"': "0.25",
    '"45 deg"': '"pi/4"',
    '"0.1 s"': "0.1",
    '"10 um"': "1e-5",
}


def read(folder: Path, text: str) -> DescribedMachine:
    path = folder / "u.toml"
    path.write_text(text, encoding="utf-8")
    return se.read(path, warn=lambda _: None)


def test_a_machine_with_units_is_that_in_si_units(tmp_path: Path) -> None:
    plain = MACHINE
    for with_unit, si in IN_SI.items():
        assert with_unit in plain
        plain = plain.replace(with_unit, si)
    found, expected = read(tmp_path, MACHINE), read(tmp_path, plain)
    assert found == expected and found.asked == expected.asked
    run("convert", tmp_path / "u.toml", tmp_path / "written.toml")
    assert "deg" not in (tmp_path / "written.toml").read_text()


def test_tables_of_python_take_units_too() -> None:
    tables = {"name": "u", "joints": [{"name": "a", "kind": "motor", "sigma": 0, "theta": "q1", "d": "3 inch"}]}
    assert se.read({**tables, "bodies": {"a": {"mass": 1}}}, warn=lambda _: None).joints[0].d.value() == 0.0762


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"120 kg"', '"120 m"', "joint 1 (a), mass: '120 m' is in m, where kg is needed"),
        ('"120 kg"', '"120 deg"', "joint 1 (a), mass: '120 deg' is in rad, where kg is needed"),
        ('"8 N/um"', '"8 kN m/rad"', "joint 2 (b), stiffness: '8 kN m/rad' is in N m/rad, where N/m is needed"),
        ('"350 mm"', '"350 deg"', "joint 1 (a), d: '350 deg' is in rad, where m is needed"),
        ('"90 deg"', '"90 mm"', "joint 1 (a), alpha: '90 mm' is in m, where rad is needed"),
        ('"2 Nm"', '"2 N"', "joint 1 (a), coulomb: '2 N' is in N, where N m is needed"),
        ('"250 ms"', '"2 Hz"', "motion, duration: '2 Hz' is in Hz, where s is needed"),
        ('"1.5 t", unit = "kg"', '"1.5 t", unit = "m"', "parameters, M: '1.5 t' is in kg, where m is needed"),
        ("ratio = 100", 'ratio = "100 m"', "joint 1 (a), ratio: '100 m' is in m, where rad/rad is needed"),
        ('"120 kg"', '"120 kgs"', "joint 1 (a), mass: 'kgs' is not a known unit; did you mean 'kg'?"),
    ],
)
def test_another_dimension_is_refused(old: str, new: str, said: str, tmp_path: Path) -> None:
    assert old in MACHINE
    with pytest.raises(se.InputError) as error:
        read(tmp_path, MACHINE.replace(old, new))
    assert said in str(error.value)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("word", WORDS)
def test_no_formula_is_a_number_and_a_unit(word: str) -> None:
    """So no file that was read before means something else now."""
    for text in (f"2 {word}", f"2{word}", f"-2.5e3 {word}/s"):
        with pytest.raises(FormulaError):
            Formula.parse(text)


@pytest.mark.parametrize(
    ("text", "si"),
    [
        ("0 deg", "0"), ("180 deg", "pi"), ("-90 deg", "-pi/2"), ("1 rev", "2*pi"), ("22.5 deg", "pi/8"),
        ("0.1 mm", "0.0001"), ("1/3", "1/3"), ("2*L", "2*L"), ("1e-3", "1e-3"), ("31/s", "31/s"), ("2.5e3", "2.5e3"),
    ],
)  # fmt: skip
def test_numbers_stay_exact(text: str, si: str) -> None:
    assert in_si(text, "rad or m") == si


def test_examples_hold_no_text_that_is_converted() -> None:
    for path in EXAMPLES.glob("*.toml"):
        for word in path.read_text().split('"')[1::2]:
            try:
                Formula.parse(word)
            except FormulaError:
                continue
            assert in_si(word, "m") == word


def test_a_value_and_its_unit_may_be_a_table(tmp_path: Path) -> None:
    """Wherever "120 kg" may stand, in lists, in [wanted], and in [parameters], where the unit is kept."""
    tables = MACHINE
    for text in IN_SI:
        number, unit = parts_of(text)
        tables = tables.replace(text, f'{{ value = {number}, unit = "{unit}" }}')
    tables = tables.replace('{ value = { value = 1.5, unit = "t" }, unit = "kg" }', '{ value = 1.5, unit = "t" }')
    assert not any(text in tables for text in IN_SI)
    found, expected = read(tmp_path, tables), read(tmp_path, MACHINE)
    assert found == expected and found.asked == expected.asked
    assert [parameter.unit for parameter in found.parameters] == ["m", "kg", "N/m"]


def parts_of(text: str) -> tuple[str, str]:
    found = in_two(text.strip('"'))
    assert found
    return found


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"120 kg"', '{ value = 120, unit = "m" }', "joint 1 (a), mass, unit: '120 m' is in m, where kg is needed"),
        ('"120 kg"', '{ value = 120, unit = "kgs" }', "(a), mass, unit: 'kgs' is not a known unit; did you mean 'kg'?"),
        ('"120 kg"', '{ value = "M", unit = "kg" }', "(a), mass, value: must be a number: write { value = 350, unit"),
        ('"120 kg"', "{ value = 120 }", "joint 1 (a), mass, unit: is missing"),
        ('"120 kg"', '{ value = nan, unit = "kg" }', "joint 1 (a), mass, value: must be a number"),
        ('"120 kg"', '{ value = 120, units = "kg" }', "mass, units: no such key here; did you mean 'unit'?"),
        ('"12 kN/mm"', '{ value = "2*6", unit = "kN/mm" }', "parameter k: its unit is 'kN/mm', but values are not"),
    ],
)
def test_tables_of_values_are_checked(old: str, new: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "u.toml"
    path.write_text(MACHINE.replace(old, new), encoding="utf-8")
    with pytest.raises(se.InputError) as error:
        read_machine(path)
    assert said in str(error.value)
