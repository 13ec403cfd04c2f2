"""One budget: the tolerances of a scene, spent on springs, numbers, steps and precision, each with what it adds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from symoro_elastic.analysis.ladder.rung import Rung, Steps
from symoro_elastic.analysis.simulation.prediction.spring_errors import relative
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.machine import Machine


class Spent(StrEnum):
    """What a part of the tolerances is spent on."""

    WHOLE = "time steps"
    SPRINGS = "springs static"
    NEUTRAL = "held as neutral"
    NUMBERS = "numbers zero"
    STEPS = "longer steps"
    PRECISION = "mixed precision"


class Word(StrEnum):
    """What stands behind an error: the linear model along the motion, or a simulation beside the whole machine."""

    PREDICTED = "predicted"
    MEASURED = "measured"


@dataclass(frozen=True)
class PathStep:
    """One step of the path: what is left out more, the error that it adds by output, and the model after it.

    `added` is the largest change of an output over the motions. `total` is the sum of what all steps up to here have
    added, never less than the error of all together (triangle inequality), and of the error of the time steps; where
    these become more accurate, it stays. `rung` is the model after it with its time steps.
    """

    spent: Spent
    names: tuple[str, ...]
    added: Mapping[str, float]
    total: Mapping[str, float]
    rung: Rung
    word: Word = Word.PREDICTED

    @property
    def steps(self) -> Steps:
        """Method, number and operations of the time steps."""
        assert self.rung.chosen is not None
        return self.rung.chosen


@dataclass(frozen=True)
class MeasuredEnd:
    """The end of a path, simulated beside the whole machine: errors of everything by output, and times of a step, s.

    `mixed` and `errors_mixed` are those in mixed precision.
    """

    errors: Mapping[str, float]
    errors_mixed: Mapping[str, float]
    seconds: float
    mixed: float


@dataclass(frozen=True, repr=False)
class Budget(Result):
    """The path of operations against error, from the whole machine to the model that is advised, its last step.

    `full` are the time steps of the whole machine with RK4, `alone` those where springs alone are left out, None where
    no rung of the ladder fits. `dropped` are steps that a simulation did not confirm.
    """

    machine: Machine
    tolerance: Mapping[str, float]
    path: tuple[PathStep, ...]
    measured: MeasuredEnd
    full: Steps
    alone: Steps | None
    dropped: tuple[PathStep, ...] = ()

    @property
    def advised(self) -> PathStep:
        """The last step: the model that is advised."""
        return self.path[-1]

    @property
    def saved(self) -> float:
        """The share of operations that it saves of those with springs alone left out, or of the whole machine."""
        before = self.path[0].steps if self.alone is None else self.alone
        return 1 - self.advised.steps.cost / before.cost

    @property
    def seconds(self) -> float:
        """The time of a step in the precision that is advised, s."""
        return self.measured.mixed if self.advised.spent is Spent.PRECISION else self.measured.seconds

    @property
    def is_within(self) -> bool:
        """Whether the measured errors are within the tolerances."""
        return relative(self.measured.errors, self.tolerance) <= 1

    @property
    def worst_output(self) -> str:
        """The output whose error is the largest part of its tolerance."""
        return max(self.tolerance, key=lambda name: self.advised.total[name] / self.tolerance[name])

    @property
    def headline(self) -> str:
        """Machine, steps, and what is saved."""
        return f"Budget of {self.machine.name}: {len(self.path)} steps, {self.saved:.0%} fewer operations"
