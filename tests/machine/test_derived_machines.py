"""Machines made of coupled ones: rotors, named and freed cells, labels, warnings, a floating base."""

from __future__ import annotations

from dataclasses import replace

import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.constants import SECTIONS, with_constants, with_free_numbers
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.frames import with_base_coordinates
from symoro_elastic.machine.labels import ParameterLabels
from symoro_elastic.machine.machine import Floating, Kind, Machine
from symoro_elastic.machine.named_cells import with_named_cells, with_values
from symoro_elastic.machine.reduced import reduced_model, rotors, with_ratios
from symoro_elastic.machine.restrict import rigid
from tests.machine.samples import COUPLED

DISC = "{ mass = 1, center_of_mass = [0, 0, 0], inertia = [0.0004, 0.0004, 0.0007] }"


def read(*changes: tuple[str, str]) -> Machine:
    text = COUPLED
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return toml.read(text, "arm.toml")


def with_discs(*names: str) -> tuple[str, str]:
    return "[bodies]", "\n".join(["[bodies]", *(f"{name} = {DISC}" for name in names)])


def test_geared_rotors_are_found() -> None:
    """The rotor follows the waist, the crank follows the drive; a jaw that slides and an arm that carries are none."""
    machine = read(with_discs("rotor", "drive", "jaw"))
    assert rotors(machine) == (2, 6)
    less = reduced_model(machine)
    for j in (2, 6):
        assert (less.joint(j).rotor_inertia.value(), less.joint(j).body.inertia[5].is_zero) == (0.0007, True)
    unbalanced = "[bodies]", "[bodies]\nrotor = { mass = 1, center_of_mass = [0.1, 0, 0] }"
    assert not {2, 3} & {*rotors(read(unbalanced, with_discs("arm")))}


@pytest.mark.parametrize(("cell", "found"), [("e", (1,)), ("e + q3/50", ())])
def test_a_spring_that_follows_another_motor_is_not_coaxial(cell: str, found: tuple[int, ...]) -> None:
    text = f"""joints = [
  {{ name = "drive", kind = "motor", sigma = 0, theta = "q1" }},
  {{ name = "gear", kind = "elastic", sigma = 0, theta = "{cell}", variable = "e" }},
  {{ name = "other", antecedent = 0, kind = "motor", sigma = 1, r = "q3" }},
]
[bodies]
drive = {DISC}
[springs]
gear = {{ stiffness = 100 }}
"""
    assert rotors(toml.read(text, "arm.toml")) == found


def test_rotor_inertia_behind_a_ratio_counts_with_its_square() -> None:
    arm = read().joint(3)
    assert arm.reflected_inertia.value({"N1": 100}) == pytest.approx(5.0, rel=1e-15)
    named = with_named_cells(read())
    assert named.joint(3).rotor_inertia.text == "arm.rotor_inertia"
    assert named.joint(3).reflected_inertia.value({"N1": 10, "arm.rotor_inertia": 3}) == 300
    heavier = with_values(read(), {"arm.rotor_inertia": 0.5})
    assert heavier.joint(3).reflected_inertia.value({"N1": 100}) == 5000


def test_the_full_model_of_a_rotor_takes_the_ratio_of_the_file_once() -> None:
    machine = read(('ratio = "N1"', "ratio = 100"))
    full = with_ratios(machine, {"arm": 100.0})
    assert full.joint(3).ratio.is_zero
    body = full.joint(3).body.inertia[5].value()
    assert full.joint(3).rotor_inertia.value() + body == pytest.approx(5.0, rel=1e-15)
    assert body == pytest.approx(5.0 / 100, rel=1e-15)
    for ratio in ("N1", "80"):
        with pytest.raises(InputError, match=f"--ratio: arm: the file gives ratio = {ratio}: remove one of the two"):
            with_ratios(read(('ratio = "N1"', f'ratio = "{ratio}"')), {"arm": 100.0})


def test_the_rigid_limit_of_an_elastic_gear_is_a_gear() -> None:
    crank = rigid(read(("crank = { stiffness", "crank = { neutral = 0.01, stiffness"))).joint(5)
    assert crank.kind is Kind.COUPLED
    assert crank.theta.value({"N1": 100, "qm": 1.0}) == pytest.approx(0.02)


def test_a_spring_that_follows_from_a_loop_has_no_rigid_limit() -> None:
    machine = read(('"q3", "rod"', '"q3", "crank"'))
    with pytest.raises(InputError, match="scene, locked, crank: its variable follows from loop ring"):
        rigid(machine)


def test_folded_parameters_are_constants_of_loops_too() -> None:
    folded = with_constants(read(), ("N1", "L3"))
    assert folded.loops[0].start["qm"].value() == 250
    assert folded.joint(2).theta.text == "(100)*q1" and folded.joint(10).r.text == "(0.2)*sin(q3)"
    assert check(folded) == []


def test_freed_cells_keep_the_couplings() -> None:
    machine = with_free_numbers(read(('ratio = "N1"', "ratio = 100")), SECTIONS)
    values = {p.name: p.value.value() for p in machine.parameters if p.value}
    assert (values["IA3"], values["ratio3"]) == (5e-4, 100.0)
    assert machine.joint(5).spring.stiffness == read().joint(5).spring.stiffness
    assert machine.joint(3).reflected_inertia.value({"IA3": 2, "ratio3": 3}) == 18
    assert check(machine) == []


def test_a_label_is_not_that_of_the_inertia_of_a_rotor_behind_a_ratio() -> None:
    named = (("rotor_inertia = 5e-4", 'rotor_inertia = "IA3"'), ("L2 = 0.7", "L2 = 0.7\nIA3 = nan"))
    assert ParameterLabels(read(*named))(3, "IA") == "IA_3"
    assert ParameterLabels(read(*named, (', ratio = "N1"', "")))(3, "IA") == "IA3"


@pytest.mark.parametrize(
    ("heavy", "idle"),
    [
        ("forearm", []),  # carried by the arm; the drive moves it through crank and loop
        ("rotor", ["joint 3 (arm)", "joint 6 (drive)"]),  # follows the waist
        ("jaw", []),  # carried by the forearm
        ("rod", []),  # the arm moves it through the loop
    ],
)
def test_motors_move_what_follows_them_and_their_loops(heavy: str, idle: list[str]) -> None:
    found = check(read(("forearm = { mass", f"{heavy} = {{ mass")))
    assert found == [f"{place}: no body beyond this motor has mass or inertia" for place in idle]


def test_loops_on_a_floating_base_keep_their_rows() -> None:
    machine = with_base_coordinates(replace(read(), floating=Floating()))
    (loop,) = machine.loops
    assert (machine.joint(loop.cut).name, machine.joint(loop.meets).name) == ("pin", "pin_end")
    assert [machine.joint(j).name for j in machine.around(loop)] == ["arm", "forearm", "crank", "rod"]


def test_a_position_of_a_named_length_is_locked() -> None:
    """A parameter of a cell has a dot in its name, which no formula is read with."""
    from symoro_elastic.machine.restrict import restrict
    from symoro_elastic.machine.scene import Scene

    slides = (('kind = "coupled", sigma = 1, r = "L3*sin(q3)"', 'kind = "motor", sigma = 1, r = "q9 + 0.4"'),)
    named = with_named_cells(read(*slides))
    still = restrict(named, Scene(locked={"jaw": Formula.parse(0.1)}))
    assert still.joint(10).r.value({"jaw.r": 0.4}) == 0.5
