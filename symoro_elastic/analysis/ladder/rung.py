"""Models of a ladder and of a budget: what they omit, their time steps and errors.

The rungs of a ladder are models without some springs; the steps of a budget omit springs, numbers of bodies, digits and
time steps, within the tolerances of a scene.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

from symoro_elastic.analysis.simulation.prediction.spring_errors import relative
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.within import Evidence

PREDICTED_FRACTION = 0.95
"""Fraction of the tolerances that predictions may use; the rest is for what the linear model does not contain."""
MODEL_SHARE = 0.7
"""Fraction of the tolerance for quasi-static springs; a quarter is for time steps, the remainder for arithmetic."""
DOUBT = 2.0
"""Ratio of measured and predicted error above which a prediction is rejected."""
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
    """A reduced model: springs made static (or `locked`), predicted errors by output, and time steps if any suffice.

    Static springs are held where a motion starts, those in `neutral` where they are neutral. `zero` are numbers of
    bodies and rotors that are left out.
    """

    left_out: tuple[str, ...]
    locked: bool
    predicted: Mapping[str, float]
    chosen: Steps | None = None
    measured: Measured | None = None
    neutral: tuple[str, ...] = ()
    zero: tuple[str, ...] = ()

    @property
    def model(self) -> tuple[tuple[str, ...], bool, tuple[str, ...], tuple[str, ...]]:
        """The omitted parts of the model, the key under which its simulations are stored."""
        return self.left_out, self.locked, self.neutral, self.zero

    def is_trusted(self, tolerance: Mapping[str, float]) -> bool:
        """Whether measured errors are within the tolerances and agree with the predicted ones, unless negligible."""
        if self.measured is None or self.chosen is None:
            return True
        of_model, of_steps = (self.predicted, self.measured.model), (self.chosen.predicted, self.measured.steps)
        for name, limit in tolerance.items():
            if self.measured.model[name] + self.measured.steps[name] > limit:
                return False
            for predicted, measured in ((x[name], y[name]) for x, y in (of_model, of_steps)):
                agrees = predicted / DOUBT <= measured <= predicted * DOUBT
                if not agrees and max(predicted, measured) > NEGLIGIBLE * limit:
                    return False
        return True


def springs_text(names: Sequence[str], how: str, named: bool = True) -> str:
    """Return text on `names`: number of springs (listed if `named`), `how` they are omitted, and parts of drives."""
    springs = [name for name in names if "." not in name]
    parts, plural = len(names) - len(springs), "s" * (len(springs) != 1)
    listed = f" ({', '.join(springs)})" if named else ""
    said = [f"{len(springs)} spring{plural} {how}{listed}"] if springs else []
    return "; ".join([*said, *([f"{parts} lags and dead times left out"] if parts else [])])


class Expense(StrEnum):
    """Kinds of simplification that use a part of the tolerances."""

    WHOLE = "time steps"
    SPRINGS = "springs static"
    NEUTRAL = "held as neutral"
    NUMBERS = "numbers zero"
    STEPS = "longer steps"
    PRECISION = "mixed precision"


@dataclass(frozen=True)
class PathStep:
    """A step of the search: the newly omitted parts, the error that they add by output, and the model after it.

    `added` is the largest change of an output over the motions. `total` is the sum of what all steps up to here have
    added, never less than the error of all together (triangle inequality), and of the error of the time steps; where
    these become more accurate, it stays. `rung` is the model after it with its time steps.
    """

    expense: Expense
    names: tuple[str, ...]
    added: Mapping[str, float]
    total: Mapping[str, float]
    rung: Rung
    evidence: Evidence = Evidence.PREDICTED

    @property
    def steps(self) -> Steps:
        """Method, number and operations of the time steps."""
        assert self.rung.chosen is not None
        return self.rung.chosen


@dataclass(frozen=True)
class MeasuredEnd:
    """Measured errors by output of the final model against the full machine, and its times of a step, s.

    `mixed` and `errors_mixed` are those in mixed precision.
    """

    errors: Mapping[str, float]
    errors_mixed: Mapping[str, float]
    seconds: float
    mixed: float


@dataclass(frozen=True, repr=False)
class Budget(Result):
    """Steps from the full machine to the advised model, with operations and errors; the last step is advised.

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
        """Fraction of the operations saved, against static springs alone or else the full machine."""
        before = self.path[0].steps if self.alone is None else self.alone
        return 1 - self.advised.steps.cost / before.cost

    @property
    def seconds(self) -> float:
        """Computing time of a step in the advised precision, s."""
        return self.measured.mixed if self.advised.expense is Expense.PRECISION else self.measured.seconds

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
