"""Pinocchio's constraint dynamics in C++: a tree whose points are kept together by multipliers."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from symoro_elastic.machine.machine import Machine
from tests.benchmarks.contest import BUILD, Array, Contestant, compiled, entry, keeping_results
from tests.benchmarks.peers import pinocchio_cpp
from tests.references.pinocchio_model import carried_frame


@dataclass(frozen=True)
class Proximal:
    """How multipliers are found: with `mu` on the diagonal, steps until they change by less than `accuracy`."""

    mu: float
    steps: int
    accuracy: float = 1e-14

    @property
    def name(self) -> str:
        return f"Pinocchio, mu {self.mu:g}, steps <= {self.steps}"


@cache
def library() -> ctypes.CDLL:
    """Compiled as `pinocchio_cpp`, with the same options."""
    command = ["g++", "-O3", "-march=native", "-DNDEBUG", "-fPIC", "-shared", *pinocchio_cpp.headers()]
    found = ctypes.CDLL(str(compiled(command, pinocchio_cpp.sources("pinocchio_loops.cpp"))))
    found.settle.argtypes = [ctypes.c_double, ctypes.c_double, ctypes.c_int]
    return found


def contestant(files: tuple[Path, Path], x: Array, proximal: Proximal) -> Contestant:
    """`constraintDynamics` on the states of `x`: q, qd and forces of all joints; qdd of all joints."""
    library().read_loops(*(str(file).encode() for file in files))
    run = entry(library(), "constrained")

    def settled(*arguments: object) -> float:
        library().settle(proximal.accuracy, proximal.mu, proximal.steps)
        return run(*arguments)

    return keeping_results(proximal.name, settled, x, x.shape[1] // 3)


def written(tree: Machine, met: Sequence[tuple[int, int]]) -> tuple[Path, Path]:
    """Files of the tree, and of the pairs of its frames (numbers from 1) whose origins meet."""
    lines = [str(len(met))]
    for j in (j for pair in met for j in pair):
        carrier, place = carried_frame(tree, j)
        numbers = [*place.rotation.ravel(), *place.translation]
        lines.append(" ".join([str(carrier), *(repr(float(x)) for x in np.round(numbers, 15) + 0.0)]))
    model = pinocchio_cpp.model_file(tree)
    points = BUILD / f"{tree.name}_points.txt"
    points.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return model, points
