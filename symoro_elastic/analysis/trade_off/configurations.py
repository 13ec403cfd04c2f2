"""Configurations under comparison, compiled one way or run by numpy, and the Pareto front of their time and error."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from symoro_elastic.analysis.trade_off.builds import Build
from symoro_elastic.analysis.trade_off.formulations import Formulation
from symoro_elastic.analysis.trade_off.timing import Time
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.numerics.verification.accuracy import Errors
from symoro_elastic.symbolic.program import OperationCount

MATTERS = 1.25
"""Ratio of worst errors over random states above which the difference is significant."""

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


def front(measurements: Iterable[Measurement], with_fast_math: bool = False) -> list[Measurement]:
    """Return the Pareto front, fastest first: no other configuration is faster and as accurate, or nearly so.

    Configurations with -ffast-math are on it only if `with_fast_math` allows them.
    """
    best: list[Measurement] = []
    for one in sorted(_allowed(measurements, with_fast_math), key=lambda f: (f.ns, f.error)):
        if math.isfinite(one.error) and (not best or one.error * MATTERS < best[-1].error):
            best.append(one)
    return best


def fastest_within(
    measurements: Iterable[Measurement], tolerance: float, with_fast_math: bool = False
) -> Measurement | None:
    """Return the fastest configuration whose errors at other states are bounded by a tolerance, or None."""
    good = [one for one in _allowed(measurements, with_fast_math) if one.bound <= tolerance]
    return min(good, key=lambda one: one.ns, default=None)


def most_accurate(measurements: Iterable[Measurement], with_fast_math: bool = False) -> Measurement:
    """Return the configuration with the smallest bound on errors, the fastest of several."""
    return min(_allowed(measurements, with_fast_math), key=lambda one: (_or_infinite(one.bound), one.ns))


def _allowed(measurements: Iterable[Measurement], with_fast_math: bool) -> list[Measurement]:
    return [one for one in measurements if with_fast_math or one.configuration.is_safe]


def _or_infinite(error: float) -> float:
    return math.inf if math.isnan(error) else error
