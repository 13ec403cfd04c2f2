"""Drives in machine files: read as they stand, written so that they are read back, or refused in one line."""

from __future__ import annotations

import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.formats.toml.writing import write
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine, drives_of
from symoro_elastic.machine.drives import TUNED, Average, Drive, LowPass, Notch
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene

ROWS = """name = "m"
joints = [
  { name = "rail", kind = "motor",   sigma = 1, r = "q1" },
  { name = "gear", kind = "elastic", sigma = 0, theta = "q2" },
  { name = "turn", kind = "motor",   sigma = 0, theta = "q3" },
]
[parameters]
K = 30
[springs]
gear = { stiffness = 1e6 }
[drives]
"""
FULL = """rail = { Kv = "K/2", Kp = "tuned", Tn = "20 ms", current = { lag = 2e-4 }, feed_forward = { velocity = 0.9, \
acceleration = 12 }, filters = [{ notch = 120, depth = 0.05, width = 0.5 }, { lowpass = "0.4 kHz", order = 2 }], \
measured = "gear.q", dead_time = "150 us", period = 1e-4, limits = { torque = "2 kN", windup = "K/1000" }, \
set_point = { average = "2 ms" } }
"""
FILTERED = "turn = { Kv = 20, Kp = 5, limits = { torque = 3 }, set_point = { lowpass = 40, order = 2 } }\n"


def machine(drives: str = FULL) -> DescribedMachine:
    return toml.read(ROWS + drives, "m.toml")


def test_all_keys_are_read() -> None:
    f = Formula.parse
    expected = Drive(
        *(f("K/2"), TUNED, f("0.02"), f("2e-4"), f("0.9"), f("12")),
        filters=(Notch(f("120"), f("0.05"), f("0.5")), LowPass(f("400"), 2)),
        measured="gear.q",
        dead_time=f("0.00015"),
        period=f("1e-4"),
        torque_limit=f("2000"),
        windup=f("K/1000"),
        set_point=Average(f("0.002")),
    )
    found = machine().drives.by_motor["rail"]
    values = {key: x.value({"K": 30.0}) for key, x in found.formulas}
    assert values == {key: x.value({"K": 30.0}) for key, x in expected.formulas}
    assert (found.Kp, found.measured, [type(one) for one in found.filters]) == (TUNED, "gear.q", [Notch, LowPass])


def test_what_is_left_out_has_its_usual_value() -> None:
    found = machine("turn = { Kv = 20, Kp = 5 }").drives.by_motor["turn"]
    assert found == Drive(Formula.parse("20"), Formula.parse("5"))


@pytest.mark.parametrize(
    "drives", [FULL, "turn = { Kv = 20, Kp = 5 }\n", FULL + 'turn = { Kv = 1, Kp = "tuned" }\n', FILTERED]
)
def test_what_is_written_is_read_back(drives: str) -> None:
    one = machine(drives)
    assert toml.read(write(one), "m.toml").drives == one.drives


def test_motors_that_are_gone_have_no_drives() -> None:
    locked = restrict(machine(), Scene(locked={"rail": Formula.parse(0)}))
    assert not drives_of(locked)


@pytest.mark.parametrize(
    ("drives", "place", "what"),
    [
        ("gear = { Kv = 1, Kp = 1 }", "drives, gear", "gear has no motor: motors are rail, turn"),
        ("rial = { Kv = 1, Kp = 1 }", "drives", "no joint 'rial'; did you mean 'rail'?"),
        ("rail = { Kp = 1 }", "drives, rail, Kv", "is missing"),
        ('rail = { kind = "cascade", Kv = 1, Kp = 1 }', "drives, rail, kind", "every drive is one: leave kind out"),
        ('rail = { kind = "torque" }', "drives, rail, kind", "left out of [drives] has its torque tau at once"),
        ('rail = { kind = "voltage" }', "drives, rail, kind", "use current = { kp = 6, ti = 2e-3 }, the winding"),
        ("rail = { kind = 3, Kv = 1, Kp = 1 }", "drives, rail, kind", "'3': is none of cascade, torque, voltage"),
        ("rail = { Kv = 1, Kp = 1, Ki = 1 }", "drives, rail, Ki", "no such key here"),
        ("rail = { Kv = -1, Kp = 1 }", "drives, rail, Kv", "-1 is not above zero"),
        ("rail = { Kv = 1, Kp = 0 }", "drives, rail, Kp", "0 is not above zero"),
        ("rail = { Kv = 1, Kp = 1, dead_time = -1e-4 }", "drives, rail, dead_time", "-0.0001 is negative"),
        ('rail = { Kv = 1, Kp = "L" }', "drives, rail, Kp", "'L' is not declared in [parameters]"),
        ('rail = { Kv = 1, Kp = "5 N m s/rad" }', "drives, rail, Kp", "is in N m s/rad, where N s/m is needed"),
        ("rail = { Kv = 1, Kp = 1, filters = [{ notch = 9 }] }", "drives, rail, filter 1, depth", "is missing"),
        ("rail = { Kv = 1, Kp = 1, filters = [{ order = 1 }] }", "filter 1, notch, lowpass", "give one of them"),
        (
            "rail = { Kv = 1, Kp = 1, filters = [{ lowpass = 9, order = 3 }] }",
            "drives, rail, filter 1, order",
            "3: a low-pass filter is of order 1 or 2",
        ),
        ('rail = { Kv = 1, Kp = 1, limits = { torque = "5 N m" } }', "rail, limits, torque", "where N is needed"),
        ("rail = { Kv = 1, Kp = 1, limits = { torque = 0 } }", "rail, limits, torque", "0 is not above zero"),
        (
            "rail = { Kv = 1, Kp = 1, limits = { torque = 5, windup = 1 } }",
            "drives, rail, limits, windup",
            "it belongs to Tn, which is missing",
        ),
        (
            "rail = { Kv = 1, Kp = 1, Tn = 1, limits = { windup = 1 } }",
            "limits, windup",
            "it belongs to torque, which is missing",
        ),
        ("rail = { Kv = 1, Kp = 1, set_point = { } }", "rail, set_point, lowpass, average", "give one of them"),
        (
            "rail = { Kv = 1, Kp = 1, set_point = { average = 1e-3 } }",
            "drives, rail, set_point, average",
            "is a mean of samples: give the drive a period",
        ),
        ("rail = { Kv = 1, Kp = 1, set_point = { lowpass = 0 } }", "set_point, frequency", "0 is not above zero"),
        ('rail = { Kv = "fast", Kp = 1 }', "drives, rail, Kv", "'fast' is not declared"),
    ],
)
def test_wrong_drives_are_refused(drives: str, place: str, what: str) -> None:
    with pytest.raises(InputError) as error:
        machine(drives)
    assert place in error.value.place and what in str(error.value)
