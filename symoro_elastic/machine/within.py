"""Tolerances of results: how far a model with terms left out may be from the whole one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from symoro_elastic.machine.formula import FormulaError, number

PERCENT = "%"
ALL_RESULTS = ""
"""Stands for all results that have no tolerance of their own."""
FREQUENCIES = "frequencies"
"""Stands for the natural frequencies, motors held and free; relative to each, or in Hz."""


class Keep(StrEnum):
    """What of the structure of a model is kept.

    Each parameter is whole or zero; or terms of the inertia matrix and of the potential are left out, and all else
    follows from these; or single terms are left out anywhere.
    """

    PARAMETERS = "parameters"
    INERTIA = "inertia"
    TERMS = "terms"


class Guaranteed(StrEnum):
    """What stands behind errors: a bound on unseen states with a stated confidence, or a proof for the whole box."""

    CONFIDENT = "confident"
    PROVEN = "proven"


@dataclass(frozen=True)
class Tolerance:
    """An allowed error: of the largest value over the box if `relative`, else in the unit of the result."""

    value: float
    relative: bool = True

    def __str__(self) -> str:
        return f"{100 * self.value:g} %" if self.relative else f"{self.value:g}"


@dataclass(frozen=True)
class Within:
    """Tolerances by the name of a result ("tau") or of a joint, `ALL_RESULTS` for all others; what is kept, and how.

    `FREQUENCIES` have a tolerance of their own, beside that of results.
    """

    tolerances: Mapping[str, Tolerance] = field(default_factory=dict)
    keep: Keep = Keep.TERMS
    guaranteed: Guaranteed = Guaranteed.CONFIDENT

    def __bool__(self) -> bool:
        """Whether anything may be left out."""
        return bool(self.tolerances)

    @property
    def frequencies(self) -> Tolerance | None:
        """The tolerance of natural frequencies."""
        return self.tolerances.get(FREQUENCIES)

    def of(self, result: str, joint: str) -> Tolerance | None:
        """The tolerance of an entry of a result: that of the joint it belongs to, of the result, or of all."""
        found = (self.tolerances.get(name) for name in (joint, result, ALL_RESULTS))
        return next((one for one in found if one is not None), None)


EXACT = Within()


def tolerance(written: str | float, of: str = ALL_RESULTS) -> Tolerance:
    """The tolerance `of` results in a text such as "1 %" or "0.5", or in a number; raises `FormulaError`.

    Frequencies may have 100 % and more: a mode that is lost is never within their tolerance.
    """
    text = str(written).strip()
    relative = text.endswith(PERCENT)
    value = number(text.removesuffix(PERCENT).strip()) / (100 if relative else 1)
    if not value > 0:
        raise FormulaError(f"{text} is not above zero: leave out the tolerance of what must be exact")
    if relative and value >= 1 and of != FREQUENCIES:
        raise FormulaError(f"{text} would let a result be zero: give less than 100 %, or leave the result out")
    return Tolerance(value, relative)
