"""Machines that are made into FMUs in tests: an elastic arm under wrenches, and linkages."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from unittest import mock

import symoro_elastic as se
from symoro_elastic.generation.fmu import Options
from symoro_elastic.generation.fmu.mock_up_unit import MockUpUnit, unit_of
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from tests.closed_chains.machines import machine as closed_chain
from tests.closed_chains.machines import without_closed_form

EXAMPLES = Path(__file__).parents[3] / "examples"
UNDER_A_WRENCH = Scene(forces=("tool",), outputs={"geometric_model": ("tool at (0.1, 0, L)", "arm")})


@cache
def elastic_arm() -> Machine:
    """A drive, a spring in turn with it, a spring along the arm with an offset, a tool."""
    joints = [
        {"name": "drive", "antecedent": 0, "kind": "motor", "sigma": 0, "theta": "q1"},
        {"name": "arm", "antecedent": "drive", "kind": "elastic", "sigma": 0, "theta": "q2"},
        {"name": "rod", "antecedent": "arm", "kind": "elastic", "sigma": 1, "alpha": "pi/2", "d": "L", "r": "q3"},
        {"name": "tool", "antecedent": "rod", "kind": "fixed", "sigma": 2, "d": 0.1, "r": 0.2},
    ]
    bodies = {
        "arm": {"mass": 4, "center_of_mass": [0.3, 0.02, 0], "inertia": [0.02, 0.2, 0.2]},
        "rod": {"mass": 1.5, "center_of_mass": [0.05, 0, 0.1], "inertia": [0.01, 0.01, 0.003]},
    }
    springs = {
        "arm": {"stiffness": 2000, "damping": 0.5},
        "rod": {"stiffness": 5e4, "damping": 3, "neutral": 0.02},
    }  # fmt: skip
    return se.read(
        {
            "name": "elastic_arm",
            "gravity": [0, -9.81, 0],
            "joints": joints,
            "parameters": {"L": {"value": 0.6, "unit": "m"}},
            "bodies": bodies,
            "springs": springs,
            "motors": {"drive": {"rotor_inertia": 0.5}},
            "friction": {"drive": {"viscous": 0.2}},
        }
    )


@cache
def four_bar() -> Machine:
    """A linkage with a closed form, and a spring on its coupler."""
    return closed_chain("four_bar")


@cache
def assembled() -> Machine:
    """A linkage whose positions have no closed form, its friction smooth."""
    described = without_closed_form()
    joints = (replace(one, friction=replace(one.friction, creep=Formula.parse(0.01))) for one in described.joints)
    return replace(described, joints=tuple(joints))


@cache
@cache
def two_r() -> Machine:
    return se.read(EXAMPLES / "planar_2r.toml")


@cache
def ball_screw() -> Machine:
    return se.read(EXAMPLES / "ball_screw.toml")


CASES: dict[str, tuple[Callable[[], Machine], Scene]] = {
    "tree": (two_r, Scene()),
    "springs": (elastic_arm, UNDER_A_WRENCH),
    "couplings": (ball_screw, Scene()),
    "loop": (four_bar, Scene()),
    "without parameters": (elastic_arm, Scene(fold=ALL)),
}
"""Machines and scenes by what is special about them."""


@cache
def unit(case: str, version: int) -> MockUpUnit:
    """An FMU of a case, compiled where there is a compiler."""
    machine, scene = CASES[case]
    return unit_of(machine(), scene, Options(version))


@cache
def sources_of_unit(case: str, version: int) -> MockUpUnit:
    """An FMU of a case without a binary."""
    machine, scene = CASES[case]
    with mock.patch.dict(os.environ, CC="no-compiler-of-this-name"):
        return unit_of(machine(), scene, Options(version))
