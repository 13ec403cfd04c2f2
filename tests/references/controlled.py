"""Machines of the examples whose motors have sampled drives with numbers."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from symoro_elastic.formats import read_machine
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.drives import Average, Drive, Drives, LowPass, Notch
from symoro_elastic.machine.formula import Formula

EXAMPLES = Path(__file__).parents[2] / "examples"
f = Formula.parse


def drive(Kp: float = 3.0, **changes: Any) -> Drive:
    """A drive with all that a controller of code has."""
    usual: dict[str, Any] = {
        "Kv": f(60),
        "Kp": f(Kp),
        "Tn": f(5e-3),
        "lag": f(2e-4),
        "velocity_forward": f(0.9),
        "acceleration_forward": f(8e-3),
        "filters": (Notch(f(1300), f(0.1), f(0.5)), LowPass(f(2500)), LowPass(f(3000), 2)),
        "period": f(1.25e-4),
        "torque_limit": f(15),
        "windup": f(8e-3),
        "set_point": LowPass(f(200), 2),
    }
    return Drive(**(usual | changes))


def controlled(name: str = "ball_screw", **drives: Drive) -> DescribedMachine:
    """An example with these drives, all of `drive` where none is given."""
    machine, _ = read_machine(EXAMPLES / f"{name}.toml")
    known = drives or {joint.name: drive() for joint in machine.motor_joints}
    return replace(machine, drives=Drives(known))


AVERAGED = drive(set_point=Average(f("5e-4")), filters=(), windup=None)
PLAIN = drive(Tn=None, windup=None, torque_limit=None, set_point=None, filters=(), acceleration_forward=f(0))
