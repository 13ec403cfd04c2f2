"""Errors a user can fix: each names the file, the place in it, and the remedy."""

from __future__ import annotations


class InputError(Exception):
    """An error in a user's input, as one line `file: place: problem, and remedy`."""

    def __init__(self, file: str, place: str, what: str) -> None:
        super().__init__(f"{file}: {place}: {what}")
        self.file, self.place, self.what = file, place, what
