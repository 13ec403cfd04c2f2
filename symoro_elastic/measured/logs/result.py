"""What an identification gives: the estimation, the rows it used, and notes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.machine import Machine
from symoro_elastic.measured.fitting.estimates import Estimate, largest_of_chance
from symoro_elastic.measured.logs.equations import Equations
from symoro_elastic.measured.logs.estimation import Estimation
from symoro_elastic.measured.logs.filtering import Filter
from symoro_elastic.measured.logs.friction_laws import FrictionLaws
from symoro_elastic.measured.logs.possible import Possible
from symoro_elastic.measured.logs.sensors import DELAY, Sensors

NEGLIGIBLE = 0.1  # of a standard deviation: differences of estimates that are of no account


@dataclass(frozen=True, repr=False)
class Identification(Result):
    """Identification result: the estimation, the rows it used (t, tau measured, averages), the filter, notes, torques
    of springs and dampers by the estimates (rows, n), neutral positions with standard deviations, and the estimation by
    driven joints alone where noise hides the parameters of the others."""

    equations: Equations
    estimation: Estimation
    t: Array
    tau: Array
    filter: Filter | None
    notes: tuple[str, ...]
    springs: Array
    neutral: dict[str, tuple[float, float]] = field(default_factory=dict)
    sensors: Sensors = field(default_factory=Sensors)
    possible: Possible | None = None
    laws: FrictionLaws = field(default_factory=FrictionLaws)
    driven: Estimation | None = None

    @property
    def machine(self) -> Machine:
        """The machine, with the values of its file, not the estimates."""
        return self.equations.machine

    @property
    def estimates(self) -> tuple[Estimate, ...]:
        """Estimates, one for each parameter or group."""
        return self.estimation.estimates

    @property
    def delay(self) -> float:
        """Delay of torques behind positions, s; zero where it is not estimated."""
        late = [e.value for e in self.estimates if e.unknown.quantity == DELAY and math.isfinite(e.value)]
        return late[0] if late else 0.0

    @property
    def headline(self) -> str:
        """Machine, parameters and samples."""
        return f"Identification of {self.machine.name}: {len(self.estimates)} parameters from {len(self.t)} samples"


def agree(fewer: Identification, more: Identification) -> bool:
    """Whether estimates from fewer and from more samples differ by no more than chance (Hausman 1978).

    By the larger standard deviations of fewer samples, on the level of all parameters together.
    """
    by_label = {e.unknown.label: e for e in more.estimates}
    pairs = [(e, by_label[e.unknown.label]) for e in fewer.estimates if e.unknown.label in by_label]
    pairs = [(estimate, other) for estimate, other in pairs if math.isfinite(estimate.std) and math.isfinite(other.std)]
    most = largest_of_chance(2 * len(pairs))
    return all(
        abs(estimate.value - other.value)
        <= most * math.sqrt(max(estimate.std**2 - other.std**2, (NEGLIGIBLE * estimate.std) ** 2))
        for estimate, other in pairs
    )
