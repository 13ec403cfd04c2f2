"""Springs that their load bends further than they bend back cannot be static."""

from __future__ import annotations

from pathlib import Path

import pytest

from symoro_elastic.errors import InputError
from symoro_elastic.machine.formats import read_machine, toml
from symoro_elastic.machine.machine import Machine
from symoro_elastic.vibration.soft_springs import refuse_soft_static

EXAMPLES = Path(__file__).parents[2] / "examples"
MASS, LENGTH, GRAVITY = 1.0, 0.5, 9.81
LIMIT = MASS * GRAVITY * LENGTH
"""Stiffness at which a pendulum upside down begins to fall, N m/rad."""


def pendulum(stiffness: float, upright: bool = True) -> Machine:
    """A body on a spring above its motor, or below it; a second spring carries nothing against gravity."""
    height = LENGTH if upright else -LENGTH
    return toml.read(
        f"""
        name = "pendulum"
        gravity = [0, 0, -{GRAVITY}]
        joints = [
          {{ name = "slide", kind = "motor", sigma = 1, r = "x" }},
          {{ name = "lean", kind = "elastic", sigma = 0, alpha = "pi/2", theta = "q" }},
          {{ name = "probe", kind = "elastic", sigma = 1, r = "z" }},
        ]
        [bodies]
        slide = {{ mass = 2 }}
        lean = {{ mass = {MASS}, center_of_mass = [0, {height}, 0], inertia = [0.01, 0.01, 0.01] }}
        probe = {{ mass = 0.1 }}
        [springs]
        lean = {{ stiffness = {stiffness} }}
        probe = {{ stiffness = 1e4 }}
        """,
        "pendulum.toml",
    )


@pytest.mark.parametrize("part", [0.2, 0.99])
def test_a_pendulum_that_falls_is_refused(part: float) -> None:
    with pytest.raises(InputError) as caught:
        refuse_soft_static(pendulum(part * LIMIT), ["probe", "lean"], {})
    said = str(caught.value)
    assert said.startswith("pendulum.toml: scene, static, lean: gravity or a load is stronger than its spring")
    assert "\n" not in said


def test_stiff_and_hanging_ones_are_not() -> None:
    refuse_soft_static(pendulum(1.01 * LIMIT), ["probe", "lean"], {"slide": 0.3})
    refuse_soft_static(pendulum(0.2 * LIMIT, upright=False), ["lean"], {})
    refuse_soft_static(pendulum(0.2 * LIMIT), ["probe"], {})
    refuse_soft_static(pendulum(0.2 * LIMIT), [], {})


def test_springs_of_the_two_axis_machine_are_stiff_enough() -> None:
    machine, _ = read_machine(EXAMPLES / "two_axis.toml")
    names = [machine.joint(j).name for j in machine.elastic]
    refuse_soft_static(machine, names, {"motor_x": 0.3, "motor_y": 0.1})
