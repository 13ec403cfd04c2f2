"""Compiled steps that take the numbers of a machine when they run: one compilation for many stiffnesses."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from symoro_elastic.analysis.simulation.compiled_steps import CompiledSteps
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.machine import Machine


class StepsWithParameters(CompiledSteps):
    """Set `p`, in the order of the parameters, before each run."""

    fold = ()
    p: Array

    def __init__(self, machine: Machine, methods: Sequence[str], folder: Path) -> None:
        super().__init__(machine, methods, folder)
        self.p = np.zeros(len(machine.parameters))
        assert [p.name for p in self.package.parameters] == [p.name for p in machine.parameters]
