"""Configurations under comparison: a formulation, compiled one way or run by numpy, called for one or many states."""

from __future__ import annotations

from dataclasses import dataclass, field

from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.numerics.accuracy import Errors
from symoro_elastic.symbolic.program import OperationCount
from symoro_elastic.trade_off.builds import Build
from symoro_elastic.trade_off.formulations import Formulation
from symoro_elastic.trade_off.timing import Time

SINGLE_CALL, BATCH = "single call", "batch"
CALLS = (SINGLE_CALL, BATCH)


@dataclass(frozen=True)
class Configuration:
    """One way to compute a model; `build` is None for numpy."""

    model: str
    form: Formulation
    build: Build | None
    precision: Precision = field(hash=False)
    call: str

    @property
    def made_by(self) -> str:
        """Compiler and flags, or numpy."""
        return self.build.words if self.build else "numpy"

    @property
    def words(self) -> str:
        """Formulation, precision, compiler and call, as a table names them."""
        return f"{self.form.words}; {self.precision.name}; {self.made_by}; {self.call}"

    @property
    def is_safe(self) -> bool:
        """Whether it may be advised: not with -ffast-math."""
        return self.build is None or self.build.is_safe

    @property
    def is_slow(self) -> bool:
        """Whether it is too slow, or too slow to judge, for tens of thousands of states."""
        return self.precision.is_pair or (self.build is None and self.call == SINGLE_CALL)


@dataclass(frozen=True)
class Measurement:
    """Time and errors of a configuration.

    Errors are those of the results that a user gets who has inputs and parameters in double precision.
    """

    configuration: Configuration
    time: Time
    errors: Errors

    @property
    def ns(self) -> float:
        """Median time of a state."""
        return self.time.median

    @property
    def error(self) -> float:
        """Worst error relative to the largest entry of a result."""
        return self.errors.relative

    @property
    def bound(self) -> float:
        """Bound on the errors at states that were not tried, relative to the largest entry of a result."""
        return self.errors.bound

    @property
    def count(self) -> OperationCount:
        """Operations of a call."""
        return self.configuration.form.count(self.configuration.model)


def judged_in(precision: Precision) -> Precision:
    """Return the precision in whose units errors are given: double for double-double, which returns doubles."""
    return DOUBLE if precision.is_pair else precision
