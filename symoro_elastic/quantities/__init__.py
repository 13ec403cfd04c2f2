"""Every argument, result and intermediate quantity of generated code, a row each.

Whatever says a name, a symbol, a unit, a shape or a meaning reads it here: the check of users' names, docstrings and
comments, tables, LaTeX, test states.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from symoro_elastic.quantities import intermediates, signatures, time_steps
from symoro_elastic.quantities.intermediates import COEFFICIENT, DERIVATIVE, FUNCTIONS, PREFIXES
from symoro_elastic.quantities.quantity import Intermediate, Quantity, Role, Samples, citation, derivative
from symoro_elastic.quantities.signatures import HIGHEST_DERIVATIVE, MOTION, VELOCITIES
from symoro_elastic.quantities.units import PairUnit, Unit

__all__ = [
    "COEFFICIENT",
    "DERIVATIVE",
    "FUNCTIONS",
    "HIGHEST_DERIVATIVE",
    "INTERMEDIATES",
    "MOTION",
    "OF_JOINTS",
    "ON_BASE",
    "PREFIXES",
    "QUANTITIES",
    "VELOCITIES",
    "Intermediate",
    "PairUnit",
    "Quantity",
    "Role",
    "Samples",
    "Unit",
    "citation",
    "derivative",
    "is_intermediate",
    "quantity",
    "words",
]

QUANTITIES: dict[str, Quantity] = {
    row.name: row
    for rows in (
        signatures.OF_JOINTS,
        signatures.MOTION,
        signatures.OF_FRAMES,
        signatures.ON_BASE,
        signatures.EXTERNAL,
        signatures.OF_FRICTION,
        signatures.COLUMNS,
        signatures.OF_CLOSED_CHAINS,
        signatures.OF_STATIC_SPRINGS,
        signatures.OF_MACHINES,
        time_steps.OF_TIME_STEPS,
        signatures.OF_CONTROLLERS,
    )
    for row in rows
}
"""Arguments and results, and what derivatives are taken by; derivatives themselves are composed by `quantity`."""
INTERMEDIATES: list[Intermediate] = list(intermediates.ROWS)
OF_JOINTS: tuple[Quantity, ...] = signatures.OF_JOINTS
"""Blocks of the state that every machine has, in the order in which test states are drawn."""
ON_BASE: tuple[Quantity, ...] = signatures.ON_BASE
"""Arguments that belong to a base that moves freely."""


def quantity(name: str, own: Iterable[Quantity] = ()) -> Quantity:
    """The quantity of this name, an argument or result; those of `own` have precedence over the table's.

    `dtau_dq` is composed of the rows of tau and q. Raises `LookupError` where no row has the name.
    """
    rows = QUANTITIES | {row.name: row for row in own}
    of, _, by = name.removeprefix("d").partition("_d")
    if name in rows:
        return rows[name]
    if of in rows and by in rows:
        return derivative(rows[of], rows[by])
    raise LookupError(f"{name}: no row of the table of quantities has this name: add it to quantities/signatures.py")


def words() -> Iterator[str]:
    """Names of arguments, which machines must not use."""
    return (row.name for row in QUANTITIES.values() if row.is_word)


def is_intermediate(name: str) -> bool:
    """Whether a name is, or resembles, one of an intermediate variable."""
    if name.startswith(PREFIXES):
        return True
    match = re.fullmatch(r"([A-Za-z]+)\d+([a-z]*|_.*)", name, re.ASCII)
    if not match:
        return False
    has_component = match[2].startswith("_")
    return any(row.name == match[1] and bool(row.component) == has_component for row in INTERMEDIATES)
