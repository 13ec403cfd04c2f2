"""What a file may not give is refused from Python and by values of parameters, too."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import symoro_elastic as se
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.drives import Average, Drive, Drives, LowPass
from symoro_elastic.machine.formula import Formula

ONE = Formula.parse(1)


def machine(**parameters: float) -> dict[str, Any]:
    """A motor and a spring, whose numbers are parameters."""
    names = {"vs": 1e-4, "mu": 0.1, "e": 1e-5, "N": 6.0, "Kp": 5.0} | parameters
    return {
        "name": "numbers",
        "parameters": names,
        "joints": [
            {"name": "motor", "kind": "motor", "sigma": 0, "theta": "q1"},
            {"name": "gear", "antecedent": "motor", "kind": "elastic", "sigma": 0, "theta": "q2"},
        ],
        "bodies": {"gear": {"inertia_at_origin": [0, 0, 0.05]}},
        "motors": {"motor": {"rotor_inertia": 0.02, "cogging": 0.01, "cogging_order": "N"}},
        "friction": {"motor": {"coulomb": 1.0, "creep": "vs", "load": "mu", "viscous": 0.1}},
        "springs": {"gear": {"stiffness": 1000.0, "damping": 0.1, "backlash": 1e-3, "rounding": "e"}},
        "drives": {"motor": {"Kv": 5, "Kp": "Kp", "current": {"lag": 1e-3}}},
    }


WRONG = {"vs": 0.0, "mu": 0.95, "e": 1e-9, "N": 0.0, "Kp": -1.0}


@pytest.mark.parametrize("name", [*WRONG])
def test_values_are_refused_as_numbers_of_a_file_are(name: str) -> None:
    with pytest.raises(InputError):
        se.control(machine(**{name: WRONG[name]}))
    with pytest.raises(InputError):
        se.control(machine(), values={name: WRONG[name]})


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"windup": ONE}, "limits, windup"),
        ({"windup": ONE, "torque_limit": ONE}, "limits, windup"),
        ({"set_point": Average(ONE)}, "set_point, average"),
        ({"set_point": LowPass(ONE, 3)}, "set_point, order"),
        ({"filters": (LowPass(ONE, 0),)}, "filter 1, order"),
        ({"voltage_limit": ONE}, "limits, voltage"),
        ({"torque_forward": True, "acceleration_forward": ONE}, "feed_forward, acceleration"),
        ({"period": Formula.parse(0)}, "period"),
    ],
)
def test_drives_made_in_python_are_refused_as_those_of_a_file(changes: dict[str, Any], place: str) -> None:
    whole = DescribedMachine.of(se.read(machine()))
    drive = replace(Drive(ONE, ONE), **changes)
    with pytest.raises(InputError, match=f"drives, motor, {place}: "):
        se.control(replace(whole, drives=Drives({"motor": drive})))
