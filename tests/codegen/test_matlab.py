"""The target matlab: its functions and MEX in GNU Octave, all calls in one process."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symoro_elastic.codegen.matlab import KEYWORDS
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.targets import TARGETS
from symoro_elastic.codegen.targets.matlab import render_matlab
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.machine.formats import read_machine
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.numerics.implementations import import_package
from symoro_elastic.packaging import reserved_words
from symoro_elastic.traced import traced
from tests.closed_chains.machines import without_closed_form
from tests.models.test_creep import creeping
from tests.codegen.test_local_names import arm
from tests.octave import Answer, Call, calls_of, needs_mkoctfile, needs_octave, octave, ulps, written

ROOT = Path(__file__).parents[2]
STATES = 3
LONG = "a" * 61
VARIABLES = ("end", "function", "i", f"{LONG}_1", f"{LONG}_2")
PARAMETERS = (
    *("j", "e", "persistent", "otherwise", "parfor", "until", "endif", "ans", "eps", "arguments", "p", "states"),
    *("checked", "zeros", "reshape", "real_sqrt", "nargin", f"{LONG}_3", f"{LONG}_4", "constants", "parameters"),
)
"""Names that MATLAB, GNU Octave or the templates use, and names of 63 characters."""


@cache
def hostile() -> Machine:
    return replace(arm(VARIABLES, PARAMETERS), name="end")


def example(name: str) -> Machine:
    return read_machine(ROOT / "examples" / name)[0]


CASES: dict[str, tuple[Any, Scene]] = {
    "hostile names": (hostile, Scene(models=("direct_dynamics", "inertia_matrix", "geometric_model"))),
    "time steps": (lambda: example("planar_2r.toml"), Scene(models=("geometric_model", "inverse_position_model"), steps=("w3",))),
    "loops": (lambda: creeping(without_closed_form()), Scene(models=("direct_dynamics", "assemble"), steps=("rk4",))),
    "floating base": (lambda: example("floating_arm.toml"), Scene(models=("velocities",), steps=("rk4",))),
}


@dataclass(frozen=True)
class Case:
    """Calls of a machine, `.m` and MEX, and the results of numpy."""

    package: Package
    module: Any
    own: list[Call]
    mex: list[Call]
    wanted: list[list[Any]]


@cache
def cases() -> dict[str, Case]:
    return {name: case(make(), scene) for name, (make, scene) in CASES.items()}


def case(machine: Machine, scene: Scene) -> Case:
    found = traced(machine, scene)
    module = import_package(render_numpy(found.package), Path(tempfile.mkdtemp()))
    return Case(found.package, module, *calls_of(found.package, found.machine, module, STATES))
