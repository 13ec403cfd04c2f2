"""Pinocchio's constraint dynamics in C++: a tree whose points are kept together by multipliers."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from symoro_elastic.machine.machine import Machine
from tests.benchmarks.contest import BUILD, CXX_COMPILERS, Array, Contestant, entry, keeping_results
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
def library(compiler: str) -> ctypes.CDLL:
    found = pinocchio_cpp.library(compiler, "pinocchio_loops.cpp")
    found.settle.argtypes = [ctypes.c_double, ctypes.c_double, ctypes.c_int]
    return found


def contestants(files: tuple[Path, Path], x: Array, proximal: Proximal) -> list[Contestant]:
    """`constraintDynamics` on the states of `x`, by each compiler: q, qd, forces; qdd of all joints."""
    return [_contestant(files, x, proximal, compiler) for compiler in CXX_COMPILERS]


def _contestant(files: tuple[Path, Path], x: Array, proximal: Proximal, compiler: str) -> Contestant:
    library(compiler).read_loops(*(str(file).encode() for file in files))
    run = entry(library(compiler), "constrained")

    def settled(*arguments: object) -> float:
        library(compiler).settle(proximal.accuracy, proximal.mu, proximal.steps)
        return run(*arguments)

    return keeping_results(f"{proximal.name}, {compiler}", settled, x, x.shape[1] // 3)


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
