"""A model within tolerances: its operations, omitted terms and errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.within import Within

if TYPE_CHECKING:
    from symoro_elastic.numerics.guarantees.certificate import Certificate
    from symoro_elastic.numerics.within.results import Reduction
    from symoro_elastic.numerics.within.structure import LostStructure


@dataclass(frozen=True, repr=False)
class ReducedModel(Result):
    """A model within a tolerance: its omitted terms and errors; certificates have the total, rounding included.

    `lost` is what an inverse model has lost of its structure, where single terms were left out. A direct model is
    `solved` if they were left out of its inverse model, which is solved exactly.
    """

    model: str
    within: Within
    reduction: Reduction
    certificates: tuple[Certificate, ...]
    lost: LostStructure | None = None
    solved: bool = False

    @property
    def operations(self) -> tuple[int, int]:
        """Products, quotients and sums of a call: of the whole model, and of this one."""
        before, after = self.reduction.before, self.reduction.after
        return before.products + before.add, after.products + after.add

    @property
    def headline(self) -> str:
        """The model, its tolerances, and its operations before and after."""
        before, after = self.operations
        tolerances = ", ".join(f"{name} {x}".strip() for name, x in self.within.tolerances.items())
        return f"{self.model} within {tolerances}: {after} of {before} operations"
