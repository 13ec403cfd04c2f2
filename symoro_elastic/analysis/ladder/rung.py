"""Rungs of a ladder: models without some springs, with steps and errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

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
    """A model: springs that are static or, if `locked`, held; predicted errors by output; steps where they suffice.

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
        """What its model leaves out."""
        return self.left_out, self.locked, self.neutral, self.zero

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


def _agree(predicted: float, measured: float, negligible: float) -> bool:
    """Whether two errors are within a factor, or both do not matter."""
    if max(predicted, measured) <= negligible:
        return True
    return predicted / DOUBT <= measured <= predicted * DOUBT
