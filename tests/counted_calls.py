"""Work counted in function calls instead of seconds, so that a busy machine changes nothing."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable
from typing import Any


def calls_of(work: Callable[[], object]) -> int:
    """Number of function calls, those of built-in functions too, that the work makes."""
    counter = itertools.count()

    def count(_frame: Any, event: str, _argument: Any) -> None:
        if event in ("call", "c_call"):
            next(counter)

    before = sys.getprofile()
    sys.setprofile(count)
    try:
        work()
    finally:
        sys.setprofile(before)
    return next(counter)
