"""Errors a user can fix: each names the file, the place in it, and the remedy."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

CONTROL = re.compile("[\0-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""Characters that steer a terminal or turn the direction of a text, and halves of characters; no tabs and line ends."""
LONG_WORD = re.compile(r"\S{501,}")
LONGEST_MESSAGE = 4000
"""Characters of a message: four times those of a list of ten names with a reason."""
TWICE = "is given twice: keep one"
NOT_FINITE = "is not finite: give a finite number"
NO_RANGE = "{:g}:{:g} is not a range: give finite LOW:HIGH, LOW first"
MOST_SAMPLES = 5_000_000
MOST_IN_FILES = 30_000_000
"""Numbers of a file of motions or measurements: 240 MB, some 2 GB to work with them."""
MOST_HELD = 50_000_000
"""Numbers of a result, 400 MB in double precision."""


def printable(text: str) -> str:
    r"""Return a text with control characters escaped: ESC is `\x1b`."""
    return CONTROL.sub(lambda character: character[0].encode("unicode_escape").decode("ascii"), text)


def readable(message: str) -> str:
    """Return a message for a terminal, with the middle of long words and texts omitted."""
    message = LONG_WORD.sub(lambda word: f"{word[0][:60]}...{word[0][-60:]}", printable(message))
    return message if len(message) <= LONGEST_MESSAGE else f"{message[:1000]} ... {message[-300:]}"


class InputError(Exception):
    """An error in a user's input, as one line `file: place: problem, and remedy`."""

    def __init__(self, file: str, place: str, what: str) -> None:
        super().__init__(readable(f"{file}: {place}: {what}"))
        self.file, self.place, self.what = file, place, what

    def __reduce__(self) -> tuple[Any, ...]:
        """Return class, text and attributes, for other processes."""
        return _restored_error, (type(self), str(self), self.__dict__)


def _restored_error(kind: type[InputError], text: str, attributes: Mapping[str, Any]) -> InputError:
    """Return an error restored from a pickle."""
    error = kind.__new__(kind, text)
    error.__dict__.update(attributes)
    return error


@contextmanager
def reported_places(places: Mapping[str, str]) -> Iterator[None]:
    """Within this block, an `InputError` at a key of `places`, or below it, reports the value: the place as typed."""
    try:
        yield
    except InputError as error:
        for place, typed in places.items():
            if error.place == place or error.place.startswith(f"{place}, "):
                raise InputError(error.file, typed + error.place[len(place) :], error.what) from None
        raise


@contextmanager
def refusing(source: str, place: str, before: str = "", kind: type[Exception] = ValueError) -> Iterator[None]:
    """Within this block, errors of `kind`, such as those of formulas and units, become `InputError`s at a place."""
    try:
        yield
    except kind as error:
        raise InputError(source, place, f"{before}{error}") from None


def some_of(names: Sequence[str], most: int = 10) -> str:
    """Return the first names of a list in words, and the number of the others."""
    remaining = len(names) - most
    return ", ".join(names[:most]) + (f" and {remaining} more" if remaining > 0 else "")


def enumeration(names: Sequence[str]) -> str:
    """Return names in words: `a`, `a and b`, `a, b and c`."""
    return ", ".join(names[:-1]) + f" and {names[-1]}" if len(names) > 1 else names[0]


def among(names: Sequence[str], allowed: Sequence[str] | Mapping[str, Any], option: str) -> tuple[str, ...]:
    """Return the names without repetition; raise `InputError` for an unknown one, and for a text as a list."""
    if isinstance(names, str):
        raise InputError("symoro-elastic", option, f"give a list of names: [{names!r}]")
    for name in names:
        if name not in allowed:
            raise InputError("symoro-elastic", option, f"unknown {name!r}: choose from {', '.join(allowed)}")
    return tuple(dict.fromkeys(names))


def without_value(names: Sequence[str], option: str = "") -> str:
    """Return the message about parameters without value; `option` is one that gives it."""
    more = f" ({len(names) - 1} more as well)" if names[1:] else ""
    return f"{names[0]} has no value{more}: give it one in the file" + f", or by {option} {names[0]}=X" * bool(option)


def refuse_numbers(count: int, what: str, source: str, place: str, way_out: str, most: int = MOST_HELD) -> None:
    """Raise `InputError` for more numbers than fit in memory; `what` they are, and how to reduce them."""
    if count > most:
        raise InputError(source, place, f"{what} make {count:.3g} numbers, {most:.0e} is the limit: {way_out}")
