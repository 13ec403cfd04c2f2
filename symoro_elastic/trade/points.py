"""The points of the trade: a form, compiled one way or run by numpy, called for one state or for many."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.numerics.accuracy import Errors
from symoro_elastic.symbolic.program import OperationCount
from symoro_elastic.trade.builds import Build
from symoro_elastic.trade.forms import Form
from symoro_elastic.trade.timing import Time

SINGLE_CALL, BATCH = "single call", "batch"
CALLS = (SINGLE_CALL, BATCH)


@dataclass(frozen=True)
class Point:
    """A way to compute a model; `build` is None for numpy."""

    model: str
    form: Form
    build: Build | None
    precision: Precision = field(hash=False)
    call: str

    @property
    def made_by(self) -> str:
        """Compiler and flags, or numpy."""
        return self.build.words if self.build else "numpy"

    @property
    def words(self) -> str:
        """The whole point in a few words."""
        return f"{self.form.words}; {self.precision.name}; {self.made_by}; {self.call}"

    @property
    def is_safe(self) -> bool:
        """Whether it may be advised: not with -ffast-math."""
        return self.build is None or self.build.is_safe

    def but(self, **changes: Any) -> Point:
        """The point that differs in these choices."""
        return replace(self, **changes)


@dataclass(frozen=True)
class Figures:
    """What was found of a point: ns a state, errors (of results as the user gets them)."""

    point: Point
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
    def count(self) -> OperationCount:
        """Operations of a call."""
        return self.point.form.count(self.point.model)


def judged_in(precision: Precision) -> Precision:
    """The precision in whose units errors are told: sums of two doubles come back rounded to one."""
    return DOUBLE if precision.is_pair else precision
