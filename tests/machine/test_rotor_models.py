"""A rotor behind a gear in three forms: an inertia with a ratio, the full model of it, and a coupled body."""

from __future__ import annotations

import numpy as np
import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.reduced import reduced_model, with_ratios
from symoro_elastic.numerics.verification.implementations import numpy_model

ARM = """
gravity = [0, 0, -9.81]
joints = [
  {{ name = "waist", kind = "motor", sigma = 0, theta = "q1" }},
  {{ name = "arm", antecedent = "waist", kind = "motor", sigma = 0, alpha = "pi/3", d = 0.2, theta = "q2" }},
  {{ name = "hand", antecedent = "arm", kind = "passive", sigma = 0, alpha = 1.1, d = 0.7, theta = "q3" }},
{rotor}]
[bodies]
waist = {{ mass = 9, center_of_mass = [0, 0.1, 0.2], inertia = [0.3, 0.3, 0.2] }}
arm = {{ mass = 5, center_of_mass = [0.3, 0, 0.1], inertia = [0.02, 0.3, 0.3] }}
hand = {{ mass = 2, center_of_mass = [0.1, 0.1, 0], inertia = [0.01, 0.02, 0.02] }}
{body}
[motors]
{motor}
"""
ROTOR = """
  { name = "rotor", antecedent = "waist", kind = "coupled", sigma = 0, alpha = "pi/3", d = 0.2, theta = "50*q2" },
"""


def by_ratio() -> Machine:
    return toml.read(ARM.format(rotor="", body="", motor="arm = { rotor_inertia = 2e-3, ratio = 50 }"), "arm.toml")


def by_body() -> Machine:
    body = "rotor = { mass = 0, center_of_mass = [0, 0, 0], inertia = [0, 0, 2e-3] }"
    return toml.read(ARM.format(rotor=ROTOR, body=body, motor=""), "arm.toml")


def inertia_and_bias(machine: Machine) -> tuple[Array, Array]:
    code = numpy_model(machine, ("inertia_matrix", "bias_forces"))
    q, qd = np.array([0.3, -0.8, 1.2]), np.array([0.5, -1.3, 0.9])
    return code.inertia_matrix(q), code.bias_forces(q, qd)


@pytest.mark.parametrize(
    ("one", "other"),
    [(with_ratios(by_ratio(), {"arm": 50.0}), by_body()), (by_ratio(), reduced_model(by_body()))],
    ids=["full", "reduced"],
)
def test_they_agree(one: Machine, other: Machine) -> None:
    for first, second in zip(inertia_and_bias(one), inertia_and_bias(other), strict=True):
        np.testing.assert_allclose(first, second, rtol=1e-12, atol=1e-13)


def test_the_reduced_model_leaves_the_gyroscopic_part_out() -> None:
    (full, _), (less, _) = inertia_and_bias(by_body()), inertia_and_bias(by_ratio())
    assert full[1, 1] == pytest.approx(less[1, 1], rel=1e-13)
    assert full[0, 1] - less[0, 1] == pytest.approx(50 * 2e-3 * np.cos(np.pi / 3), rel=1e-12)


def test_a_rotor_inertia_on_a_coupled_joint_turns_with_that_joint() -> None:
    """As a ratio on the joint that it follows; beside a body both count."""
    motor = "rotor = { rotor_inertia = 2e-3 }"
    alone = toml.read(ARM.format(rotor=ROTOR, body="", motor=motor), "arm.toml")
    for first, second in zip(inertia_and_bias(alone), inertia_and_bias(by_ratio()), strict=True):
        np.testing.assert_allclose(first, second, rtol=1e-12, atol=1e-13)
    body = "rotor = { mass = 0, center_of_mass = [0, 0, 0], inertia = [0, 0, 2e-3] }"
    both = toml.read(ARM.format(rotor=ROTOR, body=body, motor=motor), "arm.toml")
    assert inertia_and_bias(both)[0][1, 1] - inertia_and_bias(by_body())[0][1, 1] == pytest.approx(50**2 * 2e-3)
