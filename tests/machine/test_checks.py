"""Warnings about numbers that are probably not meant, and checks of machines built in Python."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

import symoro_elastic as se
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import MOST_JOINTS, check, formulas
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Body, Joint, Kind, Machine, Parameter, Spring
from tests.machine.samples import TOML
from tests.references.random_machines import planar_2r

EXAMPLES = Path(__file__).parents[2] / "examples"
parse = Formula.parse


def warnings(old: str, new: str) -> list[str]:
    assert old in TOML
    return check(toml.read(TOML.replace(old, new, 1), "arm.toml"))


def one_warning(old: str, new: str) -> str:
    found = warnings(old, new)
    assert len(found) == 1
    return found[0]


INERTIA = "mass = 2.5, center_of_mass = [0.1, 0, 0], inertia = [0.1, 0.2, 0.25]"


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("mass = 2, inertia = [1, 2, 4]", "4 exceeds the sum"),
        ("mass = 2, inertia = [-1, 2, 2]", "-1 is negative"),
        ("mass = 2, inertia = [1, 2, 0, 1, 0, 1]", "-1 is negative"),
        ("inertia = [1, 1, 1]", "without mass there can be no inertia"),
        ("inertia = [0, 0, -1]", "without mass there can be no inertia"),
        ("inertia = [0, 0.1, 0, 0, 0, 1]", "without mass there can be no inertia"),
        ("first_moments = [1, 0, 0], inertia_at_origin = [0, 0, 1]", "without mass there can be no inertia"),
        ("first_moments = [1, 0, 0]", "without mass there can be no first moments"),
        # a point mass of 2 kg at x = 3 m has 18 kg m2 about y and z; less is impossible
        ("mass = 2, first_moments = [6, 0, 0], inertia_at_origin = [0, 17, 17]", "is negative"),
        ('mass = "L2", inertia = [1, 1, "10*L2"]', "3.5 exceeds the sum"),
    ],
)
def test_inertia_that_no_body_has(body: str, said: str) -> None:
    warning = one_warning(INERTIA, body)
    assert warning.startswith("joint 2 (lift): ") and said in warning and "\n" not in warning


@pytest.mark.parametrize(
    "body",
    [
        "mass = 2, inertia = [1, 1, 2]",  # a disc: equality
        "mass = 2, first_moments = [6, 0, 0], inertia_at_origin = [0, 18, 18]",  # a point
        # a point of 0.3 kg at (0.1, 0.2, 0.3) m, up to rounding
        "mass = 0.3, first_moments = [0.03, 0.06, 0.09], "
        "inertia_at_origin = [0.039, -0.006, -0.009, 0.03, -0.018, 0.015]",
        'mass = "K2", inertia = [1, 2, 4]',  # K2 has no value
        "mass = 5",
        "mass = 0, inertia = [0, 0, 0.05]",  # a drive, of which only the turning counts
    ],
)
def test_inertia_that_some_body_has(body: str) -> None:
    assert warnings(INERTIA, body) == []


@pytest.mark.parametrize(
    ("angle", "turn"),
    [
        ("1.5708", "pi/2"),
        ("-1.57079632679", "-pi/2"),
        ("3.1416", "pi"),
        ("4.7124", "3*pi/2"),
        ("1e-4", "0"),
        ('"pi/2 + 0.0001"', "pi/2"),
        (repr(math.nextafter(math.nextafter(math.pi / 2, 2), 2)), "pi/2"),
    ],
)
def test_nearly_a_quarter_turn(angle: str, turn: str) -> None:
    warning = one_warning('alpha = "pi/2"', f"alpha = {angle}")
    assert warning.startswith("joint 2 (lift): alpha = ") and f"write {turn} if meant" in warning


@pytest.mark.parametrize(
    "angle",
    ['"pi/2"', '"-3*pi/2"', repr(math.pi / 2), repr(math.nextafter(math.pi / 2, 2)), "1.6", '"K2"', "0", '"pi/3"', "3"],
)
def test_an_angle_that_is_meant(angle: str) -> None:
    assert warnings('alpha = "pi/2"', f"alpha = {angle}") == []


@pytest.mark.parametrize(
    ("angle", "way_out"),
    [
        ("90", "write pi/2"),
        ("-45", "write -pi/4"),
        ("180", "write pi"),
        ("-180", "write -pi"),
        ("12.3", "divide by 180"),
    ],
)
def test_an_angle_in_degrees_is_questioned(angle: str, way_out: str) -> None:
    warning = one_warning('alpha = "pi/2"', f"alpha = {angle}")
    assert f"alpha = {angle} is" in warning and "turns" in warning
    assert warning.split("degrees? ")[1].startswith(way_out)


@pytest.mark.parametrize("angle", ['"2*pi"', '"-2*pi"', "6.2", '"3*pi/2"'])
def test_an_angle_within_a_turn_is_not_questioned(angle: str) -> None:
    assert warnings('alpha = "pi/2"', f"alpha = {angle}") == []


def test_zero_is_not_negative() -> None:
    assert warnings("damping = 3", 'damping = "L2 - 0.35"') == []


def test_offsets_and_gamma_are_angles_too() -> None:
    assert "theta = 1.5708" in one_warning('"q1"', '"q1 + 1.5708"')
    assert "gamma = 1.5708" in one_warning('name = "tip"', 'name = "tip", gamma = 1.5708')
    assert warnings('"q2 + L2"', '"q2 + 1.5708"') == []


def test_rotor_inertia_where_no_motor_is() -> None:
    assert "kept" in one_warning("[motors]", "[motors]\nlift = { rotor_inertia = 1 }")
    assert "no effect" in one_warning("[motors]", "[motors]\ntip = { rotor_inertia = 1 }")


ONE = Joint("a", 0, Kind.MOTOR, 0, "q1")


def refused(machine: Machine) -> str:
    with pytest.raises(InputError) as caught:
        check(machine)
    assert caught.value.file == machine.name
    return f"{caught.value.place}: {caught.value.what}"


@pytest.mark.parametrize(
    ("joint", "said"),
    [
        (replace(ONE, variable=None), "joint 1 (a), theta: the joint variable is missing"),
        (replace(ONE, sigma=1, variable=None), "joint 1 (a), r: the joint variable is missing"),
        (replace(ONE, sigma=2, kind=Kind.FIXED), "joint 1 (a), joint variable: a fixed frame has no variable"),
        (replace(ONE, sigma=-1), "joint 1 (a), sigma: -1"),
        (replace(ONE, antecedent=1), "joint 1 (a), antecedent: 1 must be 0"),
        (replace(ONE, kind=Kind.ELASTIC), "joint 1 (a), stiffness"),
        (replace(ONE, kind=Kind.PASSIVE, spring=Spring(neutral=parse(1))), "joint 1 (a), neutral"),
        (replace(ONE, body=Body(parse("m"))), "joint 1 (a), mass: 'm' is not declared"),
        (replace(ONE, name="x\ny"), "joint 1 ('x\\ny'), name: the name 'x\\ny' cannot be used"),
    ],
)
def test_machines_built_in_python(joint: Joint, said: str) -> None:
    assert check(Machine("arm", (ONE,))) == []
    assert refused(Machine("arm", (joint,))).startswith(said)


def test_numbers_whose_products_leave_double_precision_are_refused() -> None:
    """From 1e-100 to 1e50, in cells, in parts of symbolic cells, in parameters."""
    for size in ("1e51", "-1e308", "1e-101", "-1e-320"):
        number = f"{float(size):g} is out of range (1e-100 to 1e+50): check the units"
        assert refused(Machine("arm", (replace(ONE, d=parse(size)),))) == f"joint 1 (a), d: {number}"
        symbolic = replace(ONE, d=parse(f"L*{size}"))
        place = refused(Machine("arm", (symbolic,), parameters=(Parameter("L", None),)))
        assert place.startswith("joint 1 (a), d: ") and "is out of range (1e-100 to 1e+50)" in place
        valued = Machine("arm", (ONE,), parameters=(Parameter("L", parse(size)),))
        assert refused(valued) == f"parameters, L: {number}"
    for size in ("1e50", "-1e50", "1e-100", "0"):
        assert check(Machine("arm", (replace(ONE, d=parse(size)),), parameters=(Parameter("L", parse(size)),))) == []


@pytest.mark.parametrize("angle", ["pi/2", "-pi/2", "3*pi/2", "1000001*pi/2"])
def test_a_parameter_is_no_tangent_of_a_right_angle(angle: str) -> None:
    machine = Machine("arm", (replace(ONE, d=parse("L")),), parameters=(Parameter("L", parse(f"tan({angle})")),))
    assert refused(machine) == f"parameters, L: 'tan({angle})' has no value: it divides by zero"


def test_a_name_too_long_to_be_declared_is_cut() -> None:
    long = "x" * 500
    said = refused(Machine("arm", (replace(ONE, d=parse(long)),)))
    assert said.startswith("joint 1 (a), d: 'xxx") and said.endswith("...' is not declared in [parameters]")


def test_no_joint_at_all() -> None:
    assert refused(Machine("arm", ())).startswith("joints: the machine has no joint")


def test_more_joints_than_can_be_modelled() -> None:
    many = tuple(replace(ONE, name=f"j{k}", variable=f"q{k}") for k in range(MOST_JOINTS + 1))
    assert refused(Machine("arm", many)) == f"joints: {MOST_JOINTS + 1} rows: at most {MOST_JOINTS} can be modelled"


def test_formulas_are_all_of_them() -> None:
    """Every Formula reachable in the dataclasses is checked."""
    machine = toml.read(TOML, "arm.toml")
    found = [id(formula) for _, formula in formulas(machine)]
    reachable: list[int] = []

    def walk(value: object) -> None:
        if isinstance(value, Formula):
            reachable.append(id(value))
        elif isinstance(value, tuple):
            for part in value:
                walk(part)
        elif hasattr(value, "__dataclass_fields__"):
            for name in value.__dataclass_fields__:
                walk(getattr(value, name))

    walk(machine.joints)
    walk(machine.base)
    assert sorted(found) == sorted(reachable)


@pytest.mark.parametrize("unit", ["mm", "N/mm", "deg", "g mm2", "kN"])
def test_units_that_nothing_converts_are_refused(unit: str) -> None:
    machine = planar_2r()
    first, *others = machine.parameters
    with pytest.raises(
        InputError, match=rf"parameter {first.name}: its unit is '{unit}', but values are not converted"
    ):
        check(replace(machine, parameters=(replace(first, unit=unit), *others)))


@pytest.mark.parametrize("unit", ["", "m", "kg m2", "N m/rad", "m/s2", "N s/m", "Nm", "1"])
def test_units_of_si_need_no_conversion(unit: str) -> None:
    machine = planar_2r()
    check(replace(machine, parameters=tuple(replace(p, unit=unit) for p in machine.parameters)))


@pytest.mark.parametrize(("unit", "near"), [("turns of the rotor", ""), ("kgs", "; did you mean 'kg'?"), ("kg+m", "")])
def test_units_that_nobody_knows_are_refused(unit: str, near: str) -> None:
    machine = planar_2r()
    first, *others = machine.parameters
    with pytest.raises(InputError, match=rf"parameter {first.name}: .* known unit.*{re.escape(near)}"):
        check(replace(machine, parameters=(replace(first, unit=unit), *others)))


def test_angles_next_to_quarter_turns_are_one_line_of_a_file(tmp_path: Path) -> None:
    """Digits that a robot's file lacks are said once, whoever the robot is from; a table names the cells."""
    urdf = EXAMPLES / "pendant_arm.urdf"
    line = "3 angles are up to 4.9e-12 rad off quarter turns: taken as written; convert with --snap 1e-11 rounds them"
    assert [said for said in warned(urdf) if "off" in said] == [line]
    table = tmp_path / "arm.toml"
    se.write(se.read(urdf, warn=lambda _: None), table)
    table.write_text(table.read_text(encoding="utf-8").replace("1.57079632679", "1.5707963"), encoding="utf-8")
    cells = "joint 2 (shoulder) alpha, joint 4 (wrist) alpha"
    way_out = "write multiples of pi/2 if meant, or convert with --snap 1e-7 rounds them"
    assert [said for said in warned(table) if "off quarter" in said] == [
        f"2 angles are up to 7.1e-08 rad off quarter turns, taken as written; {way_out}: {cells}"
    ]


def warned(path: Path) -> list[str]:
    lines: list[str] = []
    se.read(path, warn=lines.append)
    return lines
