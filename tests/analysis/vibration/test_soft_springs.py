"""Springs that their load bends further than they bend back cannot be static."""

from __future__ import annotations

from pathlib import Path

import pytest

from symoro_elastic.analysis.simulation.reference_motion import reference_of
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.prescribed_motion import PrescribedMotion
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.motion.equilibrium import refuse_soft_static
from tests.command_line import ended

pytestmark = pytest.mark.sampled(4)

EXAMPLES = Path(__file__).parents[3] / "examples"
MASS, LENGTH, GRAVITY = 1.0, 0.5, 9.81
LIMIT = MASS * GRAVITY * LENGTH
"""Stiffness at which a pendulum upside down begins to fall, N m/rad."""


def pendulum(stiffness: float, upright: bool = True) -> Machine:
    """A body on a spring above its motor, or below it; a second spring carries nothing against gravity."""
    return toml.read(described(stiffness, upright), "pendulum.toml")


def described(stiffness: float | str, upright: bool = True) -> str:
    height = LENGTH if upright else -LENGTH
    return f"""
        name = "pendulum"
        gravity = [0, 0, -{GRAVITY}]
        joints = [
          {{ name = "slide", kind = "motor", sigma = 1, r = "x1" }},
          {{ name = "lean", kind = "elastic", sigma = 0, alpha = "pi/2", theta = "q2" }},
          {{ name = "probe", kind = "elastic", sigma = 1, r = "z3" }},
        ]
        [bodies]
        slide = {{ mass = 2 }}
        lean = {{ mass = {MASS}, center_of_mass = [0, {height}, 0], inertia = [0.01, 0.01, 0.01] }}
        probe = {{ mass = 0.1 }}
        [springs]
        lean = {{ stiffness = {stiffness} }}
        probe = {{ stiffness = 1e4 }}
        """


def with_static(machine: Machine, *names: str) -> Machine:
    return restrict(machine, Scene(static=dict.fromkeys(names)))


@pytest.mark.parametrize("part", [0.2, 0.99])
def test_a_pendulum_that_falls_is_refused(part: float) -> None:
    with pytest.raises(InputError) as caught:
        refuse_soft_static(with_static(pendulum(part * LIMIT), "probe", "lean"), {})
    said = str(caught.value)
    assert said.startswith("pendulum.toml: scene, static, lean: gravity or a load is stronger than its spring")
    assert "\n" not in said


def test_stiff_and_hanging_ones_are_not() -> None:
    refuse_soft_static(with_static(pendulum(1.01 * LIMIT), "probe", "lean"), {"slide": 0.3})
    refuse_soft_static(with_static(pendulum(0.2 * LIMIT, upright=False), "lean"), {})
    refuse_soft_static(with_static(pendulum(0.2 * LIMIT), "probe"), {})
    refuse_soft_static(pendulum(0.2 * LIMIT), {})


def test_springs_of_the_two_axis_machine_are_stiff_enough() -> None:
    machine, _ = read_machine(EXAMPLES / "two_axis.toml")
    names = [machine.joint(j).name for j in machine.elastic]
    refuse_soft_static(with_static(machine, *names), {"motor_x": 0.3, "motor_y": 0.1})


def test_no_motion_is_simulated_with_them() -> None:
    """`simulate` and `ladder` begin with the reference motion."""
    reference_of(with_static(pendulum(1.01 * LIMIT), "lean"), PrescribedMotion(1.0))
    with pytest.raises(InputError, match="scene, static, lean"):
        reference_of(with_static(pendulum(0.99 * LIMIT), "lean"), PrescribedMotion(1.0))


@pytest.mark.sampled(5)
@pytest.mark.parametrize(("stiffness", "warned"), [(0.99 * LIMIT, True), (1.01 * LIMIT, False), ('"k"', False)])
def test_generate_warns_of_them(stiffness: float | str, warned: bool, tmp_path: Path) -> None:
    """Where the stiffness has no value there is nothing to warn of."""
    scene = '[scene]\nstatic = ["lean"]\n' + "[parameters]\nk = nan\n" * isinstance(stiffness, str)
    (tmp_path / "p.toml").write_text(described(stiffness) + scene, encoding="utf-8")
    done = ended("generate", tmp_path / "p.toml", "--out", tmp_path / "generated")
    assert done.code == 0
    lines = [line for line in done.err.splitlines() if "stronger than its spring" in line]
    assert len(lines) == warned
    assert all(line.startswith(f"warning: {tmp_path / 'p.toml'}: scene, static, lean: ") for line in lines)
