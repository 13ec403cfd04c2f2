"""The ladder of models of a machine: its rungs, the one that is chosen, and the budget where it was asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from symoro_elastic.analysis.ladder.budget import Budget
from symoro_elastic.analysis.ladder.greedy import SpringFigures
from symoro_elastic.analysis.ladder.rung import Rung, Steps
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.machine import Machine


@dataclass(frozen=True, repr=False)
class Ladder(Result):
    """All rungs of a machine for its motions, the rung that is chosen, and the whole machine with RK4 to compare with.

    `chosen` is None where no rung fits the tolerances. `distrusted` are rungs whose prediction failed. `arithmetic` are
    errors by output that the chosen one has more where accelerations are in single precision; empty without one.
    `springs` are what is usually asked of each, `condensed` lines on springs in series that the machine has as one.
    `budget` is the path on which numbers, steps and precision share the tolerances with springs, where it is asked for.
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
    budget: Budget | None = None

    @property
    def advised(self) -> Rung | None:
        """The model that is advised: the end of the budget, or the chosen rung; None where no rung fits."""
        if self.budget:
            return self.budget.advised.rung
        return None if self.chosen is None else self.rungs[self.chosen]

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
