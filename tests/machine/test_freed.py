"""Numbers of the table that stay parameters of generated code."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.machine.constants import SECTIONS, with_free_numbers
from symoro_elastic.machine.machine import Parameter
from symoro_elastic.numerics.verification.implementations import numpy_model
from tests.analysis.vibration.machines import drive
from tests.command_line import EXAMPLES, refused, run
from tests.compiled_models import cell
from tests.references.random_machines import random_machine


def test_names_are_those_of_the_columns() -> None:
    machine = with_free_numbers(drive(k=2e4, d=3.0), ("springs", "bodies"))
    assert {p.name: (p.value.value() if p.value else None, p.unit) for p in machine.parameters} == {
        "M1": (3.0, "kg"), "M2": (5.0, "kg"), "k2": (2e4, "N/m"), "d2": (3.0, "N s/m"),
    }  # fmt: skip
    assert machine.joints[1].spring.neutral.is_zero, "zeros are structure"
    assert [p.name for p in with_free_numbers(drive(), ("springs",)).parameters] == ["k2"]


def test_names_that_are_used_get_another() -> None:
    machine = replace(drive(), name="M1", parameters=(Parameter("k2", cell(1)),))
    assert [p.name for p in with_free_numbers(machine, SECTIONS, reserved={"M2": "a reason"}).parameters] == [
        "k2",
        "free_M1",
        "free_M2",
        "free_k2",
    ]


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(4))
def test_results_stay_and_follow_the_parameters(seed: int) -> None:
    """Values of the table are the defaults; another mass by p is another mass in the table."""
    machine = random_machine(seed, joints=4, symbolic=False)
    free = with_free_numbers(machine, SECTIONS)
    fixed, code = numpy_model(machine), numpy_model(free)
    n, m = len(machine.independent), len(machine.motors)
    rng = np.random.default_rng(seed)
    state = [rng.normal(size=k) for k in (n, n, m)]
    np.testing.assert_allclose(code.direct_dynamics(*state), fixed.direct_dynamics(*state), rtol=1e-9)
    heavier = replace(machine.joints[3], body=replace(machine.joints[3].body, mass=cell(77)))
    other = numpy_model(replace(machine, joints=(*machine.joints[:3], heavier)))
    found = code.direct_dynamics(*state, code.parameters(M4=77.0))
    np.testing.assert_allclose(found, other.direct_dynamics(*state), rtol=1e-9)


def test_the_command(tmp_path: Path) -> None:
    asked = ("generate", EXAMPLES / "two_axis.toml", "--out", tmp_path, "--free", "springs,bodies")
    run(*asked, "--target", "numpy")
    assert "k1" in (tmp_path / "two_axis" / "__init__.py").read_text()
    assert "--free: unknown 'spring': choose from bodies, springs" in refused(*asked[:-1], "spring")
