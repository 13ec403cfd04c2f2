"""The table of a machine as `show` prints it."""

from __future__ import annotations

import pytest

from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Joint, Kind, Machine
from symoro_elastic.machine.views import machine_table


@pytest.mark.parametrize(
    ("offset", "shown"),
    [("0", "q"), ("a", "q + a"), ("-a", "q - a"), ("- a + b", "q - a + b"), ("-Pi/2", "q - pi/2"), ("-(a)", "q - (a)")],
)
def test_offsets_are_written_with_their_sign(offset: str, shown: str) -> None:
    for sigma, key in ((0, "theta"), (1, "r")):
        joint = Joint("one", 0, Kind.MOTOR, sigma, "q", **{key: Formula.parse(offset), "alpha": Formula.parse("Pi/2")})
        cells = {head: list(cells) for head, cells in machine_table(Machine("m", (joint,))).columns}
        assert cells[key] == [shown] and cells["alpha"] == ["pi/2"]


def test_motors_are_shown_as_the_joint_feels_them() -> None:
    ratio, rotor = Formula.parse("N"), Formula.parse("2e-4")
    joint = Joint("one", 0, Kind.MOTOR, 1, "q", rotor_inertia=rotor, ratio=ratio)
    assert dict(machine_table(Machine("m", (joint,)), with_units=True).columns)["joint"] == ("Ia = N^2*2e-4 kg",)
