"""Tolerances of results: the allowed difference of a reduced model from the full one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from symoro_elastic.machine.formula import FormulaError, number
from symoro_elastic.quantities.unit_reader import in_two

PERCENT = "%"
ALL_RESULTS = ""
"""Stands for all results that have no tolerance of their own."""
FREQUENCIES = "frequencies"
"""Stands for the natural frequencies, motors held and free; relative to each, or in Hz."""


TWO_DIGITS = 100.0
"""Of its error: a smaller value has fewer than two certain digits."""


class Keep(StrEnum):
    """Which structure a model with left-out terms keeps.

    Each parameter is whole or zero; or terms of the inertia matrix and of the potential are left out, and all else
    follows from these; or single terms are left out anywhere.
    """

    PARAMETERS = "parameters"
    INERTIA = "inertia"
    TERMS = "terms"


class Evidence(StrEnum):
    """Kind of evidence for an error.

    By a proof for all states of a box; by a bound on states drawn from it, with a stated confidence; by the linear
    model along a motion; by a simulation of that motion; or not at all.
    """

    PROVEN = "proven"
    CONFIDENT = "confident"
    PREDICTED = "predicted"
    MEASURED = "measured"
    NONE = "not bounded"


GUARANTEES = Evidence.CONFIDENT, Evidence.PROVEN
"""Kinds of evidence that reduced programs are generated with."""


@dataclass(frozen=True)
class Tolerance:
    """An allowed error: of the largest value over the box if `relative`, else in the unit of the result.

    `rounding` is the error of the full model in double precision: a result without two certain digits has no
    relative tolerance.
    """

    value: float
    relative: bool = True
    rounding: float = 0.0

    def is_rounding(self, largest: float) -> bool:
        """Return whether a result with this largest value is zero within rounding."""
        return self.relative and 0 < largest <= TWO_DIGITS * self.rounding

    def __str__(self) -> str:
        return f"{100 * self.value:g} %" if self.relative else f"{self.value:g}"


@dataclass(frozen=True)
class Within:
    """Tolerances by the name of a result ("tau") or of a joint, `ALL_RESULTS` for others; kept structure; evidence.

    `FREQUENCIES` have their own tolerance, apart from that of results.
    """

    tolerances: Mapping[str, Tolerance] = field(default_factory=dict)
    keep: Keep = Keep.TERMS
    guaranteed: Evidence = Evidence.CONFIDENT

    def __bool__(self) -> bool:
        """Whether any term may be left out."""
        return bool(self.tolerances)

    @property
    def frequencies(self) -> Tolerance | None:
        """The tolerance of natural frequencies."""
        return self.tolerances.get(FREQUENCIES)

    def of(self, result: str, joint: str) -> Tolerance | None:
        """The tolerance of an entry of a result: that of the joint it belongs to, of the result, or of all."""
        tolerances = (self.tolerances.get(name) for name in (joint, result, ALL_RESULTS))
        return next((tolerance for tolerance in tolerances if tolerance is not None), None)


EXACT = Within()


def tolerance(written: str | float, of: str = ALL_RESULTS) -> Tolerance:
    """The tolerance `of` results in a text such as "1 %" or "0.5", or in a number; raises `FormulaError`.

    Frequencies may have 100 % and more: a mode that is lost is never within their tolerance.
    """
    text = str(written).strip()
    relative = text.endswith(PERCENT)
    if not relative and in_two(text):
        raise FormulaError(f"{text}: give the number alone, in the unit of the result, or % of its largest value")
    value = number(text.removesuffix(PERCENT).strip()) / (100 if relative else 1)
    if not value > 0:
        raise FormulaError(f"{text} is not above zero: leave out the tolerance of what must be exact")
    if relative and value >= 1 and of != FREQUENCIES:
        raise FormulaError(f"{text} would let a result be zero: give less than 100 %, or leave the result out")
    return Tolerance(value, relative)
