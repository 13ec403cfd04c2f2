"""Closed loops: which joint of each is cut, which frames meet there, and which variables depend on the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum

from symoro_elastic.machine.formula import Formula


class Closing(StrEnum):
    """Components of the two frames at a cut joint that coincide."""

    FRAME = "frame"
    POINT = "point"


@dataclass(frozen=True)
class Loop:
    """A closed loop: the frame of the row `cut`, moved by the cut joint's variable, meets that of the row `meets`.

    Both are numbers of rows, from 1. With `closes` POINT only their origins meet: a ball joint. `dependent` are the
    joints, by name, whose variables follow from the others of the loop; where it is empty these are its passive
    joints. `start` is one rough position of the loop by joint variable, rad or m: it selects the branch.
    """

    name: str
    cut: int
    meets: int
    closes: Closing = Closing.FRAME
    dependent: tuple[str, ...] = ()
    start: dict[str, Formula] = field(default_factory=dict)


def path(antecedents: Sequence[int], j: int) -> list[int]:
    """Numbers of the rows from the base to row j; `antecedents[j - 1]` is that of row j.

    It ends where an antecedent is not a row above its own, as in a table that is not checked yet.
    """
    rows: list[int] = []
    while j > 0:
        rows.append(j)
        j = antecedents[j - 1] if antecedents[j - 1] < j else 0
    return rows[::-1]


def branches(antecedents: Sequence[int], loop: Loop) -> tuple[list[int], list[int]]:
    """Rows from the last common body of a loop to its cut joint and to the frame that this meets."""
    to_cut, to_end = path(antecedents, loop.cut), path(antecedents, loop.meets)
    while to_cut and to_end and to_cut[0] == to_end[0]:
        del to_cut[0], to_end[0]
    return to_cut, to_end
