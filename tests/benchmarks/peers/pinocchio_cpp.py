"""Pinocchio in C++: its shipped headers, compiled here for this processor."""

from __future__ import annotations

import ctypes
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from symoro_elastic.machine.machine import Kind, Machine
from tests.benchmarks.contest import BUILD, CXX_COMPILERS, MARCH, Array, Contestant, compiled, entry, keeping_results
from tests.benchmarks.peers.headers import eigen, shipped
from tests.references.pinocchio_model import model_of

HERE = Path(__file__).parent
LIMITS = (
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
)
"""What Pinocchio's own build configuration defines for those that include it."""
ALGORITHMS = {
    "inverse_dynamics": ("inverse", "rnea"),
    "direct_dynamics": ("direct", "aba"),
    "inertia_matrix": ("inertia_matrix", "crba"),
    "inverse_dynamics_derivatives": ("inverse_derivatives", "computeRNEADerivatives"),
    "direct_dynamics_derivatives": ("direct_derivatives", "computeABADerivatives"),
}


def headers() -> list[str]:
    """Options of the compiler that find Pinocchio, boost and Eigen."""
    return ["-std=c++17", *LIMITS, f"-isystem{shipped()}", f"-isystem{eigen()}"]


def sources(name: str) -> dict[str, str]:
    return {file: (HERE / file).read_text(encoding="utf-8") for file in (name, "pinocchio_model.hpp")}


@cache
def library(compiler: str, name: str) -> ctypes.CDLL:
    """Compiled with -O3 and `MARCH`, templates instantiated here: no slower than the shipped library."""
    command = [compiler, "-O3", MARCH, "-DNDEBUG", "-fPIC", "-shared", *headers()]
    return ctypes.CDLL(str(compiled(command, sources(name))))


def contestants(model_file: Path, model: str, x: Array, results: int) -> list[Contestant]:
    """One of `ALGORITHMS` on the states of `x` (q, qd and the third argument of each), by each compiler."""
    function, name = ALGORITHMS[model]
    builds = []
    for compiler in CXX_COMPILERS:
        made = library(compiler, "pinocchio_double.cpp")
        made.read_model(str(model_file).encode())
        builds.append(keeping_results(f"Pinocchio {name}, {compiler}", entry(made, function), x, results))
    return builds


def model_file(machine: Machine) -> Path:
    """A machine, written for the C++ programs."""
    BUILD.mkdir(parents=True, exist_ok=True)
    file = BUILD / f"{machine.name}.txt"
    file.write_text(model_text(machine), encoding="utf-8")
    return file


def model_text(machine: Machine) -> str:
    """A machine as the C++ programs read it: gravity, then a line a joint. Angles are exact quarter turns."""
    model, order, numbers = model_of(machine)
    assert order == sorted(order), "joints are in depth-first order"
    lines = [_line(len(order), *model.gravity.linear)]
    for k, j in enumerate(numbers.moving):
        row, joint = numbers.joints[j], k + 1
        place, inertia = model.jointPlacements[joint], model.inertias[joint]
        rotation = np.round(place.rotation, 15) + 0.0
        lines.append(
            _line(
                model.parents[joint],
                row.sigma,
                *rotation.ravel(),
                *(np.round(place.translation, 15) + 0.0),
                inertia.mass,
                *inertia.lever,
                *inertia.inertia.ravel(),
                *(row.rotor_inertia, row.stiffness, row.damping, row.neutral),
                int(row.kind is Kind.MOTOR),
            )
        )
    return "\n".join(lines) + "\n"


def _line(*numbers: Any) -> str:
    return " ".join(repr(float(x)) if isinstance(x, float) else str(int(x)) for x in numbers)
