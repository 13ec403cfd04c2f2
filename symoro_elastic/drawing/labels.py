"""Labels beside their points: none upon another, near, and clear of what is drawn as far as there is room."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from symoro_elastic.array_types import Array

HEIGHT, GAP = 15.0, 4.0
"""Of a line of text, and around it, px."""
NARROW, WIDE = frozenset("fijlrtI.,:;|'!()[] -"), frozenset("mwMW@%")
NARROW_ADVANCE, ADVANCE, CAPITAL_ADVANCE, WIDE_ADVANCE = 4.2, 6.8, 8.7, 10.2
"""Of characters in Helvetica and its likes at 12 px."""
DIRECTIONS = 16
FIRST, GROWTH = 16.0, 1.32
"""Distance of the first place from its point, px, and the ratio of those further out."""
COVERED, CROSSED, HIDDEN = 30.0, 25.0, 60.0
"""What it costs, in px, to cover something drawn, to cross another line, to have a label upon a line."""
PLENTY = 11
"""Rings of places that are compared; further ones only where these have no room."""


@dataclass(frozen=True)
class Label:
    """A text whose left end and middle are at (x, y) px, beside the point (anchor_x, anchor_y)."""

    text: str
    x: float
    y: float
    anchor_x: float
    anchor_y: float

    @cached_property
    def box(self) -> tuple[float, float, float, float]:
        """Left, top, right, bottom, px."""
        return self.x, self.y - HEIGHT / 2, self.x + width(self.text), self.y + HEIGHT / 2

    @cached_property
    def end(self) -> tuple[float, float]:
        """The end of the line from the point to the text."""
        left, _, right, _ = self.box
        return (left - GAP if self.anchor_x <= (left + right) / 2 else right + GAP), self.y


@cache
def width(text: str) -> float:
    """Return how wide a text is at most, px."""
    return sum(map(_advance, text))


def _advance(character: str) -> float:
    if character in NARROW:
        return NARROW_ADVANCE
    if character in WIDE:
        return WIDE_ADVANCE
    return CAPITAL_ADVANCE if character.isupper() else ADVANCE


def labelled(texts: Sequence[str], anchors: Array, drawn: Array) -> list[Label]:
    """Return a label for each text beside its anchor, the first of (N, 2), clear of the boxes `drawn` (M, 4), px."""
    found: list[Label] = []
    for text, anchor in zip(texts, anchors, strict=False):
        found.append(_best(text, anchor, anchors, drawn, found))
    return found


def _best(text: str, anchor: Array, anchors: Array, drawn: Array, others: Sequence[Label]) -> Label:
    """The place of least cost; rings grow until one has room, since paper has no end."""
    ring = 0
    best: tuple[float, Label] | None = None
    while best is None or (ring < PLENTY and FIRST * GROWTH**ring < best[0]):
        distance = FIRST * GROWTH**ring
        for k in range(DIRECTIONS):
            label = _placed(text, anchor, distance, 2 * math.pi * k / DIRECTIONS)
            if any(overlap(label.box, other.box) for other in others) or _covers(label, anchors):
                continue
            cost = distance + _cost(label, drawn, others)
            if best is None or cost < best[0] - 1e-6:
                best = cost, label
        ring += 1
    return best[1]


def _placed(text: str, anchor: Array, distance: float, angle: float) -> Label:
    x, y = float(anchor[0]) + distance * math.cos(angle), float(anchor[1]) - distance * math.sin(angle)
    across = math.cos(angle)
    shift = 0.0 if across > 0.35 else -width(text) if across < -0.35 else -width(text) / 2
    return Label(text, x + shift, y, float(anchor[0]), float(anchor[1]))


def overlap(one: Sequence[float], other: Sequence[float]) -> bool:
    """Return whether two boxes come nearer than the gap."""
    return (
        one[0] < other[2] + GAP
        and other[0] < one[2] + GAP
        and one[1] < other[3] + GAP / 2
        and other[1] < one[3] + GAP / 2
    )


def _covers(label: Label, points: Array) -> bool:
    left, top, right, bottom = label.box
    x, y = points[:, 0], points[:, 1]
    return bool(((left - GAP < x) & (x < right + GAP) & (top - 1 < y) & (y < bottom + 1)).any())


def _cost(label: Label, drawn: Array, others: Sequence[Label]) -> float:
    left, top, right, bottom = label.box
    covered = np.count_nonzero(
        (drawn[:, 0] < right) & (drawn[:, 2] > left) & (drawn[:, 1] < bottom) & (drawn[:, 3] > top)
    )
    cost = COVERED * min(float(covered), 6.0)
    for other in others:
        cost += CROSSED * _cross(label, other)
        cost += HIDDEN * (_runs_through(label, other.box) + _runs_through(other, label.box))
    return cost


def _cross(one: Label, other: Label) -> bool:
    """Whether the lines of two labels cross."""
    a, b = (one.anchor_x, one.anchor_y), one.end
    c, d = (other.anchor_x, other.anchor_y), other.end
    if a == c:
        return False
    return _side(a, b, c) * _side(a, b, d) < 0 and _side(c, d, a) * _side(c, d, b) < 0


def _runs_through(label: Label, box: tuple[float, float, float, float]) -> bool:
    """Whether the line of a label runs through a box."""
    for share in (0.15, 0.3, 0.45, 0.6, 0.75, 0.9):
        x = label.anchor_x + share * (label.end[0] - label.anchor_x)
        y = label.anchor_y + share * (label.end[1] - label.anchor_y)
        if box[0] - 1 < x < box[2] + 1 and box[1] < y < box[3]:
            return True
    return False


def _side(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
