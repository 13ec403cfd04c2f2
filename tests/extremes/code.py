"""Machines of the corpus as compiled C, and its errors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from symoro_elastic.codegen.compile import compile_package
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.packaging import package
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.evaluation.values import parameter_values
from symoro_elastic.numerics.verification.accuracy import Errors, Reference, measure, round_states, rounded_values
from symoro_elastic.numerics.verification.implementations import ResultArrays, c_code
from symoro_elastic.numerics.verification.states import States
from tests.extremes.corpus import DIRECT, INVERSE

QUICKLY = ("-O0",)
AS_RECOMMENDED = ("-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math")
"""By the generated source."""
BOTH = (DIRECT, INVERSE)


class Code:
    """Models of a machine, compiled in a precision."""

    def __init__(
        self, machine: Machine, folder: Path, flags: Sequence[str], models: Sequence[str], precision: Precision
    ) -> None:
        self.precision = precision
        self.values = rounded_values(parameter_values(machine), precision)
        self.traced = {name: trace(machine, name) for name in models}
        described = package(machine, list(self.traced.values()), ())
        library = compile_package(described, folder, render_c(described, precision), precision=precision, flags=flags)
        self._run = c_code(library, np.array([self.values[p.name] for p in described.parameters]))

    def results(self, model: str, states: States) -> ResultArrays:
        return self._run(self.traced[model], states)

    def errors(self, model: str, states: States) -> Errors:
        """At these states, rounded to the precision."""
        held = round_states(states, self.precision)
        return measure(Reference(self.traced[model], held, self.values), self.results(model, held), self.precision)


@contextmanager
def compiled(
    machine: Machine, flags: Sequence[str] = QUICKLY, models: Sequence[str] = BOTH, precision: Precision = DOUBLE
) -> Iterator[Code]:
    with TemporaryDirectory() as folder:
        yield Code(machine, Path(folder), flags, models, precision)
