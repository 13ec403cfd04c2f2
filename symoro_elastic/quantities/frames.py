"""Names of frames: `base` is frame 0, others have the name of their joint, `joint base` that of a joint so called."""

from __future__ import annotations

from collections.abc import Iterable

BASE = "base"
"""Frame 0, and the six rows of a base that moves."""
JOINT = "joint "
"""Stands before the name of a joint that could be taken for frame 0; it may stand before any."""


def frame_name(joint: str) -> str:
    """Return the name of the frame of a joint, which is never that of frame 0."""
    return f"{JOINT}{joint}" if joint == BASE else joint


def frame_names(joints: Iterable[str]) -> list[str]:
    """Return the names of all frames by their numbers, frame 0 first."""
    return [BASE, *map(frame_name, joints)]
