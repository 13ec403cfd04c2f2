"""What is asked of a reduced program, and what is found: tolerances, errors, what is left out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from symoro_elastic.machine.within import Tolerance
from symoro_elastic.numerics.guarantees.dropped_terms import ChangedNodes
from symoro_elastic.numerics.within.tape import Kind
from symoro_elastic.symbolic.expression import Operand
from symoro_elastic.symbolic.program import OperationCount, Output, Program

Tolerances = Mapping[str, Tolerance | Sequence[Tolerance]]
"""By the name of an output: for all its entries, or for each of them."""
Reserved = Mapping[str, Sequence[float]]
"""By the name of an output: how much of the tolerance of each entry other errors need, in its unit."""
NOTHING: Reserved = MappingProxyType({})
ErrorBound = Callable[[Program, Program, ChangedNodes], Mapping[str, Sequence[float]]]
"""From a program, the reduced one and its changes to bounds on the errors of all entries, by output, in their units."""


@dataclass(frozen=True)
class LeftOut:
    """A change of the program, for a reader: its kind, the quantity it is part of, and what is left out."""

    kind: Kind
    quantity: str
    term: str
    constant: float | None = None


@dataclass(frozen=True)
class EntryError:
    """Errors of an entry of an output, in its unit.

    `largest` is its largest value at 20 000 states; `tolerance` what is allowed; `sampled` the largest error at states
    of the search, those of earlier climbs among them; `climbed` that found by climbing from there; `unseen` that at
    states not searched; `confident` the bound on errors at as many more states, at least what is known, `bounded` the
    given bound on all; None where they were not asked for.
    """

    output: str
    index: int
    largest: float
    tolerance: float
    sampled: float
    climbed: float
    unseen: float
    confident: float | None = None
    bounded: float | None = None


@dataclass(frozen=True)
class Reduction:
    """A reduced program, what is left out of it, and its errors.

    `outputs` are those of the program with the new `values` of its nodes, by number, for `Names.moved`; `reduced` is
    the program of them. `states` were drawn for `unseen` errors, with `seed`. `ended` tells that the user ended the
    search, `unproven` which result is the reason that a program stays whole. `shift` bounds shifts of
    natural frequencies, of their tolerance, where they have one.
    """

    program: Program = field(repr=False)
    reduced: Program = field(repr=False)
    outputs: tuple[Output, ...] = field(repr=False)
    values: Mapping[int, Operand] = field(repr=False)
    left_out: tuple[LeftOut, ...]
    errors: tuple[EntryError, ...]
    states: int
    seed: int
    ended: bool = False
    unproven: str = ""
    shift: float | None = None

    @property
    def before(self) -> OperationCount:
        """Operations of a call of the program."""
        return self.program.count

    @property
    def after(self) -> OperationCount:
        """Operations of a call of the reduced program."""
        return self.reduced.count
