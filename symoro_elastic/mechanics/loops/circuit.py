"""A loop as a circuit: from its last common body along one branch, through the cut joint, back along the other.

Between its unknown joints the circuit consists of segments: displacements that are known.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

from symoro_elastic.mechanics.kinematics import Frame
from symoro_elastic.mechanics.loops.closing import CutJoint
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import IDENTITY, ZERO, AxialTransform, Axis

Step: TypeAlias = tuple[AxialTransform, int]
CUT = 0
"""Number of the cut joint among the numbers of joints."""


@dataclass(frozen=True)
class Passed:
    """A joint that a circuit passes, in its own sense or (-1) against it."""

    joint: int
    axis: Axis
    sense: int


@dataclass(frozen=True)
class Segment:
    """The displacement from one unknown joint to the next: axial transforms, each forth (1) or back (-1)."""

    steps: tuple[Step, ...]

    def __add__(self, other: Segment) -> Segment:
        return Segment(self.steps + other.steps)

    @cached_property
    def frame(self) -> Frame:
        """The frame at its end, expressed in that at its beginning."""
        rotation, origin = IDENTITY, ZERO
        for step, sense in self.steps:
            if sense > 0:
                rotation = step.rotate_rows(rotation)
                origin = origin + step.shift * rotation.T[step.axis]
            else:
                origin = origin - step.shift * rotation.T[step.axis]
                rotation = step.rotate_rows_back(rotation)
        return Frame(rotation, origin)


@dataclass(frozen=True)
class Circuit:
    """Unknown joints and, after each of them, the segment to the next; the last one leads to the first."""

    unknown: tuple[Passed, ...]
    segments: tuple[Segment, ...]

    def from_joint(self, k: int) -> Circuit:
        """The circuit from its unknown joint k on."""
        return Circuit(self.unknown[k:] + self.unknown[:k], self.segments[k:] + self.segments[:k])


def circuit(
    mechanism: Mechanism, branches: tuple[list[int], list[int]], cut: CutJoint, unknown: Collection[int]
) -> Circuit:
    """The circuit of a loop; of `unknown` joints neither angle nor shift is known, nor of the cut joint."""
    to_cut, to_end = branches
    passed: list[Passed] = []
    segments: list[list[Step]] = [[]]
    for element in _around(mechanism, to_cut, to_end, cut, unknown):
        if isinstance(element, Passed):
            passed.append(element)
            segments.append([])
        else:
            segments[-1].append(element)
    segments[-1] += segments.pop(0)
    return Circuit(tuple(passed), tuple(Segment(tuple(_without_returns(steps))) for steps in segments))


def _without_returns(steps: Iterable[Step]) -> list[Step]:
    """Steps without pairs that cancel, as where two branches leave their common body."""
    remaining: list[Step] = []
    for step, sense in steps:
        if remaining and remaining[-1] == (step, -sense):
            remaining.pop()
        else:
            remaining.append((step, sense))
    return remaining


def _around(
    mechanism: Mechanism, to_cut: list[int], to_end: list[int], cut: CutJoint, unknown: Collection[int]
) -> Iterator[Passed | Step]:
    for j in to_cut:
        yield from _through(mechanism, j, unknown)
    if cut.axis is not Axis.NONE or cut.at_point:
        yield Passed(CUT, Axis.REVOLUTE if cut.at_point else cut.axis, 1)
    for j in reversed(to_end):
        for element in reversed(list(_through(mechanism, j, unknown))):
            if isinstance(element, Passed):
                yield Passed(element.joint, element.axis, -1)
            else:
                yield element[0], -1


def _through(mechanism: Mechanism, j: int, unknown: Collection[int]) -> Iterator[Passed | Step]:
    link = mechanism.link(j)
    *before, last = link.transform.steps
    yield from ((step, 1) for step in before)
    if j not in unknown:
        yield last, 1
    elif link.axis is Axis.REVOLUTE:
        yield Passed(j, link.axis, 1)
        yield last.translation, 1
    else:
        yield last.rotation, 1
        yield Passed(j, link.axis, 1)
