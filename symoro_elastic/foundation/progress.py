"""Callbacks that report the progress of long work."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

Progress: TypeAlias = Callable[[int, int], None]
"""Called with the work done and the total."""
StepProgress: TypeAlias = Callable[[str], Progress]
"""Called with the name of a step; returns the callback of this step."""
Announce: TypeAlias = Callable[[str], None]
"""Called with the name of a step when it begins."""


def no_progress(done: int, total: int) -> None:
    """Report nothing."""


def no_step_progress(step: str) -> Progress:
    """Return a callback that reports nothing."""
    return no_progress


def announce_nothing(step: str) -> None:
    """Report nothing."""
