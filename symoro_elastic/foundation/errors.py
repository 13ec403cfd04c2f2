"""Errors a user can fix: each names the file, the place in it, and the remedy."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any


class InputError(Exception):
    """An error in a user's input, as one line `file: place: problem, and remedy`."""

    def __init__(self, file: str, place: str, what: str) -> None:
        super().__init__(f"{file}: {place}: {what}")
        self.file, self.place, self.what = file, place, what

    def __reduce__(self) -> tuple[Any, ...]:
        """Return class, text and attributes, so that the error is whole in another process."""
        return _again, (type(self), str(self), self.__dict__)


def _again(kind: type[InputError], text: str, attributes: Mapping[str, Any]) -> InputError:
    """Return an error of a pickle."""
    error = kind.__new__(kind, text)
    error.__dict__.update(attributes)
    return error


@contextmanager
def placed(places: Mapping[str, str]) -> Iterator[None]:
    """Within it, errors whose place begins with a key of `places` name what was typed in its place."""
    try:
        yield
    except InputError as error:
        for place, typed in places.items():
            if error.place == place or error.place.startswith(f"{place}, "):
                raise InputError(error.file, typed + error.place[len(place) :], error.what) from None
        raise


def some_of(names: Sequence[str], most: int = 10) -> str:
    """Return the first names of a list in words, and how many more there are."""
    rest = len(names) - most
    return ", ".join(names[:most]) + (f" and {rest} more" if rest > 0 else "")


def among(names: Sequence[str], known: Sequence[str] | Mapping[str, Any], option: str) -> tuple[str, ...]:
    """Return the names without repetition; raise `InputError` for one that is not known, and for a text as a list."""
    if isinstance(names, str):
        raise InputError("symoro-elastic", option, f"give a list of names: [{names!r}]")
    for name in names:
        if name not in known:
            raise InputError("symoro-elastic", option, f"there is no {name!r}: choose from {', '.join(known)}")
    return tuple(dict.fromkeys(names))
