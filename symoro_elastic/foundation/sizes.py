"""Bounds on what is held in memory, which commands refuse before they work."""

from __future__ import annotations

from symoro_elastic.foundation.errors import InputError

MOST_SAMPLES = 5_000_000
MOST_IN_FILES = 30_000_000
"""Numbers of a file of motions or measurements: 240 MB, some 2 GB to work with them."""
MOST_HELD = 50_000_000
"""Numbers of a result, 400 MB in double precision."""


def refuse_numbers(count: int, what: str, source: str, place: str, way_out: str, most: int = MOST_HELD) -> None:
    """Raise `InputError` for more numbers than there is room for; `what` they are, and what makes them fewer."""
    if count > most:
        raise InputError(source, place, f"{what} make {count:.3g} numbers, {most:.0e} is the limit: {way_out}")
