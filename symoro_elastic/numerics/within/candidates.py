"""What may be left out of a program: all changes that are worth a trial.

Candidates are each operand of each sum; each node that depends on positions only, as a number; and each sine, as its
angle. A node that moves with velocities, accelerations or torques is never frozen: results stay homogeneous in these,
so that what is zero at rest can stay zero. A node is frozen at the middle of its values, and at 0, 1 or -1 where these
are among them or near: then products with it are left out, too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.numerics.within.liveness import SIMPLE
from symoro_elastic.numerics.within.tape import SUMS, Change, Kind, Rows, Tape
from symoro_elastic.symbolic.expression import Level
from symoro_elastic.symbolic.operations import SIN

NEAR = 0.5
"""Of its range: how far 0, 1 or -1 may lie beyond the values of a node that is frozen there."""
DIGITS = 50
"""Into how many parts the half width of the values is divided for a round number in the middle."""


def candidates_of(tape: Tape, rows: Rows) -> list[Change]:
    """Return all candidates; `rows` are values over the box. Arguments that are results themselves stay."""
    found: list[Change] = []
    returned = {x for places in tape.entries for x in places}
    for place, node in enumerate(tape.nodes):
        if node.level != Level.STATE:
            continue
        if tape.operations[place] in SUMS:
            found += (Change(Kind.DROP, place, k) for k in (0, 1))
        if tape.of_positions[place] and (tape.operands[place] or place not in returned):
            found += (Change(Kind.FREEZE, place, constant=x) for x in constants_for(rows[place]))
        if tape.operations[place] == SIN:
            found.append(Change(Kind.STRAIGHTEN, place))
    return found


def constants_for(values: Array) -> Iterator[float]:
    """The numbers at which a node with these values may be frozen."""
    low, high = float(values.min()), float(values.max())
    if not math.isfinite(low + high):
        return
    margin = NEAR * (high - low)
    simple = [x for x in SIMPLE if low - margin <= x <= high + margin]
    yield from simple
    middle = rounded((low + high) / 2, (high - low) / 2 / DIGITS)
    if middle not in simple:
        yield middle


def rounded(x: float, step: float) -> float:
    """Return the number with the fewest decimals within about a step of x."""
    if not step:
        return x
    decimals = -math.floor(math.log10(step))
    return round(x, decimals) + 0.0
