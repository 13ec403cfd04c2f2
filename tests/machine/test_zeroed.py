"""Numbers that a scene leaves out: the machine is that of a file in which they are zero."""

from __future__ import annotations

from dataclasses import replace

import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.formats.toml.reading import scene_in
from symoro_elastic.formats.toml.tables import load
from symoro_elastic.formats.toml.writing import write_scene
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.zeroed import numbers_of, with_zeros
from symoro_elastic.models.packaging import summary, trace_models
from tests.command_line import EXAMPLES


def two_axis() -> Machine:
    return read_machine(EXAMPLES / "two_axis.toml")[0]


def test_numbers_are_those_of_bodies_and_rotors_that_are_not_zero() -> None:
    found = numbers_of(two_axis())
    assert {"cart_y.mass", "cart_y.center_of_mass.z", "ram.XX", "motor_y.rotor_inertia"} <= {*found}
    assert "cart_y.center_of_mass.y" not in found and "ram.XY" not in found
    assert not any(name.endswith((".stiffness", ".ratio", ".d")) for name in found)


def test_restricted_it_is_the_machine_of_a_file_with_zeros() -> None:
    machine = two_axis()
    rows = {joint.name: joint for joint in machine.joints}
    cart, motor = rows["cart_y"], rows["motor_y"]
    rows["cart_y"] = replace(cart, body=replace(cart.body, mass=ZERO))
    rows["motor_y"] = replace(motor, rotor_inertia=ZERO)
    names = ("cart_y.mass", "motor_y.rotor_inertia")
    assert restrict(machine, Scene(zero=names)).joints == tuple(rows.values())
    assert with_zeros(machine, ()) is machine


def test_static_springs_lose_numbers_too() -> None:
    kept = restrict(two_axis(), Scene(static={"ram": None}))
    (row,) = with_zeros(kept, ("ram.mass",)).static.values()
    assert row.body.mass.is_zero and not row.body.inertia[0].is_zero


def test_the_reduced_code_says_what_is_left_out() -> None:
    scene = Scene(models=("direct_dynamics",), zero=("ram.XX", "cart_y.center_of_mass.x"), fold="all")
    whole, left = (trace_models(two_axis(), one).package for one in (replace(scene, zero=()), scene))
    assert summary(scene) == "without ram.XX, cart_y.center_of_mass.x"
    assert left.functions[0].program.count != whole.functions[0].program.count


def test_a_scene_is_written_and_read_again() -> None:
    scene = Scene(zero=("cart_y.mass", "ram.center_of_mass.z"))
    text = write_scene(scene)
    assert 'zero = ["cart_y.mass", "ram.center_of_mass.z"]' in text
    assert scene_in(load(text, "s.toml"), two_axis()) == scene


@pytest.mark.parametrize("name", ["cart_y.mas", "nothing.mass", "ram.XY", "ram.stiffness"])
def test_unknown_numbers_are_refused(name: str) -> None:
    with pytest.raises(InputError, match=r"s\.toml: scene, zero: no rigid body, rotor or drive has a number"):
        scene_in(load(f'zero = ["{name}"]', "s.toml"), two_axis())
