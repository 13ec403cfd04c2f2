"""The ladder of models of a machine, and its rungs: models without some springs, with steps and errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from symoro_elastic.analysis.ladder.greedy import SpringFigures
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.machine import Machine

MODEL_SHARE = 0.7
"""Of the tolerance that the springs left out may take; steps take a quarter, arithmetic the rest."""
DOUBT = 2.0
"""Ratio of measured and predicted error from which a prediction is not trusted."""
NEGLIGIBLE = 0.01
"""Of the tolerance: errors that need not be predicted well."""


@dataclass(frozen=True)
class Steps:
    """Method and number of steps that suffice, their predicted errors by output, weighted operations of a step."""

    method: str
    steps: int
    predicted: Mapping[str, float]
    operations: int

    @property
    def cost(self) -> int:
        """Weighted operations over the motion."""
        return self.steps * self.operations


@dataclass(frozen=True)
class Measured:
    """Errors of a rung's model and of its steps by output, and the time of a step, s."""

    model: Mapping[str, float]
    steps: Mapping[str, float]
    seconds: float


@dataclass(frozen=True)
class Rung:
    """A model: springs that are static or, if `locked`, held; predicted errors by output; steps where they suffice."""

    left_out: tuple[str, ...]
    locked: bool
    predicted: Mapping[str, float]
    chosen: Steps | None = None
    measured: Measured | None = None

    def is_trusted(self, tolerance: Mapping[str, float]) -> bool:
        """Whether measured errors agree with the predicted ones, where they matter, and are within the tolerances."""
        if self.measured is None or self.chosen is None:
            return True
        of_model, of_steps = (self.predicted, self.measured.model), (self.chosen.predicted, self.measured.steps)
        return all(
            _agree(predicted[name], measured[name], NEGLIGIBLE * limit)
            and self.measured.model[name] + self.measured.steps[name] <= limit
            for predicted, measured in (of_model, of_steps)
            for name, limit in tolerance.items()
        )


@dataclass(frozen=True, repr=False)
class Ladder(Result):
    """All rungs of a machine for its motions, the rung that is chosen, and the whole machine with RK4 to compare with.

    `chosen` is None where no rung fits the tolerances. `distrusted` are rungs whose prediction failed. `arithmetic` are
    errors by output that the chosen one has more where accelerations are in single precision; empty without one.
    `springs` are what is usually asked of each, `condensed` lines on springs in series that the machine has as one.
    """

    machine: Machine
    references: tuple[Reference, ...]
    tolerance: Mapping[str, float]
    rungs: tuple[Rung, ...]
    chosen: int | None
    full: Steps
    distrusted: tuple[int, ...] = ()
    arithmetic: Mapping[str, float] = field(default_factory=dict)
    springs: tuple[SpringFigures, ...] = ()
    condensed: tuple[str, ...] = ()

    @property
    def saving(self) -> float:
        """Operations of the whole machine with RK4 over those of the chosen rung."""
        rung = self.rungs[self.chosen or 0]
        return self.full.cost / rung.chosen.cost if rung.chosen else 1.0

    @property
    def headline(self) -> str:
        """Machine, rungs and the chosen one."""
        choice = "none fits" if self.chosen is None else f"{self.chosen} chosen, {self.saving:.3g} times less work"
        return f"Ladder of {self.machine.name}: {len(self.rungs)} rungs, {choice}"

    @property
    def worst_output(self) -> str:
        """The output whose error is the largest part of its tolerance, over all rungs."""
        return max(self.tolerance, key=lambda name: max(x.predicted[name] for x in self.rungs) / self.tolerance[name])

    def step_of(self, rung: Rung) -> float:
        """Return the shortest step of a rung that fits over all motions, s."""
        assert rung.chosen is not None
        return min(reference.duration for reference in self.references) / rung.chosen.steps


def _agree(predicted: float, measured: float, negligible: float) -> bool:
    """Whether two errors are within a factor, or both do not matter."""
    if max(predicted, measured) <= negligible:
        return True
    return predicted / DOUBT <= measured <= predicted * DOUBT
