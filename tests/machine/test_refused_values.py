"""Values that a file may not have are refused from every other side, too: `--value`, `values=`, sweeps, Python."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import symoro_elastic as se
from symoro_elastic.analysis.sweeps.quantities import impossible, quantities
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.columns import Cell, cells, with_cells
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.drives import Average, Drive, Drives, LowPass
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine, Parameter
from symoro_elastic.machine.named_cells import with_values
from symoro_elastic.numerics.motion.equations_of_motion import motion_of

ALL_KEYS = Path(__file__).resolve().parents[2] / "examples" / "all_keys.toml"
TRIED = (-1.0, 0.0, 1e-9, 0.95, 1.0, 1e200)
PROBE = "probe"


def probed() -> Iterator[tuple[str, Machine, float]]:
    """The machine with all keys, one number of its table at a time in a parameter, with that number."""
    whole = se.read(ALL_KEYS)
    for k, joint in enumerate(whole.joints):
        for wanted, formula in cells(joint):
            if formula.names or formula.is_zero:
                continue

            def named(cell: Cell, formula: Formula, wanted: Cell = wanted) -> Formula:
                return Formula(PROBE, ("name", PROBE)) if cell == wanted else formula

            joints = tuple(with_cells(one, named) if i == k else one for i, one in enumerate(whole.joints))
            parameters = (*whole.parameters, Parameter(PROBE, formula))
            yield f"{joint.name}.{wanted.name}", replace(whole, joints=joints, parameters=parameters), formula.value()


def refuses(machine: Machine, x: float) -> bool:
    """Whether the reader refuses the machine with this value of the parameter."""
    try:
        check(replace(machine, parameters=(*machine.parameters[:-1], Parameter(PROBE, Formula.parse(x)))))
    except InputError:
        return True
    return False


def test_what_a_file_refuses_is_refused_as_a_value() -> None:
    """Each number of the table with all keys as a parameter, at six values: the reader and `with_values` agree."""
    refused = 0
    for name, machine, own in probed():
        assert not refuses(machine, own), name
        for x in TRIED:
            if not refuses(machine, x):
                with_values(machine, {PROBE: x})
                continue
            refused += 1
            with pytest.raises(InputError):
                with_values(machine, {PROBE: x})
    assert refused > 60


CARRIAGE = {
    "name": "carriage",
    "joints": [
        {"name": "drive", "antecedent": 0, "kind": "motor", "sigma": 1, "r": "q1"},
        {"name": "load", "antecedent": "drive", "kind": "elastic", "sigma": 1, "r": "q2"},
    ],
    "bodies": {"drive": {"mass": 2}, "load": {"mass": 1}},
}


@pytest.mark.parametrize(
    ("sections", "good", "bad", "what"),
    [
        ({"friction": {"load": {"coulomb": 2, "creep": "p"}}}, 1e-3, 0.0, "is 0.*: leave it out"),
        ({"friction": {"load": {"coulomb": 2, "creep": 1e-3, "load": "p"}}}, 0.1, 0.95, "it must be below 0.9"),
        ({"friction": {"load": {"coulomb": "p", "bristle": 1e5, "bristle_damping": 30}}}, 2.0, 0.0, "give coulomb"),
        ({"friction": {"load": {"coulomb": 2, "static": 3, "stribeck": "p"}}}, 0.1, 0.0, "leave out static, too"),
    ],
)
def test_laws_are_refused_where_a_value_ends_them(
    sections: dict[str, object], good: float, bad: float, what: str
) -> None:
    """In the file, as a value of equations of motion, and at a point of a sweep."""
    table = {**CARRIAGE, **sections, "springs": {"load": {"stiffness": 1e4}}}
    with pytest.raises(InputError, match=what):
        se.read({**table, "parameters": {"p": bad}})
    machine = se.read({**table, "parameters": {"p": good}})
    with pytest.raises(InputError, match=what):
        motion_of(machine, {"p": bad}).at([0.0, 0.0])
    with pytest.raises(InputError, match=what):
        se.modes(machine, hold=["drive"], values={"p": bad})
    found = se.sweep(machine, over={"p": [bad, good]}, of="modes", hold=["drive"])
    assert found.reasons[0] and not found.reasons[1]


def test_a_sweep_asks_the_law_of_each_cell() -> None:
    """A creep velocity of 0, and the negative mass of a floating base, whose body is that of no joint."""
    table = {**CARRIAGE, "friction": {"load": {"coulomb": 2, "creep": "p"}}, "parameters": {"p": 1e-3, "m": 5}}
    base = {"floating": "rotation", "body": {"mass": "m"}}
    machine = se.read({**table, "springs": {"load": {"stiffness": 1e4}}, "base": base})
    assert "leave it out" in impossible(quantities(machine, ["p"]), [0.0])
    assert impossible(quantities(machine, ["m"]), [-1.0]) == "m is negative: -1"


ONE = Formula.parse(1)


def driven(**parameters: float) -> dict[str, Any]:
    """A motor and a spring, whose numbers are parameters."""
    names = {"vs": 1e-4, "mu": 0.1, "e": 1e-5, "N": 6.0, "Kp": 5.0} | parameters
    return {
        "name": "free_numbers",
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
        se.control(driven(**{name: WRONG[name]}))
    with pytest.raises(InputError):
        se.control(driven(), values={name: WRONG[name]})


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
    whole = DescribedMachine.of(se.read(driven()))
    drive = replace(Drive(ONE, ONE), **changes)
    with pytest.raises(InputError, match=f"drives, motor, {place}: "):
        se.control(replace(whole, drives=Drives({"motor": drive})))
